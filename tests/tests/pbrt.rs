//! The scene reader: every directive, the tutorial's headers, places of messages, and damaged files.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use glam::{DMat4, DVec3, DVec4, Vec3};
use mislab_renderer::pbrt::{self, SceneFile};
use mislab_renderer::{
    Bsdf, Error, Geometry, Heuristic, OneSampleWeights, Reflectance, SamplerKind, Settings, Shape, Strategy,
};

fn parse(text: &str) -> SceneFile {
    pbrt::parse(text, "test.pbrt", None).unwrap_or_else(|e| panic!("{e}\nin\n{text}"))
}

/// Line, column and message of the error.
fn failure(text: &str) -> (u32, u32, String) {
    match pbrt::parse(text, "test.pbrt", None) {
        Err(Error::Scene(d)) => {
            assert_eq!(&*d.location.file, "test.pbrt", "the message names the file");
            assert!(!d.message.contains('\n'), "a message is one line: {}", d.message);
            (d.location.line, d.location.column, d.message)
        }
        Err(e) => panic!("expected an error with a place, found {e}"),
        Ok(_) => panic!("expected an error in\n{text}"),
    }
}

/// Fails unless the error is at that place and its message contains all the words.
#[track_caller]
fn assert_failure(text: &str, line: u32, column: u32, words: &[&str]) {
    let (l, c, message) = failure(text);
    assert_eq!((l, c), (line, column), "{message}");
    for word in words {
        assert!(message.contains(word), "expected {word:?} in {message:?}");
    }
}

/// A whole file around the content of a world.
fn world(body: &str) -> String {
    format!("Camera \"perspective\"\nWorldBegin\n{body}\nWorldEnd\n")
}

/// Warnings as (line, column, message).
fn warnings(file: &SceneFile) -> Vec<(u32, u32, &str)> {
    file.warnings.iter().map(|w| (w.location.line, w.location.column, w.message.as_str())).collect()
}

#[track_caller]
fn assert_no_warnings(file: &SceneFile) {
    assert!(file.warnings.is_empty(), "unexpected warnings: {:?}", file.warnings);
}

#[track_caller]
fn assert_matrix(found: DMat4, rows: [[f64; 4]; 4], tolerance: f64) {
    let expected = DMat4::from_cols_array_2d(&rows).transpose();
    assert!(found.abs_diff_eq(expected, tolerance), "found\n{found}\nexpected\n{expected}");
}

fn sphere(shape: &Shape) -> (Vec3, f32) {
    match &shape.geometry {
        Geometry::Sphere { center, radius } => (*center, *radius),
        Geometry::Mesh { .. } => panic!("expected a sphere"),
    }
}

fn mesh(shape: &Shape) -> (&Arc<Vec<Vec3>>, &Arc<Vec<[u32; 3]>>) {
    match &shape.geometry {
        Geometry::Mesh { positions, triangles } => (positions, triangles),
        Geometry::Sphere { .. } => panic!("expected a mesh"),
    }
}

/// The matrix after some transformations, read off the camera: it keeps the inverse.
fn ctm(directives: &str) -> DMat4 {
    parse(&format!("{directives}\nCamera \"perspective\"\nWorldBegin WorldEnd"))
        .scene
        .camera
        .world_from_camera
        .inverse()
}

// --- The scenes shipped -----------------------------------------------------------------------

const REFERENCE_CAMERA: &str = r#"Scale -1 1 1
LookAt 0 2 15  0 1.69521 14.0476  0 0.952421 -0.304787
Scale -1 1 1
Camera "perspective" "float fov" [41.0108]
"#;

#[test]
fn default_scene_is_veachs() {
    let file = pbrt::embedded_scene();
    assert_no_warnings(&file);
    assert_eq!(file.source, "embedded");
    assert_eq!(file.film_filename, "veach_mis.exr");
    assert_eq!(file.scene.name, "veach_mis");
    assert_eq!(file.settings, Settings::default());
    assert_eq!(file.scene.camera.fov_deg, 41.0108);

    let names: Vec<&str> = file.scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["plate1", "plate2", "plate3", "plate4", "floor", "wall"]);
    let alphas: Vec<Option<f32>> = file.scene.materials.iter().map(|m| m.bsdf.alpha()).collect();
    assert_eq!(alphas, [Some(0.0), Some(0.02), Some(0.05), Some(0.1), None, None]);
    let mirror = Bsdf::Conductor { reflectance: Reflectance::Constant(Vec3::ONE), alpha: 0.0 };
    assert_eq!(file.scene.materials[0].bsdf, mirror);

    let lights: Vec<&Shape> = file.scene.light_shapes().map(|i| &file.scene.shapes[i]).collect();
    assert_eq!(lights.len(), 4);
    let expected = [(-3.75, 0.03333, 901.803), (-1.25, 0.1, 100.0), (1.25, 0.3, 11.1111), (3.75, 0.9, 1.23457)];
    for (i, (light, (x, radius, l))) in lights.iter().zip(expected).enumerate() {
        assert_eq!(sphere(light), (Vec3::new(x, 0.0, 0.0), radius));
        let emission = light.light.as_ref().expect("a light");
        assert_eq!(
            (emission.name.as_str(), emission.radiance, emission.on),
            (&*format!("light{}", i + 1), Vec3::splat(l), true)
        );
        assert_eq!((light.material, light.reverse_orientation), (None, false));
    }
    assert_eq!(file.scene.shapes.len(), 10);
    // Plate 3 and the wall, found by their material.
    let of = |name: &str| {
        let index = file.scene.materials.iter().position(|m| m.name == name);
        file.scene.shapes.iter().find(|s| s.material == index).expect("a shape of that material")
    };
    assert_eq!(mesh(of("plate3")).0[1], Vec3::new(-4.0, -3.43378, 1.74564));
    assert_eq!(mesh(of("wall")).0[2], Vec3::new(10.0, 10.0, -2.0));
    assert_eq!(**mesh(of("floor")).1, [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn metal_plates_reflect_everything() {
    // The exact reflectance in double precision, rounded to single, at angles down to the worst one.
    let scene = pbrt::embedded_scene().scene;
    let Some(Bsdf::Conductor { reflectance: Reflectance::Fresnel { eta, k }, .. }) =
        scene.material("plate2").map(|m| &m.bsdf)
    else {
        panic!("plate2 is a metal")
    };
    let (eta, k) = (f64::from(eta.x), f64::from(k.x));
    for cos in [1.0, 0.5, 1e-2, 1e-4, 1e-6, 1e-7, 1e-8, 1e-9] {
        // |r|^2 for an index so large that the refracted ray runs along the normal.
        let norm = eta * eta + k * k;
        let s = (norm + cos * cos - 2.0 * eta * cos) / (norm + cos * cos + 2.0 * eta * cos);
        let p = (norm * cos * cos + 1.0 - 2.0 * eta * cos) / (norm * cos * cos + 1.0 + 2.0 * eta * cos);
        assert_eq!((0.5 * (s + p)) as f32, 1.0, "cos {cos}");
    }
}

#[test]
fn default_camera_is_the_references() {
    let camera = pbrt::embedded_scene().scene.camera;
    let reference = parse(&format!("{REFERENCE_CAMERA}\nWorldBegin WorldEnd")).scene.camera;
    assert_eq!(camera.fov_deg, reference.fov_deg);
    assert!(camera.world_from_camera.abs_diff_eq(reference.world_from_camera, 1e-12));
    // By hand: camera x is world -x, z is the viewing direction, the eye is the origin.
    let m = camera.world_from_camera;
    assert_matrix(
        m,
        [
            [-1.0, 0.0, 0.0, 0.0],
            [0.0, 0.952421, -0.304787, 2.0],
            [0.0, -0.304787, -0.952421, 15.0],
            [0.0, 0.0, 0.0, 1.0],
        ],
        1e-4,
    );
}

#[test]
fn large_light_is_on_the_left() {
    for file in [pbrt::embedded_scene(), parse(&format!("{REFERENCE_CAMERA}\nWorldBegin WorldEnd"))] {
        let view = file.scene.camera.world_from_camera.inverse();
        let screen = |x: f64| {
            let p = view.transform_point3(DVec3::new(x, 0.0, 0.0));
            assert!(p.z > 0.0, "in front of the camera");
            p.x / p.z
        };
        assert!(screen(3.75) < 0.0 && screen(-3.75) > 0.0, "x of the image points right");
        // Inside the picture: x/z = tan(fov/2) is its edge.
        assert!(screen(3.75).abs() < (0.5 * 41.0108f64).to_radians().tan());
    }
}

#[test]
fn plastic_scene_lets_pbrt_remap() {
    let file = pbrt::embedded_plastic_scene();
    assert_no_warnings(&file);
    assert_eq!(file.settings.resolution, [768, 512]);
    assert_eq!(file.scene.camera.fov_deg, 28.0);
    assert_eq!(file.scene.light_shapes().count(), 5);
    let overhead = &file.scene.shapes[4];
    assert_eq!(sphere(overhead), (Vec3::new(10.0, 10.0, 4.0), 0.5));
    let expected = [0.1033, 0.1925, 0.3125, 0.4618];
    for (i, alpha) in expected.into_iter().enumerate() {
        let material = file.scene.material(&format!("plate{}", i + 1)).expect("a plate");
        let Bsdf::Plastic { kd, ks, alpha: found } = material.bsdf else { panic!("plastic") };
        assert_eq!((kd, ks), (Vec3::new(0.07, 0.09, 0.13), Vec3::ONE));
        assert!((found - alpha).abs() < 1e-4, "alpha {found}, expected {alpha}");
    }
}

// --- The tutorial's headers -------------------------------------------------------------------

const HEADER_LIGHT: &str = r#"Sampler "stratified" "integer xsamples" [8] "integer ysamples"
[8] "bool jitter" ["true"]
Integrator "veachMIS" "string MISstrategy" ["light"]
Film "image" "string filename" ["veachMIS_L.exr"] "integer
xresolution" [800] "integer yresolution" [800]
"#;

const HEADER_BSDF: &str = r#"Integrator "veachMIS" "string MISstrategy" ["bsdf"]
Film "image" "string filename" ["veachMIS_BSDF.exr"] "integer
xresolution" [800] "integer yresolution" [800]
"#;

const HEADER_MIS_ALL: &str = r#"Sampler "stratified" "integer xsamples" [6] "integer ysamples"
[6] "bool jitter" ["true"]
Film "image" "string filename" ["veach_MIS_ALLx36.exr"] "integer
xresolution" [600] "integer yresolution" [600]
SurfaceIntegrator "veachMIS" "string sample_method" ["mis_all"]
"#;

const HEADER_MIS: &str = r#"Integrator "veachMIS" "string MISstrategy" ["mis"]
Film "image" "string filename" ["veachMIS_MIS.exr"] "integer
xresolution" [800] "integer yresolution" [800]
"#;

/// A header in front of the shipped scene, whose own one is replaced by it.
fn with_header(header: &str) -> String {
    let (own, body) = pbrt::DEFAULT_SCENE.split_once("WorldBegin").expect("a world");
    format!("{own}\n{header}\nWorldBegin{body}")
}

#[test]
fn tutorial_headers_work_as_printed() {
    let cases = [
        (HEADER_LIGHT, Strategy::Light, "veachMIS_L.exr", 64, 800),
        (HEADER_BSDF, Strategy::Bsdf, "veachMIS_BSDF.exr", 64, 800),
        (HEADER_MIS_ALL, Strategy::MisAll, "veach_MIS_ALLx36.exr", 36, 600),
        (HEADER_MIS, Strategy::Mis, "veachMIS_MIS.exr", 64, 800),
    ];
    let quotes: [fn(&str) -> String; 6] = [
        |h| h.to_owned(),
        |h| alternate(h, ['“', '”']),
        |h| alternate(h, ['„', '“']),
        |h| alternate(h, ['«', '»']),
        |h| alternate(h, ['”', '"']),
        |h| alternate(h, ['‘', '’']),
    ];
    for (header, strategy, filename, spp, size) in cases {
        for (i, quote) in quotes.iter().enumerate() {
            let file = parse(&with_header(&quote(header)));
            assert_eq!(file.settings.strategy, strategy);
            assert_eq!(file.film_filename, filename);
            assert_eq!(file.settings.spp.map(|n| n.get()), Some(spp));
            assert_eq!(file.settings.sampler.kind, SamplerKind::Stratified);
            assert!(file.settings.sampler.jitter);
            assert_eq!(file.settings.resolution, [size, size]);
            assert_eq!(file.scene, SceneFile { ..pbrt::embedded_scene() }.scene_named("test"));
            let expected = usize::from(i > 0);
            assert_eq!(file.warnings.len(), expected, "one warning about quotes: {:?}", file.warnings);
        }
    }
}

trait Renamed {
    fn scene_named(self, name: &str) -> mislab_renderer::Scene;
}

impl Renamed for SceneFile {
    fn scene_named(self, name: &str) -> mislab_renderer::Scene {
        mislab_renderer::Scene { name: name.to_owned(), ..self.scene }
    }
}

/// Replaces straight quotes by an opening and a closing one in turn.
fn alternate(text: &str, quotes: [char; 2]) -> String {
    let mut count = 0;
    text.chars()
        .map(|c| {
            if c == '"' {
                count += 1;
                quotes[(count + 1) % 2]
            } else {
                c
            }
        })
        .collect()
}

#[test]
fn header_alone_is_an_empty_scene() {
    let file = parse(HEADER_LIGHT);
    assert_eq!(file.settings.strategy, Strategy::Light);
    assert!(file.scene.shapes.is_empty());
    assert!(file.warnings.iter().any(|w| w.message.contains("WorldBegin")));
}

#[test]
fn what_copying_brings_is_read() {
    // Byte order mark, CRLF, no-break spaces, soft hyphen and line break inside a quoted text,
    // ligature, typographic minus and dash.
    let text = "\u{feff}Film\u{a0}\"image\"\r\n\u{a0}\"string \u{fb01}lename\" [\"a.exr\"] \"integer\r\n  x\u{ad}resolution\" [20]\r\n\
                \"integer yresolution\" [10]\r\nTranslate \u{2212}1 \u{2013}2 3\r\nCamera \"perspective\"\r\nWorldBegin WorldEnd";
    let file = parse(text);
    assert_eq!((file.film_filename.as_str(), file.settings.resolution), ("a.exr", [20, 10]));
    assert_eq!(file.scene.camera.world_from_camera.w_axis, DVec4::new(1.0, 2.0, -3.0, 1.0));
    let found = warnings(&file);
    assert_eq!(found.len(), 2, "{found:?}");
    assert_eq!((found[0].0, found[0].1), (2, 2));
    assert!(found[0].2.contains("ligature"));
    assert_eq!((found[1].0, found[1].1), (5, 11));
    assert!(found[1].2.contains("minus"));
}

#[test]
fn quotes_of_the_other_kind_are_content() {
    let file = parse("Film \"image\" \"string filename\" \"student's.exr\" Camera 'perspective' WorldBegin WorldEnd");
    assert_eq!(file.film_filename, "student's.exr");
    let file = parse(r#"Film "image" "string filename" "a\"b\\c\d.exr" WorldBegin WorldEnd"#);
    assert_eq!(file.film_filename, r#"a"b\c\d.exr"#);
}

// --- Header directives ------------------------------------------------------------------------

fn settings(header: &str) -> Settings {
    let file = parse(&format!("{header}\nCamera \"perspective\"\nWorldBegin WorldEnd"));
    assert_no_warnings(&file);
    file.settings
}

#[test]
fn absent_directives_and_parameters() {
    let file = parse("Camera \"perspective\" WorldBegin WorldEnd");
    assert_no_warnings(&file);
    assert_eq!((file.settings, file.film_filename.as_str()), (Settings::default(), "pbrt.exr"));
    assert_eq!((file.scene.camera.fov_deg, file.scene.camera.screen_window), (90.0, None));
    // pbrt's defaults for what a directive leaves out.
    assert_eq!(settings("Film \"image\"").resolution, [1280, 720]);
    let s = settings("Sampler \"stratified\"");
    assert_eq!((s.sampler.strata, s.sampler.jitter, s.spp.map(|n| n.get())), ([4, 4], true, Some(16)));
    assert_eq!(settings("Sampler \"random\"").spp.map(|n| n.get()), Some(4));
}

#[test]
fn film() {
    let s =
        settings(r#"Film "image" "integer xresolution" 40 "integer yresolution" [30] "float cropwindow" [.5 0 .25 1]"#);
    assert_eq!((s.resolution, s.crop), ([40, 30], [0.0, 0.5, 0.25, 1.0]));
    // The last one wins as a whole.
    let s = settings("Film \"image\" \"integer xresolution\" 40\nFilm \"image\" \"integer yresolution\" 30");
    assert_eq!(s.resolution, [1280, 30]);
    assert_failure("Film \"image\"\n \"integer xresolution\" [0]", 2, 25, &["xresolution", "0", "at least 1"]);
    assert_failure("Film \"image\"\n \"integer xresolution\" [100000]", 2, 2, &["100000", "65536"]);
    assert_failure("Film \"image\" \"float cropwindow\" [.5 .5 0 1]", 1, 34, &["crop window", "x0 < x1"]);
    assert_failure("Film \"image\" \"float cropwindow\" [0 1 0]", 1, 33, &["3 values", "expected 4"]);
}

#[test]
fn samplers() {
    for jitter in ["[\"false\"]", "[false]", "\"false\"", "false"] {
        let s = settings(&format!(
            "Sampler \"stratified\" \"bool jitter\" {jitter} \"integer xsamples\" [3] \"integer ysamples\" 5"
        ));
        assert_eq!((s.sampler.strata, s.sampler.jitter, s.spp.map(|n| n.get())), ([3, 5], false, Some(15)));
    }
    let s = settings("Sampler \"random\" \"integer pixelsamples\" [12]");
    assert_eq!(
        (s.sampler.kind, s.sampler.strata, s.spp.map(|n| n.get())),
        (SamplerKind::Independent, [3, 4], Some(12))
    );
    let s = settings("Sampler \"sobol\" \"integer pixelsamples\" [32]");
    assert_eq!((s.sampler.kind, s.spp.map(|n| n.get())), (SamplerKind::Sobol, Some(32)));
    for other in ["halton", "02sequence", "lowdiscrepancy", "maxmindist"] {
        let file = parse(&format!(
            "Sampler \"{other}\" \"integer pixelsamples\" [32]\nCamera \"perspective\" WorldBegin WorldEnd"
        ));
        assert_eq!((file.settings.sampler.kind, file.settings.spp.map(|n| n.get())), (SamplerKind::Sobol, Some(32)));
        assert_eq!(file.warnings.len(), 1);
    }
    assert_failure("Sampler \"stratified\" \"integer xsamples\" [0]", 1, 42, &["xsamples", "at least 1"]);
    assert_failure(
        "Sampler \"stratified\" \"integer xsamples\" [300]\n\"integer ysamples\" [300]",
        1,
        22,
        &["300 x 300"],
    );
    assert_failure("Sampler \"random\" \"integer pixelsamples\" [2.5]", 1, 42, &["2.5", "whole number"]);
}

#[test]
fn integrators() {
    let s = settings(
        "Integrator \"veachMIS\" \"string MISstrategy\" \"mis\" \"float lightprob\" [0.25] \"string heuristic\" [\"power\"] \"string weights\" \"tutorial\"",
    );
    assert_eq!((s.strategy, s.light_prob), (Strategy::Mis, 0.25));
    assert_eq!((s.heuristic, s.weights), (Heuristic::Power, OneSampleWeights::Tutorial));
    // The last one wins, with everything it leaves out.
    let s = settings(
        "Integrator \"veachMIS\" \"string heuristic\" \"cutoff\"\nIntegrator \"veachMIS\" \"string MISstrategy\" \"bsdf\"",
    );
    assert_eq!((s.strategy, s.heuristic), (Strategy::Bsdf, Heuristic::Balance));
    let file = parse("Integrator \"path\" \"integer maxdepth\" [5]\nCamera \"perspective\" WorldBegin WorldEnd");
    assert_eq!(file.settings.strategy, Strategy::MisAll);
    assert_eq!(file.warnings.len(), 1, "{:?}", file.warnings);
    assert!(file.warnings[0].message.contains("veachMIS"));
    assert_failure(
        "Integrator \"veachMIS\"\n  \"string MISstrategy\" [\"brdf\"]",
        2,
        25,
        &["brdf", "light, bsdf, mis_all, mis"],
    );
    assert_failure("Integrator \"veachMIS\" \"float lightprob\" [1.5]", 1, 42, &["1.5", "[0, 1]"]);
    assert_failure(
        "Integrator \"veachMIS\" \"string heuristic\" [\"max\"]",
        1,
        43,
        &["balance, power, cutoff, maximum"],
    );
}

#[test]
fn pixel_filters() {
    settings("PixelFilter \"box\" \"float xwidth\" [0.5]");
    for other in ["\"gaussian\"", "\"box\" \"float xwidth\" [2]"] {
        let file = parse(&format!("PixelFilter {other} Camera \"perspective\" WorldBegin WorldEnd"));
        assert_eq!(file.warnings.len(), 1);
        assert!(file.warnings[0].message.contains("box of one pixel"));
    }
}

#[test]
fn cameras() {
    let camera =
        |parameters: &str| parse(&format!("Camera \"perspective\" {parameters} WorldBegin WorldEnd")).scene.camera;
    assert_eq!(camera("\"float fov\" 30").fov_deg, 30.0);
    assert_eq!(camera("\"float halffov\" 20").fov_deg, 40.0);
    assert_eq!(camera("\"float screenwindow\" [-1 1 -.5 .5]").screen_window, Some([-1.0, 1.0, -0.5, 0.5]));
    assert_eq!(camera("\"float frameaspectratio\" 2").screen_window, Some([-2.0, 2.0, -1.0, 1.0]));
    assert_eq!(camera("\"float frameaspectratio\" .5").screen_window, Some([-1.0, 1.0, -2.0, 2.0]));
    assert_failure("Camera \"perspective\" \"float fov\" [180]", 1, 35, &["180", "less than 180"]);
    assert_failure("Camera \"perspective\" \"float screenwindow\" [1 1 0 1]", 1, 44, &["screenwindow"]);
    assert_failure("\nScale 1 0 1", 2, 1, &["Scale", "inverse"]);
    let file = parse("Camera \"perspective\" \"float lensradius\" 0.1 \"float focaldistance\" 3 WorldBegin WorldEnd");
    assert_eq!(file.warnings.len(), 2);
}

#[test]
fn misplaced_header_is_read_with_a_warning() {
    let file = parse(&world("Integrator \"veachMIS\" \"string MISstrategy\" \"mis\""));
    assert_eq!(file.settings.strategy, Strategy::Mis);
    assert_eq!(warnings(&file), [(3, 1, "Integrator belongs before WorldBegin; it is read all the same")]);
}

// --- Transformations --------------------------------------------------------------------------

#[test]
fn transformations_match_matrices_by_hand() {
    let id = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    assert_matrix(ctm(""), id, 0.0);
    assert_matrix(ctm("Translate 1 2 3 Scale 4 4 4 Identity"), id, 0.0);
    let translated = [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 2.0], [0.0, 0.0, 1.0, 3.0], [0.0, 0.0, 0.0, 1.0]];
    assert_matrix(ctm("Translate 1 2 3"), translated, 1e-15);
    // The directive nearest to the shape acts first: scale, then translate.
    let both = [[2.0, 0.0, 0.0, 1.0], [0.0, 3.0, 0.0, 2.0], [0.0, 0.0, 4.0, 3.0], [0.0, 0.0, 0.0, 1.0]];
    assert_matrix(ctm("Translate 1 2 3 Scale 2 3 4"), both, 1e-15);
    // A quarter turn about z takes x to y.
    let turned = [[0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    assert_matrix(ctm("Rotate 90 0 0 2"), turned, 1e-15);
    // Sixteen numbers, column after column.
    let columns = "2 0 0 0  0 3 0 0  0 0 4 0  1 2 3 1";
    assert_matrix(ctm(&format!("Scale 9 9 9 Transform [{columns}]")), both, 1e-15);
    let concat = [[4.0, 0.0, 0.0, 2.0], [0.0, 6.0, 0.0, 4.0], [0.0, 0.0, 8.0, 6.0], [0.0, 0.0, 0.0, 1.0]];
    assert_matrix(ctm(&format!("Scale 2 2 2 ConcatTransform [{columns}]")), concat, 1e-14);
    assert_matrix(
        ctm("Translate 1 2 3 CoordinateSystem \"here\" Identity CoordSysTransform \"here\""),
        translated,
        1e-15,
    );
    // From (0, 0, 5) to the origin, y up: left-handed, so right is world -x. Rows of the view are the axes.
    let view = [[-1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, -1.0, 5.0], [0.0, 0.0, 0.0, 1.0]];
    assert_matrix(ctm("LookAt 0 0 5  0 0 0  0 1 0"), view, 1e-15);
    // From (1, 2, 3) along +x, z up: right = z cross x = y.
    let view = [[0.0, 1.0, 0.0, -2.0], [0.0, 0.0, 1.0, -3.0], [1.0, 0.0, 0.0, -1.0], [0.0, 0.0, 0.0, 1.0]];
    assert_matrix(ctm("LookAt 1 2 3  7 2 3  0 0 9"), view, 1e-14);
}

#[test]
fn degenerate_transformations_are_errors() {
    assert_failure("\n LookAt 1 1 1  1 1 1  0 1 0", 2, 2, &["LookAt", "apart"]);
    assert_failure("LookAt 0 0 0  0 2 0  0 1 0", 1, 1, &["LookAt", "up"]);
    assert_failure("Rotate 90 0 0 0", 1, 1, &["axis 0 0 0"]);
    assert_failure("Translate 1 2", 1, 1, &["Translate with 2 numbers, expected 3"]);
    assert_failure("Translate 1 2 \"x\"", 1, 15, &["expected 3 numbers"]);
    assert_failure("Transform [1 0 0 1  0 1 0 0  0 0 1 0  0 0 0 1]", 1, 1, &["projective"]);
    assert_failure(&"Scale 1e38 1e38 1e38\n".repeat(9), 3, 1, &["too large"]);
    assert_failure("CoordSysTransform \"nowhere\"", 1, 1, &["nowhere"]);
}

#[test]
fn blocks_save_and_restore() {
    let file = parse(&world(
        "AttributeBegin
           Translate 1 0 0
           Material \"mirror\"
           ReverseOrientation
           AreaLightSource \"diffuse\"
           Shape \"sphere\"
         AttributeEnd
         Shape \"sphere\"
         TransformBegin
           Translate 0 1 0
           Material \"mirror\"
         TransformEnd
         Shape \"sphere\"",
    ));
    assert_no_warnings(&file);
    let [a, b, c] = &file.scene.shapes[..] else { panic!("three shapes") };
    assert_eq!(sphere(a).0, Vec3::X);
    assert!(a.reverse_orientation && a.light.is_some());
    assert_eq!(sphere(b).0, Vec3::ZERO);
    assert!(!b.reverse_orientation && b.light.is_none());
    // TransformEnd restores the matrix only.
    assert_eq!(sphere(c).0, Vec3::ZERO);
    assert_ne!(b.material, c.material);

    assert_failure(&world("AttributeEnd"), 3, 1, &["AttributeEnd without AttributeBegin"]);
    assert_failure(&world("AttributeBegin\nTransformEnd"), 4, 1, &["expected AttributeEnd", "line 3"]);
    let file = parse(&world("\n AttributeBegin"));
    assert_eq!(warnings(&file), [(4, 2, "AttributeBegin is never closed")]);
    assert_failure(&world(&"AttributeBegin\n".repeat(2000)), 1003, 1, &["at most 1000"]);
}

#[test]
fn structure_of_the_file() {
    assert_failure("Shape \"sphere\"", 1, 1, &["before WorldBegin"]);
    assert_failure("WorldEnd", 1, 1, &["without WorldBegin"]);
    assert_failure("WorldBegin\nWorldBegin", 2, 1, &["one WorldBegin"]);
    assert_failure("", 1, 1, &["no pbrt directive"]);
    assert_failure("Dear students, ...", 1, 6, &["students,", "expected"]);
    let file = parse("Camera \"perspective\"\nWorldBegin WorldEnd\nShape \"sphere\" Shape \"sphere\"");
    assert_eq!(warnings(&file), [(3, 1, "what follows WorldEnd is not read")]);
    assert_eq!(parse("Camera \"perspective\"\nWorldBegin\n").warnings.len(), 1);
}

// --- Materials --------------------------------------------------------------------------------

fn bsdf(material: &str) -> Bsdf {
    let file = parse(&world(&format!("Material {material}\nShape \"sphere\"")));
    assert_no_warnings(&file);
    file.scene.materials[0].bsdf.clone()
}

#[test]
fn materials_and_their_defaults() {
    assert_eq!(bsdf("\"matte\""), Bsdf::Matte { kd: Vec3::splat(0.5) });
    assert_eq!(bsdf("\"matte\" \"color Kd\" [.1 .2 .3]"), Bsdf::Matte { kd: Vec3::new(0.1, 0.2, 0.3) });
    let mirror = |kr| Bsdf::Conductor { reflectance: Reflectance::Constant(Vec3::splat(kr)), alpha: 0.0 };
    assert_eq!(bsdf("\"mirror\""), mirror(0.9));
    assert_eq!(bsdf("\"mirror\" \"rgb Kr\" [1 1 1]"), mirror(1.0));
    let Bsdf::Conductor { reflectance: Reflectance::Fresnel { eta, k }, alpha } = bsdf("\"metal\"") else {
        panic!("a conductor")
    };
    assert!((eta - Vec3::new(0.200, 0.924, 1.102)).abs().max_element() < 1e-3, "copper");
    assert!((k - Vec3::new(3.913, 2.453, 2.142)).abs().max_element() < 1e-3, "copper");
    assert!((alpha - 0.13892).abs() < 1e-5, "roughness 0.01 remapped: {alpha}");
    let Bsdf::Plastic { kd, ks, alpha } = bsdf("\"plastic\"") else { panic!("plastic") };
    assert_eq!((kd, ks), (Vec3::splat(0.25), Vec3::splat(0.25)));
    assert!((alpha - 0.46176).abs() < 1e-5, "roughness 0.1 remapped: {alpha}");
    let raw = "\"metal\" \"float roughness\" 0.3 \"bool remaproughness\" false";
    assert_eq!(bsdf(raw).alpha(), Some(0.3));
    assert_eq!(bsdf("\"metal\" \"float roughness\" 0 \"bool remaproughness\" false").alpha(), Some(0.0));
    // XYZ of Rec. 709 red.
    let Bsdf::Matte { kd } = bsdf("\"matte\" \"xyz Kd\" [0.412453 0.212671 0.019334]") else { panic!("matte") };
    assert!((kd - Vec3::X).abs().max_element() < 1e-4, "{kd}");
}

#[test]
fn material_warnings_and_errors() {
    let warning = |material: &str| {
        let file = parse(&world(&format!("Material {material}\nShape \"sphere\"")));
        assert_eq!(file.warnings.len(), 1, "{:?}", file.warnings);
        (file.warnings[0].message.clone(), file.scene.materials[0].bsdf.clone())
    };
    let (message, bsdf) =
        warning("\"metal\" \"float uroughness\" .1 \"float vroughness\" .4 \"bool remaproughness\" false");
    assert!(
        message.contains("0.2000") && (bsdf.alpha().unwrap_or(0.0) - 0.2).abs() < 1e-6,
        "geometric mean: {message}"
    );
    assert_eq!(warning("\"plastic\" \"float roughness\" 1").1.alpha(), Some(1.0));
    assert_eq!(warning("\"glass\" \"float index\" 1.5").1, Bsdf::Matte { kd: Vec3::splat(0.5) });
    assert_eq!(warning("\"matte\" \"rgb Kd\" [.5 .5 2]").1, Bsdf::Matte { kd: Vec3::new(0.5, 0.5, 1.0) });
    assert_eq!(warning("\"matte\" \"texture Kd\" \"wood\"").1, Bsdf::Matte { kd: Vec3::splat(0.5) });
    assert_eq!(warning("\"matte\" \"spectrum Kd\" [400 .1 700 .9]").1, Bsdf::Matte { kd: Vec3::splat(0.5) });
    assert!(warning("\"matte\" \"float sigma\" 20").0.contains("sigma"));
    assert!(warning("\"matte\" \"rgb kd\" [1 1 1]").0.contains("did you mean \"Kd\""));
    assert_failure(&world("Material \"matte\" \"rgb Kd\" [-1 0 0]"), 3, 28, &["Kd", "-1 0 0", "negative"]);
    assert_failure(&world("Material \"matte\" \"rgb Kd\" [1 1]"), 3, 27, &["2 values", "expected 3"]);
    assert_failure(&world("Material \"matte\" \"rgb Kd\" .5"), 3, 27, &["1 value", "expected 3"]);
    assert_failure(&world("Material \"matte\" \"float Kd\" .5"), 3, 18, &["float Kd", "expected", "rgb Kd"]);
    assert_failure(&world("Material \"metal\" \"float roughness\" -1"), 3, 36, &["roughness -1"]);
    assert_failure(&world("Material \"metal\" \"float roughness\" \"rough\""), 3, 36, &["rough", "number"]);
    assert_failure(&world("Material \"metal\" \"bool remaproughness\" \"no\""), 3, 40, &["no", "true"]);
    assert_failure(&world("Material"), 3, 1, &["Material", "text in quotes"]);
}

#[test]
fn material_names() {
    let file = parse(&world(
        "MakeNamedMaterial \"unused\" \"string type\" \"matte\"
         MakeNamedMaterial \"gloss\" \"string type\" \"mirror\"
         NamedMaterial \"gloss\" Shape \"sphere\" Shape \"sphere\"
         Material \"matte\" \"rgb Kd\" [0 1 0] Shape \"sphere\"
         AttributeBegin Material \"matte\" \"rgb Kd\" [0 1 0] Shape \"sphere\" AttributeEnd
         Material \"matte\" \"rgb Kd\" [0 0 1] Shape \"sphere\"
         MakeNamedMaterial \"gloss\" \"string type\" \"plastic\"
         NamedMaterial \"gloss\" Shape \"sphere\"",
    ));
    let names: Vec<&str> = file.scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["gloss", "material1", "material2", "gloss_2"]);
    let used: Vec<Option<usize>> = file.scene.shapes.iter().map(|s| s.material).collect();
    assert_eq!(used, [Some(0), Some(0), Some(1), Some(1), Some(2), Some(3)]);
    assert_eq!(file.warnings.len(), 1, "defined again: {:?}", file.warnings);
    assert_failure(&world("NamedMaterial \"gloss\""), 3, 1, &["gloss", "MakeNamedMaterial"]);
    assert_failure(&world("MakeNamedMaterial \"gloss\""), 3, 1, &["string type"]);
    // A name taken by the file is not given again.
    let file = parse(&world(
        "Shape \"sphere\" MakeNamedMaterial \"material1\" \"string type\" \"mirror\" NamedMaterial \"material1\" Shape \"sphere\"",
    ));
    let names: Vec<&str> = file.scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["material2", "material1"]);
}

// --- Shapes and lights ------------------------------------------------------------------------

#[test]
fn area_lights() {
    let file = parse(&world(
        "AreaLightSource \"diffuse\" \"rgb L\" [1 2 3] \"rgb scale\" [2 2 2] Shape \"sphere\"
         Material \"matte\" \"rgb Kd\" [0 0 0] Shape \"sphere\"
         Material \"mirror\" Shape \"sphere\"
         AreaLightSource \"area\" Shape \"sphere\"",
    ));
    assert_no_warnings(&file);
    let light = |i: usize| file.scene.shapes[i].light.as_ref().expect("a light");
    assert_eq!((light(0).name.as_str(), light(0).radiance), ("light1", Vec3::new(2.0, 4.0, 6.0)));
    assert_eq!((light(3).name.as_str(), light(3).radiance), ("light4", Vec3::ONE));
    let surfaces: Vec<Option<usize>> = file.scene.shapes.iter().map(|s| s.material).collect();
    assert_eq!(surfaces, [None, None, Some(0), Some(0)], "black unless a material says otherwise");
    assert_failure(&world("AreaLightSource \"diffuse\" \"rgb L\" [1 -1 0]"), 3, 36, &["\"L\"", "1 -1 0"]);
    let file =
        parse(&world("AreaLightSource \"diffuse\" \"blackbody L\" [5000 1] \"bool twosided\" true Shape \"sphere\""));
    assert_eq!(file.warnings.len(), 2);
    assert_eq!(file.scene.shapes[0].light.as_ref().map(|l| l.radiance), Some(Vec3::ONE));
}

#[test]
fn spheres() {
    let file = parse(&world(
        "Translate 1 2 3 Rotate 30 1 1 0 Scale -2 2 2 Translate 0 0 1 Shape \"sphere\" \"float radius\" 3",
    ));
    assert_no_warnings(&file);
    let (center, radius) = sphere(&file.scene.shapes[0]);
    // Rodrigues' formula for (0, 0, 2), 30 degrees about (1, 1, 0) / sqrt 2.
    let (sin, cos) = 30f32.to_radians().sin_cos();
    let expected = Vec3::new(1.0, 2.0, 3.0) + 2.0 * Vec3::new(sin / 2f32.sqrt(), -sin / 2f32.sqrt(), cos);
    assert!((center - expected).length() < 1e-5, "{center} {expected}");
    assert!((radius - 6.0).abs() < 1e-5, "{radius}");
    assert!(!file.scene.shapes[0].reverse_orientation, "mirroring keeps the outward normal");
    assert!(parse(&world("ReverseOrientation Shape \"sphere\"")).scene.shapes[0].reverse_orientation);
    assert!(parse(&world("Scale -1 1 1 ReverseOrientation Shape \"sphere\"")).scene.shapes[0].reverse_orientation);

    assert_failure(&world("Scale 1 2 1\n Shape \"sphere\""), 4, 2, &["uniform"]);
    let shear = "ConcatTransform [1 0 0 0  1 1 0 0  0 0 1 0  0 0 0 1]";
    assert_failure(&world(&format!("{shear}\nShape \"sphere\"")), 4, 1, &["uniform", "shear"]);
    assert_failure(&world("Shape \"sphere\" \"float radius\" [0]"), 3, 32, &["radius 0"]);
    assert_failure(&world("Scale 1e30 1e30 1e30\nShape \"sphere\" \"float radius\" 1e30"), 4, 1, &["too large"]);
    let file =
        parse(&world("Shape \"sphere\" \"float radius\" 2 \"float zmin\" -2 \"float zmax\" 2 \"float phimax\" 360"));
    assert_no_warnings(&file);
    let file = parse(&world("Shape \"sphere\" \"float zmax\" 0.5"));
    assert_eq!(warnings(&file), [(3, 29, "part of a sphere (zmin, zmax, phimax): the whole sphere is used")]);
}

/// The direction in which a triangle of the file emits.
fn emission_normal(shape: &Shape) -> Vec3 {
    let (positions, triangles) = mesh(shape);
    let [a, b, c] = triangles[0].map(|i| positions[i as usize]);
    let normal = (b - a).cross(c - a).normalize();
    if shape.reverse_orientation { -normal } else { normal }
}

const TRIANGLE: &str =
    "AreaLightSource \"diffuse\" Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [0 0 0  0 1 0  0 0 1]";

#[test]
fn mirrored_triangle_emits_the_mirrored_way() {
    let normal = |prefix: &str| emission_normal(&parse(&world(&format!("{prefix} {TRIANGLE}"))).scene.shapes[0]);
    assert_eq!(normal(""), Vec3::X);
    assert_eq!(normal("ReverseOrientation"), -Vec3::X);
    // Mirrored in x, the lamp that shone along +x shines along -x; mirrored in y it still shines along +x.
    assert_eq!(normal("Scale -1 1 1"), -Vec3::X);
    assert_eq!(normal("Scale 1 -1 1"), Vec3::X);
    assert_eq!(normal("Scale -1 -1 -1"), -Vec3::X);
    assert_eq!(normal("Scale 1 -1 1 ReverseOrientation"), -Vec3::X);
    assert_eq!(normal("ReverseOrientation ReverseOrientation"), Vec3::X);
    assert!((normal("Rotate 180 0 1 0") + Vec3::X).length() < 1e-6);
}

#[test]
fn triangle_meshes() {
    let file = parse(&world(
        "Translate 1 0 0 Scale 2 2 2
         Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2 2 1 1] \"normal N\" [0 0 1 0 0 1 0 0 1] \"float uv\" [0 0 1 0 0 1]
         Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 2 1] \"normal N\" [0 0 1 0 0 1 0 0 1]",
    ));
    let (positions, triangles) = mesh(&file.scene.shapes[0]);
    assert_eq!(**positions, [Vec3::new(1.0, 0.0, 0.0), Vec3::new(3.0, 0.0, 0.0), Vec3::new(1.0, 2.0, 0.0)]);
    assert_eq!(**triangles, [[0, 1, 2]], "a triangle without area is dropped");
    let messages: Vec<&str> = file.warnings.iter().map(|w| w.message.as_str()).collect();
    assert_eq!(messages.len(), 3, "N, uv and the triangle, each once: {messages:?}");
    assert_eq!((file.warnings[1].location.line, file.warnings[2].location.line), (4, 4));

    let mesh = |rest: &str| world(&format!("Shape \"trianglemesh\" {rest}"));
    assert_failure(&mesh("\"integer indices\" [0 1 2]"), 3, 1, &["point P"]);
    assert_failure(&mesh("\"point P\" [0 0 0 1 0 0 0 1 0]"), 3, 1, &["indices"]);
    assert_failure(&mesh("\"point P\" [0 0 0 1]"), 3, 32, &["4 values", "three"]);
    assert_failure(&mesh("\"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1]"), 3, 70, &["2 values", "three"]);
    assert_failure(
        &mesh("\"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 3]"),
        3,
        75,
        &["index 3", "3 vertices"],
    );
    assert_failure(&mesh("\"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1.5 2]"), 3, 73, &["index 1.5"]);
    assert_failure(&mesh("\"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 -1 2]"), 3, 73, &["index -1"]);
    assert_failure(&mesh("\"vector P\" [0 0 0]"), 3, 22, &["vector P", "point P"]);
}

// --- Messages ---------------------------------------------------------------------------------

#[test]
fn errors_say_where() {
    assert_failure("Film \"image\" \"string filename\" [\"a.exr\"", 1, 32, &["'['", "']'"]);
    assert_failure("Film \"image\" \"string filename", 1, 14, &["quote"]);
    assert_failure("Film \"image\"\n\t\"string filename [\"a.exr\"]", 2, 21, &["a.exr"]);
    assert_failure("Film \"image\" \"filename\" \"a.exr\"", 1, 14, &["filename", "type name"]);
    assert_failure("Film \"image\" [3]", 1, 14, &["type name"]);
    assert_failure("Film \"image\" \"float scale\"", 1, 14, &["no value"]);
    assert_failure("Film \"image\" \"float scale\" [1 \"x\"]", 1, 31, &["list of numbers"]);
    assert_failure("Film \"image\" \"float scale\" [1 [2]]", 1, 31, &["\"[\""]);
    assert_failure("Film \"image\" ]", 1, 14, &["\"]\""]);
    assert_failure("Film \"image\" \"integer xresolution\" 8O0", 1, 36, &["8O0", "number"]);
    assert_failure("Translate 1,5 0 0", 1, 11, &["1,5", "number"]);
    for bad in ["1e999", "-1e39", "3.5e38"] {
        assert_failure(&format!("Translate 0 {bad} 0"), 1, 13, &[bad, "number"]);
    }
    for bad in ["nan", "inf", "infinity"] {
        assert_failure(&format!("Translate 0 {bad} 0"), 1, 13, &[bad]);
    }
    assert_failure("Translate 0 +inf 0", 1, 13, &["+inf", "number"]);
    // Columns count characters, and the first line after a byte order mark starts at 1.
    assert_failure("# äöü\nTransläte 1 2 3", 2, 1, &["Transläte"]);
    assert_failure("\u{feff}mist", 1, 1, &["mist"]);
    assert_failure("Film “imäge” 3", 1, 14, &["type name"]);
}

#[test]
fn unknown_things_are_said_once() {
    let file = parse(
        "Accelerator \"bvh\" \"integer maxnodeprims\" [4]
Film \"image\" \"float diagonal\" [35]
Camera \"perspective\" \"float fovv\" [30]
WorldBegin
  LightSource \"point\" \"rgb I\" [1 1 1]
  LightSource \"point\" \"rgb I\" [1 1 1]
  Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"a.png\"
  ActiveTransform All
  Matirial \"matte\"
  Shape \"disk\" \"float radius\" 3
  Shape \"disk\" \"float radius\" 4
  Shape \"sphere\" \"float radius\" 2 \"float size\" 3
  Shape \"sphere\" \"float radius\" 2 \"float size\" 4
  ObjectBegin \"o\" Shape \"sphere\" ObjectEnd ObjectInstance \"o\"
WorldEnd",
    );
    let places: Vec<(u32, u32)> = file.warnings.iter().map(|w| (w.location.line, w.location.column)).collect();
    let expected = [(1, 1), (2, 14), (3, 22), (5, 3), (7, 3), (8, 3), (9, 3), (10, 3), (12, 35), (14, 3)];
    assert_eq!(places, expected, "{:#?}", file.warnings);
    assert!(file.warnings[2].message.contains("did you mean \"fov\""), "{}", file.warnings[2]);
    assert!(file.warnings[6].message.contains("did you mean \"Material\""), "{}", file.warnings[6]);
    assert_eq!(file.scene.shapes.len(), 2, "instances are left out");
    assert_eq!(file.warnings[0].to_string().split(": ").next(), Some("test.pbrt:1:1"));
}

#[test]
fn warnings_are_bounded() {
    let text: String = (0..10_000).map(|i| format!("Directive{i} 1 2 3\n")).collect();
    let file = parse(&format!("Camera \"perspective\"\n{text}"));
    assert_eq!(file.warnings.len(), 101);
    assert!(file.warnings[100].message.contains("left out"));
}

// --- Files ------------------------------------------------------------------------------------

fn write(folder: &Path, name: &str, content: impl AsRef<[u8]>) -> std::path::PathBuf {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().expect("a folder")).expect("a folder can be made");
    fs::write(&path, content).expect("a file can be written");
    path
}

#[test]
fn load_names_what_is_wrong_with_a_file() {
    let dir = tempfile::tempdir().expect("a folder");
    let missing = dir.path().join("missing.pbrt");
    assert!(matches!(pbrt::load(&missing), Err(Error::Io { .. })));
    assert!(pbrt::load(dir.path()).expect_err("a folder").to_string().contains("a folder, expected a file"));
    let binary = write(dir.path(), "picture.exr", b"v/1\x01\x02\0\0\0");
    assert!(pbrt::load(&binary).expect_err("binary").to_string().contains("picture.exr: binary data"));
    let scene = write(dir.path(), "my scene.pbrt", pbrt::DEFAULT_SCENE);
    let file = pbrt::load(&scene).expect("a scene");
    assert_eq!((file.scene.name.as_str(), file.source), ("my scene", scene.display().to_string()));
    // Windows editors.
    let mut utf16: Vec<u8> = vec![0xff, 0xfe];
    utf16.extend(pbrt::DEFAULT_SCENE.encode_utf16().flat_map(u16::to_le_bytes));
    let scene = write(dir.path(), "utf16.pbrt", utf16);
    assert_eq!(pbrt::load(&scene).expect("a scene").scene.shapes.len(), 10);
    let scene = write(dir.path(), "latin1.pbrt", b"# Licht gr\xfcn\nCamera \"perspective\"\nWorldBegin WorldEnd");
    assert!(pbrt::load(&scene).is_ok());
}

#[test]
fn include_is_relative_and_keeps_places() {
    let dir = tempfile::tempdir().expect("a folder");
    let root = dir.path();
    let main = write(
        root,
        "main.pbrt",
        "Camera \"perspective\"\nWorldBegin\nInclude \"parts/a.pbrt\"\nShape \"sphere\"\nWorldEnd",
    );
    write(root, "parts/a.pbrt", "Material \"mirror\"\nInclude \"b.pbrt\"\nInclude \"shared.pbrt\"");
    write(root, "parts/b.pbrt", "Shape \"sphere\"\n Oops 3");
    write(root, "shared.pbrt", "Shape \"sphere\" \"float radius\" 5");
    let file = pbrt::load(&main).expect("a scene");
    assert_eq!(file.scene.shapes.len(), 3);
    assert_eq!(file.scene.materials.len(), 1, "the material of the included file holds on");
    assert_eq!(sphere(&file.scene.shapes[1]).1, 5.0, "found beside the main file, as pbrt does");
    let place = &file.warnings[0].location;
    assert!(place.file.ends_with("b.pbrt") && (place.line, place.column) == (2, 2), "{place}");
    // The same text with a folder given.
    let text = fs::read_to_string(&main).expect("text");
    assert_eq!(pbrt::parse(&text, "x", Some(root)).expect("a scene").scene.shapes.len(), 3);
    assert_failure(&text, 3, 1, &["parts/a.pbrt", "no folder"]);

    let message = |content: &str| {
        let main = write(root, "bad.pbrt", content);
        pbrt::load(&main).expect_err("an error").to_string()
    };
    write(root, "loop.pbrt", "\nInclude \"bad.pbrt\"");
    assert!(message("Include \"loop.pbrt\"").contains("loop.pbrt:2:1: Include of"));
    assert!(message("Include \"bad.pbrt\"").contains("bad.pbrt:1:1: Include of"));
    assert!(message("Include \"none.pbrt\"").contains("bad.pbrt:1:1: Include: cannot read"));
    assert!(message("Include none").contains("bad.pbrt:1:9"));
    assert!(message("Include \"parts\"").contains("a folder"));
    // Twice, but not inside itself, is fine.
    let twice = write(root, "twice.pbrt", "WorldBegin Include \"shared.pbrt\" Include \"shared.pbrt\" WorldEnd");
    assert_eq!(pbrt::load(&twice).expect("a scene").scene.shapes.len(), 2);
    // Many includes of includes end.
    for i in 0..30 {
        let next = format!("Include \"deep{}.pbrt\" ", i + 1);
        write(root, &format!("deep{i}.pbrt"), next.repeat(3));
    }
    assert!(message("Include \"deep0.pbrt\"").contains("at most 16 deep"));
    for i in 0..12 {
        let next = format!("Include \"wide{}.pbrt\" ", i + 1);
        write(root, &format!("wide{i}.pbrt"), if i == 11 { String::new() } else { next.repeat(3) });
    }
    assert!(message("Include \"wide0.pbrt\"").contains("at most 1000"));
}

const PLY_ASCII: &str = "ply\nformat ascii 1.0\ncomment a square\nelement vertex 4\nproperty float x\nproperty float y\n\
    property float z\nproperty uchar red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0.5 9\n4 0 1 2 3\n";

fn ply_binary(big: bool) -> Vec<u8> {
    let order = if big { "big" } else { "little" };
    let mut out = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement vertex 4\nproperty double x\nproperty float y\nproperty float z\n\
         element face 2\nproperty uchar flags\nproperty list uchar uint vertex_index\nend_header\n"
    )
    .into_bytes();
    let f32 = |v: f32| if big { v.to_be_bytes() } else { v.to_le_bytes() };
    let u32 = |v: u32| if big { v.to_be_bytes() } else { v.to_le_bytes() };
    for [x, y, z] in [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5f32]] {
        let x = f64::from(x);
        out.extend(if big { x.to_be_bytes() } else { x.to_le_bytes() });
        out.extend(f32(y));
        out.extend(f32(z));
    }
    for face in [[0, 1, 2], [0, 2, 3]] {
        out.extend([7, 3]);
        out.extend(face.into_iter().flat_map(u32));
    }
    out
}

#[test]
fn ply_meshes() {
    let dir = tempfile::tempdir().expect("a folder");
    write(dir.path(), "ascii.ply", PLY_ASCII);
    write(dir.path(), "crlf.ply", PLY_ASCII.replace('\n', "\r\n"));
    write(dir.path(), "little.ply", ply_binary(false));
    write(dir.path(), "big.ply", ply_binary(true));
    for name in ["ascii.ply", "crlf.ply", "little.ply", "big.ply"] {
        let text = world(&format!("Translate 0 0 1 Shape \"plymesh\" \"string filename\" \"{name}\""));
        let file = pbrt::parse(&text, "t.pbrt", Some(dir.path())).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_no_warnings(&file);
        let (positions, triangles) = mesh(&file.scene.shapes[0]);
        assert_eq!(positions[3], Vec3::new(0.0, 1.0, 1.5), "{name}");
        assert_eq!(**triangles, [[0, 1, 2], [0, 2, 3]], "{name}: a quad is two triangles");
    }
}

#[test]
fn bad_ply_files_are_errors_at_the_shape() {
    let dir = tempfile::tempdir().expect("a folder");
    let message = |content: &[u8]| {
        write(dir.path(), "bad.ply", content);
        let text = world("Shape \"plymesh\" \"string filename\" \"bad.ply\"");
        let e = pbrt::parse(&text, "t.pbrt", Some(dir.path())).expect_err("an error").to_string();
        assert!(e.starts_with("t.pbrt:3:35: plymesh: ") && e.contains("bad.ply"), "{e}");
        assert!(!e.contains('\n'), "one line: {e}");
        e
    };
    assert!(message(b"hello").contains("magic"));
    assert!(message(PLY_ASCII.replace("4 0 1 2 3", "4 0 1 2 4").as_bytes()).contains("vertex index 4"));
    assert!(message(PLY_ASCII.replace("4 0 1 2 3", "4 0 1 2 -1").as_bytes()).contains("vertex_indices"));
    assert!(message(PLY_ASCII.replace("4 0 1 2 3", "2 0 1").as_bytes()).contains("at least 3"));
    assert!(message(PLY_ASCII.replace("property float y\n", "property float w\n").as_bytes()).contains("x, y or z"));
    assert!(message(PLY_ASCII.replace("0 0 0 9\n1", "0 0 1e99 9\n1").as_bytes()).contains("finite"));
    message(PLY_ASCII.replace("0 0 0 9\n1", "0 nan 0 9\n1").as_bytes());
    // Counts that no file could hold are refused before memory is asked for.
    assert!(message(PLY_ASCII.replace("vertex 4", "vertex 999999999999").as_bytes()).contains("announced"));
    assert!(
        message(PLY_ASCII.replace("element face", "element ghost 99999999\nelement face").as_bytes())
            .contains("announced")
    );
    let mut binary = ply_binary(false);
    let header_end = binary.len() - 28 + 1;
    binary[header_end] = 255;
    message(&binary);
    message(&ply_binary(true)[..200]);
    message(PLY_ASCII.replace("uchar int vertex", "float int vertex").replace("4 0 1 2 3", "4.5 0 1 2 3").as_bytes());
}

// --- Damaged files ----------------------------------------------------------------------------

/// A small generator of pseudo-random numbers (SplitMix64), so that the damage is always the same.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n as u64) as usize
    }
}

/// Changes, inserts, deletes or duplicates a few bytes.
fn damage(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    const LIKELY: &[u8] = b"\"[]#-+.e0129 \n\\'\xe2\x80\x9c\xc2\xa0AWS";
    let mut out = bytes.to_vec();
    for _ in 0..1 + random.below(6) {
        let at = random.below(out.len());
        match random.below(5) {
            0 => out[at] = random.below(256) as u8,
            1 => out[at] = LIKELY[random.below(LIKELY.len())],
            2 => out.insert(at, LIKELY[random.below(LIKELY.len())]),
            3 => {
                let end = (at + 1 + random.below(40)).min(out.len() - 1);
                out.drain(at.min(end)..end);
            }
            _ => {
                let end = (at + random.below(80)).min(out.len());
                let piece = out[at..end].to_vec();
                let to = random.below(out.len());
                out.splice(to..to, piece);
            }
        }
    }
    out
}

#[test]
fn damaged_scenes_never_panic() {
    let mut random = Random(1);
    let mut read = 0;
    for scene in [pbrt::DEFAULT_SCENE, pbrt::PLASTIC_SCENE, HEADER_MIS_ALL] {
        for _ in 0..2500 {
            let bytes = damage(scene.as_bytes(), &mut random);
            match pbrt::parse(&String::from_utf8_lossy(&bytes), "damaged.pbrt", None) {
                Ok(file) => {
                    read += 1;
                    assert_eq!(file.settings.check(), Ok(()), "what is read can be rendered");
                    assert!(
                        file.scene.shapes.iter().all(|s| s.material.is_none_or(|m| m < file.scene.materials.len()))
                    );
                }
                Err(e) => assert!(!e.to_string().contains('\n'), "one line: {e}"),
            }
        }
    }
    assert!(read > 500, "some damage is harmless, {read} were read");
}

#[test]
fn damaged_ply_files_never_panic() {
    let dir = tempfile::tempdir().expect("a folder");
    let text = world("Shape \"plymesh\" \"string filename\" \"x.ply\"");
    let mut random = Random(2);
    for original in [PLY_ASCII.as_bytes().to_vec(), ply_binary(false), ply_binary(true)] {
        for _ in 0..500 {
            write(dir.path(), "x.ply", damage(&original, &mut random));
            // Either is fine; only a panic or an endless loop is not.
            let _ = pbrt::parse(&text, "t.pbrt", Some(dir.path()));
        }
    }
}
