//! `mislab inspect`, `replay` and `fireflies`, as their users meet them.

use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

use mislab_renderer::Strategy;
use serde_json::{Value, json};

/// A folder of its own to run the program in.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn output(&self, line: &str) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_mislab"));
        command.args(line.split_whitespace()).current_dir(self.0.path()).stdin(Stdio::null());
        command.output().expect("the program starts")
    }

    /// What `mislab LINE` prints.
    fn run(&self, line: &str) -> String {
        let output = self.output(line);
        let err = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "mislab {line}\n{err}");
        String::from_utf8(output.stdout).expect("UTF-8 text")
    }

    /// What `mislab LINE --json -` prints.
    fn json(&self, line: &str) -> Value {
        let out = self.run(&format!("{line} --json -"));
        serde_json::from_str(&out).unwrap_or_else(|e| panic!("{line}: not JSON ({e}): {out}"))
    }

    /// Exit code and messages of `mislab LINE`, which prints nothing else.
    fn fails(&self, line: &str) -> (Option<i32>, String) {
        let output = self.output(line);
        assert!(output.stdout.is_empty(), "mislab {line}: {}", String::from_utf8_lossy(&output.stdout));
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    }
}

#[track_caller]
fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("no number: {value}"))
}

#[track_caller]
fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap_or_else(|| panic!("no list: {value}"))
}

/// Plate 2 of the default scene at 80 x 80.
const PIXEL: &str = "--size 80x80 --pixel 44 42";

#[test]
fn inspect_says_what_is_true_of_a_pixel() {
    let place = Place::new();
    let found = place.json(&format!("inspect {PIXEL} --light-prob 0.25"));
    for key in ["shape", "material", "alpha", "mirror", "position", "normal", "wo", "emitted"] {
        assert!(!found["surface"][key].is_null(), "{key}: {found}");
    }
    let mean = number(&found["mean"]);
    assert!(mean > 0.0 && number(&found["tolerance"]) < 1e-3, "{found}");
    for strategy in Strategy::ALL {
        let of = &found["strategies"][strategy.name()];
        let (variance, second) = (number(&of["variance"]), number(&of["second_moment"]));
        assert!((second - variance - mean * mean).abs() <= 1e-6 * second, "{}: {of}", strategy.name());
        assert_eq!(of["biased"], json!(false), "{}", strategy.name());
    }
    let one = &found["one_sample"];
    let (best, least) = (number(&one["best_c"]), number(&one["variance_at_best_c"]));
    let curve = list(&one["curve"]);
    assert_eq!(curve.len(), 101);
    for (k, at) in curve.iter().enumerate() {
        assert!((number(&at["c"]) - k as f64 / 100.0).abs() < 1e-6, "{at}");
        let second = number(&at["veach"]);
        assert!(second - mean * mean >= least * (1.0 - 1e-6), "below the best, {best}: {at}");
        if (1..100).contains(&k) {
            assert!(number(&at["tutorial"]) >= second * (1.0 - 1e-9), "{at}");
        }
    }
    // Both weights are the same at c = 1/2, and the strategy is a point of the curve.
    assert_eq!(curve[50]["veach"], curve[50]["tutorial"]);
    let own = number(&found["strategies"]["mis"]["second_moment"]);
    assert!((number(&curve[25]["veach"]) - own).abs() <= 1e-9 * own, "{own}, {}", curve[25]);
    let lights = list(&found["lights"]);
    assert_eq!(lights.len(), 4);
    let shares: f64 = lights.iter().map(|light| number(&light["share"])).sum();
    assert!((shares - 1.0).abs() < 1e-6, "{lights:?}");
    for light in lights {
        // Spheres that do not hide each other: 1 / n over their solid angle.
        let expected = 0.25 / number(&light["solid_angle"]);
        assert!((number(&light["p_light"]) - expected).abs() <= 1e-4 * expected, "{light}");
        assert!(light["name"].as_str().is_some_and(|name| name.starts_with("light")), "{light}");
    }
    let text = place.run(&format!("inspect {PIXEL}"));
    for part in ["by quadrature", "tolerance", "W/(m^2 sr)", "mis_all", "best c", "p_L (1/sr)", "size (sr)", "alpha"] {
        assert!(text.contains(part), "no {part:?} in {text}");
    }
}

#[test]
fn inspect_hears_the_render_options() {
    let place = Place::new();
    let base = place.json(&format!("inspect {PIXEL}"));
    let rough = place.json(&format!("inspect {PIXEL} --alpha plate2=0.4 --alpha plate1=0.4"));
    assert_ne!(base["mean"], rough["mean"]);
    let power = place.json(&format!("inspect {PIXEL} --heuristic power"));
    assert_eq!(base["mean"], power["mean"]);
    assert_ne!(base["strategies"]["mis_all"]["variance"], power["strategies"]["mis_all"]["variance"]);
    let tutorial = place.json(&format!("inspect {PIXEL} --weights tutorial --light-prob 1"));
    assert_eq!(tutorial["strategies"]["mis"]["biased"], json!(true));
    let curve = list(&tutorial["one_sample"]["curve"]);
    assert!(curve[0]["tutorial"].is_null() && curve[100]["tutorial"].is_null(), "biased ends");
    let text = place.run(&format!("inspect {PIXEL} --weights tutorial --light-prob 1"));
    assert!(text.contains("biased"), "{text}");
    place.run(&format!("inspect {PIXEL} --json a.json"));
    let saved = std::fs::read_to_string(place.path("a.json")).expect("the file is written");
    assert_eq!(serde_json::from_str::<Value>(&saved).expect("JSON"), base);
}

#[test]
fn replayed_samples_are_those_of_the_picture() {
    let place = Place::new();
    let options = "--size 80x80 --spp 8 --seed 5 --light-prob 0.4";
    for strategy in Strategy::ALL {
        let name = strategy.name();
        place.run(&format!(
            "render {options} --strategy {name} --cropwindow 0.5 0.6 0.5 0.6 --outfile {name}.exr --quiet"
        ));
        let image = mislab_renderer::snapshot::load_image(&place.path(&format!("{name}.exr"))).expect("a picture");
        let (x, y) = (44, 42);
        let at = (y - image.window.min[1] as usize) * image.window.size[0] as usize + x - image.window.min[0] as usize;
        let mut sum = 0.0f64;
        for index in 0..8 {
            let found = place.json(&format!("replay {name}.exr --pixel {x} {y} --index {index}"));
            let same = place.json(&format!("replay {options} --strategy {name} --pixel {x} {y} --index {index}"));
            for key in ["technique", "wi", "f", "p_light", "p_bsdf", "weight", "value", "random", "rays"] {
                assert!(found.get(key).is_some(), "{name}: no {key} in {found}");
                assert_eq!(found[key], same[key], "{name} {index}: {key} from the picture and from the scene");
            }
            let rays = list(&found["rays"]);
            assert_eq!(rays.len(), strategy.rays_per_sample() as usize, "{name}: {found}");
            sum += rays.iter().map(|ray| number(&ray["value"][1])).sum::<f64>();
            let number_of_choice = &found["random"]["technique"];
            if strategy == Strategy::Mis {
                let light = number(number_of_choice) < 0.4;
                assert_eq!(found["technique"], json!(if light { "light" } else { "bsdf" }), "{found}");
            } else {
                assert!(number_of_choice.is_null(), "{name}: {found}");
            }
        }
        let film = f64::from(image.channel("G").expect("a channel")[at]);
        assert!((sum / 8.0 - film).abs() <= 1e-6 * film, "{name}: {} is not the picture's {film}", sum / 8.0);
    }
    // One of them hits a light.
    let of = |index| place.run(&format!("replay {options} --strategy mis --pixel 44 42 --index {index}"));
    let text: String = (0..8).map(of).collect();
    for part in ["c = 0.4", "wi", "p_L", "p_B", "weight w", "value", "1/sr", "with weight", "luminance"] {
        assert!(text.contains(part), "no {part:?} in {text}");
    }
}

#[test]
fn fireflies_of_a_scene_and_of_its_picture_are_the_same() {
    let place = Place::new();
    place.run("render --size 64x64 --spp 16 --strategy bsdf --outfile a.exr --quiet");
    let found = place.json("fireflies a.exr --count 6 --quiet");
    let outliers = list(&found["outliers"]);
    assert_eq!(outliers.len(), 6);
    let values: Vec<f64> = outliers.iter().map(|outlier| number(&outlier["value"])).collect();
    assert!(values.is_sorted_by(|a, b| a >= b), "{values:?}");
    for outlier in outliers {
        let [x, y] = [0, 1].map(|axis| number(&outlier["pixel"][axis]));
        assert_eq!(outlier["technique"], json!("bsdf"));
        let share = number(&outlier["share_of_pixel"]);
        assert!(share > 0.1 && share <= 1.0 + 1e-6, "{outlier}");
        let replayed = place.json(&format!("replay a.exr --pixel {x} {y} --index {}", outlier["index"]));
        let rgb = [0, 1, 2].map(|c| number(&replayed["value"][c]));
        let luminance = 0.212_671 * rgb[0] + 0.715_160 * rgb[1] + 0.072_169 * rgb[2];
        assert!((luminance - number(&outlier["value"])).abs() <= 1e-5 * luminance, "{outlier}, {replayed}");
    }
    // The same from the scene, whose header asks for the same picture.
    let text = mislab_renderer::pbrt::DEFAULT_SCENE;
    let camera = text.find("LookAt").expect("the scene has a camera");
    let header = "Film \"image\" \"integer xresolution\" [64] \"integer yresolution\" [64]\n\
                  Sampler \"stratified\" \"integer xsamples\" [4] \"integer ysamples\" [4] \"bool jitter\" [\"true\"]\n\
                  Integrator \"veachMIS\" \"string MISstrategy\" [\"bsdf\"]\n";
    std::fs::write(place.path("a.pbrt"), format!("{header}{}", &text[camera..])).expect("the folder can be written to");
    let scene = place.json("fireflies a.pbrt --count 6 --quiet");
    assert_eq!(scene["outliers"], found["outliers"]);
    let text = place.run("fireflies a.exr --quiet");
    for part in ["value", "of pixel", "without it", "mis_all", "16 spp"] {
        assert!(text.contains(part), "no {part:?} in {text}");
    }
}

#[test]
fn what_cannot_be_asked_is_said_with_what_could() {
    let place = Place::new();
    place.run("render --size 16x12 --spp 4 --cropwindow 0.5 1 0 1 --outfile a.exr --quiet");
    std::fs::write(place.path("b.exr"), "not a picture").expect("the folder can be written to");
    for (line, code, parts) in [
        ("inspect --pixel 800 0", 2, &["--pixel 800 0", "x from 0 to 799"][..]),
        ("inspect --size 16x12 --pixel 3 12", 2, &["--pixel 3 12", "y from 0 to 11"]),
        ("replay a.exr --pixel 3 4 --index 0", 2, &["--pixel 3 4", "x from 8 to 15"]),
        ("replay a.exr --pixel 9 4 --index 4", 2, &["--index 4", "from 0 to 3"]),
        ("inspect --pixel 3", 2, &["--pixel <X> <Y>", "2 values"]),
        ("inspect --pixel -1 2", 2, &["-1", "whole number"]),
        ("inspect --pixel 1.5 2", 2, &["1.5", "whole number"]),
        ("inspect", 2, &["--pixel"]),
        ("replay --pixel 1 2", 2, &["--index"]),
        ("replay --pixel 1 2 --index x", 2, &["x", "whole number"]),
        ("fireflies a.exr --count 0", 2, &["0", "from 1 to 1000"]),
        ("fireflies b.exr", 1, &["b.exr"]),
        ("replay missing.exr --pixel 1 2 --index 0", 1, &["missing.exr"]),
        ("inspect --size 16x12 --pixel 3 4 --json a.exr", 2, &["a.exr", "numbers.json"]),
        ("inspect --size 16x12 --pixel 3 4 --alpha nothing=0.1", 2, &["nothing"]),
    ] {
        let (found, message) = place.fails(line);
        assert_eq!(found, Some(code), "mislab {line}: {message}");
        for part in parts {
            assert!(message.contains(part), "mislab {line}: no {part:?} in {message}");
        }
    }
}

#[test]
fn pixels_without_a_surface_are_said_to_have_none() {
    let place = Place::new();
    let header = "Film \"image\" \"integer xresolution\" [80] \"integer yresolution\" [60]\n";
    let scene = "Camera \"perspective\" \"float fov\" [40]\nWorldBegin\nAttributeBegin\n\
                 Material \"matte\" \"rgb Kd\" [0 0 0]\n\
                 AreaLightSource \"diffuse\" \"rgb L\" [2 3 4]\nTranslate 0 0 5\nShape \"sphere\" \"float radius\" [1]\n\
                 AttributeEnd\nWorldEnd\n";
    std::fs::write(place.path("lamp.pbrt"), format!("{header}{scene}")).expect("the folder can be written to");
    let (code, message) = place.fails("inspect lamp.pbrt --pixel 0 0 --quiet");
    assert_eq!(code, Some(1), "{message}");
    assert!(message.contains("pixel 0 0 shows nothing") && message.contains("expected a surface"), "{message}");
    let (code, message) = place.fails("inspect lamp.pbrt --pixel 40 30 --quiet");
    assert_eq!(code, Some(1), "{message}");
    assert!(message.contains("a light itself") && message.contains("expected a surface"), "{message}");
    // A sample there is one all the same.
    let seen = place.json("replay lamp.pbrt --pixel 40 30 --index 0 --quiet");
    assert!(seen["technique"].is_null() && list(&seen["rays"]).is_empty(), "{seen}");
    assert_eq!(seen["emitted"], json!([2.0, 3.0, 4.0]));
    let none = place.json("replay lamp.pbrt --pixel 0 0 --index 0 --quiet");
    assert_eq!(number(&none["luminance"]), 0.0, "{none}");
    assert!(place.run("fireflies lamp.pbrt --quiet").contains("No sample outweighs"), "nothing is reflected");
}
