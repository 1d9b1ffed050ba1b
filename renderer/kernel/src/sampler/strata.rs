//! Strata and the orders in which pixels visit them.

use super::hash::{mix_on, mix_one};
use crate::lanes::{Lanes, Mask, Uint};

/// The strata of a round, 1 to 65536 of them, and how they are permuted: rounds of a bijection of the next power of
/// two, walked until it lands below n; then a rotation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strata {
    pub(super) n: u32,
    /// For the next power of two: all its bits, and half of how many they are.
    pub(super) mask: u32,
    pub(super) fold: u32,
}

impl Strata {
    pub(super) fn new(n: u32) -> Self {
        let bits = 32 - (n - 1).leading_zeros();
        Self { n, mask: (1 << bits) - 1, fold: bits.div_ceil(2) }
    }

    /// One round: exclusive or, multiplication by an odd number, folding of the upper half onto the lower.
    #[inline(always)]
    pub(super) fn permute<L: Lanes>(&self, l: L, x: L::U, key: L::U, factor: L::U) -> L::U {
        let y = ((x ^ key) * factor) & l.u(self.mask);
        y ^ (y >> self.fold)
    }

    /// The shuffle that the random bits of `key` name.
    #[inline(always)]
    pub(super) fn shuffle<L: Lanes>(&self, l: L, key: L::U) -> Shuffle<L> {
        // floor(r n / 2^16) for 16 random bits r: uniform to 2^-16 n.
        [key, (mix_on(l, key) >> 15) | l.u(1), ((key >> 16) * l.u(self.n)) >> 16]
    }

    /// Where a pixel's shuffle takes a stratum of its patch's order.
    #[inline(always)]
    pub(super) fn place<L: Lanes>(&self, l: L, stratum: L::U, &[key, factor, shift]: &Shuffle<L>) -> L::U {
        let mut x = self.permute(l, stratum, key, factor);
        if self.n <= self.mask {
            let mut outside = !x.lt(l.u(self.n));
            while outside.any() {
                x = outside.select_u(self.permute(l, x, key, factor), x);
                outside = !x.lt(l.u(self.n));
            }
        }
        rotate(l, x, shift, self.n)
    }

    /// Position i, with its bits in reverse order, of a power of two of strata: i, i + 1, ... are as far apart as can be.
    pub(super) fn reversed(&self, i: u32) -> u32 {
        (i & self.mask).reverse_bits().checked_shr(self.mask.leading_zeros()).unwrap_or(0)
    }

    /// Where a pixel's nested shuffle takes a stratum: each bit is flipped or not, depending on those above it, so that
    /// strata far apart stay so.
    #[inline(always)]
    pub(super) fn place_nested<L: Lanes>(&self, l: L, stratum: L::U, &[key, factor, _]: &Shuffle<L>) -> L::U {
        let x = (stratum ^ key) & l.u(self.mask);
        x ^ ((x >> 1) & factor)
    }
}

/// `x + shift` modulo n, for numbers below n.
#[inline(always)]
fn rotate<L: Lanes>(l: L, x: L::U, shift: L::U, n: u32) -> L::U {
    let (x, limit) = (x + shift, l.u(n));
    x.lt(limit).select_u(x, x - limit)
}

/// How a pixel shuffles the strata, which its patch visits in an order that all its pixels have in common. The order
/// is random, the shuffle a single round: enough to make neighbours nearly independent of each other, so that the noise
/// of all patches is alike. The rotation is uniform, so that every pixel is in every stratum with equal probability at
/// every sample. These are the key, the factor (odd, if it is not nested) and the rotation (0 to n - 1).
pub(super) type Shuffle<L> = [<L as Lanes>::U; 3];

/// The nested shuffle that the random bits of `key` name.
#[inline(always)]
pub(super) fn nested<L: Lanes>(l: L, key: L::U) -> Shuffle<L> {
    [key, mix_on(l, key) >> 16, l.u(0)]
}

/// A permutation of the strata: the order in which the pixels of a patch visit them in one dimension and one round.
#[derive(Clone, Copy, Debug)]
pub(super) struct Order {
    strata: Strata,
    keys: [u32; 4],
    factors: [u32; 4],
    /// Rotation at the end.
    pub(super) shift: u32,
}

impl Order {
    /// The permutation that `key` names.
    pub(super) fn new(strata: Strata, key: u32) -> Self {
        let key = mix_one(key);
        let key2 = mix_one(key ^ 0x68e3_1da4);
        Self {
            strata,
            keys: [key, key >> 8, key >> 16, key2 >> 1],
            factors: [key2 >> 3, key2 >> 11, key2 >> 19, key >> 5].map(|factor| factor | 1),
            shift: ((mix_one(key2) >> 16) * strata.n) >> 16,
        }
    }

    /// Where positions i go; those from n on go somewhere.
    #[inline(always)]
    pub(super) fn place<L: Lanes>(&self, l: L, i: L::U) -> L::U {
        let limit = l.u(self.strata.n);
        let mut outside = i.lt(limit);
        let mut x = outside.select_u(i, l.u(0));
        while outside.any() {
            let mut y = x;
            // Four rounds; with three, pairs of successive strata are 6 % from uniform at n = 6.
            for round in 0..4 {
                y = self.strata.permute(l, y, l.u(self.keys[round]), l.u(self.factors[round]));
            }
            x = outside.select_u(y, x);
            outside = outside & !x.lt(limit);
        }
        rotate(l, x, l.u(self.shift), self.strata.n)
    }
}
