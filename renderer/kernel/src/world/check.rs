//! What can be wrong with a scene and its settings. The list is in two parts, since only those who build or look over all
//! shapes walk over their primitives: all else is here, shapes in [`Walk`].

use glam::Vec3;

use super::camera::Pinhole;
use super::primitives::Walk;
use super::{Unbuilt, emission};
use crate::request::scene::{self, Scene};
use crate::request::{Invalid, Settings};
use crate::stop::Stop;

/// Finds what [`super::BuiltScene::new`] would find wrong, without building anything: it takes as long as to look at each
/// triangle once, and no memory.
///
/// # Errors
/// Those of [`super::BuiltScene::new`].
pub fn check(scene: &Scene, settings: &Settings) -> Result<(), Invalid> {
    check_but_shapes(scene, settings)?;
    let mut walk = Walk::new(Stop::NEVER);
    // In the order of building, so that of several faults the same is named.
    for emits in [true, false] {
        for (index, shape) in scene.shapes.iter().enumerate().filter(|(_, shape)| emission(shape).is_some() == emits) {
            walk.visit(index, shape, |_| {}).map_err(Unbuilt::unstopped)?;
        }
    }
    Ok(())
}

/// Checks everything but the shapes' geometry. Returns the camera.
///
/// # Errors
/// [`Invalid`] names the setting, material or light whose numbers cannot be rendered.
pub(super) fn check_but_shapes(scene: &Scene, settings: &Settings) -> Result<Pinhole, Invalid> {
    settings.check().map_err(Invalid)?;
    let camera = Pinhole::new(&scene.camera, settings.image.resolution)?;
    for material in &scene.materials {
        check_material(material)?;
    }
    let materials = scene.materials.len();
    for (index, shape) in scene.shapes.iter().enumerate() {
        if let Some(m) = shape.material.filter(|m| *m >= materials) {
            return Err(Invalid(format!("shape {index} has material {m}, expected one of {materials}")));
        }
        if let Some(light) = emission(shape)
            && !(light.radiance.is_finite() && light.radiance.min_element() >= 0.0)
        {
            let message = "expected finite numbers >= 0";
            return Err(Invalid(format!("light {} has radiance {}, {message}", light.name, light.radiance)));
        }
    }
    Ok(camera)
}

fn check_material(material: &scene::Material) -> Result<(), Invalid> {
    let name = &material.name;
    let check = |what: &str, v: Vec3, max: f32| {
        if v.is_finite() && v.min_element() >= 0.0 && v.max_element() <= max {
            Ok(())
        } else {
            Err(Invalid(format!("material {name}: {what} {v}, expected numbers in [0, {max}]")))
        }
    };
    if let Some(alpha) = material.bsdf.alpha()
        && !(0.0..=1.0).contains(&alpha)
    {
        return Err(Invalid(format!("material {name}: roughness {alpha}, expected a number in [0, 1]")));
    }
    match &material.bsdf {
        scene::Bsdf::Matte { kd } => check("diffuse reflectance", *kd, 1.0),
        scene::Bsdf::Conductor { reflectance: scene::Reflectance::Constant(r), .. } => check("reflectance", *r, 1.0),
        scene::Bsdf::Conductor { reflectance: scene::Reflectance::Fresnel { eta, k }, .. } => {
            // Beyond, squares of squares overflow.
            check("index eta", *eta, 1e9)?;
            check("absorption k", *k, 1e9)
        }
        scene::Bsdf::Plastic { kd, ks, .. } => {
            check("diffuse reflectance", *kd, 1.0)?;
            check("specular reflectance", *ks, 1.0)
        }
    }
}
