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
    /// The lights, balls first.
    pub list: Vec<Light>,
    /// Their shapes by kind, with the radiance of each.
    balls: Vec<(Ball, Vec3)>,
    facets: Vec<(Facet, Vec3)>,
    tables: Tables,
}

/// Numbers of the sphere and facet lights by index, for fetching by lane.
#[derive(Debug, Default)]
struct Tables {
    is_ball: Vec<f32>,
    p: [Vec<f32>; 3],
    /// Of a ball: 1 / radius^2.
    curvature2: Vec<f32>,
    inward: Vec<f32>,
    e1: [Vec<f32>; 3],
    e2: [Vec<f32>; 3],
    normal: [Vec<f32>; 3],
    quad: Vec<f32>,
    any_ball: bool,
    any_inward: bool,
    any_facet: bool,
}

/// What lies in one direction, as far as lights are concerned.
pub struct Sight<L: Lanes> {
    /// `p_L` of the direction, per solid angle.
    pub pdf: L::F,
    /// Distance to the nearest light surface, infinite if none is met; if it was not asked for, any.
    pub t: L::F,
    /// Radiance that the nearest one sends back, were nothing else in the way.
    pub radiance: V3<L>,
}

/// A sphere as seen from a point.
struct Cone<L: Lanes> {
    /// `1 / (1 - cos)` of its rim; from inside 1/2, for all directions.
    inverse_one_minus_cos: L::F,
    /// The point is inside.
    inside: L::M,
}

/// The cone of a sphere from the square of its centre's distance and `1 / radius^2`.
#[inline(always)]
fn cone<L: Lanes>(l: L, distance2: L::F, curvature2: L::F) -> Cone<L> {
    let x = distance2 * curvature2;
    let inside = x.lt(l.f(1.0));
    let outside = warp::inverse_one_minus_cos_of_sphere(l, x);
    Cone { inverse_one_minus_cos: inside.select(l.f(0.5), outside), inside }
}

/// Where rays meet a light.
struct Meeting<L: Lanes> {
    /// True where they do, on either side.
    met: L::M,
    /// True where they do on the side that emits.
    faces: L::M,
    /// Density of sampling this light in that direction, per solid angle.
    density: L::F,
    /// The distance is `along - sqrt(half2)`, 0 on the very surface; from inside a sphere it is
    /// `along + sqrt(half2)`.
    along: L::F,
    half2: L::F,
    inside: L::M,
}

impl<L: Lanes> Meeting<L> {
    /// Distance to the light's surface.
    #[inline(always)]
    fn distance(&self, l: L) -> L::F {
        let half = self.half2.max(l.f(0.0)).sqrt();
        (self.along + self.inside.select(half, -half)).max(l.f(0.0))
    }
}

/// Whether and where rays meet a ball light, without a square root for the distance. From inside only
/// what lies beyond `t_min` is met.
#[inline(always)]
fn meet_ball<L: Lanes>(l: L, ball: &Ball, origin: V3<L>, dir: V3<L>, t_min: L::F) -> Meeting<L> {
    let zero = l.f(0.0);
    let to_center = V3::splat(l, ball.center) - origin;
    let cone = cone(l, to_center.dot(to_center), l.f(ball.curvature2()));
    let (along, half2) = ball.chord(l, origin, dir);
    // From outside it only has to lie ahead, however near: on its very surface it still fills half of
    // all directions. From inside, far = along + half > t_min, squared.
    let short = along - t_min;
    let far_enough = short.gt(zero) | half2.gt(short * short);
    let met = half2.ge(zero) & ((cone.inside & far_enough) | (!cone.inside & along.gt(zero)));
    let faces = met & if ball.inward { cone.inside } else { !cone.inside };
    let density = warp::cone_pdf::<L>(cone.inverse_one_minus_cos);
    Meeting { met, faces, density, along, half2, inside: cone.inside }
}

/// Whether and where rays meet a facet light beyond `t_min`.
#[inline(always)]
fn meet_facet<L: Lanes>(l: L, facet: &Facet, origin: V3<L>, dir: V3<L>, t_min: L::F) -> Meeting<L> {
    let zero = l.f(0.0);
    let (distance, inside) = facet.intersect(l, origin, dir);
    let met = inside & distance.gt(t_min);
    // Uniform over the area, dA = t^2 / cos dw.
    let cos = -(V3::splat(l, facet.normal).dot(dir));
    let density = distance * distance / (cos * facet.area);
    Meeting { met, faces: met & cos.gt(zero), density, along: distance, half2: zero, inside: l.m(false) }
}

/// What a direction meets of all lights together, whichever is in front.
struct Sum<L: Lanes> {
    density: L::F,
    /// Right where only one light is met.
    radiance: V3<L>,
    met: L::M,
    /// True where more than one is.
    overlap: L::M,
}

impl<L: Lanes> Sum<L> {
    #[inline(always)]
    fn add(&mut self, l: L, meeting: &Meeting<L>, radiance: Vec3) {
        self.overlap = self.overlap | (self.met & meeting.met);
        self.met = self.met | meeting.met;
        self.density = meeting.faces.select(self.density + meeting.density, self.density);
        self.radiance = V3::select(meeting.faces, V3::splat(l, radiance), self.radiance);
    }
}

/// The light in front.
struct Front<L: Lanes> {
    t: L::F,
    index: L::U,
    radiance: V3<L>,
}

impl<L: Lanes> Front<L> {
    #[inline(always)]
    fn none(l: L) -> Self {
        Self { t: l.f(f32::INFINITY), index: l.u(0), radiance: V3::all(l.f(0.0)) }
    }

    #[inline(always)]
    fn add(&mut self, l: L, meeting: &Meeting<L>, index: usize, radiance: Vec3) {
        let distance = meeting.distance(l);
        let nearer = meeting.met & distance.lt(self.t);
        self.t = nearer.select(distance, self.t);
        self.index = nearer.select_u(l.u(index as u32), self.index);
        let emitted = V3::select(meeting.faces, V3::splat(l, radiance), V3::all(l.f(0.0)));
        self.radiance = V3::select(nearer, emitted, self.radiance);
    }
}

impl Lights {
    /// Lays the lights out for sampling, balls first.
    pub fn new(mut list: Vec<Light>) -> Self {
        list.sort_by_key(|light| matches!(light.shape, LightShape::Facet(_)));
        let mut t = Tables::default();
        let (mut balls, mut facets) = (Vec::new(), Vec::new());
        for light in &list {
            let (ball, facet) = match light.shape {
                LightShape::Ball(b) => (Some(b), None),
                LightShape::Facet(f) => (None, Some(f)),
            };
            balls.extend(ball.map(|ball| (ball, light.radiance)));
            facets.extend(facet.map(|facet| (facet, light.radiance)));
            t.any_ball |= ball.is_some();
            t.any_facet |= facet.is_some();
            t.is_ball.push(if ball.is_some() { 1.0 } else { 0.0 });
            t.any_inward |= ball.is_some_and(|b| b.inward);
            t.curvature2.push(ball.map_or(0.0, |b| b.curvature2()));
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
        Self { list, balls, facets, tables: t }
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
            let distance2 = to.dot(to);
            let cone = cone(l, distance2, self.pick(l, &t.curvature2, choice));
            let axis = to * (l.f(1.0) / distance2.max(l.f(f32::MIN_POSITIVE)).sqrt());
            // From the very centre there is no axis; any will do.
            let axis = V3::select(distance2.gt(l.f(0.0)), axis, V3 { x: l.f(0.0), y: l.f(0.0), z: l.f(1.0) });
            let local = warp::square_to_cone(l, u, l.f(1.0) / cone.inverse_one_minus_cos);
            let (s, b) = warp::frame(l, axis);
            wi = s.scale_add(local.x, b.scale_add(local.y, axis * local.z)).renormalize(l);
            faces = !cone.inside;
            if t.any_inward {
                faces = faces ^ self.pick(l, &t.inward, choice).gt(l.f(0.5));
            }
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
            wi = V3::select(is_ball, wi, point.normalize(l));
            let normal = self.pick_v(l, &t.normal, choice);
            faces = (is_ball & faces) | (!is_ball & normal.dot(point).lt(l.f(0.0)));
        }
        (wi, faces)
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
        let mut front = Front::none(l);
        let listed = self.list.len() <= patch::MOST;
        let count = if listed { list.len() } else { self.list.len() };
        // Balls, then facets: a choice inside one loop would carry all vectors through memory.
        let mut k = 0;
        while k < count {
            let i = if listed { list.get(k) } else { k };
            let Some((ball, radiance)) = self.balls.get(i) else { break };
            front.add(l, &meet_ball(l, ball, origin, dir, t_min), i, *radiance);
            k += 1;
        }
        while k < count {
            let i = if listed { list.get(k) } else { k };
            let (facet, radiance) = &self.facets[i - self.balls.len()];
            front.add(l, &meet_facet(l, facet, origin, dir, t_min), i, *radiance);
            k += 1;
        }
        (front.t, front.index, front.radiance)
    }

    /// Density of the light technique at `wi`, and what emits there; how far that is only if
    /// `distances` are asked for.
    #[inline(always)]
    pub fn look<L: Lanes>(&self, l: L, p: V3<L>, wi: V3<L>, t_min: L::F, distances: bool) -> Sight<L> {
        let zero = l.f(0.0);
        let (none, no) = (V3::all(zero), l.m(false));
        let mut sum = Sum { density: zero, radiance: none, met: no, overlap: no };
        for (ball, radiance) in &self.balls {
            sum.add(l, &meet_ball(l, ball, p, wi, t_min), *radiance);
        }
        for (facet, radiance) in &self.facets {
            sum.add(l, &meet_facet(l, facet, p, wi, t_min), *radiance);
        }
        let pdf = sum.density * (1.0 / self.list.len().max(1) as f32);
        // Few directions meet two lights: then the nearer one hides the other.
        if distances || sum.overlap.any() {
            let mut front = Front::none(l);
            for (ball, radiance) in &self.balls {
                front.add(l, &meet_ball(l, ball, p, wi, t_min), 0, *radiance);
            }
            for (facet, radiance) in &self.facets {
                front.add(l, &meet_facet(l, facet, p, wi, t_min), 0, *radiance);
            }
            return Sight { pdf, t: front.t, radiance: front.radiance };
        }
        Sight { pdf, t: l.f(f32::INFINITY), radiance: sum.radiance }
    }
}
