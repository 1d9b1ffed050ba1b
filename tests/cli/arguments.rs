//! What every command does with its arguments, and with what it cannot use.

use std::path::Path;
use std::process::Command;

use crate::place::{Place, SMALL, scene_with_header};

#[test]
fn one_dash_will_do() {
    let place = Place::new();
    let ran = place.run("render -size 8x8 -spp=2 -outfile a.exr -nthreads 1 -json a.json -quiet");
    ran.expect_code(0);
    assert_eq!((ran.out.as_str(), ran.err.as_str()), ("", ""));
    assert_eq!(place.files(), ["a.exr", "a.json"]);
    place.run("-version").expect_code(0);
    place.run("render -help").expect_code(0);
}

#[test]
fn unusable_arguments_exit_with_2_and_say_what_is_expected() {
    let place = Place::new();
    let cases = [
        ("render --light-prob 2", ["'2'", "[0, 1]"]),
        ("render --light-prob -0.5", ["'-0.5'", "[0, 1]"]),
        ("render --light-prob nan", ["'nan'", "[0, 1]"]),
        ("render --strategy best", ["'best'", "light, bsdf, mis_all, mis"]),
        ("render --heuristic best", ["'best'", "balance, power, cutoff, maximum"]),
        ("render --weights best", ["'best'", "veach, tutorial"]),
        ("render --sampler best", ["'best'", "stratified, lattice, sobol"]),
        ("render --spp 0", ["'0'", "from 1"]),
        ("render --spp -4", ["'-4'", "from 1"]),
        ("render --spp 1e3", ["'1e3'", "whole number"]),
        ("render --seed -1", ["'-1'", "from 0"]),
        ("render --nthreads many", ["'many'", "whole number"]),
        ("render --size 800", ["'800'", "800x800"]),
        ("render --size 0x10", ["'0x10'", "1 to 65536"]),
        ("render --size 65536x65536", ["65536 x 65536", "at most"]),
        ("render --cropwindow 0 1 0", ["4 values", "3"]),
        ("render --cropwindow 0 1 0 1.5", ["'1.5'", "[0, 1]"]),
        ("render --cropwindow 0.5 0.5 0 1", ["0.5 0.5 0 1", "x0 < x1"]),
        ("render --alpha plate9=0.1", ["\"plate9\" is not in the scene", "plate1, plate2, plate3, plate4"]),
        ("render --alpha floor=0.1", ["\"floor\" has no roughness", "plate1, plate2, plate3, plate4"]),
        ("render --alpha plate1", ["'plate1'", "NAME=VALUE"]),
        ("render --alpha plate1=1.5", ["'plate1=1.5'", "[0, 1]"]),
        ("render --outfile picture.tga", ["'picture.tga'", ".exr or .png"]),
        ("render --spp 4 --spp 8", ["--spp", "multiple times"]),
        ("render --brightness 3", ["--brightness", "unexpected"]),
        ("table --format pdf", ["'pdf'", "md, csv, json"]),
        ("table --size 5", ["'5'", "800x800"]),
        ("converge --strategies light,best", ["'best'", "light, bsdf, mis_all, mis"]),
        ("converge --at 4,2", ["'4,2'", "ascending"]),
        ("converge --at 1,3,...,10", ["'1,3,...,10'", "power of 3"]),
        ("converge --replicates 1", ["'1'", "2 to 1000"]),
        ("converge --csv - --json -", ["--csv -", "at most one"]),
        ("bench --seconds -1", ["'-1'", "from 0 to 3600"]),
        ("bench --seconds nan", ["'nan'", "from 0 to 3600"]),
        ("compare a.exr", ["<B.exr>", "required"]),
        ("info", ["<FILE.exr>", "required"]),
    ];
    for (line, parts) in cases {
        let ran = place.run(line);
        ran.expect_code(2).expect_err(&parts);
        assert_eq!(ran.out, "", "{line}");
    }
    assert!(place.files().is_empty(), "nothing was written: {:?}", place.files());
}

#[test]
fn failed_runs_exit_with_1_and_say_where() {
    let place = Place::new();
    place.write("text.exr", "not a picture");
    place.write("bad.pbrt", "Film \"image\"\n  Integrator \"veachMis\"\nWorldBegin\nWorldEnd\n");
    place.write("film.pbrt", &scene_with_header("Film \"image\" \"string filename\" [\"a.pfm\"]"));
    place.write("colon.pbrt", &scene_with_header("Film \"image\" \"string filename\" [\"a?b.exr\"]"));
    place.write("old.exr", "an older file");
    let before = place.files();
    let cases: [(&str, &[&str]); 16] = [
        ("render none.pbrt", &["none.pbrt: cannot read: no such file in /"]),
        ("render bat.pbrt", &["bat.pbrt: cannot read", "did you mean \"bad.pbrt\"?"]),
        ("info txt.exr", &["txt.exr: cannot read", "did you mean \"text.exr\"?"]),
        ("render none.exr", &["none.exr: "]),
        ("render text.exr", &["text.exr: "]),
        ("render bad.pbrt", &["bad.pbrt:2:"]),
        ("render film.pbrt", &["film.pbrt: ", "a.pfm", "--outfile"]),
        ("render --outfile none/a.exr", &["none/a.exr: cannot save", "none"]),
        ("render --json none/a.json", &["none/a.json: cannot save"]),
        ("render --outfile CON.exr", &["CON.exr: cannot save: Windows keeps the name CON"]),
        ("render --outfile a:b.exr", &["a:b.exr: cannot save: Windows cannot hold :"]),
        ("render colon.pbrt", &["a?b.exr: cannot save: Windows cannot hold ?"]),
        (&format!("render --outfile {}.exr", "x".repeat(300)), &["300 bytes, expected at most 200"]),
        ("converge --csv nul.csv", &["nul.csv: cannot save"]),
        ("compare text.exr old.exr", &["text.exr: "]),
        ("info text.exr", &["text.exr: "]),
    ];
    for (line, parts) in cases {
        let ran = place.run(line);
        ran.expect_code(1).expect_err(parts);
        assert_eq!(ran.out, "", "{line}");
    }
    assert_eq!(place.files(), before, "nothing was written");
    let place_of_error = place.run("render bad.pbrt").err;
    assert!(place_of_error.starts_with("bad.pbrt:2:"), "the place stands first: {place_of_error}");
}

/// Whoever opens a pipe to read waits for somebody who writes.
#[test]
#[cfg(unix)]
fn pipes_are_refused_wherever_a_file_is_read() {
    let place = Place::new();
    place.run(&format!("{SMALL} --outfile a.exr")).expect_code(0);
    for name in ["pipe.exr", "pipe.pbrt"] {
        assert!(Command::new("mkfifo").arg(place.path(name)).status().expect("mkfifo is there").success());
    }
    for line in [
        "info pipe.exr",
        "compare a.exr pipe.exr",
        "compare pipe.exr a.exr",
        "render pipe.exr",
        "render pipe.pbrt",
        "table pipe.exr",
        "pipe.exr",
    ] {
        place.run(line).expect_code(1).expect_err(&["not a regular file"]);
    }
}

/// Numbers never replace a scene or a picture, and nothing is written into a pipe that nobody reads.
#[test]
fn results_do_not_replace_what_they_are_about() {
    let place = Place::new();
    place.write("a.pbrt", &scene_with_header(""));
    let before = std::fs::read(place.path("a.pbrt")).expect("a file");
    for line in [
        "render a.pbrt --spp 1 --size 8x8 --outfile o.exr --json a.pbrt",
        "render a.pbrt --spp 1 --size 8x8 --outfile o.exr --json o.exr",
        "converge a.pbrt --size 8x8 --csv a.pbrt",
    ] {
        place.run(line).expect_code(2).expect_err(&["scene or picture", "numbers.json"]);
    }
    assert_eq!(std::fs::read(place.path("a.pbrt")).expect("a file"), before);
    assert!(!place.files().iter().any(|name| name == "o.exr"), "refused before anything is rendered");
    #[cfg(unix)]
    {
        let made = std::process::Command::new("mkfifo").arg(place.path("p.exr")).status();
        assert!(made.is_ok_and(|status| status.success()), "a pipe");
        let line = "render a.pbrt --spp 1 --size 8x8 --outfile p.exr";
        place.run(line).expect_code(1).expect_err(&["p.exr", "pipe or device"]);
    }
}

#[test]
fn a_misspelt_command_opens_no_window() {
    let place = Place::new();
    for line in ["rendr", "rendr a.pbrt", "rendr --spp 4"] {
        let ran = place.run(line);
        ran.expect_code(2).expect_err(&["\"rendr\" is neither a command nor a file", "did you mean render?"]);
        assert!(!ran.err.contains("No window"), "{}", ran.err);
    }
    assert!(place.files().is_empty());
}

#[test]
fn help_names_every_command_and_option() {
    let place = Place::new();
    let help = place.run("--help");
    help.expect_code(0);
    for command in ["render", "table", "converge", "compare", "info", "bench"] {
        assert!(help.out.contains(command), "{command}");
    }
    let help = place.run("render --help").out;
    let options = "strategy light-prob heuristic weights sampler spp seed nthreads size cropwindow alpha outfile json quiet quick";
    for option in options.split(' ') {
        assert!(help.contains(&format!("--{option}")), "{option}");
    }
    assert!(place.run("--version").out.starts_with("mislab "));
    assert!(Path::new(env!("CARGO_BIN_EXE_mislab")).exists());
}
