//! What a camera ray hits.

use glam::Vec3;
use mislab_kernel::bsdf::{BuiltMaterial, Surface};
use mislab_kernel::geometry::grid::SIDE;
use mislab_kernel::lanes::{Single, V3, fused};
use mislab_kernel::request::Settings;
use mislab_kernel::world::culling::Culled;
use mislab_kernel::world::{BuiltScene, View};

use super::plain;

/// Asks about the pixels of one picture.
#[derive(Clone, Copy, Debug)]
pub struct Inspector<'a> {
    scene: &'a BuiltScene,
    settings: &'a Settings,
}

/// What a camera ray hits.
pub enum Seen<'a> {
    /// Nothing.
    Nothing,
    /// A light that reflects nothing, seen directly: its radiance, 0 from behind.
    Light(Vec3),
    /// A surface.
    Surface(Point<'a>),
}

/// A surface point and the direction it is seen from: where the reflected radiance is estimated.
pub struct Point<'a> {
    pub(super) scene: &'a BuiltScene,
    pub(super) surface: Surface<'a, Single>,
    pub(super) wo: V3<Single>,
    pub(super) near: Culled,
    shape: u32,
    emitted: Vec3,
}

impl<'a> Inspector<'a> {
    /// For a scene and the settings that it was built with.
    pub fn new(scene: &'a BuiltScene, settings: &'a Settings) -> Self {
        Self { scene, settings }
    }

    /// What the camera ray through image point (x, y) hits, in pixels from the top left: the centre of pixel (i, j) is
    /// (i + 1/2, j + 1/2).
    pub fn at_pixel(&self, x: f32, y: f32) -> Seen<'a> {
        let [width, height] = self.settings.image.resolution.map(|n| n as f32);
        let inside = (0.0..width).contains(&x) && (0.0..height).contains(&y);
        let near = if inside {
            self.scene.culled([x, y].map(|v| v as u32 / SIDE * SIDE))
        } else {
            self.scene.patches.everything()
        };
        fused(
            #[inline(always)]
            || seen(self.scene, near, x, y),
        )
    }
}

#[inline(always)]
fn seen(scene: &BuiltScene, near: Culled, x: f32, y: f32) -> Seen<'_> {
    let dir = scene.camera.direction(Single, x, y);
    let hit = View { l: Single, scene, culled: &near }.camera_hit(dir);
    let emitted = plain(hit.emitted);
    if !hit.surface {
        return if hit.emits { Seen::Light(emitted) } else { Seen::Nothing };
    }
    let material = scene.material(hit.first);
    if hit.emits && material.is_none() {
        return Seen::Light(emitted);
    }
    let surface = Surface { material: material.unwrap_or(&BuiltMaterial::BLACK), ..hit.points };
    Seen::Surface(Point { scene, surface, wo: -dir, near, shape: hit.first, emitted })
}

impl<'a> Seen<'a> {
    /// The surface point, if there is one.
    pub fn point(self) -> Option<Point<'a>> {
        match self {
            Self::Surface(point) => Some(point),
            Self::Nothing | Self::Light(_) => None,
        }
    }
}

impl Point<'_> {
    /// Where it is.
    pub fn position(&self) -> Vec3 {
        plain(self.surface.p)
    }

    /// Unit normal on the viewer's side.
    pub fn normal(&self) -> Vec3 {
        plain(self.surface.n)
    }

    /// Unit direction towards the viewer.
    pub fn wo(&self) -> Vec3 {
        plain(self.wo)
    }

    /// Number of its shape in the scene; with it, its material.
    pub fn shape(&self) -> usize {
        self.shape as usize
    }

    /// GGX width alpha of its specular lobe; `None` without one.
    pub fn alpha(&self) -> Option<f32> {
        self.surface.material.alpha()
    }

    /// True if its specular lobe is a perfect mirror, see [`Self::mirror`].
    pub fn is_mirror(&self) -> bool {
        self.surface.material.is_dirac()
    }

    /// True if it is nothing but a perfect mirror: no light but that from [`Self::mirror`] is reflected.
    pub(super) fn reflects_by_delta_alone(&self) -> bool {
        self.is_mirror() && !self.surface.material.has_two_lobes()
    }

    /// False if it is black.
    pub fn reflects(&self) -> bool {
        self.surface.material.scatters()
    }

    /// Radiance that the point itself emits towards the viewer: 0 unless it belongs to a light that reflects as well.
    pub fn emitted(&self) -> Vec3 {
        self.emitted
    }
}
