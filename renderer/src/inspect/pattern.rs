//! The random numbers of one pixel, as points to look at.

use mislab_kernel::geometry::grid::SIDE;
use mislab_kernel::lanes::{Single, Wrapping};
use mislab_kernel::request::{PerTechnique, Sampling, Strategy};
use mislab_kernel::sampler::{Dimension, Pixels, Sampler, Which, patch_key, pixel_keys};

/// The first `count` points of the pixel (x, y) in the unit square that directions are drawn from: `(u, v)` before any
/// choice has taken one of so many `parts` of u ([`mislab_kernel::request::Estimator::parts`]). Of padded samplers, the points of the BSDF technique.
pub fn points(sampling: &Sampling, parts: usize, [x, y]: [u32; 2], count: u32) -> Vec<[f32; 2]> {
    let mut sampler = Sampler::new(&sampling.sampler, Dimension::wanted(Strategy::Bsdf, false, false), parts);
    let mut pixels = Pixels::new(Single, pixel_keys(Single, sampling.seed, Wrapping(x), Wrapping(y)));
    let patch = patch_key(sampling.seed, [x, y].map(|v| v / SIDE * SIDE));
    let point = |index| {
        sampler.start(index, 1);
        sampler.enter(Single, patch);
        sampler.turn(Single, &mut pixels);
        let mut numbers = sampler.nothing(Single);
        sampler.sample(Single, Which { sample: 0, next: false }, &pixels).draw(PerTechnique::BOTH, &mut numbers);
        numbers.get_2d(Dimension::Bsdf)
    };
    (0..count).map(point).collect()
}
