//! Hashes: random bits from integers.

use crate::lanes::Lanes;

/// A bijection of 32-bit integers with good avalanche (two multiply-xorshift rounds, constants of
/// the low-bias search by Wellons 2018 and followers).
#[inline(always)]
pub(crate) fn mix<L: Lanes>(l: L, x: L::U) -> L::U {
    let x = (x ^ (x >> 16)) * l.u(0x21f0_aaad);
    let x = (x ^ (x >> 15)) * l.u(0xd35a_2d97);
    x ^ (x >> 15)
}

/// [`mix`] for one number.
#[inline(always)]
pub(crate) const fn mix_one(x: u32) -> u32 {
    let x = (x ^ (x >> 16)).wrapping_mul(0x21f0_aaad);
    let x = (x ^ (x >> 15)).wrapping_mul(0xd35a_2d97);
    x ^ (x >> 15)
}

/// The upper half of the avalanche of [`mix`] again, for a second number from the bits of a first one. It costs half as
/// much; its upper bits, which are the ones used, depend on all bits of the first.
#[inline(always)]
pub(crate) fn mix_on<L: Lanes>(l: L, x: L::U) -> L::U {
    (x ^ (x >> 16)) * l.u(0x7feb_352d)
}
