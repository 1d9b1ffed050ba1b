//! Lights: the light technique's way to draw a direction, and its density.
//!
//! The density of a direction is that of the whole mixture: `p_L(w) = sum_l q_l p_l(w)` over every
//! light that the line meets, hidden or not, with `q_l = 1 / n`. It is defined once, in
//! [`Lights::look`], as a function of the direction alone; both techniques and every strategy use
//! that function, so that the two weights of a direction always sum to one.

use glam::Vec3;

use crate::lanes::{Lanes, Mask, Real, Uint, V3};
use crate::patch::{self, List};
use crate::sampler::{Dimension, Numbers};
use crate::shape::{Ball, Facet};
use crate::warp;

/// Where a light is.
#[derive(Clone, Copy, Debug)]
pub enum LightShape {
    /// Sampled over the cone it fills; from inside, over all directions.
    Ball(Ball),
    /// Sampled over its area.
    Facet(Facet),
}

/// A surface that emits, on its outer side.
#[derive(Clone, Copy, Debug)]
pub struct Light {
    /// The surface.
    pub shape: LightShape,
    /// Emitted radiance.
    pub radiance: Vec3,
    /// What it reflects.
    pub material: crate::bsdf::Material,
}

/// All lights that are on.
#[derive(Debug, Default)]
pub struct Lights {
    /// The lights.
    pub list: Vec<Light>,
    tables: Tables,
}

/// Numbers of the sphere and facet lights by index, for fetching by lane.
#[derive(Debug, Default)]
struct Tables {
    is_ball: Vec<f32>,
    p: [Vec<f32>; 3],
    radius: Vec<f32>,
    inward: Vec<f32>,
    e1: [Vec<f32>; 3],
    e2: [Vec<f32>; 3],
    normal: [Vec<f32>; 3],
    quad: Vec<f32>,
    any_ball: bool,
    any_facet: bool,
}

/// What lies in one direction, as far as lights are concerned.
pub struct Sight<L: Lanes> {
    /// `p_L` of the direction, per solid angle.
    pub pdf: L::F,
    /// Distance to the nearest light surface; infinite if none is met.
    pub t: L::F,
    /// Radiance that the nearest one sends back, were nothing else in the way.
    pub radiance: V3<L>,
}

/// A sphere as seen from a point.
struct Cone<L: Lanes> {
    /// `1 - cos` of its rim, 2 from inside.
    one_minus_cos: L::F,
    /// The point is inside.
    inside: L::M,
}

#[inline(always)]
fn cone<L: Lanes>(l: L, distance2: L::F, radius2: L::F) -> Cone<L> {
    let inside = distance2.lt(radius2);
    let outside_cos = warp::one_minus_cos_of_sphere(l, (radius2 / distance2).min(l.f(1.0)));
    Cone { one_minus_cos: inside.select(l.f(2.0), outside_cos), inside }
}

impl Light {
    /// Where a ray meets the light, whether it does, and if so on the emitting side. A sphere from inside and
    /// a facet are only met beyond `t_min`.
    #[inline(always)]
    fn meet<L: Lanes>(&self, l: L, origin: V3<L>, dir: V3<L>, t_min: L::F) -> (L::F, L::M, L::M) {
        match &self.shape {
            LightShape::Ball(ball) => {
                let to_center = V3::splat(l, ball.center) - origin;
                let inside = to_center.dot(to_center).lt(l.f(ball.radius * ball.radius));
                let hit = ball.intersect(l, origin, dir);
                // From outside it only has to lie ahead, however near: on its very surface it still fills
                // half of all directions, though the distance is 0.
                let zero = l.f(0.0);
                let distance = inside.select(hit.far, hit.near.max(zero));
                let ahead = (inside & hit.far.gt(t_min)) | (!inside & (hit.near + hit.far).gt(zero));
                let met = hit.meets & ahead;
                (distance, met, met & if ball.inward { inside } else { !inside })
            }
            LightShape::Facet(facet) => {
                let (distance, inside) = facet.intersect(l, origin, dir);
                let met = inside & distance.gt(t_min);
                (distance, met, met & V3::splat(l, facet.normal).dot(dir).lt(l.f(0.0)))
            }
        }
    }
}

impl Lights {
    /// Lays the lights out for sampling.
    pub fn new(list: Vec<Light>) -> Self {
        let mut t = Tables::default();
        for light in &list {
            let (ball, facet) = match light.shape {
                LightShape::Ball(b) => (Some(b), None),
                LightShape::Facet(f) => (None, Some(f)),
            };
            t.any_ball |= ball.is_some();
            t.any_facet |= facet.is_some();
            t.is_ball.push(if ball.is_some() { 1.0 } else { 0.0 });
            t.radius.push(ball.map_or(0.0, |b| b.radius));
            t.inward.push(if ball.is_some_and(|b| b.inward) { 1.0 } else { 0.0 });
            t.quad.push(if facet.is_some_and(|f| f.quad) { 1.0 } else { 0.0 });
            let p = ball.map(|b| b.center).or(facet.map(|f| f.p0)).unwrap_or_default();
            let e1 = facet.map_or(Vec3::ZERO, |f| f.e1);
            let e2 = facet.map_or(Vec3::ZERO, |f| f.e2);
            let normal = facet.map_or(Vec3::ZERO, |f| f.normal);
            for axis in 0..3 {
                t.p[axis].push(p[axis]);
                t.e1[axis].push(e1[axis]);
                t.e2[axis].push(e2[axis]);
                t.normal[axis].push(normal[axis]);
            }
        }
        Self { list, tables: t }
    }

    /// Draws a direction from `p` towards a light: light l with probability `1 / n`, then a
    /// direction by its own law. The density is `look(..).pdf`. False where the light chosen turns
    /// its back: such a sample has failed, whatever else lies in its direction.
    #[inline(always)]
    pub fn sample<L: Lanes>(&self, l: L, p: V3<L>, random: &Numbers<L>) -> (V3<L>, L::M) {
        let n = self.list.len();
        if n == 0 {
            return (V3 { x: l.f(0.0), y: l.f(0.0), z: l.f(1.0) }, l.m(false));
        }
        let u = random.get_2d(Dimension::Light);
        let mut choice = l.u(0);
        if n > 1 {
            let last = l.u(n as u32 - 1);
            let drawn = (random.get_1d(Dimension::LightChoice) * n as f32).to_uint();
            choice = drawn.lt(last).select_u(drawn, last);
        }
        let t = &self.tables;
        let at = self.pick_v(l, &t.p, choice);
        let to = at - p;

        let mut wi = to;
        let mut faces = l.m(true);
        if t.any_ball {
            let radius = self.pick(l, &t.radius, choice);
            let distance2 = to.dot(to);
            let cone = cone(l, distance2, radius * radius);
            let axis = to * (l.f(1.0) / distance2.max(l.f(f32::MIN_POSITIVE)).sqrt());
            // From the very centre there is no axis; any will do.
            let axis = V3::select(distance2.gt(l.f(0.0)), axis, V3 { x: l.f(0.0), y: l.f(0.0), z: l.f(1.0) });
            let local = warp::square_to_cone(l, u, cone.one_minus_cos);
            let (s, b) = warp::frame(l, axis);
            wi = s.scale_add(local.x, b.scale_add(local.y, axis * local.z));
            let inward = self.pick(l, &t.inward, choice).gt(l.f(0.5));
            faces = !(inward ^ cone.inside);
        }
        if t.any_facet {
            let [b1, b2] = u;
            let [f1, f2] = warp::square_to_triangle(l, u);
            let quad = self.pick(l, &t.quad, choice).gt(l.f(0.5));
            let (b1, b2) = (quad.select(b1, f1), quad.select(b2, f2));
            let e1 = self.pick_v(l, &t.e1, choice);
            let e2 = self.pick_v(l, &t.e2, choice);
            let point = e1.scale_add(b1, e2.scale_add(b2, to));
            let is_ball = self.pick(l, &t.is_ball, choice).gt(l.f(0.5));
            wi = V3::select(is_ball, wi, point);
            let normal = self.pick_v(l, &t.normal, choice);
            faces = (is_ball & faces) | (!is_ball & normal.dot(point).lt(l.f(0.0)));
        }
        (wi.normalize(l), faces)
    }

    /// `table[choice]`: by comparing for a handful of lights, by fetching for many.
    #[inline(always)]
    fn pick<L: Lanes>(&self, l: L, table: &[f32], choice: L::U) -> L::F {
        if table.len() > 8 {
            return l.gather(table, choice);
        }
        let mut v = l.f(table[0]);
        for (i, &x) in table.iter().enumerate().skip(1) {
            v = choice.eq(l.u(i as u32)).select(l.f(x), v);
        }
        v
    }

    #[inline(always)]
    fn pick_v<L: Lanes>(&self, l: L, table: &[Vec<f32>; 3], choice: L::U) -> V3<L> {
        V3 {
            x: self.pick(l, &table[0], choice),
            y: self.pick(l, &table[1], choice),
            z: self.pick(l, &table[2], choice),
        }
    }

    /// First light surface of the list that each ray meets: distance, index, and the radiance it
    /// sends back.
    #[inline(always)]
    pub fn nearest<L: Lanes>(&self, l: L, origin: V3<L>, dir: V3<L>, list: &List) -> (L::F, L::U, V3<L>) {
        let t_min = l.f(0.0);
        let mut t = l.f(f32::INFINITY);
        let mut index = l.u(0);
        let mut radiance = V3::all(l.f(0.0));
        let listed = self.list.len() <= patch::MOST;
        for k in 0..if listed { list.len() } else { self.list.len() } {
            let i = if listed { list.get(k) } else { k };
            let light = &self.list[i];
            let (distance, met, faces) = light.meet(l, origin, dir, t_min);
            let nearer = met & distance.lt(t);
            t = nearer.select(distance, t);
            index = nearer.select_u(l.u(i as u32), index);
            let emitted = V3::select(faces, V3::splat(l, light.radiance), V3::all(l.f(0.0)));
            radiance = V3::select(nearer, emitted, radiance);
        }
        (t, index, radiance)
    }

    /// Density of the light technique at `wi`, and what emits there.
    #[inline(always)]
    pub fn look<L: Lanes>(&self, l: L, p: V3<L>, wi: V3<L>, t_min: L::F) -> Sight<L> {
        let zero = l.f(0.0);
        let mut pdf = zero;
        let mut t = l.f(f32::INFINITY);
        let mut radiance = V3::all(zero);
        for light in &self.list {
            let (distance, met, faces) = light.meet(l, p, wi, t_min);
            let density = match &light.shape {
                LightShape::Ball(ball) => {
                    let to_center = V3::splat(l, ball.center) - p;
                    let cone = cone(l, to_center.dot(to_center), l.f(ball.radius * ball.radius));
                    warp::cone_pdf(l, cone.one_minus_cos)
                }
                LightShape::Facet(facet) => {
                    // Uniform over the area, dA = t^2 / cos dw.
                    let cos = -(V3::splat(l, facet.normal).dot(wi));
                    distance * distance / (cos * facet.area)
                }
            };
            pdf = faces.select(pdf + density, pdf);
            let nearer = met & distance.lt(t);
            t = nearer.select(distance, t);
            let emitted = V3::select(faces, V3::splat(l, light.radiance), V3::all(zero));
            radiance = V3::select(nearer, emitted, radiance);
        }
        Sight { pdf: pdf * (1.0 / self.list.len().max(1) as f32), t, radiance }
    }
}
