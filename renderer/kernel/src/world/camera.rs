//! From pixels to camera rays.

use glam::{DVec3, Vec3};

use crate::lanes::{Lanes, V3};
use crate::request::Invalid;
use crate::request::scene::Camera;
use crate::world::projection::Projector;

/// A pinhole camera, ready for use: the direction through image point (x, y), in pixels from the
/// top left, is `corner + x right + y down`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pinhole {
    /// Eye point.
    pub origin: Vec3,
    corner: Vec3,
    right: Vec3,
    down: Vec3,
}

impl Pinhole {
    /// The axes of the [`Projector`], rounded.
    ///
    /// # Errors
    /// [`Invalid`] for a field of view outside (0, 180) or a transform that is not usable.
    pub fn new(camera: &Camera, resolution: [u32; 2]) -> Result<Self, Invalid> {
        if !(camera.fov_deg > 0.0 && camera.fov_deg < 180.0) {
            return Err(Invalid(format!("field of view {} degrees, expected between 0 and 180", camera.fov_deg)));
        }
        let m = camera.world_from_camera;
        if !m.is_finite() || m.determinant().abs() < 1e-30 {
            return Err(Invalid("camera transform cannot be inverted, expected position and directions".into()));
        }
        let Projector { eye, corner, right, down, .. } = Projector::new(camera, resolution);
        Ok(Self { origin: eye.as_vec3(), corner: corner.as_vec3(), right: right.as_vec3(), down: down.as_vec3() })
    }

    /// Direction of the ray through image point (x, y), not of unit length: linear over the image.
    pub fn ray(&self, x: f64, y: f64) -> DVec3 {
        self.corner.as_dvec3() + self.right.as_dvec3() * x + self.down.as_dvec3() * y
    }

    /// Unit direction of the ray through image point (x, y).
    #[inline(always)]
    pub fn direction<L: Lanes>(&self, l: L, x: L::F, y: L::F) -> V3<L> {
        let d = V3::splat(l, self.right).scale_add(x, V3::splat(l, self.corner));
        V3::splat(l, self.down).scale_add(y, d).normalize(l)
    }
}
