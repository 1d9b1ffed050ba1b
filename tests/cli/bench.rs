//! `mislab bench`.

use mislab_renderer::SamplerKind;
use serde_json::Value;

use crate::place::Place;

#[test]
fn the_benchmark_has_its_keys() {
    // What it measures is nobody's to test; that scripts find their numbers is.
    let place = Place::new();
    let ran = place.run("bench --seconds 0 --json bench.json");
    ran.expect_code(0).expect_err(&["measuring: threads"]);
    assert!(ran.out.contains("Mpaths/s per core"), "{}", ran.out);
    let text = std::fs::read_to_string(place.path("bench.json")).expect("the file is there");
    let report: Value = serde_json::from_str(&text).expect("JSON");
    for strategy in ["light", "bsdf", "mis_all", "mis"] {
        for key in ["simd", "scalar", "ratio"] {
            assert!(report["strategies"][strategy][key].as_f64().is_some_and(|v| v > 0.0), "{strategy}.{key}: {text}");
        }
    }
    for (group, key) in [
        ("threads", "count"),
        ("threads", "speedup"),
        ("first_frame_ms", "p50"),
        ("first_frame_ms", "p99"),
        ("cancel_ms", "p50"),
        ("cancel_ms", "p99"),
    ] {
        assert!(report[group][key].as_f64().is_some_and(|v| v > 0.0), "{group}.{key}: {text}");
    }
    for strategy in ["light", "bsdf", "mis_all", "mis"] {
        for sampler in SamplerKind::ALL.map(SamplerKind::name) {
            let value = &report["efficiency"][strategy][sampler];
            assert!(value.as_f64().is_some_and(|v| v > 0.0), "efficiency.{strategy}.{sampler}: {text}");
        }
    }
    assert!(report["layers_cost"].is_f64() && report["simd"].is_string(), "{text}");
}
