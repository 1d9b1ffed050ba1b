//! Numbers in lanes: the only file that names the SIMD crate.
//!
//! The estimator is written once, over a [`Lanes`] type. [`Wide`] runs it on 16 pixels at a time
//! with whatever vector unit the machine has (chosen at run time, see [`Level`]), [`Twice`] on two
//! such packets side by side; [`Single`] is the same text on one pixel, plain `f32`, for tests, replay and comparison.
//!
//! Everything here and everything generic over `Lanes` is `#[inline(always)]`, helper for helper:
//! a function that does not inline into the dispatched one is compiled for the baseline
//! instruction set and loses a factor of ten, silently. For the same reason there are no closures.

use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub};

use fearless_simd::{
    Bytes as _, SimdBase as _, SimdFloat as _, SimdFrom as _, SimdInt as _, SimdMask as _, f32x8, f32x16, i32x8,
    i32x16, mask32x8, mask32x16, u8x64, u32x8, u32x16,
};

pub use fearless_simd::{Level, Simd, dispatch};

/// Pixels per packet: a block of 8 x 4, the most lanes there are. [`Single`] walks the same blocks one pixel at a time.
pub const PACKET: usize = 32;

/// Length of the tables that lanes look numbers up in: one vector of the widest machines.
pub const SHORT: usize = 16;

/// A set of lanes: how many, and the types of their numbers. The value itself is a token that
/// makes new numbers.
pub trait Lanes: Copy + Send + Sync + 'static {
    /// Number of lanes, a divisor of [`PACKET`].
    const N: usize;
    /// 32-bit floats.
    type F: Real<L = Self>;
    /// 32-bit unsigned integers, wrapping.
    type U: Uint<L = Self>;
    /// One truth value per lane.
    type M: Mask<L = Self>;
    /// As many lanes as fill one vector of the machine.
    type Part: Lanes<Few = Self::Few>;
    /// At most eight lanes, for what is not more than that.
    type Few: Lanes;

    /// See [`Self::Part`].
    fn part(self) -> Self::Part;
    /// See [`Self::Few`].
    fn few(self) -> Self::Few;

    /// The same float in every lane.
    fn f(self, v: f32) -> Self::F;
    /// The same integer in every lane.
    fn u(self, v: u32) -> Self::U;
    /// The same truth value in every lane.
    fn m(self, v: bool) -> Self::M;
    /// 0, 1, 2, ...
    fn iota(self) -> Self::U;
    /// The first [`Self::N`] elements of `from`.
    fn load(self, from: &[f32]) -> Self::F;
    /// The first [`Self::N`] elements of `from`.
    fn load_u(self, from: &[u32]) -> Self::U;
    /// True in the lanes whose bits are set, lane i being bit i.
    fn mask(self, bits: u32) -> Self::M;
    /// `table[index]` for indices below `count`, lane by lane.
    fn lookup(self, table: &[f32; SHORT], count: usize, index: Self::U) -> Self::F;
    /// `table[index]`, lane by lane, of tables of any length. Slow.
    fn gather(self, table: &[f32], index: Self::U) -> Self::F;

    /// Does a task in a function of its own, with the same vector unit: for what is long and not always needed, or
    /// takes so long that a call does not matter. It is then compiled once, not wherever it is used, and what
    /// is always needed stays short. The task must be `#[inline(always)]` and own all lanes that it takes
    /// along: those it borrowed would have to stay in memory.
    fn apart<R>(self, task: impl FnOnce() -> R) -> R;
}

/// Floats in lanes.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Add<f32, Output = Self>
    + Sub<Output = Self>
    + Sub<f32, Output = Self>
    + Mul<Output = Self>
    + Mul<f32, Output = Self>
    + Div<Output = Self>
    + Div<f32, Output = Self>
    + Neg<Output = Self>
{
    /// The lanes they are in.
    type L: Lanes<F = Self>;

    /// Writes the lanes to the first elements of `to`.
    fn store(self, to: &mut [f32]);
    /// One lane.
    fn lane(self, i: usize) -> f32;
    /// The smallest of all lanes, none of which may be NaN.
    fn least(self) -> f32;
    /// The largest of all lanes, none of which may be NaN.
    fn largest(self) -> f32;
    /// Correctly rounded square root.
    fn sqrt(self) -> Self;
    /// `self * a + b`, fused where the machine can.
    fn mul_add(self, a: Self, b: Self) -> Self;
    /// The smaller of two numbers.
    fn min(self, b: Self) -> Self;
    /// The larger of two numbers.
    fn max(self, b: Self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Nearest integer, ties to even.
    fn round(self) -> Self;
    /// Towards zero, for values in [0, 2^31).
    fn to_uint(self) -> <Self::L as Lanes>::U;
    /// `self < b`
    fn lt(self, b: Self) -> <Self::L as Lanes>::M;
    /// `self <= b`
    fn le(self, b: Self) -> <Self::L as Lanes>::M;
    /// `self > b`
    fn gt(self, b: Self) -> <Self::L as Lanes>::M;
    /// `self >= b`
    fn ge(self, b: Self) -> <Self::L as Lanes>::M;
}

/// Unsigned integers in lanes, wrapping arithmetic.
pub trait Uint:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + BitXor<Output = Self>
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + Shl<u32, Output = Self>
    + Shr<u32, Output = Self>
{
    /// The lanes they are in.
    type L: Lanes<U = Self>;

    /// Writes the lanes to the first elements of `to`.
    fn store(self, to: &mut [u32]);
    /// One lane.
    fn lane(self, i: usize) -> u32;
    /// As floats; exact below 2^24, values below 2^31 only.
    fn to_real(self) -> <Self::L as Lanes>::F;
    /// `self == b`
    fn eq(self, b: Self) -> <Self::L as Lanes>::M;
    /// `self < b`
    fn lt(self, b: Self) -> <Self::L as Lanes>::M;
}

/// Truth values in lanes.
pub trait Mask:
    Copy + BitAnd<Output = Self> + BitOr<Output = Self> + BitXor<Output = Self> + Not<Output = Self>
{
    /// The lanes they are in.
    type L: Lanes<M = Self>;

    /// True in at least one lane.
    fn any(self) -> bool;
    /// True in every lane.
    fn all(self) -> bool;
    /// Bit i is lane i.
    fn bits(self) -> u32;
    /// `a` where true, `b` elsewhere.
    fn select(self, a: <Self::L as Lanes>::F, b: <Self::L as Lanes>::F) -> <Self::L as Lanes>::F;
    /// `a` where true, `b` elsewhere.
    fn select_u(self, a: <Self::L as Lanes>::U, b: <Self::L as Lanes>::U) -> <Self::L as Lanes>::U;
}

// ---------------------------------------------------------------------------------------------
// Sixteen lanes, and eight

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
            fn apart<R>(self, task: impl FnOnce() -> R) -> R {
                /// `vectorize` by itself may be inlined.
                #[inline(never)]
                fn call<S: Simd, R>(simd: S, task: impl FnOnce() -> R) -> R {
                    simd.vectorize(task)
                }
                call(self.0, task)
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
        let bytes: u8x64<S> = (index * 0x0404_0404 + 0x0302_0100).bitcast();
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

// ---------------------------------------------------------------------------------------------
// One lane

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
    fn apart<R>(self, task: impl FnOnce() -> R) -> R {
        task()
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
    fn sqrt(self) -> Self {
        f32::sqrt(self)
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        // Not `f32::mul_add`, which is a library call where the target has no fused instruction.
        self * a + b
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

// ---------------------------------------------------------------------------------------------
// Two sets of lanes side by side

/// The lanes of `A` twice: every operation is done on one half, then on the other. The two have nothing to
/// do with each other, so the processor works on one where it would wait for a result of the other.
#[derive(Clone, Copy, Debug)]
pub struct Twice<A>(pub A);

/// Numbers of [`Twice`].
#[derive(Clone, Copy, Debug)]
pub struct Two<T>(T, T);

impl<A: Lanes> Lanes for Twice<A> {
    const N: usize = 2 * A::N;
    type F = Two<A::F>;
    type U = Two<A::U>;
    type M = Two<A::M>;
    type Part = A::Part;
    type Few = A::Few;

    #[inline(always)]
    fn part(self) -> A::Part {
        self.0.part()
    }
    #[inline(always)]
    fn few(self) -> A::Few {
        self.0.few()
    }
    #[inline(always)]
    fn f(self, v: f32) -> Two<A::F> {
        let v = self.0.f(v);
        Two(v, v)
    }
    #[inline(always)]
    fn u(self, v: u32) -> Two<A::U> {
        let v = self.0.u(v);
        Two(v, v)
    }
    #[inline(always)]
    fn m(self, v: bool) -> Two<A::M> {
        let v = self.0.m(v);
        Two(v, v)
    }
    #[inline(always)]
    fn iota(self) -> Two<A::U> {
        let first = self.0.iota();
        Two(first, first + self.0.u(A::N as u32))
    }
    #[inline(always)]
    fn load(self, from: &[f32]) -> Two<A::F> {
        Two(self.0.load(from), self.0.load(&from[A::N..]))
    }
    #[inline(always)]
    fn load_u(self, from: &[u32]) -> Two<A::U> {
        Two(self.0.load_u(from), self.0.load_u(&from[A::N..]))
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> Two<A::M> {
        Two(self.0.mask(bits), self.0.mask(bits >> A::N))
    }
    #[inline(always)]
    fn lookup(self, table: &[f32; SHORT], count: usize, index: Two<A::U>) -> Two<A::F> {
        Two(self.0.lookup(table, count, index.0), self.0.lookup(table, count, index.1))
    }
    #[inline(always)]
    fn gather(self, table: &[f32], index: Two<A::U>) -> Two<A::F> {
        Two(self.0.gather(table, index.0), self.0.gather(table, index.1))
    }
    #[inline(always)]
    fn apart<R>(self, task: impl FnOnce() -> R) -> R {
        self.0.apart(task)
    }
}

macro_rules! two_ops {
    ($($op:ident $fn:ident),*) => {$(
        impl<T: $op<Output = T>> $op for Two<T> {
            type Output = Self;
            #[inline(always)]
            fn $fn(self, b: Self) -> Self {
                Self(self.0.$fn(b.0), self.1.$fn(b.1))
            }
        }
    )*};
}
two_ops!(Add add, Sub sub, Mul mul, Div div, BitXor bitxor, BitAnd bitand, BitOr bitor);

macro_rules! two_with_one {
    ($($op:ident $fn:ident $one:ty),*) => {$(
        impl<T: $op<$one, Output = T>> $op<$one> for Two<T> {
            type Output = Self;
            #[inline(always)]
            fn $fn(self, b: $one) -> Self {
                Self(self.0.$fn(b), self.1.$fn(b))
            }
        }
    )*};
}
two_with_one!(Add add f32, Sub sub f32, Mul mul f32, Div div f32, Shl shl u32, Shr shr u32);

impl<T: Neg<Output = T>> Neg for Two<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl<T: Not<Output = T>> Not for Two<T> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0, !self.1)
    }
}

impl<F: Real> Real for Two<F> {
    type L = Twice<F::L>;

    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        self.0.store(to);
        self.1.store(&mut to[F::L::N..]);
    }
    #[inline(always)]
    fn lane(self, i: usize) -> f32 {
        if i < F::L::N { self.0.lane(i) } else { self.1.lane(i - F::L::N) }
    }
    #[inline(always)]
    fn least(self) -> f32 {
        self.0.least().min(self.1.least())
    }
    #[inline(always)]
    fn largest(self) -> f32 {
        self.0.largest().max(self.1.largest())
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt(), self.1.sqrt())
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Self(self.0.mul_add(a.0, b.0), self.1.mul_add(a.1, b.1))
    }
    #[inline(always)]
    fn min(self, b: Self) -> Self {
        Self(self.0.min(b.0), self.1.min(b.1))
    }
    #[inline(always)]
    fn max(self, b: Self) -> Self {
        Self(self.0.max(b.0), self.1.max(b.1))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs(), self.1.abs())
    }
    #[inline(always)]
    fn round(self) -> Self {
        Self(self.0.round(), self.1.round())
    }
    #[inline(always)]
    fn to_uint(self) -> Two<<F::L as Lanes>::U> {
        Two(self.0.to_uint(), self.1.to_uint())
    }
    #[inline(always)]
    fn lt(self, b: Self) -> Two<<F::L as Lanes>::M> {
        Two(self.0.lt(b.0), self.1.lt(b.1))
    }
    #[inline(always)]
    fn le(self, b: Self) -> Two<<F::L as Lanes>::M> {
        Two(self.0.le(b.0), self.1.le(b.1))
    }
    #[inline(always)]
    fn gt(self, b: Self) -> Two<<F::L as Lanes>::M> {
        Two(self.0.gt(b.0), self.1.gt(b.1))
    }
    #[inline(always)]
    fn ge(self, b: Self) -> Two<<F::L as Lanes>::M> {
        Two(self.0.ge(b.0), self.1.ge(b.1))
    }
}

impl<U: Uint> Uint for Two<U> {
    type L = Twice<U::L>;

    #[inline(always)]
    fn store(self, to: &mut [u32]) {
        self.0.store(to);
        self.1.store(&mut to[U::L::N..]);
    }
    #[inline(always)]
    fn lane(self, i: usize) -> u32 {
        if i < U::L::N { self.0.lane(i) } else { self.1.lane(i - U::L::N) }
    }
    #[inline(always)]
    fn to_real(self) -> Two<<U::L as Lanes>::F> {
        Two(self.0.to_real(), self.1.to_real())
    }
    #[inline(always)]
    fn eq(self, b: Self) -> Two<<U::L as Lanes>::M> {
        Two(self.0.eq(b.0), self.1.eq(b.1))
    }
    #[inline(always)]
    fn lt(self, b: Self) -> Two<<U::L as Lanes>::M> {
        Two(self.0.lt(b.0), self.1.lt(b.1))
    }
}

impl<M: Mask> Mask for Two<M> {
    type L = Twice<M::L>;

    #[inline(always)]
    fn any(self) -> bool {
        (self.0 | self.1).any()
    }
    #[inline(always)]
    fn all(self) -> bool {
        (self.0 & self.1).all()
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        self.0.bits() | self.1.bits() << M::L::N
    }
    #[inline(always)]
    fn select(self, a: Two<<M::L as Lanes>::F>, b: Two<<M::L as Lanes>::F>) -> Two<<M::L as Lanes>::F> {
        Two(self.0.select(a.0, b.0), self.1.select(a.1, b.1))
    }
    #[inline(always)]
    fn select_u(self, a: Two<<M::L as Lanes>::U>, b: Two<<M::L as Lanes>::U>) -> Two<<M::L as Lanes>::U> {
        Two(self.0.select_u(a.0, b.0), self.1.select_u(a.1, b.1))
    }
}

// ---------------------------------------------------------------------------------------------
// Vectors of three

/// A point, direction or colour in every lane.
#[derive(Clone, Copy)]
pub struct V3<L: Lanes> {
    /// First component, or red.
    pub x: L::F,
    /// Second component, or green.
    pub y: L::F,
    /// Third component, or blue.
    pub z: L::F,
}

impl<L: Lanes> V3<L> {
    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat(l: L, v: glam::Vec3) -> Self {
        Self { x: l.f(v.x), y: l.f(v.y), z: l.f(v.z) }
    }
    /// The same number in every component.
    #[inline(always)]
    pub fn all(v: L::F) -> Self {
        Self { x: v, y: v, z: v }
    }
    /// Inner product.
    #[inline(always)]
    pub fn dot(self, b: Self) -> L::F {
        self.x.mul_add(b.x, self.y.mul_add(b.y, self.z * b.z))
    }
    /// Cross product.
    #[inline(always)]
    pub fn cross(self, b: Self) -> Self {
        Self { x: self.y * b.z - self.z * b.y, y: self.z * b.x - self.x * b.z, z: self.x * b.y - self.y * b.x }
    }
    /// Component by component, for colours.
    #[inline(always)]
    pub fn times(self, b: Self) -> Self {
        Self { x: self.x * b.x, y: self.y * b.y, z: self.z * b.z }
    }
    /// `self * s + b`
    #[inline(always)]
    pub fn scale_add(self, s: L::F, b: Self) -> Self {
        Self { x: self.x.mul_add(s, b.x), y: self.y.mul_add(s, b.y), z: self.z.mul_add(s, b.z) }
    }
    /// Unit vector of the same direction.
    #[inline(always)]
    pub fn normalize(self, l: L) -> Self {
        self * (l.f(1.0) / self.dot(self).sqrt())
    }
    /// Of unit length where rounding alone has kept it from that: one step of Newton's.
    #[inline(always)]
    pub fn renormalize(self, l: L) -> Self {
        self * (l.f(1.5) - self.dot(self) * 0.5)
    }
    /// `a` where true, `b` elsewhere.
    #[inline(always)]
    pub fn select(m: L::M, a: Self, b: Self) -> Self {
        Self { x: m.select(a.x, b.x), y: m.select(a.y, b.y), z: m.select(a.z, b.z) }
    }
}

impl<L: Lanes> Add for V3<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self { x: self.x + b.x, y: self.y + b.y, z: self.z + b.z }
    }
}

impl<L: Lanes> Sub for V3<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self { x: self.x - b.x, y: self.y - b.y, z: self.z - b.z }
    }
}

impl<L: Lanes> Mul<L::F> for V3<L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: L::F) -> Self {
        Self { x: self.x * s, y: self.y * s, z: self.z * s }
    }
}

impl<L: Lanes> Neg for V3<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

/// Short name of the level that [`Wide`] runs at.
pub fn level_name(level: Level) -> &'static str {
    let text = format!("{level:?}");
    if text.starts_with("Avx512") {
        "AVX-512"
    } else if text.starts_with("Avx2") {
        "AVX2"
    } else if text.starts_with("Sse4_2") {
        "SSE4.2"
    } else if text.starts_with("Sse2") {
        "SSE2"
    } else if text.starts_with("Neon") {
        "NEON"
    } else {
        "scalar"
    }
}
