//! The random numbers of some pixels, any sample at a time.

use mislab_renderer::SamplerSettings;
use mislab_renderer::lanes::Lanes;
use mislab_renderer::sampler::{Dimension, Numbers, Pixels, Sampler};

/// A sampler and the pixels it is for.
pub struct Draws<'a, L: Lanes> {
    l: L,
    sampler: Sampler<'a>,
    pixels: Pixels<L>,
    patch: u32,
}

impl<'a, L: Lanes> Draws<'a, L> {
    /// For the dimensions that are wanted.
    #[inline(always)]
    pub fn new(l: L, settings: &'a SamplerSettings, wanted: [bool; Dimension::ALL.len()]) -> Self {
        Self { l, sampler: Sampler::new(settings, wanted), pixels: Pixels::new(l, l.u(0)), patch: 0 }
    }

    /// Turns to the pixels with these keys (`pixel_keys`), in the patch with this one (`patch_key`).
    #[inline(always)]
    pub fn start(&mut self, pixels: L::U, patch: u32) {
        self.pixels.change(pixels);
        self.patch = patch;
    }

    /// The numbers of sample `index`.
    #[inline(always)]
    pub fn draw(&mut self, index: u32) -> Numbers<L> {
        self.sampler.start(index, 1);
        self.sampler.enter(self.l, self.patch);
        self.sampler.turn(self.l, &mut self.pixels);
        let mut numbers = Numbers::nothing(self.l);
        self.sampler.draw(self.l, 0, &self.pixels, &mut numbers);
        numbers
    }
}
