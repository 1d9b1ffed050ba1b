//! Estimators as functions of two densities: what each technique's sample is weighted and divided by.

use glam::Vec3;

use crate::lanes::Single;
use crate::mis::{self, CUTOFF_ALPHA};
use crate::settings::{Heuristic, OneSampleWeights, Settings, Strategy};

/// What decides the value of a sample, given its direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimator {
    /// Which techniques are drawn.
    pub strategy: Strategy,
    /// From densities to weights; [`Strategy::MisAll`] and [`Strategy::Mis`] alone ask it.
    pub heuristic: Heuristic,
    /// Whether it sees c; [`Strategy::Mis`] alone.
    pub weights: OneSampleWeights,
    /// c, the probability of the light technique, in [0, 1]; [`Strategy::Mis`] alone.
    pub c: f32,
}

/// A technique's sample in a given direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weighted {
    /// Weight w of the technique; 0 where it does not draw this direction.
    pub weight: f32,
    /// Contribution `w f / (c p)`, per channel: c is 1 for all strategies but [`Strategy::Mis`].
    pub value: Vec3,
}

/// The same before f is known.
#[derive(Clone, Copy)]
pub(super) struct Technique {
    /// Probability c of the technique.
    pub c: f64,
    /// w.
    pub weight: f64,
    /// `w / (c p)`.
    pub per_f: f64,
}

/// On which side of a heuristic's jump a direction lies.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Side {
    /// The light technique alone is kept.
    Light,
    /// Both are, and balanced.
    Both,
    /// The BSDF technique alone is kept.
    Bsdf,
}

impl From<&Settings> for Estimator {
    fn from(s: &Settings) -> Self {
        Self { strategy: s.strategy, heuristic: s.heuristic, weights: s.weights, c: s.light_prob }
    }
}

impl Estimator {
    /// Probabilities that the techniques, light and BSDF, draw: those of the one-sample model, else 1 or 0.
    pub fn probabilities(&self) -> [f32; 2] {
        match self.strategy {
            Strategy::Light => [1.0, 0.0],
            Strategy::Bsdf => [0.0, 1.0],
            Strategy::MisAll => [1.0, 1.0],
            Strategy::Mis => [self.c, 1.0 - self.c],
        }
    }

    /// True where the weights of a direction depend on a heuristic.
    fn is_weighted(&self) -> bool {
        matches!(self.strategy, Strategy::MisAll | Strategy::Mis)
    }

    /// What the heuristic sees of each density, per density: n (Veach 1997, eq. 9.4) or c (eq. 9.15), which the
    /// tutorial leaves out.
    fn shares(&self) -> [f32; 2] {
        match (self.strategy, self.weights) {
            (Strategy::Mis, OneSampleWeights::Veach) => self.probabilities(),
            _ => [1.0; 2],
        }
    }

    /// Weights at a direction with these densities, light and BSDF.
    pub(super) fn weigh(&self, p: [f32; 2]) -> [Technique; 2] {
        self.weigh_by(p, |a, b, ties| mis::weight(Single, self.heuristic, a, b, ties))
    }

    /// The same as if it lay on that side of the heuristic's jumps.
    pub(super) fn weigh_on(&self, side: Side, p: [f32; 2]) -> [Technique; 2] {
        self.weigh_by(p, |a, b, by_light| match side {
            Side::Both => mis::weight(Single, Heuristic::Balance, a, b, by_light),
            Side::Light if by_light => (1.0, 1.0 / a),
            Side::Bsdf if !by_light => (1.0, 1.0 / a),
            Side::Light | Side::Bsdf => (0.0, 0.0),
        })
    }

    fn weigh_by(&self, p: [f32; 2], heuristic: impl Fn(f32, f32, bool) -> (f32, f32)) -> [Technique; 2] {
        let (probabilities, shares) = (self.probabilities(), self.shares());
        [0, 1].map(|t| {
            let (c, a, other) = (probabilities[t], shares[t] * p[t], shares[1 - t] * p[1 - t]);
            // Not drawn, or not here.
            if c <= 0.0 || a <= 0.0 {
                return Technique { c: f64::from(c), weight: 0.0, per_f: 0.0 };
            }
            let (weight, per_a) = if self.is_weighted() { heuristic(a, other, t == 0) } else { (1.0, 1.0 / a) };
            // `a` holds c already, or it is left out.
            let rest = if shares[t] == c { 1.0 } else { c };
            Technique { c: f64::from(c), weight: f64::from(weight), per_f: f64::from(per_a) / f64::from(rest) }
        })
    }

    /// Where the weights jump: logarithms of p_L / p_B, rising, and the sides before, between and after them.
    pub(super) fn jumps(&self) -> (Vec<f64>, &'static [Side]) {
        let [light, bsdf] = self.shares().map(f64::from);
        if !self.is_weighted() || light <= 0.0 || bsdf <= 0.0 {
            return (Vec::new(), &[]);
        }
        let at = |ratio: f64| (ratio * bsdf / light).ln();
        let cutoff = f64::from(CUTOFF_ALPHA);
        match self.heuristic {
            Heuristic::Balance | Heuristic::Power => (Vec::new(), &[]),
            Heuristic::Cutoff => (vec![at(cutoff), at(1.0 / cutoff)], &[Side::Bsdf, Side::Both, Side::Light]),
            Heuristic::Maximum => (vec![at(1.0)], &[Side::Bsdf, Side::Light]),
        }
    }
}
