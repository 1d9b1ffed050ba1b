//! `mislab converge`.

use serde_json::Value;

use crate::place::{Place, scene_with_header};

#[test]
fn errors_are_measured_against_samples() {
    let place = Place::new();
    let ran = place.run(
        "converge --size 32x32 --strategies light,mis --at 1,2,...,8 --replicates 3 --by-square --csv c.csv --json -",
    );
    ran.expect_code(0);
    let report: Value = serde_json::from_str(&ran.out).expect("JSON");
    assert!(report["reference"]["spp"].as_u64() >= Some(32) && report["reference"]["rel_mse"].is_f64(), "{report}");
    let curves = report["curves"].as_array().expect("curves");
    assert_eq!(curves.iter().map(|c| c["strategy"].as_str()).collect::<Vec<_>>(), [Some("light"), Some("mis")]);
    for curve in curves {
        for key in ["heuristic", "weights", "sampler"] {
            assert!(curve[key].is_string(), "{key}: {curve}");
        }
        assert!(curve["light_prob"].is_f64() && curve["slope"].is_f64(), "{curve}");
        assert_eq!(curve["slope_interval"].as_array().map(Vec::len), Some(2));
        let squares = curve["squares"].as_array().expect("squares");
        assert_eq!(squares.len(), 4);
        assert!(squares.iter().all(|s| s["light"].is_string() && s["bsdf"].is_string()), "{curve}");
        for points in squares.iter().chain([curve]).map(|c| c["points"].as_array().expect("points")) {
            assert_eq!(points.iter().map(|p| p["spp"].as_u64()).collect::<Vec<_>>(), [1, 2, 4, 8].map(Some));
            for point in points {
                for key in ["rays", "cpu_seconds", "rel_mse", "standard_error"] {
                    assert!(point[key].is_number(), "{key}: {point}");
                }
            }
        }
    }
    let csv = std::fs::read_to_string(place.path("c.csv")).expect("a file");
    assert_eq!(csv.lines().count(), 1 + 2 * 5 * 4, "{csv}");

    place.run("render --size 32x32 --spp 64 --outfile r.exr --quiet").expect_code(0);
    let ran = place.run("converge --size 32x32 --at 4,8 --replicates 2 --reference r.exr --quiet");
    ran.expect_code(0);
    assert_eq!(ran.err, "");
    for part in ["mis_all", "slope", "r.exr", "64 spp"] {
        assert!(ran.out.contains(part), "{part}: {}", ran.out);
    }
    let ran = place.run("converge --size 16x16 --reference r.exr");
    ran.expect_code(1).expect_err(&["r.exr", "32 x 32", "16 x 16"]);
}

#[test]
fn a_black_picture_says_why_in_tables_and_curves() {
    let place = Place::new();
    let film = "Film \"image\" \"integer xresolution\" [16] \"integer yresolution\" [16]";
    let dark = scene_with_header(film).replace("AreaLightSource", "#");
    place.write("dark.pbrt", &dark);
    let why = "no light reaches this picture directly";
    let ran = place.run("converge dark.pbrt --quiet --at 1,2 --replicates 2 --strategies mis_all");
    ran.expect_err(&["dark.pbrt: warning: ", why]);
    assert!(!ran.out.contains("0.00000"), "one number format: {}", ran.out);
    // A table needs lights: they shine inwards.
    let inwards = scene_with_header(film).replace("AreaLightSource", "ReverseOrientation AreaLightSource");
    place.write("inwards.pbrt", &inwards);
    place.run("table inwards.pbrt --quiet --size 16x16").expect_err(&["veachMIS_MIS.exr: warning: ", why]);
}
