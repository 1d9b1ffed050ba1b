//! Shapes in world space, and lights.

use glam::{DVec3, Vec3};
use mislab_renderer::{Bsdf, Shape};

use crate::{assert_left_out, assert_no_warnings, assert_warning, mesh, parse, sphere, warnings, world};

#[test]
fn area_lights() {
    let file = parse(&world(
        "AreaLightSource \"diffuse\" \"rgb L\" [1 2 3] \"rgb scale\" [2 2 2] Shape \"sphere\"
         Translate 3 0 0 Material \"matte\" \"rgb Kd\" [0 0 0] Shape \"sphere\"
         Translate 3 0 0 Material \"mirror\" Shape \"sphere\"
         Translate 3 0 0 AreaLightSource \"area\" Shape \"sphere\"",
    ));
    assert_no_warnings(&file);
    let light = |i: usize| file.scene.shapes[i].light.as_ref().expect("a light");
    assert_eq!((light(0).name.as_str(), light(0).radiance), ("light1", Vec3::new(2.0, 4.0, 6.0)));
    assert_eq!((light(3).name.as_str(), light(3).radiance), ("light4", Vec3::ONE));
    let surfaces: Vec<Option<usize>> = file.scene.shapes.iter().map(|s| s.material).collect();
    assert_eq!(surfaces, [Some(0), None, Some(1), Some(1)], "grey unless a material says otherwise");
    assert_eq!(file.scene.materials[0].bsdf, Bsdf::Matte { kd: Vec3::splat(0.5) });
    assert_warning(&world("AreaLightSource \"diffuse\" \"rgb L\" [1 -1 0]"), 3, 36, &["\"L\"", "1 -1 0", "default"]);
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

    assert_left_out(&world("Shape \"sphere\" \"float radius\" [0]"), 3, 32, &["radius 0"]);
    assert_left_out(&world("Scale 1e30 1e30 1e30\nShape \"sphere\" \"float radius\" 1e30"), 4, 1, &["1e15"]);
    let file =
        parse(&world("Shape \"sphere\" \"float radius\" 2 \"float zmin\" -2 \"float zmax\" 2 \"float phimax\" 360"));
    assert_no_warnings(&file);
    let file = parse(&world("Shape \"sphere\" \"float zmax\" 0.5"));
    assert_eq!(warnings(&file), [(3, 29, "part of a sphere (zmin, zmax, phimax): the whole sphere is used")]);
}

#[test]
fn spheres_scaled_unevenly_are_ellipsoids() {
    let shear = "ConcatTransform [1 0 0 0  1 1 0 0  0 0 1 0  0 0 0 1]";
    for (transform, volume) in
        [("Scale 1 2 3", 6.0), ("Scale -1 2 3", 6.0), (shear, 1.0), ("Rotate 30 1 1 0 Scale 1 1 .1", 0.1)]
    {
        for (light, least) in [("", 30_000), ("AreaLightSource \"diffuse\"", 500)] {
            let file = assert_warning(&world(&format!("{light} {transform}\n Shape \"sphere\"")), 4, 2, &["ellipsoid"]);
            let shape = &file.scene.shapes[0];
            let (positions, triangles) = mesh(shape);
            assert!(triangles.len() > least);
            let corners = triangles.iter().map(|t| t.map(|i| positions[i as usize].as_dvec3()));
            // Signed: all normals are outward.
            let outward = if shape.reverse_orientation { -1.0 } else { 1.0 };
            let found: f64 = outward * corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum::<f64>();
            let expected = volume * 4.0 / 3.0 * std::f64::consts::PI;
            assert!((found / expected - 1.0).abs() < 0.02, "{transform}: {found}, expected {expected}");
        }
    }
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
fn normals_say_which_side_is_in_front() {
    let normal = |prefix: &str, n: &str| {
        let text = world(&format!("{prefix} {TRIANGLE} \"normal N\" [{n} {n} {n}]"));
        let file = parse(&text);
        assert_no_warnings(&file);
        emission_normal(&file.scene.shapes[0])
    };
    for (n, along) in [("1 0 0", Vec3::X), ("-1 0 0", -Vec3::X), ("-.1 3 0", -Vec3::X)] {
        assert_eq!(normal("", n), along);
        // Mirrored they are mirrored, whatever that does to the order of the vertices.
        assert_eq!(normal("Scale -1 1 1", n), -along);
        assert_eq!(normal("Scale 1 -1 1", n), along);
        assert_eq!(normal("Scale -1 -1 -1", n), -along);
        assert_eq!(normal("Scale .1 1 20", n), along);
        // As in pbrt-v3's light samples.
        assert_eq!(normal("ReverseOrientation", n), along);
    }
    // Sheared along x by y, a normal that leans towards y leans back: they stay normals.
    let shear = "ConcatTransform [1 0 0 0  5 1 0 0  0 0 1 0  0 0 0 1]";
    let sheared = normal(shear, "1 .1 0");
    assert!((sheared - Vec3::new(1.0, -5.0, 0.0).normalize()).length() < 1e-6, "{sheared}");
    // Normals that say nothing leave it to the vertices.
    assert_eq!(normal("", "0 1 0"), Vec3::X);
    assert_eq!(normal("ReverseOrientation", "0 0 0"), -Vec3::X);

    // Each triangle by itself: the second is turned round, the first is not.
    let file = parse(&world(
        "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0  0 0 1 1 0 1 0 1 1] \"integer indices\" [0 1 2 3 4 5]
         \"normal N\" [0 0 1 0 0 1 0 0 1  0 0 -1 0 0 -1 0 0 -1]",
    ));
    assert_eq!(
        (&**mesh(&file.scene.shapes[0]).1, file.scene.shapes[0].reverse_orientation),
        (&vec![[0, 1, 2], [3, 5, 4]], false)
    );

    let text = world(&format!("{TRIANGLE} \"normal N\" [-1 0 0]"));
    let file = assert_warning(&text, 3, 117, &["3 values of \"N\"", "3 vertices"]);
    assert_eq!(emission_normal(&file.scene.shapes[0]), Vec3::X, "as if there were none");
    // A letter is no misspelling of another.
    let file = parse(&world(&format!("{TRIANGLE} \"vector S\" [0 0 0]")));
    assert!(!file.warnings[0].message.contains("did you mean"), "{:?}", file.warnings);
}

#[test]
fn sphere_lights_too_small_to_aim_at_keep_their_power() {
    let light = |radius: &str| {
        let text = world(&format!(
            "AreaLightSource \"diffuse\" \"rgb L\" [8 4 2] Translate 0 0 6\nShape \"sphere\" \"float radius\" {radius}"
        ));
        let file = parse(&text);
        let shape = &file.scene.shapes[0];
        let l = shape.light.as_ref().expect("a light").radiance.as_dvec3();
        (file.warnings.clone(), f64::from(sphere(shape).1), l)
    };
    for radius in ["1e-3", "4e-4"] {
        let (warnings, found, l) = light(radius);
        assert!(warnings.is_empty(), "{warnings:?}");
        assert_eq!((found as f32, l), (radius.parse().unwrap_or(0.0), DVec3::new(8.0, 4.0, 2.0)));
    }
    for radius in ["2e-4", "1e-6", "1e-9", "2e-15"] {
        let (warnings, found, l) = light(radius);
        assert!((found - 3e-4).abs() < 1e-9, "5e-5 times the distance from the eye: {found}");
        assert_eq!(warnings.len(), 1);
        for words in [radius, "3.00e-4", "power"] {
            assert!(warnings[0].message.contains(words), "{}", warnings[0]);
        }
        let radius: f64 = radius.parse().unwrap_or(0.0);
        let expected = DVec3::new(8.0, 4.0, 2.0) * (radius / found).powi(2);
        assert!((l / expected - 1.0).abs().max_element() < 1e-6, "{l}, expected {expected}");
    }
    assert_left_out(&world("AreaLightSource \"diffuse\"\nShape \"sphere\" \"float radius\" 1e-16"), 4, 1, &["1e-15"]);
    // A body is not made larger.
    assert_no_warnings(&parse(&world("Translate 0 0 6 Shape \"sphere\" \"float radius\" 1e-9")));
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
    assert_eq!(messages.len(), 2, "uv and the triangle, each once: {messages:?}");
    assert_eq!((file.warnings[0].location.line, file.warnings[1].location.line), (4, 4));

    let mesh = |rest: &str| world(&format!("Shape \"trianglemesh\" {rest}"));
    assert_left_out(&mesh("\"integer indices\" [0 1 2]"), 3, 1, &["point P"]);
    assert_left_out(&mesh("\"point P\" [0 0 0 1 0 0 0 1 0]"), 3, 1, &["indices"]);
    assert_left_out(&mesh("\"point P\" [0 0 0 1]"), 3, 32, &["4 values", "three"]);
    assert_left_out(&mesh("\"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1]"), 3, 70, &["2 values", "three"]);
    assert_left_out(
        &mesh("\"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 3]"),
        3,
        75,
        &["index 3", "3 vertices"],
    );
    assert_left_out(&mesh("\"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1.5 2]"), 3, 73, &["index 1.5"]);
    assert_left_out(&mesh("\"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 -1 2]"), 3, 73, &["index -1"]);
    assert_left_out(&mesh("\"vector P\" [0 0 0]"), 3, 22, &["vector P", "point P"]);
}
