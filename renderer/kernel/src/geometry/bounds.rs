//! Boxes around primitives.

use glam::Vec3A;
use obvhs::aabb::Aabb;

use super::shape::{Ball, Facet};

/// Box around a facet.
pub(crate) fn facet_box(facet: &Facet) -> Aabb {
    facet.corners().fold(Aabb::empty(), |mut bounds, p| {
        bounds.extend(p.into());
        bounds
    })
}

/// Box around a ball.
pub(crate) fn ball_box(ball: &Ball) -> Aabb {
    Aabb::new(Vec3A::from(ball.center) - ball.radius, Vec3A::from(ball.center) + ball.radius)
}
