//! The current matrix and the blocks that save it.

use glam::Vec3;

use crate::{assert_failure, assert_matrix, assert_no_warnings, ctm, parse, sphere, warnings, world};

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
