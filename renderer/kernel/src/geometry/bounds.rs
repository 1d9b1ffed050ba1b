//! Boxes around primitives.

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;

use super::shape::{Ball, Facet};

/// Box around points.
fn around(points: impl Iterator<Item = Vec3>) -> Aabb {
    points.map(Vec3A::from).fold(Aabb::empty(), |all, p| all.union(&Aabb::new(p, p)))
}

/// Box around a facet.
pub(crate) fn facet_box(facet: &Facet) -> Aabb {
    around(facet.corners())
}

/// Box around a ball.
pub(crate) fn ball_box(ball: &Ball) -> Aabb {
    Aabb::new(Vec3A::from(ball.center) - ball.radius, Vec3A::from(ball.center) + ball.radius)
}
