//! Shapes in world space, and lights.

use glam::Vec3;
use mislab_renderer::Shape;

use crate::{assert_failure, assert_no_warnings, mesh, parse, sphere, warnings, world};

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
    assert_failure(&world("Scale 1e30 1e30 1e30\nShape \"sphere\" \"float radius\" 1e30"), 4, 1, &["1e15"]);
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
