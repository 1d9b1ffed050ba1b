//! The random numbers of some pixels, any sample at a time.

use mislab_kernel::lanes::Lanes;
use mislab_kernel::request::PerTechnique;
use mislab_kernel::sampler::{Dimension, Numbers, Pixels, Sampler, Which};
use mislab_renderer::{SamplerSettings, Settings};

/// A sampler and the pixels it is for.
pub struct Draws<L: Lanes> {
    l: L,
    sampler: Sampler,
    pixels: Pixels<L>,
    patch: u32,
    techniques: bool,
}

impl<L: Lanes> Draws<L> {
    /// For the dimensions that are wanted, as where nothing is chosen among several.
    #[inline(always)]
    pub fn new(l: L, settings: &SamplerSettings, wanted: [bool; Dimension::ALL.len()]) -> Self {
        Self::among(l, settings, wanted, 1)
    }

    /// For the dimensions that are wanted, where choices fall into so many parts.
    #[inline(always)]
    pub fn among(l: L, settings: &SamplerSettings, wanted: [bool; Dimension::ALL.len()], parts: usize) -> Self {
        let techniques = wanted[Dimension::Technique as usize];
        let sampler = Sampler::new(settings, wanted, parts);
        Self { l, sampler, pixels: Pixels::new(l, l.u(0)), patch: 0, techniques }
    }

    /// For what the strategy asks for, where there are several lights and surfaces of two lobes.
    #[inline(always)]
    pub fn of(l: L, settings: &Settings) -> Self {
        Self::new(l, &settings.sampling.sampler, Dimension::wanted(settings.estimator.strategy, true, true))
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
        let mut numbers = self.sampler.nothing(self.l);
        let sample = self.sampler.sample(self.l, Which { sample: 0, next: self.l.m(false) }, &self.pixels);
        if self.techniques {
            numbers.set_technique(sample.technique());
        }
        sample.draw(PerTechnique::BOTH, &mut numbers);
        numbers
    }
}
