//! How rays hit one light, and with which density the light technique draws that direction: the textbook's formulas.

use crate::geometry::shape::{Ball, BallLanes};
use crate::lanes::{Lanes, Mask, Real, V3};
use crate::warp;

/// Where rays hit a light.
pub(super) struct LightHit<L: Lanes> {
    /// True where they do, on either side.
    pub(super) hit: L::M,
    /// True where they do on the side that emits.
    pub(super) faces: L::M,
    /// Density of sampling this light in that direction, per solid angle.
    pub(super) density: L::F,
    /// Distance to the light's surface.
    pub(super) distance: L::F,
}

/// Where rays hit a ball light's surface from outside or from within, without a square root: how far
/// along the ray the nearest point to the centre is, and the square of half the chord.
pub(super) struct Chord<L: Lanes> {
    pub(super) along: L::F,
    pub(super) half2: L::F,
    /// Square of the centre's distance in units of the radius squared; with `from_outside`, [`far_distance2`] knows it.
    pub(super) x: L::F,
    /// The rays start inside.
    pub(super) inside: L::M,
    /// The line hits the sphere, and not only behind the start.
    pub(super) hit: L::M,
}

/// With `from_outside`, rays start outside, and not next to the surface.
#[inline(always)]
pub(super) fn chord<L: Lanes>(
    l: L,
    ball: &BallLanes<L>,
    curvature2: L::F,
    origin: V3<L>,
    dir: V3<L>,
    from_outside: bool,
) -> Chord<L> {
    let zero = l.f(0.0);
    let (along, half2) = ball.chord(origin, dir);
    // Whether the whole line hits it.
    let (line, ahead) = (half2.ge(zero), along.gt(zero));
    // Seen from outside it only has to lie ahead, however near: on its very surface it still fills half of all directions.
    if from_outside {
        return Chord { along, half2, x: zero, inside: l.m(false), hit: line & ahead };
    }
    let to_center = ball.center - origin;
    let x = to_center.dot(to_center) * curvature2;
    let inside = x.lt(l.f(1.0));
    Chord { along, half2, x, inside, hit: line & (inside | ahead) }
}

/// See [`Chord::x`]; not for points next to the surface, where it would not be exact.
#[inline(always)]
pub(super) fn far_distance2<L: Lanes>(l: L, along: L::F, half2: L::F, curvature2: L::F) -> L::F {
    (along * along - half2).mul_add(curvature2, l.f(1.0))
}

/// Density of sampling a ball from outside, `1 / (2 pi (1 - cos))`: from the square of the centre's distance in units
/// of the radius squared.
#[inline(always)]
pub(super) fn density_from_outside<L: Lanes>(l: L, x: L::F) -> L::F {
    warp::cone_pdf::<L>(warp::inverse_one_minus_cos_of_sphere(l, x))
}

/// A ball light in every lane, the same or another one in each.
pub(super) struct BallLightLanes<L: Lanes> {
    pub(super) ball: BallLanes<L>,
    pub(super) curvature2: L::F,
    pub(super) inward: L::M,
}

impl<L: Lanes> BallLightLanes<L> {
    #[inline(always)]
    pub(super) fn splat(l: L, ball: &Ball) -> Self {
        Self { ball: BallLanes::splat(l, ball), curvature2: l.f(ball.curvature2()), inward: l.m(ball.inward) }
    }

    /// Whether and where rays hit it. From inside only what lies beyond `t_min` is hit.
    #[inline(always)]
    pub(super) fn hit(&self, l: L, origin: V3<L>, dir: V3<L>, t_min: L::F, from_outside: bool) -> LightHit<L> {
        let Chord { along, half2, x, inside, hit } = chord(l, &self.ball, self.curvature2, origin, dir, from_outside);
        let x = if from_outside { far_distance2(l, along, half2, self.curvature2) } else { x };
        let half = half2.max(l.f(0.0)).sqrt();
        let distance = (along + inside.select(half, -half)).max(l.f(0.0));
        let hit = hit & (!inside | distance.gt(t_min));
        let faces = hit & !(inside ^ self.inward);
        // From inside, all directions alike.
        let density = inside.select(l.f(warp::SPHERE_PDF), density_from_outside(l, x));
        LightHit { hit, faces, density, distance }
    }
}

/// What a facet light is that rays hit at `distance` if they are `inside` its edges; only beyond `t_min`.
#[inline(always)]
pub(super) fn hit_facet<L: Lanes>(
    l: L,
    (distance, inside): (L::F, L::M),
    normal: V3<L>,
    area: L::F,
    dir: V3<L>,
    t_min: L::F,
) -> LightHit<L> {
    let hit = inside & distance.gt(t_min);
    // Uniform over the area, dA = t^2 / cos dw.
    let cos = -(normal.dot(dir));
    let density = distance * distance / (cos * area);
    LightHit { hit, faces: hit & cos.gt(l.f(0.0)), density, distance }
}

impl<L: Lanes> LightHit<L> {
    /// The same where true, nothing elsewhere.
    #[inline(always)]
    pub(super) fn only(self, here: L::M) -> Self {
        Self { hit: self.hit & here, faces: self.faces & here, ..self }
    }
}
