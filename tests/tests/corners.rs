//! No sample is invalid, a NaN or infinite, in the scenes of this program and in corners of what can be
//! described: widths of lobes at the limits, lights tiny, huge, touching and around the camera, scales far
//! from 1. (`patches.rs` has heaps of slivers.)

use std::sync::Arc;

use glam::{DVec3, Vec3};
use mislab_renderer::{
    Bsdf, Estimator, Geometry, Heuristic, OneSampleWeights, Reflectance, SamplerKind, SamplerSettings, Sampling, Scene,
    Settings, Strategy,
};
use mislab_tests::depth::depth;
use mislab_tests::experiment::{camera, independent, render, veach};

/// Every metal of a scene with this width and reflectance.
fn metal(alpha: f32, reflectance: &Reflectance) -> Scene {
    let mut scene = veach();
    for material in &mut scene.materials {
        if material.bsdf.alpha().is_some() {
            material.bsdf = Bsdf::Conductor { reflectance: reflectance.clone(), alpha };
        }
    }
    scene
}

/// The default scene, moved and scaled; the camera with it.
fn moved(scale: f64, by: DVec3) -> Scene {
    let mut scene = veach();
    let place = |p: Vec3| (p.as_dvec3() * scale + by).as_vec3();
    for shape in &mut scene.shapes {
        match &mut shape.geometry {
            Geometry::Sphere { center, radius } => {
                *center = place(*center);
                *radius *= scale as f32;
            }
            Geometry::Mesh { positions, .. } => Arc::make_mut(positions).iter_mut().for_each(|p| *p = place(*p)),
        }
    }
    scene.camera.world_from_camera.w_axis = (scene.camera.world_from_camera.w_axis.truncate() * scale + by).extend(1.0);
    scene
}

/// The default scene after `edit` of its lights: number, centre, radius, radiance.
fn lights(edit: impl Fn(usize, &mut Vec3, &mut f32, &mut Vec3)) -> Scene {
    let mut scene = veach();
    for (i, shape) in scene.light_shapes().collect::<Vec<_>>().into_iter().enumerate() {
        let shape = &mut scene.shapes[shape];
        let (Geometry::Sphere { center, radius }, Some(light)) = (&mut shape.geometry, &mut shape.light) else {
            panic!("the lights are spheres");
        };
        edit(i, center, radius, &mut light.radiance);
    }
    scene
}

fn corners() -> Vec<(String, Scene)> {
    let mut all = vec![
        ("default".to_owned(), veach()),
        ("plastic".to_owned(), mislab_renderer::pbrt::embedded_plastic_scene().scene),
    ];
    let white = Reflectance::Constant(Vec3::ONE);
    for alpha in [0.0, 1e-4, 9.999e-4, 1e-3, 1.001e-3, 0.9, 1.0] {
        all.push((format!("alpha {alpha}"), metal(alpha, &white)));
    }
    for (eta, k) in [(0.0, 0.0), (1e-6, 1e9), (1e9, 0.0), (1.0, 1e-6), (0.2, 3.9)] {
        let reflectance = Reflectance::Fresnel { eta: Vec3::splat(eta), k: Vec3::splat(k) };
        all.push((format!("eta {eta}, k {k}"), metal(0.05, &reflectance)));
    }
    for (scale, by) in [(1e-4, 0.0), (1e4, 0.0), (1.0, 1e4), (1e-4, 1.0)] {
        all.push((format!("scaled by {scale}, moved by {by}"), moved(scale, DVec3::splat(by))));
    }
    for radius in [1e-6, 1e-3, 3.0, 30.0] {
        all.push((format!("lights of radius {radius}"), lights(|_, _, r, _| *r = radius)));
    }
    for radiance in [1e-20, 1e15] {
        all.push((format!("radiance {radiance}"), lights(|_, _, _, e| *e = Vec3::splat(radiance))));
    }
    all.push(("lights in one point".to_owned(), lights(|i, c, r, _| (*c, *r) = (Vec3::ZERO, 0.1 * (i + 1) as f32))));
    all.push(("lights on the wall".to_owned(), lights(|_, c, _, _| c.z = -2.0)));
    all.push(("lights that touch the wall".to_owned(), lights(|_, c, r, _| c.z = -2.0 + *r)));
    all.push(("lights in the floor".to_owned(), lights(|_, c, _, _| c.y = -4.14615)));
    all.push(("light around the camera".to_owned(), lights(|_, c, r, _| (*c, *r) = (Vec3::new(0.0, 2.0, 15.0), 1.0))));
    let mut inward = lights(|_, c, r, _| (*c, *r) = (Vec3::ZERO, 60.0));
    for shape in inward.light_shapes().collect::<Vec<_>>() {
        inward.shapes[shape].reverse_orientation = true;
    }
    all.push(("inside inward lights".to_owned(), inward));
    let mut dark = veach();
    dark.shapes.iter_mut().filter_map(|shape| shape.light.as_mut()).for_each(|light| light.on = false);
    all.push(("no light".to_owned(), dark));
    // Grazing views of the floor, and from a point of the floor.
    for (eye, target) in [
        (DVec3::new(0.0, -4.1461, 14.0), DVec3::new(0.0, -4.1461, 0.0)),
        (DVec3::new(0.0, -4.14615, 9.0), DVec3::new(0.5, -3.0, 0.0)),
    ] {
        all.push((format!("from {eye}"), Scene { camera: camera(eye, target, 60.0), ..veach() }));
    }
    // Enough spheres for a tree.
    let mut many = veach();
    let body = many.shapes[0].clone();
    for i in 0..40 {
        let mut shape = body.clone();
        let at = Vec3::new((i % 8) as f32 - 3.5, -3.0, 2.0 + (i / 8) as f32);
        (shape.geometry, shape.light) = (Geometry::Sphere { center: at, radius: 0.3 }, None);
        many.shapes.push(shape);
    }
    all.push(("40 spheres".to_owned(), many));
    all
}

#[test]
fn no_sample_is_invalid() {
    // 1e8 samples in the ordinary run, 1e10 in the deep one.
    let wanted = depth(1e8, 1e10);
    let scenes = corners();
    let mut combinations = Vec::new();
    for strategy in Strategy::ALL {
        for heuristic in Heuristic::ALL {
            for weights in OneSampleWeights::ALL {
                combinations.push((strategy, heuristic, weights));
            }
        }
    }
    let size = [64, 48];
    let pictures = scenes.len() * combinations.len();
    let spp = (wanted / (pictures as f64 * f64::from(size[0] * size[1]))).ceil() as u32;
    let mut samples = 0.0;
    for (name, scene) in scenes {
        let scene = Arc::new(scene);
        for (i, &(strategy, heuristic, weights)) in combinations.iter().enumerate() {
            let base = independent(spp, 3 + i as u32, size);
            // Not in step with c.
            let kind = SamplerKind::ALL[(i + i / 5) % SamplerKind::ALL.len()];
            let sampler = SamplerSettings { kind, strata: [3, 5], ..base.sampling.sampler };
            let light_prob = [0.5, 0.0, 1.0, 1e-6, 0.9][i % 5];
            let settings = Settings {
                estimator: Estimator { strategy, heuristic, weights, light_prob },
                sampling: Sampling { sampler, ..base.sampling },
                ..base
            };
            let frame = render(&scene, &settings);
            let invalid = frame.stats().invalid_samples;
            assert_eq!(invalid, 0, "{name}: {invalid} invalid samples with {settings:?}");
            samples += f64::from(spp * size[0] * size[1]);
        }
    }
    println!("{samples:e} samples, {pictures} pictures");
    assert!(samples >= wanted, "only {samples:e} samples");
}
