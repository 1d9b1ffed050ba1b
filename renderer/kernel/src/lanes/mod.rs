//! Numbers in lanes: the only folder that names the SIMD crate.
//!
//! The estimator is written once, over a [`Lanes`] type. [`Wide`] runs it on 16 pixels at a time
//! with whatever vector unit the machine has (chosen at run time, see [`Level`]), [`Twice`] on two
//! such packets side by side; [`Single`] is the same text on one pixel, plain `f32`, for tests, replay and comparison.
//!
//! Everything here and everything generic over `Lanes` is `#[inline(always)]`, helper for helper:
//! a function that does not inline into the dispatched one is compiled for the baseline
//! instruction set and loses a factor of ten, silently. Closures carry `#[inline(always)]`, too.

mod level;
mod single;
mod twice;
mod vectors;
mod wide;

use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub};

#[cfg(target_arch = "x86_64")]
pub use fearless_simd::x86::{Avx2, Avx512, Sse4_2};
pub use fearless_simd::{Level, Simd, dispatch};
pub use level::{Lanewise, Task, fused};
pub use single::{Single, Wrapping};
pub use twice::{Twice, Two};
pub use vectors::V3;
pub use wide::{Eight, Wide};

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
    fn out_of_line<P: Place, R>(self, task: impl FnOnce() -> R) -> R;
}

/// Where a task that is compiled out of line is put: into the module of this type. The compiler works on modules side by
/// side; all such tasks in one took most of the time of a build.
pub trait Place {
    /// Does the task with a vector unit. (`vectorize` by itself may be inlined.)
    #[inline(never)]
    fn call<S: Simd, R>(simd: S, task: impl FnOnce() -> R) -> R {
        simd.vectorize(task)
    }
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
    /// `1 / self`, correctly rounded.
    fn recip(self) -> Self;
    /// Correctly rounded square root.
    fn sqrt(self) -> Self;
    /// `self * a + b`, rounded once; SSE4.2 rounds twice.
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
