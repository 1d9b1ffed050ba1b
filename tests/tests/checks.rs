//! What is wrong with a scene is found without building it, in the same words.

use std::sync::Arc;

use glam::Vec3;
use mislab_kernel::world::{self, BuiltScene};
use mislab_renderer::pbrt::embedded_scene;
use mislab_renderer::{Bsdf, Geometry, Reflectance, Scene, Settings};

/// The shape of a kind that comes first, and edited.
fn edit_first(scene: &mut Scene, is: impl Fn(&Geometry) -> bool, edit: impl FnOnce(&mut Geometry)) {
    let shape = scene.shapes.iter_mut().find(|shape| is(&shape.geometry)).expect("there is one");
    edit(&mut shape.geometry);
}

fn edit_mesh(scene: &mut Scene, edit: impl FnOnce(&mut Vec<Vec3>, &mut Vec<[u32; 3]>)) {
    let mesh = |geometry: &Geometry| matches!(geometry, Geometry::Mesh { .. });
    edit_first(scene, mesh, |geometry| {
        if let Geometry::Mesh { positions, triangles } = geometry {
            edit(Arc::make_mut(positions), Arc::make_mut(triangles));
        }
    });
}

fn edit_sphere(scene: &mut Scene, edit: impl FnOnce(&mut Vec3, &mut f32)) {
    let sphere = |geometry: &Geometry| matches!(geometry, Geometry::Sphere { .. });
    edit_first(scene, sphere, |geometry| {
        if let Geometry::Sphere { center, radius } = geometry {
            edit(center, radius);
        }
    });
}

type Edit = (&'static str, fn(&mut Scene, &mut Settings));

/// One fault each.
const FAULTS: &[Edit] = &[
    ("strata", |_, settings| settings.sampling.sampler.strata = [0, 8]),
    ("probability", |_, settings| settings.estimator.light_prob = f32::NAN),
    ("field of view", |scene, _| scene.camera.fov_deg = 180.0),
    ("camera", |scene, _| scene.camera.world_from_camera.x_axis.x = f64::NAN),
    ("roughness", |scene, _| {
        scene.materials[1].bsdf = Bsdf::Conductor { reflectance: Reflectance::Constant(Vec3::ONE), alpha: 1.5 };
    }),
    ("reflectance", |scene, _| scene.materials[0].bsdf = Bsdf::Matte { kd: Vec3::new(0.5, 1.5, 0.5) }),
    ("material", |scene, _| {
        let shape = scene.shapes.iter_mut().find(|shape| shape.light.is_none()).expect("a plate");
        shape.material = Some(99);
    }),
    ("radiance", |scene, _| {
        let light = scene.shapes.iter_mut().rev().find_map(|shape| shape.light.as_mut()).expect("a light");
        light.radiance.y = f32::INFINITY;
    }),
    ("sphere", |scene, _| edit_sphere(scene, |_, radius| *radius = 0.0)),
    ("sphere", |scene, _| edit_sphere(scene, |center, _| center.z = f32::NAN)),
    ("sphere", |scene, _| edit_sphere(scene, |_, radius| *radius = 1e-30)),
    ("vertex at", |scene, _| edit_mesh(scene, |positions, _| positions[2].x = 1e16)),
    ("refers to vertex", |scene, _| {
        edit_mesh(scene, |positions, triangles| triangles[0][1] = positions.len() as u32);
    }),
    ("refers to vertex", |scene, _| edit_mesh(scene, |_, triangles| triangles.push([0, 1, u32::MAX]))),
];

#[test]
fn scenes_are_checked_as_by_those_who_build_them() {
    let file = embedded_scene();
    assert_eq!(world::check(&file.scene, &file.settings), Ok(()));
    let both = |first: &Edit, second: &Edit| {
        let (mut scene, mut settings) = (file.scene.clone(), file.settings.clone());
        for (_, edit) in [first, second] {
            edit(&mut scene, &mut settings);
        }
        let found = world::check(&scene, &settings);
        let built = BuiltScene::new(&scene, &settings).map(|_| ());
        assert_eq!(found, built, "{} and {}", first.0, second.0);
        found.expect_err(first.0).0
    };
    for fault in FAULTS {
        let found = both(fault, fault);
        assert!(found.contains(fault.0), "{}: {found}", fault.0);
        // Of two, the same is named.
        for other in FAULTS {
            both(fault, other);
        }
    }
}
