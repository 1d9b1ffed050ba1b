//! Errors and warnings, and where they point.

use crate::{assert_failure, parse};

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
