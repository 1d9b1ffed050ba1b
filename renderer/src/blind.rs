//! What a strategy cannot sample, however many samples it takes, and what a pixel without light is.

use mislab_kernel::bsdf::MIRROR_ALPHA;
use mislab_kernel::request::{Estimator, Request, Scene, Strategy};

use crate::table::regions::{shows_surface, visible_materials};

/// The materials in use, by index, whose mirror the estimator never meets: it draws no BSDF samples, and a light sample
/// has probability 0 of a mirror's one direction.
pub fn blind_materials(scene: &Scene, estimator: &Estimator) -> Vec<usize> {
    let only_light = match estimator.strategy {
        Strategy::Light => true,
        Strategy::Mis => estimator.light_prob == 1.0,
        Strategy::Bsdf | Strategy::MisAll => false,
    };
    if only_light { mirrors(scene) } else { Vec::new() }
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
    /// It is black: there is no surface that could reflect anything, or a mirror whose one direction shows no light.
    Empty,
    /// No sample has hit a light yet.
    Unhit,
    /// None ever will: it shows nothing but [`blind_materials`].
    Blind,
}

/// For each pixel of the full image, row by row. It takes the time of a camera ray or two for each.
pub fn dark_pixels(request: &Request) -> Vec<Dark> {
    let (scene, resolution) = (&request.scene, request.settings.image.resolution);
    let of_surface = |shows| if shows { Dark::Unhit } else { Dark::Empty };
    let mut pixels: Vec<Dark> = shows_surface(scene, resolution).into_iter().map(of_surface).collect();
    let mirrors = mirrors(scene);
    if !mirrors.is_empty() {
        let blind = !blind_materials(scene, &request.settings.estimator).is_empty();
        for (pixel, material) in pixels.iter_mut().zip(visible_materials(scene, resolution)) {
            if material.is_some_and(|index| mirrors.contains(&index)) {
                *pixel = if blind { Dark::Blind } else { Dark::Empty };
            }
        }
    }
    pixels
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DMat4;
    use mislab_kernel::request::Settings;

    use super::*;
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
}
