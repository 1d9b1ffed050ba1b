//! From random bits to numbers in [0, 1).

use crate::lanes::{Lanes, Real, Uint};

/// 2^-24: what makes 24 bits a number in [0, 1).
pub(super) const UNIT: f32 = 1.0 / 16_777_216.0;

/// The largest float below 1.
pub(super) const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// One half in 24 bits.
pub(super) const HALF: f32 = 8_388_608.0;

/// The upper 24 bits as a float in [0, 1).
#[inline(always)]
pub(super) fn to_unit<L: Lanes>(x: L::U) -> L::F {
    (x >> 8).to_real() * UNIT
}

/// A number in a stratum of n, at `offset` in units of 2^-24.
#[inline(always)]
pub(super) fn in_stratum<L: Lanes>(l: L, stratum: L::F, n: u32, offset: L::F) -> L::F {
    offset.mul_add(l.f(UNIT / n as f32), stratum * (1.0 / n as f32)).min(l.f(BELOW_ONE))
}
