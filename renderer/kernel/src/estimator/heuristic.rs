//! The heuristics: from two densities to a weight and the effective density that goes with it.
//!
//! Densities differ by many orders of magnitude (a mirror-like lobe reaches 1e6 per steradian, a whole sky 0.08): none is
//! squared, only their ratio is.

use crate::lanes::{Lanes, Mask, Real};
use crate::request::{Heuristic, PerTechnique};

/// Exponent of the power heuristic.
pub const POWER_BETA: u32 = 2;
/// Share of the largest density below which the cutoff heuristic drops a technique.
pub const CUTOFF_ALPHA: f32 = 0.1;

/// How densely the techniques draw one direction, seen from the one that drew it: `p` or `c p` (`p` with
/// the tutorial's weights), per solid angle.
#[derive(Clone, Copy)]
pub struct Rivals<L: Lanes> {
    /// The technique that drew it.
    pub own: L::F,
    /// The other one.
    pub other: L::F,
    /// True for exactly one of the two techniques; only the maximum heuristic looks at it.
    pub wins_ties: L::M,
}

impl<L: Lanes> Rivals<L> {
    /// From the densities by technique; ties go to light.
    #[inline(always)]
    pub fn of(q: PerTechnique<L::F>, by_light: L::M) -> Self {
        Self { own: by_light.select(q.light, q.bsdf), other: by_light.select(q.bsdf, q.light), wins_ties: by_light }
    }
}

/// A weight, and what it makes of the density.
#[derive(Clone, Copy)]
pub struct Weighted<L: Lanes> {
    /// MIS weight w of the technique that drew the direction, in [0, 1].
    pub w: L::F,
    /// Effective density `d = q / w`, so that `w f / q = f / d`; infinite where w is 0.
    pub d: L::F,
}

/// The weight of the technique that drew a direction (Veach 1997, eqs. 9.8 and 9.10 to 9.12). Where both densities are 0
/// the result is undefined: mask it.
#[inline(always)]
pub fn weigh<L: Lanes>(l: L, heuristic: Heuristic, q: &Rivals<L>) -> Weighted<L> {
    let one = l.f(1.0);
    // The sum of two finite densities shall be one.
    let most = l.f(0.5 * f32::MAX);
    let (own, other) = (q.own.gt(most).select(most, q.own), q.other.gt(most).select(most, q.other));
    let sum = own + other;
    match heuristic {
        Heuristic::Balance => Weighted { w: own / sum, d: sum },
        Heuristic::Power => {
            let ratio = other / own;
            let squares = one + ratio * ratio;
            Weighted { w: one / squares, d: own * squares }
        }
        Heuristic::Cutoff => {
            let dropped = own.lt(other * CUTOFF_ALPHA);
            let alone = other.lt(own * CUTOFF_ALPHA);
            lost(l, dropped, Weighted { w: alone.select(one, own / sum), d: alone.select(own, sum) })
        }
        Heuristic::Maximum => {
            let wins = own.gt(other) | (q.wins_ties & own.ge(other));
            lost(l, !wins, Weighted { w: one, d: own })
        }
    }
}

/// Weight 0 where true.
#[inline(always)]
fn lost<L: Lanes>(l: L, lost: L::M, x: Weighted<L>) -> Weighted<L> {
    Weighted { w: lost.select(l.f(0.0), x.w), d: lost.select(l.f(f32::INFINITY), x.d) }
}
