//! Sixteen lanes on a vector unit, and eight: the only file that names the vectors of the SIMD crate.

use fearless_simd::{
    Bytes as _, Simd, SimdBase as _, SimdFloat as _, SimdFrom as _, SimdInt as _, SimdMask as _, f32x8, f32x16, i32x8,
    i32x16, mask32x8, mask32x16, u32x8, u32x16,
};

use super::{Lanes, Mask, Place, Real, SHORT, Uint};

/// Sixteen lanes on the vector unit that the token `S` stands for.
#[derive(Clone, Copy)]
pub struct Wide<S: Simd>(pub S);

/// Eight lanes on the same vector unit.
#[derive(Clone, Copy)]
pub struct Eight<S: Simd>(pub S);

macro_rules! vector_lanes {
    ($lanes:ident, $n:literal, $f:ident, $u:ident, $i:ident, $m:ident, $lookup:ident, $iota:expr) => {
        impl<S: Simd> Lanes for $lanes<S> {
            const N: usize = $n;
            type F = $f<S>;
            type U = $u<S>;
            type M = $m<S>;
            type Part = Self;
            type Few = Eight<S>;

            #[inline(always)]
            fn part(self) -> Self {
                self
            }
            #[inline(always)]
            fn few(self) -> Eight<S> {
                Eight(self.0)
            }
            #[inline(always)]
            fn f(self, v: f32) -> $f<S> {
                $f::splat(self.0, v)
            }
            #[inline(always)]
            fn u(self, v: u32) -> $u<S> {
                $u::splat(self.0, v)
            }
            #[inline(always)]
            fn m(self, v: bool) -> $m<S> {
                $m::splat(self.0, v)
            }
            #[inline(always)]
            fn iota(self) -> $u<S> {
                $u::simd_from(self.0, $iota)
            }
            #[inline(always)]
            fn load(self, from: &[f32]) -> $f<S> {
                $f::from_slice(self.0, &from[..$n])
            }
            #[inline(always)]
            fn load_u(self, from: &[u32]) -> $u<S> {
                $u::from_slice(self.0, &from[..$n])
            }
            #[inline(always)]
            fn mask(self, bits: u32) -> $m<S> {
                $m::from_bitmask(self.0, bits.into())
            }
            #[inline(always)]
            fn lookup(self, table: &[f32; SHORT], count: usize, index: $u<S>) -> $f<S> {
                $lookup(self, table, count, index)
            }
            #[inline(always)]
            fn gather(self, table: &[f32], index: $u<S>) -> $f<S> {
                let mut out = [0.0; $n];
                for i in 0..$n {
                    out[i] = table[index[i] as usize];
                }
                $f::simd_from(self.0, out)
            }
            #[inline(always)]
            fn out_of_line<P: Place, R>(self, task: impl FnOnce() -> R) -> R {
                P::call(self.0, task)
            }
        }

        impl<S: Simd> Real for $f<S> {
            type L = $lanes<S>;

            #[inline(always)]
            fn store(self, to: &mut [f32]) {
                self.store_slice(&mut to[..$n]);
            }
            #[inline(always)]
            fn lane(self, i: usize) -> f32 {
                self[i]
            }
            #[inline(always)]
            fn least(self) -> f32 {
                self.reduce_min()
            }
            #[inline(always)]
            fn largest(self) -> f32 {
                self.reduce_max()
            }
            #[inline(always)]
            fn recip(self) -> Self {
                $f::splat(self.simd, 1.0) / self
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                fearless_simd::SimdFloat::sqrt(self)
            }
            #[inline(always)]
            fn mul_add(self, a: Self, b: Self) -> Self {
                fearless_simd::SimdFloat::mul_add(self, a, b)
            }
            #[inline(always)]
            fn min(self, b: Self) -> Self {
                fearless_simd::SimdBase::min(self, b)
            }
            #[inline(always)]
            fn max(self, b: Self) -> Self {
                fearless_simd::SimdBase::max(self, b)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                fearless_simd::SimdBase::abs(self)
            }
            #[inline(always)]
            fn round(self) -> Self {
                self.round_ties_even()
            }
            #[inline(always)]
            fn to_uint(self) -> $u<S> {
                let i: $i<S> = self.to_int();
                i.bitcast()
            }
            #[inline(always)]
            fn lt(self, b: Self) -> $m<S> {
                self.simd_lt(b)
            }
            #[inline(always)]
            fn le(self, b: Self) -> $m<S> {
                self.simd_le(b)
            }
            #[inline(always)]
            fn gt(self, b: Self) -> $m<S> {
                self.simd_gt(b)
            }
            #[inline(always)]
            fn ge(self, b: Self) -> $m<S> {
                self.simd_ge(b)
            }
        }

        impl<S: Simd> Uint for $u<S> {
            type L = $lanes<S>;

            #[inline(always)]
            fn store(self, to: &mut [u32]) {
                self.store_slice(&mut to[..$n]);
            }
            #[inline(always)]
            fn lane(self, i: usize) -> u32 {
                self[i]
            }
            #[inline(always)]
            fn to_real(self) -> $f<S> {
                let i: $i<S> = self.bitcast();
                i.to_float()
            }
            #[inline(always)]
            fn eq(self, b: Self) -> $m<S> {
                self.simd_eq(b)
            }
            #[inline(always)]
            fn lt(self, b: Self) -> $m<S> {
                self.simd_lt(b)
            }
        }

        impl<S: Simd> Mask for $m<S> {
            type L = $lanes<S>;

            #[inline(always)]
            fn any(self) -> bool {
                self.any_true()
            }
            #[inline(always)]
            fn all(self) -> bool {
                self.all_true()
            }
            #[inline(always)]
            fn bits(self) -> u32 {
                self.to_bitmask() as u32
            }
            #[inline(always)]
            fn select(self, a: $f<S>, b: $f<S>) -> $f<S> {
                fearless_simd::Select::select(self, a, b)
            }
            #[inline(always)]
            fn select_u(self, a: $u<S>, b: $u<S>) -> $u<S> {
                fearless_simd::Select::select(self, a, b)
            }
        }
    };
}
vector_lanes!(
    Wide,
    16,
    f32x16,
    u32x16,
    i32x16,
    mask32x16,
    lookup_in_vector,
    [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15]
);
vector_lanes!(Eight, 8, f32x8, u32x8, i32x8, mask32x8, lookup_by_comparing, [0, 1, 2, 3, 4, 5, 6, 7]);

/// [`Lanes::lookup`] in a vector as long as the table.
#[inline(always)]
fn lookup_in_vector<S: Simd>(l: Wide<S>, table: &[f32; SHORT], count: usize, index: u32x16<S>) -> f32x16<S> {
    #[cfg(target_arch = "x86_64")]
    if l.0.level().as_avx512().is_some() {
        // One instruction; its indices are those of bytes.
        let bytes: fearless_simd::u8x64<S> = (index * 0x0404_0404 + 0x0302_0100).bitcast();
        return f32x16::from_slice(l.0, table).swizzle_dyn(bytes);
    }
    lookup_by_comparing(l, table, count, index)
}

/// [`Lanes::lookup`] that goes through the table.
#[inline(always)]
fn lookup_by_comparing<L: Lanes>(l: L, table: &[f32; SHORT], count: usize, index: L::U) -> L::F {
    let mut v = l.f(table[0]);
    for (&number, i) in table[..count.min(SHORT)].iter().zip(0..).skip(1) {
        v = index.eq(l.u(i)).select(l.f(number), v);
    }
    v
}
