//! Estimators as functions of two densities: what each technique's sample is weighted and divided by.

use glam::Vec3;
use mislab_kernel::estimator::heuristic::{self, CUTOFF_ALPHA, Rivals, Weighted as Effective};
use mislab_kernel::lanes::Single;
use mislab_kernel::request::{Estimator, Heuristic, OneSampleWeights, Strategy};

/// A technique's sample in a given direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weighted {
    /// Weight w of the technique; 0 where it does not draw this direction.
    pub weight: f32,
    /// Contribution `w f / (c p)`, per channel: c is 1 for all strategies but [`Strategy::Mis`].
    pub value: Vec3,
}

/// Weight and contribution of a sample by either technique, light and BSDF, in a direction with this integrand and
/// these densities: of a replayed [`Ray`](super::Ray), what another estimator, or the other technique, makes of it.
pub fn weighted(f: Vec3, p: [f32; 2], estimator: &Estimator) -> [Weighted; 2] {
    estimator.weigh(p).map(|technique| Weighted { weight: technique.weight as f32, value: f * technique.per_f as f32 })
}

/// The same before f is known.
#[derive(Clone, Copy)]
pub(super) struct Share {
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

/// What quadrature asks of an estimator.
pub(super) trait Weigh {
    /// Weights at a direction with these densities, light and BSDF.
    fn weigh(&self, p: [f32; 2]) -> [Share; 2];
    /// The same as if it lay on that side of the heuristic's jumps.
    fn weigh_on(&self, side: Side, p: [f32; 2]) -> [Share; 2];
    /// Where the weights jump: logarithms of p_L / p_B, rising, and the sides before, between and after them.
    fn jumps(&self) -> (Vec<f64>, &'static [Side]);
}

impl Weigh for Estimator {
    fn weigh(&self, p: [f32; 2]) -> [Share; 2] {
        weigh_by(self, p, |a, b, ties| weigh(self.heuristic, a, b, ties))
    }

    fn weigh_on(&self, side: Side, p: [f32; 2]) -> [Share; 2] {
        weigh_by(self, p, |a, b, by_light| match side {
            Side::Both => weigh(Heuristic::Balance, a, b, by_light),
            Side::Light if by_light => (1.0, 1.0 / a),
            Side::Bsdf if !by_light => (1.0, 1.0 / a),
            Side::Light | Side::Bsdf => (0.0, 0.0),
        })
    }

    fn jumps(&self) -> (Vec<f64>, &'static [Side]) {
        let [light, bsdf] = shares(self).map(f64::from);
        if !is_weighted(self) || light <= 0.0 || bsdf <= 0.0 {
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

/// Probabilities that the techniques, light and BSDF, draw: those of the one-sample model, else 1 or 0.
pub(super) fn probabilities(estimator: &Estimator) -> [f32; 2] {
    match estimator.strategy {
        Strategy::Light => [1.0, 0.0],
        Strategy::Bsdf => [0.0, 1.0],
        Strategy::MisAll => [1.0, 1.0],
        Strategy::Mis => [estimator.light_prob, 1.0 - estimator.light_prob],
    }
}

/// True where the weights of a direction depend on a heuristic.
fn is_weighted(estimator: &Estimator) -> bool {
    matches!(estimator.strategy, Strategy::MisAll | Strategy::Mis)
}

/// What the heuristic sees of each density, per density: n (Veach 1997, eq. 9.4) or c (eq. 9.15), which the
/// tutorial leaves out.
fn shares(estimator: &Estimator) -> [f32; 2] {
    match (estimator.strategy, estimator.weights) {
        (Strategy::Mis, OneSampleWeights::Veach) => probabilities(estimator),
        _ => [1.0; 2],
    }
}

fn weigh_by(estimator: &Estimator, p: [f32; 2], heuristic: impl Fn(f32, f32, bool) -> (f32, f32)) -> [Share; 2] {
    let (probabilities, shares) = (probabilities(estimator), shares(estimator));
    [0, 1].map(|t| {
        let (c, a, other) = (probabilities[t], shares[t] * p[t], shares[1 - t] * p[1 - t]);
        // Not drawn, or not here.
        if c <= 0.0 || a <= 0.0 {
            return Share { c: f64::from(c), weight: 0.0, per_f: 0.0 };
        }
        let (weight, per_a) = if is_weighted(estimator) { heuristic(a, other, t == 0) } else { (1.0, 1.0 / a) };
        // `a` holds c already, or it is left out.
        let rest = if shares[t] == c { 1.0 } else { c };
        Share { c: f64::from(c), weight: f64::from(weight), per_f: f64::from(per_a) / f64::from(rest) }
    })
}

/// Weight, and what f is multiplied by for each unit of density: `w` and `1 / d`.
fn weigh(heuristic: Heuristic, own: f32, other: f32, wins_ties: bool) -> (f32, f32) {
    let Effective { w, d } = heuristic::weigh(Single, heuristic, &Rivals { own, other, wins_ties });
    (w, 1.0 / d)
}
