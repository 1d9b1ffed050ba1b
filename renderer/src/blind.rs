//! What a strategy cannot sample, however many samples it takes, and what a pixel without light is.

use mislab_kernel::bsdf::{BuiltMaterial, MIRROR_ALPHA};
use mislab_kernel::request::scene::Material;
use mislab_kernel::request::{Estimator, Request, Scene, Strategy};

use crate::shade::Shade;
use crate::table::regions::{Primitive, first_hits};

/// The materials in use, by index, whose mirror the estimator never meets: it draws no BSDF samples, and a light sample
/// has probability 0 of a mirror's one direction.
pub fn blind_materials(scene: &Scene, estimator: &Estimator) -> Vec<usize> {
    if draws_only_light(estimator) { mirrors(scene) } else { Vec::new() }
}

fn draws_only_light(estimator: &Estimator) -> bool {
    match estimator.strategy {
        Strategy::Light => true,
        Strategy::Mis => estimator.light_prob == 1.0,
        Strategy::Bsdf | Strategy::MisAll => false,
    }
}

/// The materials in use that are mirrors, by index.
pub fn mirrors(scene: &Scene) -> Vec<usize> {
    let in_use = |index: usize| scene.shapes.iter().any(|shape| shape.material == Some(index));
    let is_mirror = |index: usize| scene.materials[index].bsdf.alpha().is_some_and(|alpha| alpha < MIRROR_ALPHA);
    (0..scene.materials.len()).filter(|&index| is_mirror(index) && in_use(index)).collect()
}

/// The same as a sentence without full stop; `None` if there is no such material.
pub fn why_blind(scene: &Scene, estimator: &Estimator) -> Option<String> {
    let blind = blind_materials(scene, estimator);
    let names: Vec<&str> = blind.iter().map(|&index| scene.materials[index].name.as_str()).collect();
    let names = match names.as_slice() {
        [] => return None,
        [one] => (*one).to_owned(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    };
    Some(format!("biased on {names}: a light sample never meets a mirror's one direction"))
}

/// What it says of a pixel that it is black.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dark {
    /// It is black: there is no surface that could reflect anything, no light reaches it, or it is a mirror whose one direction
    /// shows no light.
    Empty,
    /// No sample has hit a light yet.
    Unhit,
    /// None ever will: it shows mirrors that the estimator never meets, and nothing else that light reaches.
    Blind,
}

/// For each material, what a pixel that shows nothing else is where it is black, if light reaches it.
pub fn dark_materials(scene: &Scene, estimator: &Estimator) -> Vec<Dark> {
    let of_mirror = if draws_only_light(estimator) { Dark::Blind } else { Dark::Empty };
    let dark = |material: &Material| {
        let material = BuiltMaterial::new(&material.bsdf);
        match (material.scatters(), material.is_dirac() && !material.has_two_lobes()) {
            (false, _) => Dark::Empty,
            (true, true) => of_mirror,
            (true, false) => Dark::Unhit,
        }
    };
    scene.materials.iter().map(dark).collect()
}

/// For each pixel of the full image, row by row. It takes the time of a camera ray or two for each, and of some to all lights from those
/// in shadow.
pub fn dark_pixels(request: &Request) -> Vec<Dark> {
    let Request { scene, settings } = request;
    let resolution = settings.image.resolution;
    let materials = dark_materials(scene, &settings.estimator);
    let of_surface = |primitive: Primitive| {
        let shape = &scene.shapes[primitive.shape as usize];
        shape.material.filter(|_| shape.light.is_none()).map(|material| materials[material])
    };
    let shade = Shade::new(scene, resolution);
    let columns = resolution[0] as usize;
    let of_pixel = |(index, seen): (usize, [Option<Primitive>; 5])| {
        if seen[0].and_then(of_surface).is_none() {
            return Dark::Empty;
        }
        let surfaces = || seen.into_iter().flatten();
        let is_lit = |primitive: Primitive| {
            of_surface(primitive) == Some(Dark::Unhit) && !shade.covers(primitive, [index % columns, index / columns])
        };
        if surfaces().any(is_lit) {
            Dark::Unhit
        } else if surfaces().any(|primitive| of_surface(primitive) == Some(Dark::Blind)) {
            Dark::Blind
        } else {
            Dark::Empty
        }
    };
    first_hits(scene, resolution).enumerate().map(of_pixel).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DMat4;
    use mislab_kernel::request::Settings;

    use super::*;
    use crate::layer::Layer;
    use crate::pbrt::embedded_scene;

    #[test]
    fn only_strategies_without_bsdf_samples_are_blind_to_mirrors() {
        let mut scene = embedded_scene().scene;
        let of = |strategy, light_prob| Estimator { strategy, light_prob, ..Estimator::default() };
        let set = |scene: &mut Scene, name, alpha| {
            *scene.material_mut(name).and_then(|m| m.bsdf.alpha_mut()).expect("the plates are glossy") = alpha;
        };
        set(&mut scene, "plate1", 0.1);
        assert_eq!(why_blind(&scene, &of(Strategy::Light, 0.5)), None, "a rough plate is no mirror");
        set(&mut scene, "plate1", 0.0);
        set(&mut scene, "plate2", 0.0);
        let words = "biased on plate1 and plate2: a light sample never meets a mirror's one direction";
        for (estimator, expected) in [
            (of(Strategy::Light, 0.5), Some(words)),
            (of(Strategy::Mis, 1.0), Some(words)),
            (of(Strategy::Mis, 0.999), None),
            (of(Strategy::MisAll, 1.0), None),
            (of(Strategy::Bsdf, 1.0), None),
        ] {
            assert_eq!(why_blind(&scene, &estimator).as_deref(), expected, "{estimator:?}");
        }
    }

    #[test]
    fn black_means_one_of_three_things() {
        let mut file = embedded_scene();
        file.settings.image.resolution = [80, 80];
        let estimator = Estimator { strategy: Strategy::Light, ..Estimator::default() };
        *file.scene.material_mut("plate1").and_then(|m| m.bsdf.alpha_mut()).expect("a plate is glossy") = 0.0;
        let settings = Settings { estimator, ..file.settings };
        let mut request = Request { scene: Arc::new(file.scene), settings };
        let count = |request: &Request, dark| dark_pixels(request).into_iter().filter(|pixel| *pixel == dark).count();
        let counts = |request: &Request| [Dark::Empty, Dark::Unhit, Dark::Blind].map(|dark| count(request, dark));
        let [empty, unhit, blind] = counts(&request);
        assert!(empty > 0 && unhit > 1000 && blind > 50, "lights, surfaces and a mirror: {empty}, {unhit}, {blind}");
        request.settings.estimator.strategy = Strategy::MisAll;
        assert_eq!(counts(&request), [empty + blind, unhit, 0], "BSDF samples see what the mirror shows");
        let about = DMat4::from_rotation_y(std::f64::consts::PI);
        Arc::make_mut(&mut request.scene).camera.world_from_camera *= about;
        assert_eq!(counts(&request), [80 * 80, 0, 0], "behind the camera there is nothing");
    }

    #[test]
    fn what_no_light_reaches_is_empty_and_nothing_else() {
        let file = embedded_scene();
        let mut settings = file.settings;
        settings.image.resolution = [200, 200];
        settings.estimator.strategy = Strategy::Light;
        let request = Request { scene: Arc::new(file.scene), settings };
        let frame = crate::render(&request, 1, &mut |_| true).expect("the scene can be rendered");
        let mut light = vec![0.0; 3 * 200 * 200];
        frame.resolve(Layer::Light.channels(), &mut light);
        let materials = dark_materials(&request.scene, &request.settings.estimator);
        let is_rough = |hit: Option<Primitive>| {
            let shape = hit.map(|hit| &request.scene.shapes[hit.shape as usize]);
            shape.and_then(|shape| shape.material).is_some_and(|material| materials[material] == Dark::Unhit)
        };
        let (mut shadow, mut missed) = (0, 0);
        let seen = first_hits(&request.scene, [200, 200]);
        for (i, (dark, seen)) in dark_pixels(&request).into_iter().zip(seen).enumerate() {
            // Others show a light or a mirror.
            if seen.into_iter().all(is_rough) {
                let black = light[i] == 0.0;
                assert!(dark == Dark::Unhit || black, "light at {}, {}", i % 200, i / 200);
                shadow += usize::from(dark == Dark::Empty);
                missed += usize::from(dark == Dark::Unhit && black);
            }
        }
        // Two plates together hide the lights from some, and a few only look black so far.
        assert!(shadow > 500 && missed < shadow / 3, "under the plates' front edges: {shadow}, not found {missed}");
    }
}
