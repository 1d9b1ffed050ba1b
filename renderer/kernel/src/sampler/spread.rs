//! Permutations of the integers below n that take neighbours far apart.

use super::sobol::pascal;
use super::strata::Strata;
use crate::lanes::{Single, Wrapping};

/// Fractions that multiples of spread evenly modulo 1: the golden section; and two for the plane, by powers of the plastic
/// number (Roberts 2018).
const GOLDEN: f64 = 0.618_033_988_749_894_9;
const PLASTIC: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];

/// Up to here, golden permutations are ranks.
const RANKS: usize = 16;

/// The golden permutation of n numbers: q goes to the rank of `q` times the golden section, modulo 1. Of more than
/// [`RANKS`] it goes to `g q mod n` with g near the golden section of n, which needs no table.
#[derive(Clone, Copy, Debug)]
pub(super) struct Golden {
    ranks: [u32; RANKS],
    steps: Steps,
}

impl Golden {
    pub(super) fn new(n: u32) -> Self {
        let fraction = |q: u32| (f64::from(q) * GOLDEN).fract();
        let mut ranks = [0; RANKS];
        for (q, rank) in ranks.iter_mut().enumerate().take(n as usize) {
            *rank = (0..n.min(RANKS as u32)).filter(|&other| fraction(other) < fraction(q as u32)).count() as u32;
        }
        Self { ranks, steps: Steps::new(GOLDEN, n) }
    }

    /// Where q goes.
    pub(super) fn place(&self, q: u32) -> u32 {
        if self.steps.n as usize <= RANKS { self.ranks[q as usize] } else { self.steps.place(q) }
    }
}

/// Two orders of n things, each visiting all of them, unrelated to each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Orders {
    strata: Strata,
    half: Steps,
    whole: [Steps; 2],
}

impl Orders {
    pub(super) fn new(n: u32) -> Self {
        let whole = PLASTIC.map(|ratio| Steps::new(ratio, n));
        Self { strata: Strata::new(n), half: Steps::new(PLASTIC[0], (n / 2).max(1)), whole }
    }

    /// Which come i-th. In the first order the next one is half of all things further, where i is even and n is.
    pub(super) fn place(&self, i: u32) -> [u32; 2] {
        let n = self.strata.n;
        if n.is_power_of_two() {
            // The first two dimensions of Sobol's points.
            return [i, pascal(Single, Wrapping(i)).0].map(|i| self.strata.reversed(i));
        }
        let [first, second] = self.whole.map(|steps| steps.place(i));
        if n.is_multiple_of(2) { [self.half.place(i / 2) + i % 2 * (n / 2), second] } else { [first, second] }
    }
}

/// Multiples of a number coprime to n, modulo n.
#[derive(Clone, Copy, Debug)]
struct Steps {
    n: u32,
    step: u32,
}

impl Steps {
    /// The number is the one nearest to `ratio` n.
    fn new(ratio: f64, n: u32) -> Self {
        let ideal = ratio * f64::from(n);
        let off = |step: &u32| (f64::from(*step) - ideal).abs();
        // Among four dozen successive numbers below 65536 one at least is coprime to n.
        let near = (ideal as u32).saturating_sub(24)..(ideal as u32 + 25).min(n.max(2));
        let step = near.filter(|&step| coprime(step, n)).min_by(|a, b| off(a).total_cmp(&off(b)));
        Self { n, step: step.expect("a number coprime to n is near") }
    }

    fn place(&self, i: u32) -> u32 {
        (u64::from(i) * u64::from(self.step) % u64::from(self.n)) as u32
    }
}

fn coprime(a: u32, b: u32) -> bool {
    let (mut a, mut b) = (a, b);
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a == 1
}
