//! The renderer's functions for one lane, each compiled once: as all lane code they go into every place they are called
//! from, and the time to compile them is most of the time that a mutant takes.

use glam::{DVec3, Vec3};
use mislab_kernel::bsdf::{self, BsdfValue, Surface};
use mislab_kernel::estimator::{Point, Reflected};
use mislab_kernel::lanes::{Lanes, Single, V3, Wrapping};
use mislab_kernel::light::{Lights, Sight};
use mislab_kernel::sampler::{Dimension, Numbers, patch_key, pixel_keys};
use mislab_kernel::world::culling::Culled;
use mislab_kernel::world::{BuiltScene, CameraHit, View};
use mislab_renderer::Settings;
use mislab_tests::draws::Draws;
use mislab_tests::pair::INDEPENDENT;

/// For the renderer.
pub fn v3(v: DVec3) -> V3<Single> {
    V3::splat(Single, v.as_vec3())
}

/// For the renderer, as it is.
pub fn splat(v: Vec3) -> V3<Single> {
    V3::splat(Single, v)
}

/// For formulas.
pub fn d(v: V3<Single>) -> DVec3 {
    DVec3::new(v.x.into(), v.y.into(), v.z.into())
}

#[inline(never)]
pub fn key(seed: u32, x: u32, y: u32) -> Wrapping {
    pixel_keys(Single, seed, Wrapping(x), Wrapping(y))
}

/// Of the patch that a pixel is in.
pub fn patch(seed: u32, x: u32, y: u32) -> u32 {
    patch_key(seed, [x, y].map(|c| c / 8 * 8))
}

#[inline(never)]
pub fn draw(sampler: &mut Draws<Single>, index: u32) -> Numbers<Single> {
    sampler.draw(index)
}

/// Independent numbers of all dimensions: sample `index` of a pixel with this key.
pub fn numbers(key: u32, index: u32) -> Numbers<Single> {
    let mut sampler = Draws::new(Single, &INDEPENDENT, [true; Dimension::ALL.len()]);
    sampler.start(Wrapping(key), key);
    draw(&mut sampler, index)
}

#[inline(never)]
pub fn evaluate(s: &Surface<'_, Single>, wo: V3<Single>, wi: V3<Single>) -> BsdfValue<Single> {
    bsdf::evaluate(Single, s, wo, wi)
}

/// A direction drawn from the BSDF, and what a mirror's direction is worth there.
pub struct Drawn {
    pub wi: V3<Single>,
    pub dirac: bool,
    pub dirac_f: V3<Single>,
    pub dirac_pmf: f32,
}

#[inline(never)]
pub fn sample(s: &Surface<'_, Single>, wo: V3<Single>, random: &Numbers<Single>) -> Drawn {
    let (wi, dirac) = bsdf::sample(Single, s, wo, random);
    let mirror = bsdf::evaluate_mirror(Single, s, wo);
    Drawn { wi, dirac, dirac_f: mirror.f_cos, dirac_pmf: mirror.pdf }
}

#[inline(never)]
pub fn look(lights: &Lights, p: V3<Single>, wi: V3<Single>, t_min: f32, distances: bool) -> Sight<Single> {
    lights.look(Single, p, wi, t_min, distances)
}

#[inline(never)]
pub fn sample_light(lights: &Lights, p: V3<Single>, random: &Numbers<Single>) -> (V3<Single>, bool) {
    let aim = lights.sample(Single, p, random);
    (aim.wi, aim.valid)
}

#[inline(never)]
pub fn camera_hit<'a>(scene: &'a BuiltScene, dir: V3<Single>, near: &'a Culled) -> CameraHit<'a, Single> {
    View { l: Single, scene, culled: near }.camera_hit(dir)
}

/// What was met there, if it scatters.
pub fn surface<'a>(scene: &'a BuiltScene, hit: &CameraHit<'a, Single>) -> Option<Surface<'a, Single>> {
    scene.material(hit.first).map(|material| Surface { material, ..hit.points })
}

#[inline(never)]
pub fn reflected<L: Lanes>(
    view: View<'_, L>,
    settings: &Settings,
    s: &Surface<'_, L>,
    wo: V3<L>,
    random: &Numbers<L>,
) -> Reflected<L> {
    let at = Point { view, estimator: &settings.estimator, surface: *s, wo, here: view.l.m(true) };
    Reflected::none(view.l).replaced(&at.reflected(random))
}
