//! The current matrix and the blocks that save it.

use glam::Vec3;

use crate::{
    assert_failure, assert_left_out, assert_matrix, assert_no_warnings, assert_warning, ctm, parse, sphere, warnings,
    world,
};

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
fn degenerate_transformations_are_left_out() {
    assert_left_out("\n LookAt 1 1 1  1 1 1  0 1 0", 2, 2, &["LookAt", "apart"]);
    assert_left_out("LookAt 0 0 0  0 2 0  0 1 0", 1, 1, &["LookAt", "up"]);
    assert_left_out("Rotate 90 0 0 0", 1, 1, &["axis 0 0 0"]);
    assert_left_out("Translate 1 2", 1, 1, &["Translate with 2 numbers, expected 3"]);
    assert_left_out("Translate 1 2 \"x\"", 1, 15, &["expected 3 numbers"]);
    assert_left_out("Transform [1 0 0 1  0 1 0 0  0 0 1 0  0 0 0 1]", 1, 1, &["projective"]);
    assert_left_out(&"Scale 1e38 1e38 1e38\n".repeat(9), 3, 1, &["too large"]);
    assert_left_out("CoordSysTransform \"nowhere\"", 1, 1, &["nowhere"]);
    // What follows stands where it would without them.
    let degenerate = world("Translate 1 0 0\nScale 1 0 1\nRotate 20 0 0 0\nShape \"sphere\"");
    let file = assert_warning(&degenerate, 4, 1, &["Scale", "a scale is 0", "what follows is drawn without it"]);
    assert_eq!(sphere(&file.scene.shapes[0]), (Vec3::X, 1.0));
    assert_eq!(warnings(&file).len(), 2);
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
         Shape \"sphere\" \"float radius\" 2",
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

    assert_left_out(&world("AttributeEnd"), 3, 1, &["AttributeEnd without AttributeBegin"]);
    assert_left_out(&world("TransformEnd"), 3, 1, &["TransformEnd without TransformBegin"]);
    let file = parse(&world("\n AttributeBegin"));
    assert_eq!(warnings(&file), [(4, 2, "AttributeBegin is never closed")]);
    assert_left_out(&world(&"AttributeBegin\n".repeat(100_001)), 100_003, 1, &["at most 100000"]);
    assert_warning(&world("AttributeBegin 3 AttributeEnd"), 3, 16, &["values after AttributeBegin"]);
}

#[test]
fn crossed_blocks_are_closed_as_in_pbrt() {
    let crossed = |body: &str| {
        let file = assert_warning(&world(body), 4, 1, &["End, expected ", "Begin of line 3"]);
        assert_eq!(file.warnings.iter().filter(|w| w.message.contains("expected")).count(), 1, "said once");
        file.scene.shapes.iter().map(|s| sphere(s).0.x).collect::<Vec<f32>>()
    };
    // Each end takes back the last of all saved transformations.
    assert_eq!(crossed("AttributeBegin\nTransformEnd AttributeEnd Shape \"sphere\""), [0.0]);
    let text = "Translate 1 0 0 AttributeBegin Translate 2 0 0 TransformBegin Translate 4 0 0\nAttributeEnd
                Shape \"sphere\" TransformEnd Shape \"sphere\"";
    assert_eq!(crossed(text), [3.0, 1.0]);
    // An object lasts until it ends.
    let text = "AttributeBegin ObjectBegin \"bolt\" Shape \"sphere\"\nAttributeEnd Shape \"sphere\" ObjectEnd Shape \"sphere\"";
    assert_eq!(crossed(text), [0.0]);
}

#[test]
fn rotations_typed_with_three_digits_are_rotations() {
    // 30 degrees about (1, 2, 2) / 3, and twice that.
    let typed = "ConcatTransform [.881 .363 -.304 0  -.304 .926 .225 0  .363 -.106 .926 0  0 0 0 1]";
    for text in [typed.to_owned(), format!("{typed} {typed}"), format!("Scale 3 3 3 {typed} Scale .5 .5 .5")] {
        let file = parse(&world(&format!("{text} Shape \"sphere\"")));
        assert_no_warnings(&file);
        let (_, radius) = sphere(&file.scene.shapes[0]);
        let expected = if text.contains("Scale") { 1.5 } else { 1.0 };
        assert!((radius / expected - 1.0).abs() < 2e-3, "{radius}");
    }
    assert_warning(&world("Scale 1 1 1.01\nShape \"sphere\""), 4, 1, &["ellipsoid"]);
}

#[test]
fn structure_of_the_file() {
    assert_left_out("Shape \"sphere\"", 1, 1, &["before WorldBegin"]);
    assert_left_out("WorldEnd", 1, 1, &["without WorldBegin"]);
    assert_left_out("WorldBegin\nWorldBegin", 2, 1, &["one WorldBegin"]);
    assert_failure("", 1, 1, &["no pbrt directive"]);
    assert_failure("Dear students, ...", 1, 6, &["students,", "expected"]);
    let file = parse("Camera \"perspective\"\nWorldBegin WorldEnd\nShape \"sphere\" Shape \"sphere\"");
    assert_eq!(warnings(&file), [(3, 1, "what follows WorldEnd is not read")]);
    assert_eq!(parse("Camera \"perspective\"\nWorldBegin\n").warnings.len(), 1);
}

#[test]
fn camera_is_a_coordinate_system() {
    // In the camera's own system one unit ahead of the eye, along +z.
    let file = parse(
        "LookAt 1 2 3  7 2 3  0 0 1 Camera \"perspective\" WorldBegin
         Translate 9 9 9 CoordSysTransform \"camera\" Translate 0 0 1 Shape \"sphere\"
         CoordSysTransform \"world\" Shape \"sphere\" WorldEnd",
    );
    let centers: Vec<Vec3> = file.scene.shapes.iter().map(|s| sphere(s).0).collect();
    assert_eq!(centers, [Vec3::new(2.0, 2.0, 3.0), Vec3::ZERO]);
}
