//! In which order two successive samples are taken.

use crate::estimator::drawn_by_light;
use crate::lanes::{Lanes, Mask};
use crate::request::{Estimator, PerTechnique, Strategy};
use crate::sampler::{Drawing, Numbers, Which};

/// In which order a packet takes one or two successive samples. In the one-sample model a pair usually has one sample
/// of either technique, but not the same one first in every pixel. There the light sample comes first: then all lanes
/// do the same, once what the light technique needs and once the BSDF technique. Neither technique's samples
/// change their order among themselves.
pub(super) struct Turns<L: Lanes> {
    sample: usize,
    /// Where the second sample of a pair comes first.
    pub(super) swapped: L::M,
    /// Of the one-sample model: the number that says which technique, and the lanes that the light technique draws;
    /// of both samples.
    technique: Option<[(L::F, L::M); 2]>,
    /// Which techniques the strategy draws.
    draws: PerTechnique<bool>,
    /// How many turns are over.
    pub(super) done: u32,
}

impl<L: Lanes> Turns<L> {
    /// Of a sample and, in a `pair`, the one after it.
    #[inline(always)]
    pub(super) fn new(estimator: &Estimator, sample: Drawing<'_, L>, pair: bool) -> Self {
        let Drawing { l, which, .. } = sample;
        let draws = estimator.strategy.draws();
        let mut turns = Self { sample: which.sample, swapped: l.m(false), technique: None, draws, done: 0 };
        if estimator.strategy == Strategy::Mis {
            let first = sample.technique();
            let second = if pair { sample.following().technique() } else { first };
            let by_light = [drawn_by_light(l, estimator, first), drawn_by_light(l, estimator, second)];
            turns.swapped = !by_light[0] & by_light[1];
            turns.technique = Some([(first, by_light[0]), (second, by_light[1])]);
        }
        turns
    }

    /// Which sample's turn it is, and the techniques that it needs numbers of. The number that says which
    /// technique is put into `random`.
    #[inline(always)]
    pub(super) fn next(&self, random: &mut Numbers<L>) -> (Which<L>, PerTechnique<bool>) {
        let Some([(first, first_by_light), (second, second_by_light)]) = self.technique else {
            return (Which { sample: self.sample, next: self.swapped }, self.draws);
        };
        let next = if self.done == 0 { self.swapped } else { !self.swapped };
        let by_light = (next & second_by_light) | (!next & first_by_light);
        random.set_technique(next.select(second, first));
        (Which { sample: self.sample, next }, PerTechnique { light: by_light.any(), bsdf: !by_light.all() })
    }
}
