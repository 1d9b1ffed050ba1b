//! The tutorial's table: whose pixel is it, how wrong is it, and who gets the cross.

use std::sync::Arc;

use glam::{DMat4, DVec3, DVec4, Vec3};
use mislab_renderer::pbrt::embedded_scene;
use mislab_renderer::table::quality::{Reference, crosses, mean_and_error, p_value_above, sidak};
use mislab_renderer::table::regions::{Groups, Square, visible_materials};
use mislab_renderer::table::{LightSize, LobeWidth, TableOptions, TableResult, TutorialRun, run_table};
use mislab_renderer::{Bsdf, Camera, Geometry, Light, Material, Reflectance, Scene, Shape, Strategy};

fn metal(name: &str, alpha: f32) -> Material {
    Material { name: name.into(), bsdf: Bsdf::Conductor { reflectance: Reflectance::Constant(Vec3::ONE), alpha } }
}

fn quad(corners: [Vec3; 4], material: usize) -> Shape {
    Shape {
        geometry: Geometry::Mesh {
            positions: Arc::new(corners.into()),
            triangles: Arc::new(vec![[0, 1, 2], [0, 2, 3]]),
        },
        reverse_orientation: false,
        material: Some(material),
        light: None,
    }
}

fn ball(name: &str, center: Vec3, radius: f32) -> Shape {
    Shape {
        geometry: Geometry::Sphere { center, radius },
        reverse_orientation: false,
        material: None,
        light: Some(Light { name: name.into(), radiance: Vec3::ONE, on: true }),
    }
}

/// At the origin, looking along z, 90 degrees wide: the plane z = 1 shows x and y in [-1, 1].
fn camera() -> Camera {
    Camera { world_from_camera: DMat4::IDENTITY, fov_deg: 90.0, screen_window: None }
}

/// A wall of matte in which two metals stand, seen head on, and a small ball before one of them.
fn simple() -> Scene {
    let strip = |x0: f32, x1: f32, z: f32, m: usize| {
        quad([Vec3::new(x0, -5.0, z), Vec3::new(x1, -5.0, z), Vec3::new(x1, 5.0, z), Vec3::new(x0, 5.0, z)], m)
    };
    Scene {
        name: "simple".into(),
        camera: camera(),
        materials: vec![
            metal("rough", 0.5),
            Material { name: "wall".into(), bsdf: Bsdf::Matte { kd: Vec3::ONE } },
            metal("smooth", 0.0),
            metal("unused", 0.3),
        ],
        shapes: vec![
            strip(-20.0, 20.0, 2.0, 1),
            strip(-0.9, -0.1, 1.0, 2),
            strip(0.1, 0.9, 1.0, 0),
            ball("big", Vec3::new(0.0, 30.0, 0.0), 3.0),
            ball("small", Vec3::new(0.25, 0.25, 0.5), 0.02),
        ],
    }
}

#[test]
fn pixels_show_a_material_only_if_centre_and_corners_agree() {
    // 8 x 8 pixels of 0.25: the strips begin and end inside pixels 0, 3, 4 and 7.
    let found = visible_materials(&simple(), [8, 8]);
    let (wall, smooth, rough) = (Some(1), Some(2), Some(0));
    for (y, row) in found.chunks(8).enumerate() {
        let mut expected = [None, smooth, smooth, None, None, rough, rough, None];
        if y == 1 || y == 2 {
            // The ball is seen around (0.5, 0.5), a corner of four pixels.
            expected[5] = None;
            expected[6] = None;
        }
        assert_eq!(row, expected, "row {y}");
    }
    let mut turned = simple();
    turned.camera.screen_window = Some([-8.0, 8.0, -1.0, 1.0]);
    assert_eq!(visible_materials(&turned, [8, 8])[0], wall, "the screen window widens the view");
    turned.camera.world_from_camera = DMat4::from_rotation_y(std::f64::consts::PI);
    assert!(visible_materials(&turned, [8, 8]).iter().all(Option::is_none), "nothing is behind the camera");
}

#[test]
fn surfaces_that_pass_the_camera_are_seen() {
    let mut scene = simple();
    scene.shapes = vec![quad(
        [
            Vec3::new(-50.0, -1.0, -50.0),
            Vec3::new(50.0, -1.0, -50.0),
            Vec3::new(50.0, -1.0, 50.0),
            Vec3::new(-50.0, -1.0, 50.0),
        ],
        0,
    )];
    let found = visible_materials(&scene, [4, 4]);
    assert_eq!(&found[..8], [None; 8], "sky");
    assert_eq!(&found[12..], [Some(0); 4], "the floor underfoot");
}

#[test]
fn veach_plates_are_where_they_are_in_the_picture() {
    // LookAt 0 2 15 / 0 1.69521 14.0476 / 0 0.952421 -0.304787 between two flips of x, as public scene files have it.
    let (eye, forward) = (DVec3::new(0.0, 2.0, 15.0), DVec3::new(0.0, 1.69521 - 2.0, 14.0476 - 15.0).normalize());
    let right = DVec3::new(0.0, 0.952421, -0.304787).cross(forward).normalize();
    let look = DMat4::from_cols(
        right.extend(0.0),
        forward.cross(right).extend(0.0),
        forward.extend(0.0),
        DVec4::new(eye.x, eye.y, eye.z, 1.0),
    );
    let flip = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let plates = [
        [-2.70651, 0.25609, -2.08375, -0.526323],
        [-3.28825, 1.36973, -2.83856, 0.476536],
        [-3.73096, 2.70046, -3.43378, 1.74564],
        [-3.99615, 4.0667, -3.82069, 3.08221],
    ];
    let plate = |(i, [y0, z0, y1, z1]): (usize, [f32; 4])| {
        quad([Vec3::new(-4.0, y0, z0), Vec3::new(-4.0, y1, z1), Vec3::new(4.0, y1, z1), Vec3::new(4.0, y0, z0)], i)
    };
    let scene = Scene {
        name: "veach".into(),
        camera: Camera { world_from_camera: flip * look * flip, fov_deg: 41.0108, screen_window: None },
        materials: (1..=4).map(|i| metal(&format!("plate{i}"), 0.1)).collect(),
        shapes: plates.into_iter().enumerate().map(plate).collect(),
    };
    let found = visible_materials(&scene, [400, 400]);
    let counts: Vec<_> = (0..4).map(|m| found.iter().filter(|f| **f == Some(m)).count()).collect();
    assert!(counts.iter().all(|&n| n > 2000), "pixels per plate: {counts:?}");
    let first_row = |m| found.iter().position(|f| *f == Some(m)).expect("is seen") / 400;
    assert!((0..3).all(|m| first_row(m) < first_row(m + 1)), "the mirror is the farthest and highest");
}

#[test]
fn plates_and_lights_sort_into_halves() {
    let scene = simple();
    let groups = Groups::of(&scene).expect("two metals, two lights");
    assert_eq!((&groups.sharp[..], &groups.broad[..]), (&[2][..], &[0][..]), "by roughness; unused ones do not count");
    assert_eq!((&groups.small[..], &groups.large[..]), (&[4][..], &[3][..]), "by radius");

    let mut named = simple();
    for (material, name) in named.materials.iter_mut().zip(["plate4", "wall", "plate3", "plate1"]) {
        material.name = name.into();
    }
    named.materials.push(metal("plate2", 0.9));
    named.shapes.extend([3, 4].map(|m| quad([Vec3::ZERO, Vec3::X, Vec3::ONE, Vec3::Y], m)));
    let groups = Groups::of(&named).expect("four plates");
    assert_eq!((&groups.sharp[..], &groups.broad[..]), (&[3, 4][..], &[2, 0][..]), "by name, whatever the roughness");

    let mut three = simple();
    three.shapes.push(ball("middle", Vec3::splat(9.0), 1.0));
    assert_eq!(Groups::of(&three).expect("three lights").small, [4], "the middle one of three counts as large");
    three.shapes[5].light.as_mut().expect("a light").on = false;
    three.shapes[3].light.as_mut().expect("a light").on = false;
    let error = Groups::of(&three).expect_err("one light").to_string();
    assert!(error.contains("1 lights that are on"), "{error}");
    let mut dull = simple();
    dull.shapes.remove(1);
    let error = Groups::of(&dull).expect_err("one metal").to_string();
    assert!(error.contains("1 glossy surfaces"), "{error}");
}

#[test]
fn a_pixel_belongs_to_the_light_that_contributes_most() {
    let groups = Groups { sharp: vec![2], broad: vec![0], small: vec![4], large: vec![3] };
    let materials = [Some(2), Some(2), Some(0), Some(0), Some(1), None, Some(0)];
    let small = vec![2.0, 1.0, 5.0, 1e-9, 9.0, 9.0, 0.0];
    let large = vec![1.0, 3.0, 4.0, 1e-8, 1.0, 1.0, 0.0];
    let square = |light, bsdf| Some(Square { light, bsdf });
    let expected = [
        square(LightSize::Small, LobeWidth::Sharp),
        square(LightSize::Large, LobeWidth::Sharp),
        square(LightSize::Small, LobeWidth::Broad),
        square(LightSize::Large, LobeWidth::Broad),
        None, // a wall
        None, // nothing
        None, // no light at all
    ];
    assert_eq!(groups.squares(&materials, &[small, large]), expected);
}

/// Numbers in [-1, 1) (xorshift32, fixed seed); variance 1/3.
fn noise() -> impl FnMut() -> f64 {
    let mut state = 0x1234_5678_u32;
    move || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        f64::from(state) / f64::from(1_u32 << 31) - 1.0
    }
}

#[test]
fn relmse_by_hand() {
    let square = |light, bsdf| Some(Square { light, bsdf });
    let squares = [
        square(LightSize::Small, LobeWidth::Broad),
        square(LightSize::Large, LobeWidth::Sharp),
        None,
        square(LightSize::Large, LobeWidth::Sharp),
    ];
    let half = |offset: f64| [1.0, 2.0, 3.0].map(|c| vec![c + offset; 4]);
    let reference = Reference { halves: [half(0.1), half(-0.1)] };
    let (r, g, b) = ([1.5_f32, 1.0, 99.0, 1.0], [2.0_f32, 2.0, 99.0, 2.0], [3.0_f32, 5.0, 99.0, 3.0]);
    let found = reference.rel_mse([&r, &g, &b], &squares);
    // (x - r1)(x - r2) = (x - r)^2 - 0.01 for halves 0.1 above and below
    let expected_small_broad = ((0.25 - 0.01) / 1.01 - 0.01 / 4.01 - 0.01 / 9.01) / 3.0;
    let exact = -0.01 / 1.01 - 0.01 / 4.01 - 0.01 / 9.01;
    let expected_large_sharp = (exact + (exact + 4.0 / 9.01)) / 6.0;
    assert!((found[0].expect("one pixel") - expected_small_broad).abs() < 1e-9, "{found:?}");
    assert!((found[3].expect("two pixels") - expected_large_sharp).abs() < 1e-9, "{found:?}");
    assert_eq!((found[1], found[2]), (None, None), "squares without pixels");
    let own = reference.own_rel_mse(&squares)[0].expect("one pixel");
    assert!((own - (0.01 / 1.01 + 0.01 / 4.01 + 0.01 / 9.01) / 3.0).abs() < 1e-12, "{own}");
}

#[test]
fn the_noise_of_the_reference_does_not_count_as_error_of_the_picture() {
    let (n, mut noise) = (40_000, noise());
    let squares = vec![Some(Square::ALL[0]); n];
    let mut plane = |size: f64| (0..n).map(|_| 1.0 + size * noise()).collect::<Vec<f64>>();
    let reference = Reference { halves: [0, 1].map(|_| [plane(0.05), plane(0.05), plane(0.05)]) };
    let picture = [0, 1, 2].map(|_| plane(0.1).into_iter().map(|v| v as f32).collect::<Vec<f32>>());
    let found = reference.rel_mse([&picture[0], &picture[1], &picture[2]], &squares)[0].expect("pixels");
    // Variance of the picture over r^2 + epsilon. With (x - r)^2 it would be an eighth more.
    let expected = 0.01 / 3.0 / 1.01;
    assert!((found / expected - 1.0).abs() < 0.03, "{found}, expected {expected}");
}

#[test]
fn rank_test_agrees_with_counting_by_hand() {
    // 2 of a and 2 of b: 6 orders, with a above in 0, 1, 2, 2, 3 and 4 pairs.
    for (a, p) in [
        ([0.1, 0.2], 1.0),
        ([0.1, 1.5], 5.0 / 6.0),
        ([0.1, 2.5], 4.0 / 6.0),
        ([1.5, 2.5], 2.0 / 6.0),
        ([3.0, 4.0], 1.0 / 6.0),
    ] {
        let found = p_value_above(&a, &[1.0, 2.0]);
        assert!((found - p).abs() < 1e-12, "{a:?}: {found}, expected {p}");
    }
    assert!((p_value_above(&[9.0; 5], &[1.0; 5]) - 1.0 / 252.0).abs() < 1e-12, "one order of 252");
    assert_eq!(p_value_above(&[1.0, 1.0], &[1.0, 1.0]), 1.0, "ties tell nothing");
    let (mean, error) = mean_and_error(&[1.0, 2.0, 3.0, 6.0]);
    assert_eq!(mean, 3.0);
    assert!((error - (14.0_f64 / 3.0 / 4.0).sqrt()).abs() < 1e-12);
}

#[test]
fn crosses_go_to_the_best_and_to_what_cannot_be_told_from_it() {
    let around = |mean: f64| [0.9, 0.95, 1.0, 1.05, 1.1].map(|v| v * mean);
    let outlier = [2.0, 2.1, 2.2, 2.3, 900.0];
    let (best, near, far) = (around(1.0), around(1.1), around(9.0));
    let each = sidak(0.05, 12);
    assert_eq!(crosses(&[&best, &near, &far, &outlier], each), [true, true, false, false]);
    assert_eq!(crosses(&[&[], &far, &[], &far], each), [false, true, false, true]);
    assert_eq!(crosses(&[&[][..]; 4], each), [false; 4]);
    // 1 - (1 - 0.05)^(1/12)
    assert!((each - 0.004_265_3).abs() < 1e-6, "{each}");
}

#[test]
fn the_files_are_the_tutorials() {
    let files: Vec<_> = TutorialRun::ALL.iter().map(|run| run.file).collect();
    assert_eq!(files, ["veachMIS_L.exr", "veachMIS_BSDF.exr", "veach_MIS_ALLx36.exr", "veachMIS_MIS.exr"]);
    let settings = TutorialRun::ALL[2].settings(None, 7);
    assert_eq!(
        (settings.estimator.strategy, settings.image.resolution, settings.sampling.seed),
        (Strategy::MisAll, [600, 600], 7)
    );
    assert_eq!((settings.sampling.sampler.strata, settings.sampling.spp.map(|n| n.get())), ([6, 6], Some(36)));
    assert_eq!(TutorialRun::ALL[3].settings(Some([40, 30]), 1).image.resolution, [40, 30]);
}

#[test]
fn a_small_table_of_the_tutorials_scene_says_what_the_picture_shows() {
    let scene = Arc::new(embedded_scene().scene);
    let options = TableOptions { size: Some([64, 64]), reference_spp: 64, replicates: 5, threads: 2, seed: 1 };
    let (mut last, mut finished) = (0.0, Vec::new());
    let result = run_table(&scene, &options, &mut |p| {
        assert!((last..=1.0).contains(&p.fraction), "{} after {last}", p.fraction);
        last = p.fraction;
        finished.extend(p.finished.as_ref().map(|(run, frame)| (run.file, frame.spp())));
        true
    });
    let TableResult { table, frames } = result.expect("can be rendered").expect("nobody stopped it");
    println!("{}", table.to_markdown());
    assert_eq!(
        finished,
        [("veachMIS_L.exr", 64), ("veachMIS_BSDF.exr", 64), ("veach_MIS_ALLx36.exr", 36), ("veachMIS_MIS.exr", 64)]
    );
    assert_eq!(frames.len(), 4);
    assert_eq!(table.rows.iter().map(|r| r.paths).collect::<Vec<_>>(), [64, 64, 72, 64].map(|n| n * 64 * 64));
    let error = |row: usize, cell: usize| table.rows[row].cells[cell].rel_mse.expect("every square has pixels");
    let [light, bsdf, all] = [0, 1, 2];
    let [small_broad, small_sharp, large_broad, large_sharp] = [0, 1, 2, 3];
    assert!(
        error(light, small_broad) < error(bsdf, small_broad) / 4.0,
        "light sampling is for small lights, broad lobes"
    );
    assert!(
        error(bsdf, large_sharp) < error(light, large_sharp) / 4.0,
        "BSDF sampling is for large lights, sharp lobes"
    );
    for cell in [small_broad, small_sharp, large_broad, large_sharp] {
        assert!(
            error(all, cell) < 8.0 * error(light, cell).min(error(bsdf, cell)),
            "mis_all is never far from the best"
        );
        assert!(table.rows.iter().any(|row| row.cells[cell].cross), "someone has the cross");
    }
    assert!(!table.rows[light].cells[large_sharp].cross && !table.rows[bsdf].cells[small_broad].cross);

    assert_eq!(table.to_csv().lines().count(), 1 + 16);
    let columns: Vec<_> = table.to_csv().lines().map(|line| line.split(',').count()).collect();
    assert!(columns.iter().all(|&n| n == columns[0]), "{columns:?}");
    let json: serde_json::Value = serde_json::from_str(&table.to_json()).expect("is JSON");
    assert_eq!(json["rows"][2]["strategy"], "mis_all");
    assert_eq!(json["rows"][2]["cells"][3]["light"], "large");
}

#[test]
fn a_table_can_be_stopped_and_refuses_what_it_cannot_do() {
    let scene = Arc::new(embedded_scene().scene);
    let options = TableOptions { size: Some([64, 64]), threads: 1, ..TableOptions::default() };
    let stopped = run_table(&scene, &options, &mut |_| false).expect("stopping is no failure");
    assert!(stopped.is_none());
    let few = TableOptions { replicates: 4, ..options.clone() };
    assert!(run_table(&scene, &few, &mut |_| true).is_err(), "four replicates tell nothing apart");
    let none = TableOptions { size: Some([0, 64]), ..options };
    assert!(run_table(&scene, &none, &mut |_| true).is_err(), "no pixels");
}
