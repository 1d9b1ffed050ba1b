//! One sample of one pixel once more, to the bit, with the densities of all its rays.

use glam::Vec3;
use mislab_kernel::lanes::Lanewise;
use mislab_kernel::request::Settings;
use mislab_kernel::tile::replay::{self, Replayed};
use mislab_kernel::world::BuiltScene;

use super::point::{Inspector, Seen};

/// Sample number `index` of the pixel (x, y), at the level `how`: see [`replay::replay`]. The densities of rays that hit no
/// light are evaluated on one lane, and may differ from those of the level in the last bits.
pub fn replay(how: Lanewise, scene: &BuiltScene, settings: &Settings, pixel: [u32; 2], index: u32) -> Replayed {
    let mut replayed = replay::replay(how, scene, settings, pixel, index);
    let [x, y] = [0, 1].map(|axis| pixel[axis] as f32 + replayed.drawn.pixel[axis]);
    for ray in replayed.rays.iter_mut().filter(|ray| ray.f == Vec3::ZERO) {
        if let Seen::Surface(point) = Inspector::new(scene, settings).at_pixel(x, y) {
            let seen = point.mirror().filter(|_| ray.dirac).unwrap_or_else(|| point.direction(ray.wi));
            (ray.p_light, ray.p_bsdf) = (seen.p_light, seen.p_bsdf);
        }
    }
    replayed
}
