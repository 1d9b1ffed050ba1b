//! Vectors of three components in lanes: points, directions, colours.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Lanes, Mask, Real};

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
    /// Of a colour: it is not black. True for NaN, which is to be counted further on.
    #[inline(always)]
    pub fn is_lit(self, l: L) -> L::M {
        !(self.x + self.y + self.z).le(l.f(0.0))
    }
    /// This where true, 0 elsewhere: selected, since 0 times NaN is NaN.
    #[inline(always)]
    pub fn or_zero(self, l: L, m: L::M) -> Self {
        Self::select(m, self, Self::all(l.f(0.0)))
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

impl<L: Lanes> Div<L::F> for V3<L> {
    type Output = Self;
    /// One division for all three components.
    #[inline(always)]
    #[expect(clippy::suspicious_arithmetic_impl, reason = "a product with the inverse")]
    fn div(self, s: L::F) -> Self {
        self * s.recip()
    }
}

impl<L: Lanes> Neg for V3<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}
