//! Two lanes in plain arrays, to find out whether lanes know of each other. Each does exactly what [`Single`] does, so that
//! results have to agree to the bit.
//!
//! [`Single`]: mislab_kernel::lanes::Single

use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub};

use mislab_kernel::lanes::{Lanes, Mask, Place, Real, SHORT, Uint};

/// Two lanes.
#[derive(Clone, Copy, Debug)]
pub struct Two;

/// Two floats.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Floats(pub [f32; 2]);

/// Two integers that wrap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Integers(pub [u32; 2]);

/// Two truth values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Truths(pub [bool; 2]);

impl Lanes for Two {
    const N: usize = 2;
    type F = Floats;
    type U = Integers;
    type M = Truths;
    type Part = Self;
    type Few = Self;

    fn part(self) -> Self {
        self
    }
    fn few(self) -> Self {
        self
    }
    fn f(self, v: f32) -> Floats {
        Floats([v; 2])
    }
    fn u(self, v: u32) -> Integers {
        Integers([v; 2])
    }
    fn m(self, v: bool) -> Truths {
        Truths([v; 2])
    }
    fn iota(self) -> Integers {
        Integers([0, 1])
    }
    fn load(self, from: &[f32]) -> Floats {
        Floats([from[0], from[1]])
    }
    fn load_u(self, from: &[u32]) -> Integers {
        Integers([from[0], from[1]])
    }
    fn mask(self, bits: u32) -> Truths {
        Truths([0, 1].map(|i| bits >> i & 1 == 1))
    }
    fn lookup(self, table: &[f32; SHORT], _: usize, index: Integers) -> Floats {
        Floats(index.0.map(|i| table[i as usize]))
    }
    fn gather(self, table: &[f32], index: Integers) -> Floats {
        Floats(index.0.map(|i| table[i as usize]))
    }
    fn out_of_line<P: Place, R>(self, task: impl FnOnce() -> R) -> R {
        task()
    }
}

/// `op(a, b)` in each lane.
#[inline]
fn both<A: Copy, B: Copy, C>(a: [A; 2], b: [B; 2], op: impl Fn(A, B) -> C) -> [C; 2] {
    [op(a[0], b[0]), op(a[1], b[1])]
}

macro_rules! operators {
    ($($type:ident { $($op:ident $fn:ident $how:expr;)* })*) => {$($(
        impl $op for $type {
            type Output = Self;
            fn $fn(self, b: Self) -> Self {
                Self(both(self.0, b.0, $how))
            }
        }
    )*)*};
}
operators!(
    Floats {
        Add add |a, b| a + b;
        Sub sub |a, b| a - b;
        Mul mul |a, b| a * b;
        Div div |a, b| a / b;
    }
    Integers {
        Add add u32::wrapping_add;
        Sub sub u32::wrapping_sub;
        Mul mul u32::wrapping_mul;
        BitXor bitxor |a, b| a ^ b;
        BitAnd bitand |a, b| a & b;
        BitOr bitor |a, b| a | b;
    }
    Truths {
        BitXor bitxor |a, b| a ^ b;
        BitAnd bitand |a, b| a & b;
        BitOr bitor |a, b| a | b;
    }
);

macro_rules! operators_with_one {
    ($($type:ident { $($op:ident $fn:ident $other:ident $how:expr;)* })*) => {$($(
        impl $op<$other> for $type {
            type Output = Self;
            fn $fn(self, b: $other) -> Self {
                Self(both(self.0, [b; 2], $how))
            }
        }
    )*)*};
}
operators_with_one!(
    Floats {
        Add add f32 |a, b| a + b;
        Sub sub f32 |a, b| a - b;
        Mul mul f32 |a, b| a * b;
        Div div f32 |a, b| a / b;
    }
    Integers {
        Shl shl u32 |a, n| a << n;
        Shr shr u32 |a, n| a >> n;
    }
);

impl Neg for Floats {
    type Output = Self;
    fn neg(self) -> Self {
        Self(self.0.map(|a| -a))
    }
}

impl Not for Truths {
    type Output = Self;
    fn not(self) -> Self {
        Self(self.0.map(|a| !a))
    }
}

impl Real for Floats {
    type L = Two;

    fn store(self, to: &mut [f32]) {
        to[..2].copy_from_slice(&self.0);
    }
    fn lane(self, i: usize) -> f32 {
        self.0[i]
    }
    fn least(self) -> f32 {
        self.0[0].min(self.0[1])
    }
    fn largest(self) -> f32 {
        self.0[0].max(self.0[1])
    }
    fn recip(self) -> Self {
        Self(self.0.map(|x| 1.0 / x))
    }
    fn sqrt(self) -> Self {
        Self(self.0.map(f32::sqrt))
    }
    fn mul_add(self, a: Self, b: Self) -> Self {
        Self([0, 1].map(|i| f32::mul_add(self.0[i], a.0[i], b.0[i])))
    }
    fn min(self, b: Self) -> Self {
        Self(both(self.0, b.0, f32::min))
    }
    fn max(self, b: Self) -> Self {
        Self(both(self.0, b.0, f32::max))
    }
    fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }
    fn round(self) -> Self {
        Self(self.0.map(f32::round_ties_even))
    }
    fn to_uint(self) -> Integers {
        Integers(self.0.map(|a| a as u32))
    }
    fn lt(self, b: Self) -> Truths {
        Truths(both(self.0, b.0, |a, b| a < b))
    }
    fn le(self, b: Self) -> Truths {
        Truths(both(self.0, b.0, |a, b| a <= b))
    }
    fn gt(self, b: Self) -> Truths {
        Truths(both(self.0, b.0, |a, b| a > b))
    }
    fn ge(self, b: Self) -> Truths {
        Truths(both(self.0, b.0, |a, b| a >= b))
    }
}

impl Uint for Integers {
    type L = Two;

    fn store(self, to: &mut [u32]) {
        to[..2].copy_from_slice(&self.0);
    }
    fn lane(self, i: usize) -> u32 {
        self.0[i]
    }
    fn to_real(self) -> Floats {
        Floats(self.0.map(|a| a as f32))
    }
    fn eq(self, b: Self) -> Truths {
        Truths(both(self.0, b.0, |a, b| a == b))
    }
    fn lt(self, b: Self) -> Truths {
        Truths(both(self.0, b.0, |a, b| a < b))
    }
}

impl Mask for Truths {
    type L = Two;

    fn any(self) -> bool {
        self.0[0] || self.0[1]
    }
    fn all(self) -> bool {
        self.0[0] && self.0[1]
    }
    fn bits(self) -> u32 {
        u32::from(self.0[0]) | u32::from(self.0[1]) << 1
    }
    fn select(self, a: Floats, b: Floats) -> Floats {
        Floats([0, 1].map(|i| if self.0[i] { a.0[i] } else { b.0[i] }))
    }
    fn select_u(self, a: Integers, b: Integers) -> Integers {
        Integers([0, 1].map(|i| if self.0[i] { a.0[i] } else { b.0[i] }))
    }
}
