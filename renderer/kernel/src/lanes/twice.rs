//! Two sets of lanes side by side.

use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub};

use super::{Lanes, Mask, Place, Real, SHORT, Uint};

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
    fn out_of_line<P: Place, R>(self, task: impl FnOnce() -> R) -> R {
        self.0.out_of_line::<P, R>(task)
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
    fn recip(self) -> Self {
        Self(self.0.recip(), self.1.recip())
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
