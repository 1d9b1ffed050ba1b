//! What a strategy cannot sample, however many samples it takes.

use mislab_kernel::bsdf::MIRROR_ALPHA;
use mislab_kernel::request::{Estimator, Request, Scene, Strategy};

use crate::table::regions::visible_materials;

/// The materials in use, by index, whose mirror the estimator never meets: it draws no BSDF samples, and a light sample
/// has probability 0 of a mirror's one direction.
pub fn blind_materials(scene: &Scene, estimator: &Estimator) -> Vec<usize> {
    let only_light = match estimator.strategy {
        Strategy::Light => true,
        Strategy::Mis => estimator.light_prob == 1.0,
        Strategy::Bsdf | Strategy::MisAll => false,
    };
    if !only_light {
        return Vec::new();
    }
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

/// For each pixel of the full image, row by row, whether it shows nothing but [`blind_materials`]; `None` if there are
/// none. It takes the time of a camera ray or two for each pixel.
pub fn blind_pixels(request: &Request) -> Option<Vec<bool>> {
    let blind = blind_materials(&request.scene, &request.settings.estimator);
    if blind.is_empty() {
        return None;
    }
    let seen = visible_materials(&request.scene, request.settings.image.resolution);
    Some(seen.into_iter().map(|material| material.is_some_and(|index| blind.contains(&index))).collect())
}

#[cfg(test)]
mod tests {
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
}
