//! Permutations of the integers below n that take neighbours far apart.

use super::strata::Strata;
use crate::lanes::SHORT;

/// The golden and the silver section: their multiples spread evenly modulo 1.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
const SILVER: f64 = std::f64::consts::SQRT_2 - 1.0;

/// The golden permutation of n numbers: q goes to the rank of `q` times the golden section, modulo 1. Of more than
/// [`SHORT`] it goes to `g q mod n` with g near the golden section of n, which needs no table. Of six it goes where [`SIX`]
/// says: the golden one takes 5 and 0, neighbours once slots are rotated, to 1 and 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Golden {
    ranks: [u32; SHORT],
    steps: Steps,
}

/// The one order of six numbers in a circle (but for its mirror images) in which no neighbours are neighbours in size.
const SIX: [u32; 6] = [0, 2, 4, 1, 5, 3];

impl Golden {
    pub(super) fn new(n: u32) -> Self {
        let fraction = |q: u32| (f64::from(q) * GOLDEN).fract();
        let mut ranks = [0; SHORT];
        for (q, rank) in ranks.iter_mut().enumerate().take(n as usize) {
            *rank = (0..n.min(SHORT as u32)).filter(|&other| fraction(other) < fraction(q as u32)).count() as u32;
        }
        if n == 6 {
            ranks[..6].copy_from_slice(&SIX);
        }
        Self { ranks, steps: Steps::new(GOLDEN, n) }
    }

    /// Where q goes.
    pub(super) fn place(&self, q: u32) -> u32 {
        if self.steps.n as usize > SHORT { self.steps.place(q) } else { self.ranks[q as usize] }
    }
}

/// An order to visit n strata in, such that those visited are far apart at any time; and another one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Orders {
    strata: Strata,
    steps: Steps,
    other: Steps,
}

impl Orders {
    pub(super) fn new(n: u32) -> Self {
        let steps = Steps::new(GOLDEN, if n.is_multiple_of(2) { n / 2 } else { n });
        Self { strata: Strata::new(n), steps, other: Steps::new(SILVER, n) }
    }

    /// Which come i-th. If n is even, those numbered 2j and 2j + 1 in the first order are n / 2 apart.
    pub(super) fn place(&self, i: u32) -> [u32; 2] {
        let n = self.strata.n;
        let first = if n.is_power_of_two() {
            self.strata.reversed(i)
        } else if n.is_multiple_of(2) {
            self.steps.place(i / 2) + i % 2 * (n / 2)
        } else {
            self.steps.place(i)
        };
        [first, self.other.place(first)]
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
