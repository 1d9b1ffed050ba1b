//! The renderer's functions for one lane, each compiled once: as all lane code they go into every place they are called
//! from, and the time to compile them is most of the time that a mutant takes.

use glam::{DVec3, Vec3};
use mislab_renderer::Settings;
use mislab_renderer::bsdf::{self, BsdfSample, BsdfValue, Surface};
use mislab_renderer::build::{BuiltScene, CameraHit};
use mislab_renderer::estimator::{Reflected, reflected_radiance};
use mislab_renderer::lanes::{Single, V3, Wrapping};
use mislab_renderer::light::{Lights, Sight};
use mislab_renderer::patch::Candidates;
use mislab_renderer::sampler::{Dimension, Numbers, Sampler, pixel_keys};
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

#[inline(never)]
pub fn draw(sampler: &mut Sampler<'_, Single>, index: u32) -> Numbers<Single> {
    sampler.draw(index)
}

/// Independent numbers of all dimensions: sample `index` of a pixel with this key.
pub fn numbers(key: u32, index: u32) -> Numbers<Single> {
    let mut sampler = Sampler::new(Single, &INDEPENDENT, [true; Dimension::ALL.len()]);
    sampler.start(Wrapping(key));
    draw(&mut sampler, index)
}

#[inline(never)]
pub fn evaluate(s: &Surface<'_, Single>, wo: V3<Single>, wi: V3<Single>) -> BsdfValue<Single> {
    bsdf::evaluate(Single, s, wo, wi)
}

#[inline(never)]
pub fn sample(s: &Surface<'_, Single>, wo: V3<Single>, random: &Numbers<Single>) -> BsdfSample<Single> {
    bsdf::sample(Single, s, wo, random)
}

#[inline(never)]
pub fn look(lights: &Lights, p: V3<Single>, wi: V3<Single>, t_min: f32, distances: bool) -> Sight<Single> {
    lights.look(Single, p, wi, t_min, distances)
}

#[inline(never)]
pub fn sample_light(lights: &Lights, p: V3<Single>, random: &Numbers<Single>) -> (V3<Single>, bool) {
    lights.sample(Single, p, random)
}

#[inline(never)]
pub fn camera_hit(scene: &BuiltScene, dir: V3<Single>, near: &Candidates) -> CameraHit<Single> {
    scene.camera_hit(Single, dir, near)
}

#[inline(never)]
pub fn reflected(
    scene: &BuiltScene,
    settings: &Settings,
    s: &Surface<'_, Single>,
    wo: V3<Single>,
    random: &Numbers<Single>,
    near: &Candidates,
) -> Reflected<Single> {
    reflected_radiance(Single, scene, settings, s, wo, random, near)
}
