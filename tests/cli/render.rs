//! `mislab render`: what it renders and says of it.

use mislab_renderer::snapshot;
use serde_json::Value;

use crate::place::{Place, SMALL, scene_with_header};

#[test]
fn json_holds_what_was_done() {
    let place = Place::new();
    let report = place.json("render --size 20x10 --spp 6 --outfile a.exr");
    let expected = [
        ("scene", "embedded"),
        ("outfile", "a.exr"),
        ("strategy", "mis_all"),
        ("heuristic", "balance"),
        ("weights", "veach"),
        ("sampler", "stratified"),
        ("version", env!("CARGO_PKG_VERSION")),
    ];
    for (key, value) in expected {
        assert_eq!(report[key], value, "{key}");
    }
    for (key, value) in [("spp", 6), ("seed", 1), ("width", 20), ("height", 10), ("invalid_samples", 0)] {
        assert_eq!(report[key], value, "{key}");
    }
    assert_eq!(report["light_prob"], 0.5);
    assert_eq!(report["strata"], serde_json::json!([2, 3]));
    assert_eq!(report["jitter"], true);
    assert_eq!(report["pixel_bounds"], serde_json::json!([0, 20, 0, 10]));
    assert_eq!(report["paths"], 20 * 10 * 6 * 2, "mis_all traces two secondary rays per camera ray");
    let number = |key: &str| report[key].as_f64().unwrap_or_else(|| panic!("{key} is no number: {report}"));
    assert!(number("threads") >= 1.0);
    assert!(number("render_seconds") > 0.0 && number("cpu_seconds") > 0.0);
    let rate = number("paths") * 1e-6 / number("render_seconds");
    assert!((number("mpaths_per_second") / rate - 1.0).abs() < 1e-6);
    assert!(report["simd"].as_str().is_some_and(|name| !name.is_empty()));
}

#[test]
fn every_flag_is_heard() {
    let place = Place::new();
    let report = place.json(
        "render --strategy mis --light-prob 0.25 --heuristic power --weights tutorial --sampler sobol --spp 5 --seed 77 \
         --nthreads 3 --size 32x24 --cropwindow 0.25 0.75 0 0.5 --alpha plate1=0.3 --alpha plate4=0 --outfile b.exr --quiet",
    );
    for (key, value) in [("strategy", "mis"), ("heuristic", "power"), ("weights", "tutorial"), ("sampler", "sobol")] {
        assert_eq!(report[key], value, "{key}");
    }
    let numbers = [("spp", 5), ("seed", 77), ("threads", 3), ("width", 32), ("height", 24), ("paths", 16 * 12 * 5)];
    for (key, value) in numbers {
        assert_eq!(report[key], value, "{key}");
    }
    assert_eq!(report["light_prob"], 0.25);
    assert_eq!(report["strata"], Value::Null);
    assert_eq!(report["pixel_bounds"], serde_json::json!([8, 24, 0, 12]));

    let restored = snapshot::restore(&place.path("b.exr")).expect("a snapshot");
    let alpha = |name: &str| restored.request.scene.material(name).and_then(|m| m.bsdf.alpha());
    assert_eq!(alpha("plate1"), Some(0.3));
    assert_eq!(alpha("plate2"), Some(0.02), "not named");
    assert_eq!(alpha("plate4"), Some(0.0));

    for sampler in ["stratified", "lattice", "sobol", "independent", "padded_stratified", "padded_sobol"] {
        assert_eq!(place.json(&format!("{SMALL} --sampler {sampler}"))["sampler"], sampler);
    }
    for heuristic in ["balance", "power", "cutoff", "maximum"] {
        assert_eq!(place.json(&format!("{SMALL} --heuristic {heuristic}"))["heuristic"], heuristic);
    }
    for strategy in ["light", "bsdf", "mis_all", "mis"] {
        assert_eq!(place.json(&format!("{SMALL} --strategy {strategy}"))["strategy"], strategy);
    }
    for weights in ["veach", "tutorial"] {
        assert_eq!(place.json(&format!("{SMALL} --weights {weights}"))["weights"], weights);
    }
}

#[test]
fn quick_is_a_quarter_of_the_size_and_few_samples() {
    let place = Place::new();
    let report = place.json("render --quick");
    assert_eq!((&report["width"], &report["height"], &report["spp"]), (&200.into(), &200.into(), &4.into()));
    let named = place.json("render --quick --size 12x8 --spp 9");
    assert_eq!((&named["width"], &named["height"], &named["spp"]), (&12.into(), &8.into(), &9.into()));
    place.write("one.pbrt", &scene_with_header("Film \"image\" \"integer xresolution\" [40] \"integer yresolution\" [2]\nSampler \"random\" \"integer pixelsamples\" [2]"));
    let few = place.json("render one.pbrt --quick");
    assert_eq!(
        (&few["width"], &few["height"], &few["spp"]),
        (&10.into(), &1.into(), &2.into()),
        "never more than asked for"
    );
}

#[test]
fn standard_output_is_for_results_and_a_pipe_gets_no_bar() {
    let place = Place::new();
    let ran = place.run("render --size 16x12 --spp 64");
    ran.expect_code(0);
    assert_eq!(ran.out, "");
    assert_eq!(ran.err.lines().count(), 1, "only the summary: {}", ran.err);
    ran.expect_err(&["veach_mis.exr: mis_all, 64 spp, ", "24.6 k paths in ", "Mpaths/s"]);
    assert_eq!(place.files(), ["veach_mis.exr"], "the Film's filename");
    let quiet = place.run(&format!("{SMALL} --outfile quiet.exr"));
    assert_eq!((quiet.out.as_str(), quiet.err.as_str()), ("", ""));
}

#[test]
fn a_crop_is_a_part_of_the_picture_at_any_number_of_threads() {
    let place = Place::new();
    let line = "render --size 40x32 --spp 3 --sampler independent --quiet";
    place.run(&format!("{line} --nthreads 1 --outfile full.exr")).expect_code(0);
    place.run(&format!("{line} --nthreads 3 --outfile part.exr --cropwindow 0.5 0.75 0.25 0.75")).expect_code(0);
    let (full, part) = (place.image("full.exr"), place.image("part.exr"));
    assert_eq!((part.window.min, part.window.size, part.display.size), ([20, 8], [10, 16], [40, 32]));
    for (name, values) in &part.channels {
        let full = full.channel(name).expect("the same channels");
        for (i, value) in values.iter().enumerate() {
            let (x, y) = (20 + i % 10, 8 + i / 10);
            assert_eq!(value.to_bits(), full[y * 40 + x].to_bits(), "{name} at {x}, {y}");
        }
    }
}

#[test]
fn a_picture_renders_again_to_the_same_bits() {
    let place = Place::new();
    let flags = "--strategy mis --light-prob 0.3 --alpha plate2=0.07 --spp 7 --seed 5 --cropwindow 0 1 0 0.5";
    place.run(&format!("render --size 32x32 --quiet {flags} --outfile one.exr")).expect_code(0);
    let report = place.json("render one.exr --quiet");
    assert_eq!((&report["outfile"], &report["scene"]), (&"one_again.exr".into(), &"one.exr".into()));
    assert_eq!(place.json("compare one.exr one_again.exr")["identical"], true);

    place.run("render one.exr --seed 6 --quiet --outfile other.exr").expect_code(0);
    let difference = place.json("compare one.exr other.exr");
    assert_eq!(difference["identical"], false);
    assert!(difference["layers"][0]["mse"].as_f64().is_some_and(|mse| mse > 0.0), "{difference}");
}

#[test]
fn a_png_is_the_picture_clipped_and_encoded() {
    let place = Place::new();
    for file in ["a.exr", "a.png"] {
        place.run(&format!("render --size 24x16 --spp 4 --quiet --outfile {file}")).expect_code(0);
    }
    let file = std::io::BufReader::new(std::fs::File::open(place.path("a.png")).expect("the PNG"));
    let mut reader = png::Decoder::new(file).read_info().expect("a PNG file");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a small picture")];
    let info = reader.next_frame(&mut bytes).expect("a PNG picture");
    assert_eq!((info.width, info.height, info.bit_depth), (24, 16, png::BitDepth::Eight));
    let samples = info.color_type.samples();
    let exr = place.image("a.exr");
    for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
        for (i, linear) in exr.channel(name).expect("a colour picture").iter().enumerate() {
            // IEC 61966-2-1
            let v = linear.clamp(0.0, 1.0);
            let encoded = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
            let found = f32::from(bytes[i * samples + channel]);
            assert!((encoded * 255.0 - found).abs() <= 1.0, "{name} of pixel {i}: {linear} became {found}");
        }
    }
}

#[test]
fn what_is_not_understood_is_said_once_and_does_not_stop() {
    let place = Place::new();
    place.write(
        "odd.pbrt",
        &scene_with_header("Frobnicate \"x\"\nFilm \"image\" \"string filename\" [\"odd.exr\"] \"float shine\" [2]"),
    );
    let ran = place.run("render odd.pbrt --size 8x8 --spp 1");
    ran.expect_code(0).expect_err(&["odd.pbrt:1:1: warning: ", "Frobnicate", "odd.pbrt:2:", "shine"]);
    assert_eq!(ran.err.matches("warning:").count(), 2, "{}", ran.err);
    assert_eq!(place.run("render odd.pbrt --size 8x8 --spp 1 --quiet --outfile odd.exr").err, "");
}

#[test]
fn a_black_picture_says_why_even_if_asked_to_be_quiet() {
    let place = Place::new();
    let room = "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [-4 -1 9  4 -1 9  0 4 9]";
    place.write("dark.pbrt", &format!("Camera \"perspective\"\nWorldBegin\nLightSource \"point\"\n{room}\nWorldEnd"));
    place.write("empty.pbrt", "Camera \"perspective\"\nWorldBegin\nWorldEnd");
    place.write(
        "away.pbrt",
        &format!(
            "LookAt 0 0 0 0 0 -1 0 1 0 Camera \"perspective\"\nWorldBegin AreaLightSource \"diffuse\"\n{room}\nWorldEnd"
        ),
    );
    for (scene, words) in
        [("dark", "no area light"), ("empty", "no shapes"), ("away", "nothing of the scene is in view")]
    {
        let line = format!("render {scene}.pbrt --size 8x8 --spp 1 --outfile a.exr");
        let quiet = place.run(&format!("{line} --quiet"));
        quiet.expect_code(0).expect_err(&["a.exr: warning: no light reaches this picture directly: ", words]);
        assert_eq!((quiet.err.lines().count(), quiet.out.as_str()), (1, ""), "{}", quiet.err);
        let report = place.json(&line);
        let warnings = report["warnings"].as_array().expect("a list");
        assert!(warnings.iter().any(|w| w.as_str().is_some_and(|w| w.contains(words))), "{warnings:?}");
    }
    assert_eq!(place.json("render --size 8x8 --spp 4")["warnings"], serde_json::json!([]));
    let mirror = "biased on plate1: a light sample never meets a mirror's one direction";
    assert_eq!(place.json("render --size 8x8 --spp 4 --strategy light")["warnings"], serde_json::json!([mirror]));
}

#[test]
fn bias_is_said() {
    let place = Place::new();
    let at =
        |c: &str| place.run(&format!("render --strategy mis --weights tutorial --light-prob {c} --size 8x8 --spp 1"));
    at("1").expect_code(0).expect_err(&["warning", "biased"]);
    at("0").expect_code(0).expect_err(&["warning", "biased"]);
    let unbiased = at("0.5");
    unbiased.expect_code(0);
    assert!(!unbiased.err.contains("biased"), "{}", unbiased.err);
}
