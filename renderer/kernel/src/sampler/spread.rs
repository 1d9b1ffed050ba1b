//! Permutations of the integers below n that take neighbours far apart.

use super::strata::Strata;
use crate::lanes::SHORT;

/// The golden section: its multiples spread evenly modulo 1.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

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
        Self { ranks, steps: Steps::golden(n) }
    }

    /// Where q goes.
    pub(super) fn place(&self, q: u32) -> u32 {
        if self.steps.n as usize > SHORT { self.steps.place(q) } else { self.ranks[q as usize] }
    }
}

/// An order to visit n strata in, such that those visited are far apart at any time; and another one, such that strata near
/// each other in the first are far apart in it: positions in the pixel and directions of one sample should have nothing to do
/// with each other. (Paired by a poor step, 13 at n = 36, they cost 7 to 17 % where shadows end.)
#[derive(Clone, Copy, Debug)]
pub(super) struct Orders {
    strata: Strata,
    steps: Steps,
    other: Steps,
}

impl Orders {
    pub(super) fn new(n: u32) -> Self {
        let steps = Steps::golden(if n.is_multiple_of(2) { n / 2 } else { n });
        Self { strata: Strata::new(n), steps, other: Steps::apart(n) }
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
    /// The number is the one nearest to the golden section of n.
    fn golden(n: u32) -> Self {
        Self { n, step: near_golden(n)[0] }
    }

    /// The number, near the golden section of n, is the one whose points `(q, place(q))` are farthest apart.
    fn apart(n: u32) -> Self {
        let steps = near_golden(n).into_iter().rev();
        Self { n, step: steps.max_by_key(|&step| shortest(step, n)).unwrap_or(1) }
    }

    fn place(&self, i: u32) -> u32 {
        (u64::from(i) * u64::from(self.step) % u64::from(self.n)) as u32
    }
}

/// Numbers coprime to n near the golden section of n, the nearest first.
fn near_golden(n: u32) -> Vec<u32> {
    let ideal = GOLDEN * f64::from(n);
    let off = |step: &u32| (f64::from(*step) - ideal).abs();
    // Among four dozen successive numbers below 65536 one at least is coprime to n.
    let near = (ideal as u32).saturating_sub(24)..(ideal as u32 + 25).min(n.max(2));
    let mut steps: Vec<u32> = near.filter(|&step| coprime(step, n)).collect();
    steps.sort_by(|a, b| off(a).total_cmp(&off(b)));
    steps
}

/// Square of the shortest vector between points `(q, q step mod n)`, by Gauss's reduction.
fn shortest(step: u32, n: u32) -> i64 {
    let length = |[x, y]: [i64; 2]| x * x + y * y;
    let (mut a, mut b) = ([1, i64::from(step)], [0, i64::from(n)]);
    loop {
        if length(a) > length(b) {
            (a, b) = (b, a);
        }
        let dot = a[0] * b[0] + a[1] * b[1];
        // Rounded to the nearest.
        let times = (2 * dot + length(a)).div_euclid(2 * length(a));
        if times == 0 {
            return length(a);
        }
        b = [b[0] - times * a[0], b[1] - times * a[1]];
    }
}

fn coprime(a: u32, b: u32) -> bool {
    let (mut a, mut b) = (a, b);
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against all vectors, one by one.
    #[test]
    fn what_is_paired_is_as_far_apart_as_a_step_allows() {
        let exhaustive = |step: u32, n: u32| {
            let length = |q: u32| {
                let rest = q * step % n;
                i64::from(q).pow(2) + i64::from(rest.min(n - rest)).pow(2)
            };
            // The vector (0, n) is one of them.
            (1..n).map(length).chain([i64::from(n).pow(2)]).min().unwrap_or_default()
        };
        for n in 1..150 {
            let steps = near_golden(n);
            for &step in &steps {
                assert_eq!(shortest(step, n), exhaustive(step, n), "step {step} of {n}");
            }
            let farthest = steps.iter().map(|&step| exhaustive(step, n)).max();
            assert_eq!(Some(exhaustive(Steps::apart(n).step, n)), farthest, "n = {n}");
        }
        assert_eq!([36, 64].map(|n| Steps::apart(n).step), [29, 37], "the nearest to the golden section of those");
    }
}
