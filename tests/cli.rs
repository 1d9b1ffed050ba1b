//! The command line as its users meet it: the built program is run, and its output, files and exit codes are looked at.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use mislab_renderer::memory::Need;
use mislab_renderer::snapshot::Contents;
use mislab_renderer::{FrameStats, Request, SamplerKind, Strategy, pbrt, snapshot};
use serde_json::Value;

/// A folder of its own to run the program in.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).expect("the folder can be written to");
    }

    fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).expect("the folder can be read");
        let name = |entry: std::io::Result<std::fs::DirEntry>| entry.expect("an entry").file_name();
        let mut names: Vec<String> = entries.map(|entry| name(entry).to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_mislab"));
        command.args(line.split_whitespace()).current_dir(self.0.path()).stdin(Stdio::null());
        command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        command
    }

    /// Runs `mislab LINE`.
    fn run(&self, line: &str) -> Ran {
        Ran::new(line, self.command(line).output().expect("the program starts"))
    }

    /// Runs `mislab LINE --json -` and reads what it prints.
    fn json(&self, line: &str) -> Value {
        let ran = self.run(&format!("{line} --json -"));
        ran.expect_code(0);
        serde_json::from_str(&ran.out).unwrap_or_else(|e| panic!("{line}: not JSON ({e}): {}", ran.out))
    }

    fn image(&self, name: &str) -> snapshot::Image {
        snapshot::load_image(&self.path(name)).expect("an EXR file")
    }
}

struct Ran {
    line: String,
    code: Option<i32>,
    out: String,
    err: String,
}

impl Ran {
    fn new(line: &str, output: Output) -> Self {
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8 text");
        Self { line: line.to_owned(), code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
    }

    #[track_caller]
    fn expect_code(&self, code: i32) -> &Self {
        assert_eq!(self.code, Some(code), "mislab {}\n{}\n{}", self.line, self.out, self.err);
        self
    }

    #[track_caller]
    fn expect_err(&self, parts: &[&str]) -> &Self {
        for part in parts {
            assert!(self.err.contains(part), "mislab {}: no {part:?} in: {}", self.line, self.err);
        }
        self
    }
}

/// The shipped scene with other header lines, as the tutorial asks for.
fn scene_with_header(header: &str) -> String {
    let text = pbrt::DEFAULT_SCENE;
    let camera = text.find("LookAt").expect("the scene has a camera");
    format!("{header}\n{}", &text[camera..])
}

const SMALL: &str = "render --size 16x12 --spp 4 --quiet";

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
fn standard_output_is_for_results_and_a_pipe_gets_no_bar() {
    let place = Place::new();
    let ran = place.run("render --size 16x12 --spp 64");
    ran.expect_code(0);
    assert_eq!(ran.out, "");
    assert_eq!(ran.err.lines().count(), 1, "only the summary: {}", ran.err);
    ran.expect_err(&["veach_mis.exr: mis_all, 64 spp, ", "M paths in ", "Mpaths/s"]);
    assert_eq!(place.files(), ["veach_mis.exr"], "the Film's filename");
    let quiet = place.run(&format!("{SMALL} --outfile quiet.exr"));
    assert_eq!((quiet.out.as_str(), quiet.err.as_str()), ("", ""));
}

/// The tutorial's three headers as printed there, with the line breaks and quotation marks of its PDF.
#[test]
fn the_tutorials_headers_render_to_their_files() {
    let headers = [
        (
            "veachMIS_L.exr",
            "light",
            64,
            "Sampler “stratified” “integer xsamples” [8] “integer ysamples”\n[8] “bool jitter” [“true”]\n\
             Integrator “veachMIS” “string MISstrategy” [“light”]\n\
             Film “image” “string filename” [“veachMIS_L.exr”] “integer\nxresolution” [800] “integer yresolution” [800]",
        ),
        (
            "veachMIS_BSDF.exr",
            "bsdf",
            64,
            "Integrator \"veachMIS\" \"string MISstrategy\" [\"bsdf\"]\n\
             Film \"image\" \"string filename\" [\"veachMIS_BSDF.exr\"] \"integer\nxresolution\" [800] \"integer yresolution\" [800]",
        ),
        (
            "veach_MIS_ALLx36.exr",
            "mis_all",
            36,
            "Sampler \"stratified\" \"integer xsamples\" [6] \"integer ysamples\"\n[6] \"bool jitter\" [\"true\"]\n\
             Film \"image\" \"string filename\" [\"veach_MIS_ALLx36.exr\"] \"integer\nxresolution\" [600] \"integer yresolution\" [600]\n\
             SurfaceIntegrator \"veachMIS\" \"string sample_method\" [\"mis_all\"]",
        ),
    ];
    let place = Place::new();
    for (file, strategy, spp, header) in headers {
        place.write("veach_mis.pbrt", &scene_with_header(header));
        let report = place.json("render veach_mis.pbrt --size 40x40 --quiet");
        assert_eq!(report["outfile"], file);
        assert_eq!(report["strategy"], strategy, "{file}");
        assert_eq!(report["spp"], spp, "{file}");
        let image = place.image(file);
        assert_eq!(image.display.size, [40, 40]);
        assert_eq!(image.attribute("strategy"), Some(strategy));
    }
    assert_eq!(place.files(), ["veachMIS_BSDF.exr", "veachMIS_L.exr", "veach_MIS_ALLx36.exr", "veach_mis.pbrt"]);
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
fn unusable_arguments_exit_with_2_and_say_what_is_expected() {
    let place = Place::new();
    let cases = [
        ("render --light-prob 2", ["'2'", "[0, 1]"]),
        ("render --light-prob -0.5", ["'-0.5'", "[0, 1]"]),
        ("render --light-prob nan", ["'nan'", "[0, 1]"]),
        ("render --strategy best", ["'best'", "light, bsdf, mis_all, mis"]),
        ("render --heuristic best", ["'best'", "balance, power, cutoff, maximum"]),
        ("render --weights best", ["'best'", "veach, tutorial"]),
        ("render --sampler best", ["'best'", "stratified, independent, sobol"]),
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
fn another_programs_integrator_stands_in_the_pictures_name() {
    let place = Place::new();
    place.write(
        "path.pbrt",
        &scene_with_header("Integrator \"path\"\nFilm \"image\" \"string filename\" [\"veachMIS_L.exr\"]"),
    );
    let line = "render path.pbrt --size 8x8 --spp 1";
    let report = place.json(line);
    assert_eq!(report["outfile"], "veachMIS_L_mis_all.exr");
    let warnings = report["warnings"].as_array().expect("a list");
    assert!(warnings.len() == 1 && warnings[0].as_str().is_some_and(|w| w.contains("path")), "{warnings:?}");
    // The name says what was used, and whoever gives one is not contradicted.
    assert_eq!(place.json(&format!("{line} --strategy light"))["outfile"], "veachMIS_L_light.exr");
    assert_eq!(place.json(&format!("{line} --outfile mine.exr"))["outfile"], "mine.exr");
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

/// What is foreseen is what is taken, on the safe side: the peak of the whole process less what it takes for a tiny picture.
#[test]
#[cfg(target_os = "linux")]
fn the_memory_of_a_picture_is_foreseen() {
    let place = Place::new();
    let peak = |line: &str| {
        let mut child = place.command(line).stderr(Stdio::null()).spawn().expect("the program starts");
        let status = format!("/proc/{}/status", child.id());
        let mut peak = 0;
        while child.try_wait().expect("it can be asked").is_none() {
            let text = std::fs::read_to_string(&status).unwrap_or_default();
            let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
            let kilobytes = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<u64>().ok());
            peak = kilobytes.unwrap_or(0).max(peak);
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        peak * 1024
    };
    let nothing = peak("render --size 8x8 --spp 2 --quiet --outfile small.exr");
    for strategy in [Strategy::Light, Strategy::MisAll] {
        let name = strategy.name();
        let taken = peak(&format!("render --size 900x900 --spp 2 --strategy {name} --quiet --outfile {name}.exr"));
        let taken = taken.saturating_sub(nothing);
        let file = pbrt::embedded_scene();
        let mut settings = file.settings;
        settings.image.resolution = [900, 900];
        settings.estimator.strategy = strategy;
        settings.sampling.spp = std::num::NonZeroU32::new(2);
        let foreseen = Need::of(&Request { scene: std::sync::Arc::new(file.scene), settings }).total();
        let share = taken as f64 / foreseen as f64;
        assert!((0.7..1.0).contains(&share), "{name}: {taken} bytes of {foreseen} foreseen");
    }
}

/// With less memory than the picture takes there is a message, and no core dump.
#[test]
#[cfg(target_os = "linux")]
fn a_picture_too_large_for_the_memory_is_refused_in_words() {
    let place = Place::new();
    let program = env!("CARGO_BIN_EXE_mislab");
    let run = |line: &str| {
        // Kilobytes of address space.
        let script = format!("ulimit -v 1500000; exec {program} {line}");
        let mut command = Command::new("sh");
        command.args(["-c", &script]).current_dir(place.0.path()).stdin(Stdio::null());
        Ran::new(line, command.output().expect("a shell"))
    };
    let big = run("render --size 5000x5000 --spp 1 --nthreads 1 --outfile a.exr");
    big.expect_code(1).expect_err(&["takes about 3.9 GB", "film 2.6 GB", " are free", "crop window"]);
    assert!(place.files().is_empty());
    run("render --size 64x64 --spp 1 --nthreads 1 --quiet --outfile b.exr").expect_code(0);
    run("render --size 5000x5000 --cropwindow 0 0.1 0 0.1 --spp 1 --nthreads 1 --quiet --outfile c.exr").expect_code(0);
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

const TUTORIAL_FILES: [&str; 4] = ["veachMIS_BSDF.exr", "veachMIS_L.exr", "veachMIS_MIS.exr", "veach_MIS_ALLx36.exr"];

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

#[test]
fn the_table_in_all_formats_with_its_pictures() {
    let place = Place::new();
    let ran = place.run("table --size 24x24 --outdir lesson/pictures --format json");
    ran.expect_code(0).expect_err(&TUTORIAL_FILES);
    let table: Value = serde_json::from_str(&ran.out).expect("JSON");
    assert_eq!(table["rows"].as_array().map(Vec::len), Some(4));
    let folder = place.path("lesson/pictures");
    for (file, strategy, spp) in [
        ("veachMIS_L", "light", 64),
        ("veachMIS_BSDF", "bsdf", 64),
        ("veach_MIS_ALLx36", "mis_all", 36),
        ("veachMIS_MIS", "mis", 64),
    ] {
        let restored = snapshot::restore(&folder.join(format!("{file}.exr"))).expect("a snapshot");
        assert_eq!(restored.request.settings.estimator.strategy.name(), strategy);
        assert_eq!((restored.spp, restored.request.settings.image.resolution), (spp, [24, 24]));
    }

    let csv = place.run("table --size 24x24 --format csv --quiet");
    csv.expect_code(0);
    assert_eq!(csv.err, "");
    assert_eq!(csv.out.lines().count(), 1 + 4 * 4, "{}", csv.out);
    let markdown = place.run("table --size 24x24 --quiet -nthreads 2");
    markdown.expect_code(0);
    assert!(markdown.out.starts_with('|'), "{}", markdown.out);
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

/// A file named for one strategy does not get the picture of another.
#[test]
fn a_strategy_of_the_command_line_stands_in_the_pictures_name() {
    let place = Place::new();
    let film = "Film \"image\" \"integer xresolution\" [8] \"integer yresolution\" [8] \"string filename\" [\"veachMIS_L.exr\"]";
    let integrator = "Integrator \"veachMIS\" \"string MISstrategy\" [\"light\"]";
    place.write("a.pbrt", &scene_with_header(&format!("{film} {integrator}")));
    place.run("render a.pbrt --spp 1 --strategy bsdf").expect_code(0);
    place.run("render a.pbrt --spp 1 --strategy light").expect_code(0);
    let mut files = place.files();
    files.retain(|name| name.ends_with(".exr"));
    files.sort();
    assert_eq!(files, ["veachMIS_L.exr", "veachMIS_L_bsdf.exr"]);
}

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

/// Where no window can be opened, the lesson's results come all the same. The scene's own size keeps this short.
#[test]
fn without_a_display_the_pictures_and_the_table_are_made() {
    let place = Place::new();
    place.write(
        "small.pbrt",
        &scene_with_header("Film \"image\" \"integer xresolution\" [24] \"integer yresolution\" [20]"),
    );
    let ran = place.run("small.pbrt");
    ran.expect_code(0).expect_err(&["No window: ", "display", "pictures and table"]).expect_err(&TUTORIAL_FILES);
    assert!(ran.out.contains("veachMIS_MIS.exr") && ran.out.starts_with('|'), "{}", ran.out);
    for file in TUTORIAL_FILES {
        assert_eq!(place.image(file).display.size, [24, 20], "{file}");
    }
    let ran = place.run("none.pbrt");
    ran.expect_code(1).expect_err(&["none.pbrt: cannot read"]);
    assert!(!ran.err.contains("Rendering"), "nothing is announced that does not happen: {}", ran.err);
}

/// The names that nobody named on the command line: the Film's, and that of a picture rendered again.
#[test]
fn only_a_file_named_on_the_command_line_is_replaced() {
    let place = Place::new();
    let film =
        "Film \"image\" \"integer xresolution\" [16] \"integer yresolution\" [16] \"string filename\" [\"a.exr\"]";
    place.write("a.pbrt", &scene_with_header(film));
    place.run("render a.pbrt --spp 1 --quiet --outfile one.exr").expect_code(0);
    for own in ["a.exr", "one_again.exr"] {
        place.write(own, "somebody's own");
    }
    for (line, own, saved) in [
        ("render a.pbrt --spp 1", "a.exr", "a_2.exr"),
        ("render a.pbrt --spp 1 --quiet", "a.exr", "a_3.exr"),
        ("render a.pbrt --quick", "a.exr", "a_4.exr"),
        ("render one.exr --quiet", "one_again.exr", "one_again_2.exr"),
    ] {
        let kept = format!("{own}: was there before and is kept as it was, the picture is {saved}");
        place.run(line).expect_code(0).expect_err(&[&kept]);
        assert_eq!(std::fs::read_to_string(place.path(own)).expect("is there"), "somebody's own", "{line}");
        assert!(place.files().contains(&saved.to_owned()), "{line}: {:?}", place.files());
    }
    assert_eq!(place.json("render a.pbrt --spp 1")["outfile"], "a_5.exr");
    place.run("render a.pbrt --spp 1 --outfile a.exr").expect_code(0);
    assert_eq!(place.image("a.exr").window.size, [16, 16], "named, it is replaced");
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

#[test]
fn without_a_display_no_file_is_replaced() {
    let place = Place::new();
    place.write(
        "small.pbrt",
        &scene_with_header("Film \"image\" \"integer xresolution\" [16] \"integer yresolution\" [16]"),
    );
    place.write("veachMIS_L.exr", "somebody's own");
    let ran = place.run("small.pbrt");
    ran.expect_code(0).expect_err(&["veachMIS_L_2.exr: light", "veachMIS_L.exr: was there before and is kept"]);
    assert_eq!(std::fs::read_to_string(place.path("veachMIS_L.exr")).expect("is there"), "somebody's own");
    assert_eq!(place.image("veachMIS_L_2.exr").display.size, [16, 16]);
    assert!(!place.files().contains(&"veachMIS_BSDF_2.exr".to_owned()), "what is free keeps its name");
    place.run("small.pbrt").expect_code(0);
    assert_eq!(place.image("veachMIS_BSDF_2.exr").attribute("strategy"), Some("bsdf"), "nor those of the run before");
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
fn a_home_folder_is_found_where_the_shell_leaves_it() {
    let place = Place::new();
    let mut command = place.command("render --size 8x8 --spp 1 --quiet --outfile=~/deep.exr");
    let home = Place::new();
    command.env("HOME", home.0.path());
    assert_eq!(command.status().expect("the program starts").code(), Some(0));
    assert!(home.path("deep.exr").exists() && place.files().is_empty());
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
