//! The heuristics: from two densities to two weights that sum to one.
//!
//! Each takes `a = n_i p_i` of this technique and `b` of the other one and returns the weight of
//! *this* one. Densities differ by many orders of magnitude (a mirror-like lobe reaches 1e6 per steradian, a whole sky
//! 0.08): none is squared, only their ratio is.

use crate::lanes::{Lanes, Mask, Real};
use crate::request::Heuristic;

/// Exponent of the power heuristic.
pub const POWER_BETA: u32 = 2;
/// Share of the largest density below which the cutoff heuristic drops a technique.
pub const CUTOFF_ALPHA: f32 = 0.1;

/// Weight w of the technique with `a = n_i p_i` against the other one's `b` (Veach 1997,
/// eqs. 9.8 and 9.10 to 9.12), and `w / a`, which is what the integrand is multiplied by: for the balance heuristic
/// `1 / (a + b)`, which need not wait for the weight. `wins_ties` must be true for exactly one of the two; only the
/// maximum heuristic asks. Where both are 0 the result is undefined: mask it.
#[inline(always)]
pub fn weight<L: Lanes>(l: L, heuristic: Heuristic, a: L::F, b: L::F, wins_ties: L::M) -> (L::F, L::F) {
    let (one, zero) = (l.f(1.0), l.f(0.0));
    // The sum of two finite densities shall be one.
    let most = l.f(0.5 * f32::MAX);
    let (a, b) = (a.gt(most).select(most, a), b.gt(most).select(most, b));
    let sum = a + b;
    let share = a / sum;
    let weight = match heuristic {
        Heuristic::Balance => return (share, one / sum),
        Heuristic::Power => {
            let ratio = b / a;
            one / (ratio * ratio + 1.0)
        }
        Heuristic::Cutoff => {
            let dropped = a.lt(b * CUTOFF_ALPHA);
            let other_dropped = b.lt(a * CUTOFF_ALPHA);
            dropped.select(zero, other_dropped.select(one, share))
        }
        Heuristic::Maximum => (a.gt(b) | (wins_ties & a.ge(b))).select(one, zero),
    };
    (weight, weight / a)
}
