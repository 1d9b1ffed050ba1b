//! Owen-scrambled Sobol points.

use super::hash::mix;
use super::unit::to_unit;
use crate::lanes::Lanes;

/// Keys of one dimension's Owen scrambling: of the index, of the first and the second number.
#[inline(always)]
pub(super) fn scramble<L: Lanes>(l: L, key: L::U) -> [L::U; 3] {
    [key, mix(l, key + l.u(1)), mix(l, key + l.u(2))]
}

#[inline(always)]
pub(super) fn sobol_1d<L: Lanes>(l: L, reversed: L::U, keys: &[L::U; 3]) -> L::F {
    let index = shuffled_index(l, reversed, keys[0]);
    to_unit::<L>(reverse_bits(l, scramble_reversed(l, index, keys[1])))
}

/// Owen-scrambled first two Sobol dimensions, decoupled between groups by shuffling the index
/// ("padding", Burley 2020, sections 4 and 5).
#[inline(always)]
pub(super) fn sobol_2d<L: Lanes>(l: L, reversed: L::U, keys: &[L::U; 3]) -> [L::F; 2] {
    let index = shuffled_index(l, reversed, keys[0]);
    let x = scramble_reversed(l, index, keys[1]);
    let y = scramble_reversed(l, pascal(l, index), keys[2]);
    [to_unit::<L>(reverse_bits(l, x)), to_unit::<L>(reverse_bits(l, y))]
}

/// Reverses the order of the bits.
#[inline(always)]
pub(super) fn reverse_bits<L: Lanes>(l: L, x: L::U) -> L::U {
    let x = ((x >> 1) & l.u(0x5555_5555)) | ((x & l.u(0x5555_5555)) << 1);
    let x = ((x >> 2) & l.u(0x3333_3333)) | ((x & l.u(0x3333_3333)) << 2);
    let x = ((x >> 4) & l.u(0x0f0f_0f0f)) | ((x & l.u(0x0f0f_0f0f)) << 4);
    let x = ((x >> 8) & l.u(0x00ff_00ff)) | ((x & l.u(0x00ff_00ff)) << 8);
    (x >> 16) | (x << 16)
}

/// Owen scrambling of bit-reversed fractions: a hash in which a bit depends on lower bits only
/// (Laine and Karras 2011; constants found by Vegdahl 2021).
#[inline(always)]
pub(super) fn scramble_reversed<L: Lanes>(l: L, x: L::U, seed: L::U) -> L::U {
    let x = x ^ (x * l.u(0x3d20_adea));
    let x = x + seed;
    let x = x * ((seed >> 16) | l.u(1));
    let x = x ^ (x * l.u(0x0552_6c56));
    x ^ (x * l.u(0x53a2_2864))
}

/// The index whose bits are given in reverse order, Owen-scrambled as an integer: aligned runs of 2^k indices stay together.
#[inline(always)]
pub(super) fn shuffled_index<L: Lanes>(l: L, reversed: L::U, key: L::U) -> L::U {
    reverse_bits(l, scramble_reversed(l, reversed, key))
}

/// Second Sobol dimension, bit-reversed: the generator matrix is Pascal's triangle modulo 2, that
/// is, the bits are coefficients of a polynomial p(x) and the result those of p(x + 1). Since
/// (x + 1)^s = x^s + 1 for powers of two, each halving needs one shift.
#[inline(always)]
pub(super) fn pascal<L: Lanes>(l: L, x: L::U) -> L::U {
    let x = x ^ (x >> 16);
    let x = x ^ ((x & l.u(0xff00_ff00)) >> 8);
    let x = x ^ ((x & l.u(0xf0f0_f0f0)) >> 4);
    let x = x ^ ((x & l.u(0xcccc_cccc)) >> 2);
    x ^ ((x & l.u(0xaaaa_aaaa)) >> 1)
}
