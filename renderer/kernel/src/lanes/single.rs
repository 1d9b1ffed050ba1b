//! One lane: plain scalars.

use std::ops::{Add, BitAnd, BitOr, BitXor, Mul, Shl, Shr, Sub};

use super::{Lanes, Mask, Place, Real, SHORT, Uint, fused};

/// One lane: plain scalars.
#[derive(Clone, Copy, Debug)]
pub struct Single;

/// A `u32` that wraps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wrapping(pub u32);

impl Lanes for Single {
    const N: usize = 1;
    type F = f32;
    type U = Wrapping;
    type M = bool;
    type Part = Self;
    type Few = Self;

    #[inline(always)]
    fn part(self) -> Self {
        self
    }
    #[inline(always)]
    fn few(self) -> Self {
        self
    }
    #[inline(always)]
    fn f(self, v: f32) -> f32 {
        v
    }
    #[inline(always)]
    fn u(self, v: u32) -> Wrapping {
        Wrapping(v)
    }
    #[inline(always)]
    fn m(self, v: bool) -> bool {
        v
    }
    #[inline(always)]
    fn iota(self) -> Wrapping {
        Wrapping(0)
    }
    #[inline(always)]
    fn load(self, from: &[f32]) -> f32 {
        from[0]
    }
    #[inline(always)]
    fn load_u(self, from: &[u32]) -> Wrapping {
        Wrapping(from[0])
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> bool {
        bits & 1 == 1
    }
    #[inline(always)]
    fn lookup(self, table: &[f32; SHORT], _: usize, index: Wrapping) -> f32 {
        table[index.0 as usize]
    }
    #[inline(always)]
    fn gather(self, table: &[f32], index: Wrapping) -> f32 {
        table[index.0 as usize]
    }
    #[inline(never)]
    fn out_of_line<P: Place, R>(self, task: impl FnOnce() -> R) -> R {
        fused(task)
    }
}

impl Real for f32 {
    type L = Single;

    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        to[0] = self;
    }
    #[inline(always)]
    fn lane(self, _: usize) -> f32 {
        self
    }
    #[inline(always)]
    fn least(self) -> f32 {
        self
    }
    #[inline(always)]
    fn largest(self) -> f32 {
        self
    }
    #[inline(always)]
    fn recip(self) -> Self {
        1.0 / self
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f32::sqrt(self)
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        f32::mul_add(self, a, b)
    }
    #[inline(always)]
    fn min(self, b: Self) -> Self {
        f32::min(self, b)
    }
    #[inline(always)]
    fn max(self, b: Self) -> Self {
        f32::max(self, b)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f32::abs(self)
    }
    #[inline(always)]
    fn round(self) -> Self {
        self.round_ties_even()
    }
    #[inline(always)]
    fn to_uint(self) -> Wrapping {
        Wrapping(self as u32)
    }
    #[inline(always)]
    fn lt(self, b: Self) -> bool {
        self < b
    }
    #[inline(always)]
    fn le(self, b: Self) -> bool {
        self <= b
    }
    #[inline(always)]
    fn gt(self, b: Self) -> bool {
        self > b
    }
    #[inline(always)]
    fn ge(self, b: Self) -> bool {
        self >= b
    }
}

macro_rules! wrapping_ops {
    ($($op:ident $fn:ident $how:ident),*) => {$(
        impl $op for Wrapping {
            type Output = Self;
            #[inline(always)]
            fn $fn(self, b: Self) -> Self {
                Self(self.0.$how(b.0))
            }
        }
    )*};
}
wrapping_ops!(
    Add add wrapping_add,
    Sub sub wrapping_sub,
    Mul mul wrapping_mul,
    BitXor bitxor bitxor,
    BitAnd bitand bitand,
    BitOr bitor bitor
);

impl Shl<u32> for Wrapping {
    type Output = Self;
    #[inline(always)]
    fn shl(self, n: u32) -> Self {
        Self(self.0 << n)
    }
}

impl Shr<u32> for Wrapping {
    type Output = Self;
    #[inline(always)]
    fn shr(self, n: u32) -> Self {
        Self(self.0 >> n)
    }
}

impl Uint for Wrapping {
    type L = Single;

    #[inline(always)]
    fn store(self, to: &mut [u32]) {
        to[0] = self.0;
    }
    #[inline(always)]
    fn lane(self, _: usize) -> u32 {
        self.0
    }
    #[inline(always)]
    fn to_real(self) -> f32 {
        self.0 as f32
    }
    #[inline(always)]
    fn eq(self, b: Self) -> bool {
        self.0 == b.0
    }
    #[inline(always)]
    fn lt(self, b: Self) -> bool {
        self.0 < b.0
    }
}

impl Mask for bool {
    type L = Single;

    #[inline(always)]
    fn any(self) -> bool {
        self
    }
    #[inline(always)]
    fn all(self) -> bool {
        self
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self)
    }
    #[inline(always)]
    fn select(self, a: f32, b: f32) -> f32 {
        if self { a } else { b }
    }
    #[inline(always)]
    fn select_u(self, a: Wrapping, b: Wrapping) -> Wrapping {
        if self { a } else { b }
    }
}
