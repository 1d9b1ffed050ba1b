//! `mislab info`.

use std::process::Stdio;

use crate::place::{Place, SMALL};

#[test]
fn info_shows_the_settings() {
    let place = Place::new();
    place
        .run("render --size 16x16 --spp 3 --seed 9 --strategy mis --light-prob 0.25 --quiet --outfile a.exr")
        .expect_code(0);
    let ran = place.run("info a.exr");
    ran.expect_code(0);
    let value = |name: &str| {
        let line = ran.out.lines().find(|line| line.split_whitespace().next() == Some(name));
        line.map(|line| line[name.len()..].trim().to_owned()).unwrap_or_else(|| panic!("no {name} in {}", ran.out))
    };
    let expected = [
        ("strategy", "mis"),
        ("lightProb", "0.25"),
        ("samplesPerPixel", "3"),
        ("seed", "9"),
        ("sceneName", "veach_mis"),
    ];
    for (name, expected) in expected {
        assert_eq!(value(name), expected, "{name}");
    }
    assert_eq!((value("dataWindow"), value("displayWindow")), ("16 x 16 at (0 0)".into(), "16 x 16 at (0 0)".into()));
    assert_eq!(value("light.R"), "FLOAT");
    assert!(ran.out.starts_with("a.exr: written by MIS Lab "), "{}", ran.out);
}

#[test]
fn info_shows_what_pictures_of_other_programs_hold() {
    let place = Place::new();
    place.run("render --size 16x16 --spp 1 --quiet --outfile a.exr").expect_code(0);
    // The same file without a word of ours.
    let mut bytes = std::fs::read(place.path("a.exr")).expect("reads");
    for name in ["mislabSettings", "mislabFormat"] {
        let at = bytes.windows(name.len()).position(|w| w == name.as_bytes()).expect("an attribute of ours");
        bytes[at..at + 6].copy_from_slice(b"others");
    }
    std::fs::write(place.path("b.exr"), bytes).expect("writes");
    let ran = place.run("info b.exr");
    ran.expect_code(0);
    assert_eq!(ran.err, "");
    for part in
        ["b.exr: not written by MIS Lab", "dataWindow     16 x 16 at (0 0)", "light.R        FLOAT", "13 channels"]
    {
        assert!(ran.out.contains(part), "no {part:?} in {}", ran.out);
    }
}

#[test]
fn a_reader_that_leaves_early_is_no_failure() {
    let place = Place::new();
    place.run(&format!("{SMALL} --outfile a.exr")).expect_code(0);
    let mut child =
        place.command("info a.exr").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("the program ends");
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}
