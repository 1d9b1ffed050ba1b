//! Primitives and their intersection with a packet of rays.

use glam::{DVec3, Vec3};

use crate::lanes::{Lanes, Mask, Real, V3};

/// A triangle or a parallelogram: `p0 + u e1 + v e2` with u, v >= 0 and u + v <= 1, or both <= 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// The corner both edges start from.
    pub p0: Vec3,
    /// First edge.
    pub e1: Vec3,
    /// Second edge.
    pub e2: Vec3,
    /// Unit normal, the side that a light emits from.
    pub normal: Vec3,
    /// `u = u_axis . (p - p0)` for points p of the plane.
    u_axis: Vec3,
    /// `v = v_axis . (p - p0)` for points p of the plane.
    v_axis: Vec3,
    /// Area in square units.
    pub area: f32,
    /// Parallelogram rather than triangle.
    pub quad: bool,
    /// Index of the shape it belongs to.
    pub shape: u32,
}

impl Facet {
    /// The facet spanned by two edges; `None` if they do not span an area. `flip` turns the normal
    /// `e1 x e2` round. The axes are worked out in f64 from the f32 corners.
    pub fn new(p0: Vec3, p1: Vec3, p2: Vec3, quad: bool, flip: bool, shape: u32) -> Option<Self> {
        let (o, a, b) = (p0.as_dvec3(), p1.as_dvec3(), p2.as_dvec3());
        let (e1, e2) = (a - o, b - o);
        let n = e1.cross(e2);
        let double_area = n.length();
        let unit = n / double_area;
        // Duals of the edges in their plane.
        let u_axis: DVec3 = e2.cross(unit) / e1.dot(e2.cross(unit));
        let v_axis: DVec3 = unit.cross(e1) / e2.dot(unit.cross(e1));
        if !(u_axis.as_vec3().is_finite() && v_axis.as_vec3().is_finite()) || double_area <= 0.0 {
            return None;
        }
        Some(Self {
            p0,
            e1: e1.as_vec3(),
            e2: e2.as_vec3(),
            normal: if flip { -unit } else { unit }.as_vec3(),
            u_axis: u_axis.as_vec3(),
            v_axis: v_axis.as_vec3(),
            area: (if quad { double_area } else { 0.5 * double_area }) as f32,
            quad,
            shape,
        })
    }

    /// Corners, three or four.
    pub fn corners(&self) -> impl Iterator<Item = Vec3> {
        let last = self.quad.then_some(self.p0 + self.e1 + self.e2);
        [self.p0, self.p0 + self.e1, self.p0 + self.e2].into_iter().chain(last)
    }

    /// The vectors that give a point p of the plane its coordinates: `u = u_axis . (p - p0)`, v alike.
    pub fn axes(&self) -> [Vec3; 2] {
        [self.u_axis, self.v_axis]
    }

    /// The numbers that [`FacetLanes`] are made of: p0, normal, the two axes, and whether it is a triangle.
    pub fn numbers(&self) -> [f32; FACET_NUMBERS] {
        let [p, n, u, v] = [self.p0, self.normal, self.u_axis, self.v_axis];
        let triangle = if self.quad { 0.0 } else { 1.0 };
        [p.x, p.y, p.z, n.x, n.y, n.z, u.x, u.y, u.z, v.x, v.y, v.z, triangle]
    }

    /// Distance along each ray to the plane. It may be negative or not a number.
    #[inline(always)]
    pub fn distance<L: Lanes>(&self, l: L, origin: V3<L>, dir: V3<L>) -> L::F {
        let normal = V3::splat(l, self.normal);
        -(normal.dot(origin - V3::splat(l, self.p0))) / normal.dot(dir)
    }

    /// Distance along each ray to the plane, and whether the point there is inside. The distance
    /// may be negative or not a number where the answer is no.
    #[inline(always)]
    pub fn intersect<L: Lanes>(&self, l: L, origin: V3<L>, dir: V3<L>) -> (L::F, L::M) {
        let from_p0 = origin - V3::splat(l, self.p0);
        let t = self.distance(l, origin, dir);
        let q = dir.scale_add(t, from_p0);
        let u = V3::splat(l, self.u_axis).dot(q);
        let v = V3::splat(l, self.v_axis).dot(q);
        let upper = if self.quad { u.max(v) } else { u + v };
        (t, u.min(v).ge(l.f(0.0)) & upper.le(l.f(1.0)))
    }
}

/// How many numbers [`Facet::numbers`] are.
pub const FACET_NUMBERS: usize = 13;

/// A facet in every lane, the same or another one in each.
#[derive(Clone, Copy)]
pub struct FacetLanes<L: Lanes> {
    /// Corner.
    pub p0: V3<L>,
    /// Unit normal.
    pub normal: V3<L>,
    /// Gives the first coordinate in the facet.
    pub u_axis: V3<L>,
    /// Gives the second coordinate.
    pub v_axis: V3<L>,
    /// 1 for a triangle, 0 for a parallelogram.
    pub triangle: L::F,
}

impl<L: Lanes> FacetLanes<L> {
    /// As [`Facet::intersect`], and the same bits.
    #[inline(always)]
    pub fn intersect(&self, l: L, origin: V3<L>, dir: V3<L>) -> (L::F, L::M) {
        let from_p0 = origin - self.p0;
        let t = -(self.normal.dot(from_p0)) / self.normal.dot(dir);
        let q = dir.scale_add(t, from_p0);
        let (u, v) = (self.u_axis.dot(q), self.v_axis.dot(q));
        // Either the larger of the two or, with the smaller one added, their sum.
        let upper = u.min(v).mul_add(self.triangle, u.max(v));
        (t, u.min(v).ge(l.f(0.0)) & upper.le(l.f(1.0)))
    }
}

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Centre.
    pub center: Vec3,
    /// Radius.
    pub radius: f32,
    /// The normal points to the centre.
    pub inward: bool,
    /// Index of the shape it belongs to.
    pub shape: u32,
}

impl Ball {
    /// 1 / radius^2.
    #[inline(always)]
    pub fn curvature2(&self) -> f32 {
        1.0 / (self.radius * self.radius)
    }

    /// Where the lines `origin + t dir`, `dir` of length 1, come nearest to the centre, and the square
    /// of half the chord inside the sphere, negative where they miss it. The distance of the line to
    /// the centre is taken from the vector between them: the difference of squares would lose the
    /// smallest lights (radius 0.03 at distance 15) to cancellation in f32.
    #[inline(always)]
    pub fn chord<L: Lanes>(&self, l: L, origin: V3<L>, dir: V3<L>) -> (L::F, L::F) {
        BallLanes::splat(l, self).chord(origin, dir)
    }

    /// Nearest intersection beyond `t_min`; infinite if there is none.
    #[inline(always)]
    pub fn nearest<L: Lanes>(&self, l: L, origin: V3<L>, dir: V3<L>, t_min: L::F) -> L::F {
        BallLanes::splat(l, self).nearest(l, origin, dir, t_min)
    }
}

/// See [`Ball::chord`]: of the ball whose centre is at `to_center` from where the rays start.
#[inline(always)]
pub fn chord<L: Lanes>(to_center: V3<L>, radius2: L::F, dir: V3<L>) -> (L::F, L::F) {
    let along = to_center.dot(dir);
    let off = dir.scale_add(-along, to_center);
    (along, radius2 - off.dot(off))
}

/// A sphere in every lane, the same or another one in each.
#[derive(Clone, Copy)]
pub struct BallLanes<L: Lanes> {
    /// Centre.
    pub center: V3<L>,
    /// Square of the radius.
    pub radius2: L::F,
}

impl<L: Lanes> BallLanes<L> {
    /// The same in every lane.
    #[inline(always)]
    pub fn splat(l: L, ball: &Ball) -> Self {
        Self { center: V3::splat(l, ball.center), radius2: l.f(ball.radius * ball.radius) }
    }

    /// See [`Ball::chord`].
    #[inline(always)]
    pub fn chord(&self, origin: V3<L>, dir: V3<L>) -> (L::F, L::F) {
        chord(self.center - origin, self.radius2, dir)
    }

    /// Nearest intersection beyond `t_min`; infinite if there is none.
    #[inline(always)]
    pub fn nearest(&self, l: L, origin: V3<L>, dir: V3<L>, t_min: L::F) -> L::F {
        let (along, half2) = self.chord(origin, dir);
        let half = half2.max(l.f(0.0)).sqrt();
        let (near, far) = (along - half, along + half);
        let hits = half2.ge(l.f(0.0));
        let infinite = l.f(f32::INFINITY);
        let far = (hits & far.gt(t_min)).select(far, infinite);
        (hits & near.gt(t_min)).select(near, far)
    }
}
