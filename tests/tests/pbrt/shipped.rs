//! The scenes shipped, against their published numbers.

use glam::{DVec3, Vec3};
use mislab_kernel::world::BuiltScene;
use mislab_renderer::{Bsdf, Reflectance, Settings, Shape, pbrt};

use crate::{assert_matrix, assert_no_warnings, mesh, parse, sphere};

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
    // The exact reflectance in double precision, rounded to single, at all but the last 0.01 degrees.
    let scene = pbrt::embedded_scene().scene;
    let Some(Bsdf::Conductor { reflectance: Reflectance::Fresnel { eta, k }, .. }) =
        scene.material("plate2").map(|m| &m.bsdf)
    else {
        panic!("plate2 is a metal")
    };
    let (eta, k) = (f64::from(eta.x), f64::from(k.x));
    for cos in [1.0, 0.9, 0.5, 0.1, 1e-2, 1e-3, 1.8e-4] {
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
    assert_eq!(camera.world_from_camera.w_axis.truncate(), DVec3::new(0.0, 2.0, 15.0));
    assert_matrix(
        camera.world_from_camera,
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
    assert_eq!(file.settings.image.resolution, [768, 512]);
    assert_eq!(file.scene.camera.fov_deg, 28.0);
    assert_eq!(file.scene.light_shapes().count(), 5);
    let overhead = &file.scene.shapes[4];
    assert_eq!(sphere(overhead), (Vec3::new(10.0, 10.0, 4.0), 0.5));
    let expected = [0.1033, 0.1925, 0.3125, 0.4618];
    for (i, alpha) in expected.into_iter().enumerate() {
        let material = file.scene.material(&format!("plate{}", i + 1)).expect("a plate");
        let Bsdf::Plastic { kd, ks, alpha: found, swapped_indices } = material.bsdf else { panic!("plastic") };
        assert_eq!((kd, ks, swapped_indices), (Vec3::new(0.07, 0.09, 0.13), Vec3::ONE, false));
        assert!((found - alpha).abs() < 1e-4, "alpha {found}, expected {alpha}");
    }
}

#[test]
fn shipped_scenes_can_be_rendered() {
    for file in [pbrt::embedded_scene(), pbrt::embedded_plastic_scene()] {
        assert!(BuiltScene::new(&file.scene, &file.settings).is_ok(), "{}", file.scene.name);
    }
}
