//! `mislab compare`.

use mislab_renderer::snapshot::Contents;
use mislab_renderer::{FrameStats, snapshot};
use serde_json::Value;

use crate::place::Place;

#[test]
fn compare_says_how_far_apart() {
    let place = Place::new();
    for (file, seed, size) in [("a.exr", 1, "16x16"), ("b.exr", 2, "16x16"), ("c.exr", 1, "8x8")] {
        place.run(&format!("render --size {size} --spp 4 --seed {seed} --quiet --outfile {file}")).expect_code(0);
    }
    let text = place.run("compare a.exr b.exr --json d.json");
    text.expect_code(0);
    for part in ["A: a.exr", "B: b.exr", "mean A", "MSE", "relMSE", "max |A-B|", "RGB", "light.G", "variance.Y"] {
        assert!(text.out.contains(part), "no {part} in {}", text.out);
    }
    let report: Value =
        serde_json::from_slice(&std::fs::read(place.path("d.json")).expect("the JSON file")).expect("JSON");
    assert_eq!(report, place.json("compare a.exr b.exr"), "a file and standard output get the same");
    assert_eq!((&report["a"], &report["b"], &report["identical"]), (&"a.exr".into(), &"b.exr".into(), &false.into()));
    assert_eq!(report["channels"].as_array().map(Vec::len), Some(13));
    for key in ["name", "mean_a", "mean_b", "mse", "rel_mse", "maximum"] {
        assert!(!report["channels"][0][key].is_null(), "{key}: {report}");
    }

    // The numbers, from the pixels.
    let (a, b) = (place.image("a.exr"), place.image("b.exr"));
    let (a, b) = (a.channel("G").expect("green"), b.channel("G").expect("green"));
    let mse = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>() / a.len() as f64;
    let channels = report["channels"].as_array().expect("a list");
    let green = channels.iter().find(|channel| channel["name"] == "G").expect("green");
    let found = green["mse"].as_f64().expect("a number");
    assert!((found / mse - 1.0).abs() < 1e-5, "{found}, expected {mse}");

    assert!(place.run("compare a.exr a.exr").out.contains("Every value is the same"));
    place.run("compare a.exr c.exr").expect_code(1).expect_err(&["16 x 16", "8 x 8"]);
}

#[test]
fn compare_takes_a_crop_with_the_whole_and_counts_holes_by_picture() {
    let place = Place::new();
    let line = "render --size 16x16 --spp 2 --sampler independent --quiet";
    place.run(&format!("{line} --outfile full.exr")).expect_code(0);
    place.run(&format!("{line} --outfile part.exr --cropwindow 0.25 0.5 0.5 1")).expect_code(0);
    let report = place.json("compare part.exr full.exr");
    assert_eq!(report["identical"], true, "{report}");
    assert_eq!((&report["window"]["min"], &report["window"]["size"]), (&[4, 8].into(), &[4, 8].into()));
    assert_eq!(report["window_b"]["size"], serde_json::json!([16, 16]));
    let text = place.run("compare part.exr full.exr");
    assert!(text.out.contains("a part of B's 16 x 16 at (0 0)"), "{}", text.out);
    assert!(text.out.contains("Every value of these pixels is the same"), "{}", text.out);

    // A picture like the part, with a hole.
    let mut image = place.image("part.exr");
    let (_, red) = image.channels.iter_mut().find(|(name, _)| name == "R").expect("red");
    red[3] = f32::NAN;
    let request = snapshot::restore(&place.path("part.exr")).expect("a snapshot").request;
    let bounds = request.settings.pixel_bounds();
    let stats =
        FrameStats { paths: 0, render_seconds: 0.0, cpu_seconds: 0.0, threads: 1, simd: "", invalid_samples: 0 };
    let contents = Contents { request: request.into(), bounds, spp: 2, stats, layers: image.channels };
    contents.save(&place.path("hole.exr"), &snapshot::SaveOptions::default()).expect("saves");
    let ran = place.run("compare hole.exr part.exr");
    ran.expect_code(0);
    let rgb = ran.out.lines().find(|line| line.starts_with("RGB")).expect("the layer");
    assert!(rgb.ends_with("1 in A only"), "{rgb}");
    assert_eq!(rgb.split_whitespace().nth(3), Some("-"), "no MSE of 0: {rgb}");
    assert_eq!(place.json("compare part.exr hole.exr")["layers"][0]["undefined_in_b"], 1);
}

/// The tutorial compares pictures of 800 and of 600 pixels.
#[test]
fn compare_resamples_pictures_of_other_sizes_if_asked_to() {
    let place = Place::new();
    place.run("render --size 32x32 --spp 4 --outfile a.exr --quiet").expect_code(0);
    place.run("render --size 24x24 --spp 4 --outfile b.exr --quiet").expect_code(0);
    place.run("compare a.exr b.exr").expect_code(1).expect_err(&["32 x 32", "24 x 24", "--resample"]);
    let ran = place.run("compare a.exr b.exr --resample");
    ran.expect_code(0);
    for part in ["grid of 24 x 24", "means over areas", "32 x 32"] {
        assert!(ran.out.contains(part), "{part}: {}", ran.out);
    }
    let ran = place.run("compare a.exr b.exr --resample --json -");
    let report: Value = serde_json::from_str(&ran.out).expect("JSON");
    assert_eq!(report["resampled"], serde_json::json!([24, 24]));
    let (a, b) = (&report["layers"][0]["mean_a"], &report["layers"][0]["mean_b"]);
    let [a, b] = [a, b].map(|mean| mean.as_f64().expect("a number"));
    assert!((a / b - 1.0).abs() < 0.2, "the same scene: {a} and {b}");
    let same = place.run("compare a.exr a.exr --resample");
    assert!(same.out.contains("Every value is the same") && !same.out.contains("grid"), "{}", same.out);
}
