//! Points of the default scene, and of its variants, that mean and variance are known at.

use glam::{DVec3, Vec3};
use mislab_kernel::world::BuiltScene;
use mislab_renderer::inspect::{Inspector, Point};
use mislab_renderer::{Bsdf, Estimator, Reflectance, Scene, Settings};

use crate::experiment::{highlight, independent, keyhole, mesh_lights, veach};

/// Where the default scene's camera is.
pub const EYE: DVec3 = DVec3::new(0.0, 2.0, 15.0);
/// Side of a picture through a keyhole.
const SIDE: u32 = 32;

/// Points to be seen from [`EYE`], each with its scene: those of the default scene and of plates of other roughness.
///
/// # Panics
/// If the scene is not the default one.
pub fn places(veach: &Scene) -> Vec<(String, Scene, DVec3)> {
    let mut all: Vec<_> = points(veach).into_iter().map(|(label, p)| (label, veach.clone(), p)).collect();
    all.extend(rougher(veach));
    all
}

/// The first shape of the scene with the material of that name.
///
/// # Panics
/// If there is none.
fn shape_of(scene: &Scene, material: &str) -> usize {
    let index = scene.materials.iter().position(|m| m.name == material).expect("the material exists");
    scene.shapes.iter().position(|s| s.material == Some(index)).expect("a shape has the material")
}

/// Points of the default scene: the highlights of all lights on all plates, between highlights, and
/// floor and wall lit, half shadowed and near a light.
fn points(scene: &Scene) -> Vec<(String, DVec3)> {
    let mut points = Vec::new();
    for plate in ["plate1", "plate2", "plate3", "plate4"] {
        let shape = shape_of(scene, plate);
        for (i, light) in scene.light_shapes().enumerate() {
            points.push((format!("{plate} at light {}", i + 1), highlight(scene, shape, light, EYE)));
        }
    }
    let mid = |a: &(String, DVec3), b: &(String, DVec3)| (a.1 + b.1) / 2.0;
    for (plate, first) in [("plate2", 4), ("plate3", 8), ("plate4", 12)] {
        let between = mid(&points[first + 2], &points[first + 3]);
        points.push((format!("{plate} between lights 3 and 4"), between));
    }
    let y = -4.14615;
    points.push(("floor in front".to_owned(), DVec3::new(0.7, y, 7.0)));
    points.push(("floor left".to_owned(), DVec3::new(-5.5, y, 4.0)));
    points.push(("floor in a wide penumbra".to_owned(), DVec3::new(4.4, y, 0.0)));
    points.push(("wall beside the smallest light".to_owned(), DVec3::new(-3.4, 0.3, -2.0)));
    points.push(("wall beside the largest light".to_owned(), DVec3::new(2.4, 0.9, -2.0)));
    points.push(("wall above".to_owned(), DVec3::new(0.2, 5.0, -2.0)));
    points.push(("wall beside the plates".to_owned(), DVec3::new(-4.8, -2.5, -2.0)));
    points.push(("wall at the side, lights in a row".to_owned(), DVec3::new(9.0, 0.2, -2.0)));
    points
}

/// The default scene with other roughnesses of its plates, 0 to 0.5, at the highlight of a light, the smallest
/// among them, and beside it.
fn rougher(veach: &Scene) -> Vec<(String, Scene, DVec3)> {
    let mut all = Vec::new();
    for (i, alpha) in [0.0f32, 0.002, 0.01, 0.03, 0.15, 0.3, 0.5].into_iter().enumerate() {
        let mut scene = veach.clone();
        let plate = ["plate1", "plate2", "plate3", "plate4"][i % 4];
        *scene.material_mut(plate).and_then(|m| m.bsdf.alpha_mut()).expect("plates are metal") = alpha;
        let shape = shape_of(&scene, plate);
        for (light, aside) in [(0, 0.0), (i % 4, 0.03)] {
            let light = scene.light_shapes().nth(light).expect("there are four lights");
            let target = highlight(&scene, shape, light, EYE) + DVec3::new(aside, 0.0, 0.0);
            all.push((format!("{plate} of alpha {alpha} at shape {light}"), scene.clone(), target));
        }
    }
    all
}

/// Other materials and lights than those of the default scene, each at a point of its own.
///
/// # Panics
/// If the scenes that come with the renderer have changed.
pub fn variants() -> Vec<(String, Scene, DVec3)> {
    let mut all = Vec::new();
    // From nearly a mirror to very rough, on the highlight of the largest and of a small light.
    for (i, alpha) in [0.0, 0.0015, 0.005, 0.3, 0.5].into_iter().enumerate() {
        let mut scene = veach();
        for plate in ["plate2", "plate4"] {
            if let Some(a) = scene.material_mut(plate).and_then(|m| m.bsdf.alpha_mut()) {
                *a = alpha;
            }
        }
        let light = scene.light_shapes().nth([3, 3, 3, 0, 1][i]).expect("there are four lights");
        let shape = shape_of(&scene, ["plate2", "plate4"][i % 2]);
        let target = highlight(&scene, shape, light, EYE);
        // Beside the centre, so that nothing is symmetric by chance.
        all.push((format!("roughness {alpha}"), scene, target + DVec3::new(0.02, 0.0, 0.0)));
    }
    // Plastic of several colours under coloured lights, and a light switched off.
    let mut plastic = mislab_renderer::pbrt::embedded_plastic_scene().scene;
    let lights: Vec<usize> = plastic.light_shapes().collect();
    for (i, &shape) in lights.iter().enumerate() {
        if let Some(light) = &mut plastic.shapes[shape].light {
            light.radiance *= [Vec3::new(1.0, 0.2, 0.1), Vec3::ONE, Vec3::new(0.1, 1.5, 0.3)][i % 3];
            light.on = i != 1;
        }
    }
    for (i, (x, y, z)) in [(0.4, -3.9, 3.5), (1.3, -3.6, 2.2), (2.0, -3.1, 1.0), (-1.0, -2.5, 0.0), (3.0, 3.0, -2.0)]
        .into_iter()
        .enumerate()
    {
        all.push((format!("plastic scene, point {i}"), plastic.clone(), DVec3::new(x, y, z)));
    }
    // A real metal, and one light after the other alone.
    let mut gold = veach();
    if let Some(material) = gold.material_mut("plate4") {
        let reflectance = Reflectance::Fresnel { eta: Vec3::new(0.14, 0.37, 1.44), k: Vec3::new(3.98, 2.39, 1.6) };
        material.bsdf = Bsdf::Conductor { reflectance, alpha: 0.2 };
    }
    all.push(("gold".to_owned(), gold.clone(), DVec3::new(-1.0, -3.9, 3.5)));
    for alone in 0..4 {
        let mut scene = gold.clone();
        for (i, shape) in gold.light_shapes().enumerate() {
            if let Some(light) = &mut scene.shapes[shape].light {
                light.on = i == alone;
            }
        }
        let target = [DVec3::new(0.5, -3.9, 3.5), DVec3::new(2.0, 2.0, -2.0)][alone % 2];
        all.push((format!("light {} alone", alone + 1), scene, target));
    }
    let mesh = mesh_lights(Vec3::splat(3.0));
    for (i, (x, y, z)) in [(0.4, 2.0, -2.0), (1.0, -4.14615, 6.0), (1.5, -3.9, 3.5)].into_iter().enumerate() {
        all.push((format!("mesh lights, point {i}"), mesh.clone(), DVec3::new(x, y, z)));
    }
    all
}

/// Asks about what is seen from [`EYE`] at a point: the middle of a picture through a keyhole.
///
/// # Panics
/// If the scene cannot be built, or shows no surface there.
pub fn through_keyhole<R>(scene: &Scene, target: DVec3, ask: impl FnOnce(&Point<'_>) -> R) -> R {
    let settings = of_one_sample(Estimator::default());
    let mut built = BuiltScene::new(&keyhole(scene, EYE, target), &settings).expect("the scene can be built");
    // Secondary rays start a little above the surface, which moves the edges of shadows: in the wide penumbra 1.6e-4 of
    // the light. The oracle's do not.
    built.epsilon *= 0.1;
    let middle = SIDE as f32 / 2.0;
    let seen = Inspector::new(&built, &settings).at_pixel(middle, middle);
    ask(&seen.point().expect("a surface is seen"))
}

/// One independent sample of an estimator, in a picture through a keyhole.
pub fn of_one_sample(estimator: Estimator) -> Settings {
    Settings { estimator, ..independent(1, 1, [SIDE, SIDE]) }
}
