//! Boxes around primitives.

use glam::{Vec3, Vec3A};

use super::shape::{Ball, Facet};

/// A box along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Least coordinates.
    pub min: Vec3A,
    /// Largest coordinates.
    pub max: Vec3A,
}

impl Aabb {
    /// Around nothing.
    pub const EMPTY: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    /// From its corners.
    pub fn new(min: Vec3A, max: Vec3A) -> Self {
        Self { min, max }
    }

    /// Around both.
    #[inline(always)]
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Half of its surface area, to which the number of rays that enter it is proportional.
    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let d = self.max - self.min;
        d.x * d.y + d.y * d.z + d.z * d.x
    }
}

/// Box around points.
fn around(points: impl Iterator<Item = Vec3>) -> Aabb {
    points.map(Vec3A::from).fold(Aabb::EMPTY, |all, p| all.union(&Aabb::new(p, p)))
}

/// Box around a facet.
pub(crate) fn facet_box(facet: &Facet) -> Aabb {
    around(facet.corners())
}

/// Box around a ball.
pub(crate) fn ball_box(ball: &Ball) -> Aabb {
    Aabb::new(Vec3A::from(ball.center) - ball.radius, Vec3A::from(ball.center) + ball.radius)
}
