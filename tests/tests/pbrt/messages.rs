//! Errors and warnings, and where they point.

use glam::Vec3;

use crate::{assert_failure, assert_left_out, assert_warning, parse, sphere, warnings, world};

#[test]
fn errors_say_where() {
    assert_failure("Film \"image\" \"string filename\" [\"a.exr\"", 1, 32, &["'['", "']'"]);
    assert_failure("Film \"image\" \"string filename", 1, 14, &["quote"]);
    assert_failure("Film \"image\" \"filename\" \"a.exr\"", 1, 14, &["filename", "type name"]);
    assert_failure("Film \"image\" [3]", 1, 14, &["type name"]);
    assert_failure("Film \"image\" \"float scale\"", 1, 14, &["no value"]);
    assert_failure("Film \"image\" \"float scale\" [1 \"x\"]", 1, 31, &["list of numbers"]);
    assert_failure("Film \"image\" \"float scale\" [1 [2]]", 1, 31, &["\"[\""]);
    assert_failure("Film \"image\" ]", 1, 14, &["\"]\""]);
    assert_failure("Film \"image\" \"integer xresolution\" 8O0", 1, 36, &["8O0", "number"]);
    assert_failure("Translate 1,5 0 0", 1, 11, &["1,5", "number"]);
    // Columns count characters, and the first line after a byte order mark starts at 1.
    assert_failure("# äöü\nTransläte 1 2 3", 2, 1, &["Transläte"]);
    assert_failure("\u{feff}mist", 1, 1, &["mist"]);
    assert_failure("Film “imäge” 3", 1, 14, &["type name"]);
}

#[test]
fn a_missing_quote_is_reported_where_the_text_begins() {
    // To the end of the file.
    assert_failure("Film \"image\" \"string filename", 1, 14, &["the text that begins at 1:14 has no closing quote"]);
    assert_failure("Film \"image", 1, 6, &["1:6", "closing quote"]);
    assert_failure("Film \"image\"\n\"", 2, 1, &["2:1", "closing quote"]);
    // To the opening quote of the next text, in which everything is the other way round from there on.
    let text = "\t\"string filename [\"a.exr\"] \"integer xresolution\" [8]";
    assert_failure(&format!("Film \"image\"\n{text}"), 2, 2, &["begins at 2:2 "]);
    for text in [
        "Material \"matte\nShape \"trianglemesh\" \"float x\" 3",
        "Material \"matte\nNamedMaterial \"Floor\"",
        "Material \"matte\nShape \"plymesh\" \"string filename\" \"3d.ply\"",
        "Shape \"plymesh\" \"string filename\" [\"a.ply]\nMaterial \"mirror\"",
    ] {
        let quote = text.find(['\n']).map(|end| text[..end].rfind('"').unwrap_or(0) as u32 + 1);
        let column = quote.unwrap_or(1);
        assert_failure(&world(text), 3, column, &[&format!("begins at 3:{column} has no closing quote")]);
    }
    // What may stand right behind a text.
    let file = parse(
        "Camera\"perspective\"\"float fov\"30\"float lensradius\"[0]WorldBegin Material\"mirror\"Shape\"sphere\"\
                      LightSource\"point\"WorldEnd",
    );
    assert_eq!((file.scene.camera.fov_deg, file.scene.shapes.len()), (30.0, 1));
    parse("Sampler \"stratified\" \"bool jitter\"true#comment\nCamera \"perspective\"#comment\nWorldBegin WorldEnd");
}

#[test]
fn numbers_that_are_none_leave_out_what_they_are_of() {
    for bad in ["1e999", "-1e39", "3.5e38", "nan", "-nan", "NaN", "inf", "+inf", "-Infinity", "nan(0x1)"] {
        assert_left_out(&world(&format!("Translate 0 {bad} 0")), 3, 13, &[bad, "number"]);
        let text = world(&format!("Material \"matte\" \"rgb Kd\" [.1 {bad} .1] Shape \"sphere\""));
        assert_left_out(&text, 3, 31, &[bad, "\"Kd\" is left out"]);
        let text = world(&format!("Shape \"sphere\" Shape \"sphere\" \"float radius\" {bad}"));
        assert_left_out(&text, 3, 46, &[bad]);
        assert_eq!(parse(&text).scene.shapes.len(), 1, "the rest is there");
        let mesh = "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [0 0 0 0 1 0 1 0 0] \"normal N\"";
        let file = parse(&world(&format!("{mesh} [{bad} 0 0 0 0 0 0 0 0]")));
        assert_eq!((file.scene.shapes.len(), file.warnings.len()), (1, 1), "a mesh can do without normals");
        // What is computed is not left to chance.
        assert_failure(&format!("Camera \"perspective\" \"float fov\" {bad}"), 1, 34, &[bad, "finite"]);
    }
}

#[test]
fn commas_separate_numbers() {
    let text = "Camera \"perspective\"\nWorldBegin\nTranslate 1, 2 ,3\n\
                AreaLightSource \"diffuse\" \"rgb L\" [8, 8,\n 4,]\nShape \"sphere\" \"float radius\" 2,\nWorldEnd";
    let file = parse(text);
    assert_eq!(sphere(&file.scene.shapes[0]), (Vec3::new(1.0, 2.0, 3.0), 2.0));
    let light = file.scene.shapes[0].light.as_ref().expect("a light");
    assert_eq!(light.radiance, Vec3::new(8.0, 8.0, 4.0));
    let found = warnings(&file);
    assert_eq!(found.len(), 1, "said once: {found:?}");
    assert_eq!((found[0].0, found[0].1), (3, 12));
    assert!(found[0].2.contains("comma"), "{found:?}");
    // A number that lacks is not made up for, nor does a comma stand inside of one.
    for (values, column, found) in [("8,8 8", 36, "\"8,8\""), ("8,,8 8", 36, "\"8,,8\"")] {
        assert_failure(&world(&format!("AreaLightSource \"diffuse\" \"rgb L\" [{values}]")), 3, column, &[found]);
    }
}

#[test]
fn a_comma_with_no_number_before_it_costs_its_list() {
    for (values, column) in [("8, ,8 8", 39), (",8 8 8", 36), (", 8 8 8", 36), ("8, 8, , 8", 42), (",", 36)] {
        let light = world(&format!("AreaLightSource \"diffuse\" \"rgb L\" [{values}] Shape \"sphere\""));
        let file = assert_warning(&light, 3, column, &["a comma with no number before it", "\"L\" is left out"]);
        assert_eq!(file.scene.shapes[0].light.as_ref().map(|l| l.radiance), Some(Vec3::ONE), "{values}: the default");
    }
    // Without its radius a sphere is another one, without its numbers a translation is none.
    let file =
        assert_warning(&world("Shape \"sphere\" \"float radius\" [, 2]\nShape \"sphere\""), 3, 32, &["left out"]);
    assert_eq!(file.scene.shapes.len(), 1);
    assert_left_out(&world("Translate , 1 2 3"), 3, 11, &["a comma"]);
    assert_left_out(
        &world("Material \"matte\", \"rgb Kd\" [1 1 1]"),
        3,
        17,
        &["\"matte\"", "values without a parameter"],
    );
    assert_failure("Film \"image\" \"integer xresolution\" [,8]", 1, 37, &["a comma"]);
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
