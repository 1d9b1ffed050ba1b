//! Lights: the light technique's way to draw a direction, and its density.
//!
//! The density of a direction is that of the whole mixture: `p_L(wi) = sum_l p_l(wi) / n` over every
//! light that the line hits, hidden or not. It is defined once, in
//! [`Lights::look`], as a function of the direction alone; both techniques and every strategy use
//! that function, so that the two weights of a direction always sum to one.

mod built;
mod hit;
mod tables;
mod tree;

use glam::Vec3;

use crate::geometry::bounds::{ball_box, facet_box};
use crate::geometry::list::{self, List};
use crate::geometry::shape::{self, Ball, BallLanes, Facet, FacetLanes};
use crate::lanes::{Lanes, Mask, Place, Real, SHORT, Uint, V3};
use crate::sampler::Numbers;
use crate::stop::{Stop, Stopped};
use crate::warp;
pub use built::{BuiltLight, LightShape};
use hit::{BallLightLanes, LightHit, chord, density_from_outside, far_distance2, hit_facet};
use tables::Tables;
use tree::LightTree;

/// Most sphere lights that are looked up in a table of [`SHORT`] numbers, in which 0 stands for no light.
pub const IN_TABLE: usize = SHORT - 1;

/// Up to so many lights each is asked for every direction; a tree pays from about there.
const FLAT_LIMIT: usize = 32;

/// All lights that are on.
#[derive(Debug, Default)]
pub struct Lights {
    /// The lights, balls first.
    pub list: Vec<BuiltLight>,
    /// Their shapes by kind, with the radiance of each.
    balls: Vec<BallLight>,
    facets: Vec<(Facet, Vec3)>,
    tables: Tables,
    outside: Outside,
    tree: Option<LightTree>,
    /// No ray starts inside a ball light or next to its surface.
    from_outside: bool,
}

/// Samples of lights that are not a few spheres, compiled out of line.
struct AnyShapes;
impl Place for AnyShapes {}

/// A sphere light.
#[derive(Clone, Copy, Debug)]
struct BallLight {
    ball: Ball,
    radiance: Vec3,
    /// Its place in [`Outside`]; 0 if it emits inwards.
    outside: u32,
}

/// Of up to [`IN_TABLE`] ball lights, what they show outside: nothing, then one after the other.
#[derive(Debug, Default)]
struct Outside {
    curvature2: [f32; SHORT],
    radiance: [[f32; SHORT]; 3],
}

/// What lies in one direction, as far as lights are concerned.
pub struct Sight<L: Lanes> {
    /// `p_L` of the direction, per solid angle.
    pub pdf: L::F,
    /// Distance to the nearest light surface, infinite if none is hit; if it was not asked for, any.
    pub t: L::F,
    /// Radiance that the nearest one sends back, were nothing else in the way.
    pub radiance: V3<L>,
    /// True where that is not 0.
    pub shines: L::M,
}

impl<L: Lanes> Sight<L> {
    /// No light.
    #[inline(always)]
    fn nothing(l: L) -> Self {
        Self { pdf: l.f(0.0), t: l.f(f32::INFINITY), radiance: V3::all(l.f(0.0)), shines: l.m(false) }
    }
}

/// A direction that the light technique drew.
#[derive(Clone, Copy)]
pub struct Aim<L: Lanes> {
    /// The direction, of unit length.
    pub wi: V3<L>,
    /// False where the light chosen turns its back: such a sample has failed, whatever else lies in its direction.
    pub valid: L::M,
    /// Number of the light.
    choice: L::U,
    /// From the surface to its centre (a ball) or corner (a facet).
    to: V3<L>,
}

impl<L: Lanes> Aim<L> {
    /// No direction.
    #[inline(always)]
    pub fn nowhere(l: L) -> Self {
        let z = V3 { x: l.f(0.0), y: l.f(0.0), z: l.f(1.0) };
        Self { wi: z, valid: l.m(false), choice: l.u(0), to: z }
    }
}

/// The light in front, and the densities of all.
struct Front<L: Lanes> {
    t: L::F,
    index: L::U,
    radiance: V3<L>,
    density: L::F,
}

impl<L: Lanes> Front<L> {
    #[inline(always)]
    fn none(l: L) -> Self {
        Self { t: l.f(f32::INFINITY), index: l.u(0), radiance: V3::all(l.f(0.0)), density: l.f(0.0) }
    }

    #[inline(always)]
    fn add(&mut self, l: L, hit: &LightHit<L>, index: L::U, radiance: V3<L>) {
        let nearer = hit.hit & hit.distance.lt(self.t);
        self.t = nearer.select(hit.distance, self.t);
        self.index = nearer.select_u(index, self.index);
        let emitted = V3::select(hit.faces, radiance, V3::all(l.f(0.0)));
        self.radiance = V3::select(nearer, emitted, self.radiance);
        self.density = hit.faces.select(self.density + hit.density, self.density);
    }
}

impl Lights {
    /// Lays the lights out for sampling, balls first.
    ///
    /// # Errors
    /// If it is stopped.
    pub fn new(mut list: Vec<BuiltLight>, stop: Stop<'_>) -> Result<Self, Stopped> {
        list.sort_by_key(|light| matches!(light.shape, LightShape::Facet(_)));
        let mut outside = Outside::default();
        let (mut balls, mut facets) = (Vec::new(), Vec::new());
        for light in &list {
            let (ball, facet) = match light.shape {
                LightShape::Ball(b) => (Some(b), None),
                LightShape::Facet(f) => (None, Some(f)),
            };
            balls.extend(ball.map(|ball| BallLight {
                ball,
                radiance: light.radiance,
                outside: if ball.inward || balls.len() >= IN_TABLE { 0 } else { balls.len() as u32 + 1 },
            }));
            if let Some(BallLight { ball, radiance, outside: at @ 1.. }) = balls.last() {
                let at = *at as usize;
                outside.curvature2[at] = ball.curvature2();
                for axis in 0..3 {
                    outside.radiance[axis][at] = radiance[axis];
                }
            }
            facets.extend(facet.map(|facet| (facet, light.radiance)));
        }
        let tree = (list.len() > FLAT_LIMIT).then(|| {
            let boxes: Vec<_> = list
                .iter()
                .map(|light| match &light.shape {
                    LightShape::Ball(ball) => ball_box(ball),
                    LightShape::Facet(facet) => facet_box(facet),
                })
                .collect();
            LightTree::new(&boxes, stop)
        });
        let tree = tree.transpose()?;
        let tables = Tables::new(&list);
        Ok(Self { list, balls, facets, tables, outside, tree, from_outside: false })
    }

    /// True if these are the same shapes, whatever they emit.
    pub fn has_shapes_of(&self, other: &Self) -> bool {
        self.list.len() == other.list.len() && self.list.iter().zip(&other.list).all(|(a, b)| a.shape == b.shape)
    }

    /// True if there are so many that a tree narrows them down.
    pub fn has_tree(&self) -> bool {
        self.tree.is_some()
    }

    /// The same lights, each of which is asked for every ray: to compare with.
    #[must_use]
    pub fn without_tree(mut self) -> Self {
        self.tree = None;
        self
    }

    /// The same lights, where no point that is asked about can lie inside of one or nearer to its surface than a
    /// thousandth of its radius.
    #[must_use]
    pub fn seen_from_outside(mut self) -> Self {
        self.from_outside = true;
        self
    }

    /// See [`Self::seen_from_outside`].
    pub fn are_seen_from_outside(&self) -> bool {
        self.from_outside
    }

    /// Draws a direction from `p` towards a light: light l with probability `1 / n`, then a
    /// direction by its own law. The density is `look(..).pdf`.
    #[inline(always)]
    pub fn sample<L: Lanes>(&self, l: L, p: V3<L>, random: &Numbers<L>) -> Aim<L> {
        let n = self.list.len();
        if n == 0 {
            return Aim::nowhere(l);
        }
        let (choice, u) = random.choose_light(l, n);
        if n <= SHORT && !self.tables.any_facet {
            return self.sample_one::<L, true>(l, p, u, choice);
        }
        l.out_of_line::<AnyShapes, _>(
            #[inline(always)]
            move || self.sample_one::<L, false>(l, p, u, choice),
        )
    }

    /// Draws a direction from `p` towards the light chosen. `SHORT_LIST`: there are [`SHORT`] at most, all of them balls.
    #[inline(always)]
    fn sample_one<L: Lanes, const SHORT_LIST: bool>(&self, l: L, p: V3<L>, u: [L::F; 2], choice: L::U) -> Aim<L> {
        let t = &self.tables;
        let to = t.pick_v::<L, SHORT_LIST>(l, &t.p, choice) - p;

        let mut wi = to;
        let mut faces = l.m(true);
        if SHORT_LIST || t.any_ball {
            let distance2 = to.dot(to);
            let x = distance2 * t.pick::<L, SHORT_LIST>(l, &t.curvature2, choice);
            let inside = x.lt(l.f(1.0));
            let axis = to * (l.f(1.0) / distance2.max(l.f(f32::MIN_POSITIVE)).sqrt());
            // From the very centre there is no axis; any will do.
            let axis = V3::select(distance2.gt(l.f(0.0)), axis, V3 { x: l.f(0.0), y: l.f(0.0), z: l.f(1.0) });
            let one_minus_cos = inside.select(l.f(2.0), l.f(1.0) / warp::inverse_one_minus_cos_of_sphere(l, x));
            let local = warp::square_to_cone(l, u, one_minus_cos);
            let (s, b) = warp::frame(l, axis);
            wi = s.scale_add(local.x, b.scale_add(local.y, axis * local.z)).renormalize(l);
            faces = !inside;
            if t.any_inward {
                faces = faces ^ t.pick::<L, SHORT_LIST>(l, &t.inward, choice).gt(l.f(0.5));
            }
        }
        if !SHORT_LIST && t.any_facet {
            let [b1, b2] = u;
            let [f1, f2] = warp::square_to_triangle(l, u);
            let quad = t.pick::<L, SHORT_LIST>(l, &t.quad, choice).gt(l.f(0.5));
            let (b1, b2) = (quad.select(b1, f1), quad.select(b2, f2));
            let e1 = t.pick_v::<L, SHORT_LIST>(l, &t.e1, choice);
            let e2 = t.pick_v::<L, SHORT_LIST>(l, &t.e2, choice);
            let point = e1.scale_add(b1, e2.scale_add(b2, to));
            let is_ball = t.pick::<L, SHORT_LIST>(l, &t.is_ball, choice).gt(l.f(0.5));
            wi = V3::select(is_ball, wi, point.normalize(l));
            let normal = t.pick_v::<L, SHORT_LIST>(l, &t.normal, choice);
            faces = (is_ball & faces) | (!is_ball & normal.dot(point).lt(l.f(0.0)));
        }
        Aim { wi, valid: faces, choice, to }
    }

    /// First light surface of the list that each ray hits: distance, index, and the radiance it
    /// sends back.
    #[inline(always)]
    pub fn nearest<L: Lanes>(&self, l: L, origin: V3<L>, dir: V3<L>, list: &List) -> (L::F, L::U, V3<L>) {
        let t_min = l.f(0.0);
        if let Some(tree) = &self.tree {
            let front = self.front_by_tree(l, tree, origin, dir, t_min, false);
            return (front.t, front.index, front.radiance);
        }
        let mut front = Front::none(l);
        let listed = self.list.len() <= list::MOST;
        // Balls, then facets: a choice inside one loop would carry all vectors through memory.
        let (mut balls, mut facets) = list.split(self.balls.len());
        let mut next = 0;
        while let Some(i) = if listed { balls.take_first() } else { Some(next) } {
            let Some(light) = self.balls.get(i) else { break };
            let hit = BallLightLanes::splat(l, &light.ball).hit(l, origin, dir, t_min, false);
            front.add(l, &hit, l.u(i as u32), V3::splat(l, light.radiance));
            next += 1;
        }
        while let Some(i) = if listed { facets.take_first() } else { Some(next) } {
            let Some((facet, radiance)) = self.facets.get(i - self.balls.len()) else { break };
            let hit = self.hit_facet_light(l, facet, origin, dir, t_min);
            front.add(l, &hit, l.u(i as u32), V3::splat(l, *radiance));
            next += 1;
        }
        (front.t, front.index, front.radiance)
    }

    #[inline(always)]
    fn hit_facet_light<L: Lanes>(&self, l: L, facet: &Facet, origin: V3<L>, dir: V3<L>, t_min: L::F) -> LightHit<L> {
        hit_facet(l, facet.intersect(l, origin, dir), V3::splat(l, facet.normal), l.f(facet.area), dir, t_min)
    }

    /// What all lights are for rays that are `here`.
    #[inline(always)]
    fn front_of_all<L: Lanes>(
        &self,
        l: L,
        front: &mut Front<L>,
        (origin, dir): (V3<L>, V3<L>),
        t_min: L::F,
        from_outside: bool,
        here: L::M,
    ) {
        for (i, light) in self.balls.iter().enumerate() {
            let hit = BallLightLanes::splat(l, &light.ball).hit(l, origin, dir, t_min, from_outside);
            front.add(l, &hit.only(here), l.u(i as u32), V3::splat(l, light.radiance));
        }
        for (i, (facet, radiance)) in self.facets.iter().enumerate() {
            let hit = self.hit_facet_light(l, facet, origin, dir, t_min);
            let index = l.u((self.balls.len() + i) as u32);
            front.add(l, &hit.only(here), index, V3::splat(l, *radiance));
        }
    }

    /// The same by way of the tree.
    #[inline(always)]
    fn front_by_tree<L: Lanes>(
        &self,
        l: L,
        tree: &LightTree,
        origin: V3<L>,
        dir: V3<L>,
        t_min: L::F,
        from_outside: bool,
    ) -> Front<L> {
        let t = &self.tables;
        let mut front = Front::none(l);
        let lists = tree.may_hit(l, origin, dir);
        let (longest, too_many) = lists.longest::<L>();
        for k in 0..longest {
            let (numbers, there) = lists.get::<L>(k);
            let (number, there) = (l.load_u(numbers), l.mask(there));
            let is_ball = t.pick::<L, false>(l, &t.is_ball, number).gt(l.f(0.5));
            let (at, radiance) = (t.pick_v::<L, false>(l, &t.p, number), t.pick_v::<L, false>(l, &t.radiance, number));
            if (is_ball & there).any() {
                let light = BallLightLanes {
                    ball: BallLanes { center: at, radius2: t.pick::<L, false>(l, &t.radius2, number) },
                    curvature2: t.pick::<L, false>(l, &t.curvature2, number),
                    inward: t.pick::<L, false>(l, &t.inward, number).gt(l.f(0.5)),
                };
                let hit = light.hit(l, origin, dir, t_min, from_outside);
                front.add(l, &hit.only(is_ball & there), number, radiance);
            }
            if (!is_ball & there).any() {
                let facet = FacetLanes {
                    p0: at,
                    normal: t.pick_v::<L, false>(l, &t.normal, number),
                    u_axis: t.pick_v::<L, false>(l, &t.u_axis, number),
                    v_axis: t.pick_v::<L, false>(l, &t.v_axis, number),
                    triangle: l.f(1.0) - t.pick::<L, false>(l, &t.quad, number),
                };
                let area = t.pick::<L, false>(l, &t.area, number);
                let hit = hit_facet(l, facet.intersect(l, origin, dir), facet.normal, area, dir, t_min);
                front.add(l, &hit.only(!is_ball & there), number, radiance);
            }
        }
        if too_many != 0 {
            self.front_of_all(l, &mut front, (origin, dir), t_min, from_outside, l.mask(too_many));
        }
        front
    }

    /// Density of the light technique at `wi`, and what emits there; how far that is only if
    /// `distances` are asked for.
    #[inline(always)]
    pub fn look<L: Lanes>(&self, l: L, p: V3<L>, wi: V3<L>, t_min: L::F, distances: bool) -> Sight<L> {
        let each = 1.0 / self.list.len().max(1) as f32;
        if !self.tables.any_facet && self.balls.len() <= IN_TABLE {
            // Nearly every direction hits one ball or none, from outside.
            let (sight, doubtful) = self.only_ball(l, p, wi, distances);
            if !doubtful.any() {
                return Sight { pdf: sight.pdf * each, ..sight };
            }
        }
        let front = l.out_of_line::<tree::ManyLights, _>(
            #[inline(always)]
            move || match &self.tree {
                Some(tree) => self.front_by_tree(l, tree, p, wi, t_min, self.from_outside),
                None => {
                    let mut front = Front::none(l);
                    self.front_of_all(l, &mut front, (p, wi), t_min, self.from_outside, l.m(true));
                    front
                }
            },
        );
        let Front { t, radiance, density, .. } = front;
        let shines = (radiance.x + radiance.y + radiance.z).gt(l.f(0.0));
        Sight { pdf: density * each, t, radiance, shines }
    }

    /// Index of the light surface that each ray hits first beyond `t_min`, as [`Self::look`] finds it; of those that hit
    /// none, any.
    #[inline(always)]
    pub fn first_hit<L: Lanes>(&self, l: L, p: V3<L>, wi: V3<L>, t_min: L::F) -> L::U {
        match &self.tree {
            Some(tree) => self.front_by_tree(l, tree, p, wi, t_min, self.from_outside).index,
            None => {
                let mut front = Front::none(l);
                self.front_of_all(l, &mut front, (p, wi), t_min, self.from_outside, l.m(true));
                front.index
            }
        }
    }

    /// The same for directions that were drawn towards lights, where no ray hits two of them (see
    /// [`Self::can_be_disjoint`] and [`crate::world::culling::Culled::lights_disjoint`]): only the light chosen is asked.
    #[inline(always)]
    pub fn look_at<L: Lanes>(&self, l: L, aim: &Aim<L>, distances: bool) -> Sight<L> {
        let each = 1.0 / self.list.len().max(1) as f32;
        let t = &self.tables;
        let (along, half2) = shape::chord(aim.to, t.pick::<L, true>(l, &t.radius2, aim.choice), aim.wi);
        let hit = half2.ge(l.f(0.0)) & along.gt(l.f(0.0));
        let place = hit.select_u(aim.choice + l.u(1), l.u(0));
        let sight = self.ball_in(l, place, hit, (along, half2), None, distances);
        Sight { pdf: sight.pdf * each, ..sight }
    }

    /// True if [`Self::look_at`] can be asked at all: few lights, all of them balls that shine outwards, and no ray that
    /// starts inside.
    pub fn can_be_disjoint(&self) -> bool {
        self.from_outside && !self.tables.any_facet && !self.tables.any_inward && self.balls.len() <= IN_TABLE
    }

    /// The ball that each direction hits, with the density of sampling that ball; and where that is not the whole
    /// truth, since there are more of them, or one around `p`. One density for all lanes, not one for each light.
    #[inline(always)]
    fn only_ball<L: Lanes>(&self, l: L, p: V3<L>, wi: V3<L>, distances: bool) -> (Sight<L>, L::M) {
        let zero = l.f(0.0);
        // Counted rather than remembered as a mask: a mask that a loop carries along wanders in and out of the scalar unit.
        let mut times = l.u(0);
        let mut around = l.m(false);
        let (mut along, mut half2, mut x, mut place) = (zero, zero, zero, l.u(0));
        for light in &self.balls {
            let BallLightLanes { ball, curvature2, .. } = BallLightLanes::splat(l, &light.ball);
            let chord = chord(l, &ball, curvature2, p, wi, self.from_outside);
            times = chord.hit.select_u(times + l.u(1), times);
            if self.from_outside {
                along = chord.hit.select(chord.along, along);
                half2 = chord.hit.select(chord.half2, half2);
            } else {
                around = around | chord.inside;
                x = chord.hit.select(chord.x, x);
                if distances {
                    along = chord.hit.select(chord.along, along);
                    half2 = chord.hit.select(chord.half2, half2);
                }
            }
            place = chord.hit.select_u(l.u(light.outside), place);
        }
        let hit = !times.eq(l.u(0));
        let x = if self.from_outside { None } else { Some(x) };
        (self.ball_in(l, place, hit, (along, half2), x, distances), around | l.u(1).lt(times))
    }

    /// What the ball in a place of [`Outside`] is for rays with these chords that `hit` it or another one; without its
    /// share of 1 / n. `x`: see [`hit::Chord::x`].
    #[inline(always)]
    fn ball_in<L: Lanes>(
        &self,
        l: L,
        place: L::U,
        hit: L::M,
        (along, half2): (L::F, L::F),
        x: Option<L::F>,
        distances: bool,
    ) -> Sight<L> {
        // Most BSDF samples meet no light: often not one of a packet does.
        if !hit.any() {
            return Sight::nothing(l);
        }
        let zero = l.f(0.0);
        let count = self.balls.len() + 1;
        let Outside { curvature2, radiance: [red, green, blue] } = &self.outside;
        let radiance =
            V3 { x: l.lookup(red, count, place), y: l.lookup(green, count, place), z: l.lookup(blue, count, place) };
        let x = match x {
            Some(x) => x,
            None => far_distance2(l, along, half2, l.lookup(curvature2, count, place)),
        };
        let shines = !place.eq(l.u(0));
        let pdf = shines.select(density_from_outside(l, x), zero);
        let t = if distances { (along - half2.max(zero).sqrt()).max(zero) } else { zero };
        Sight { pdf, t: hit.select(t, l.f(f32::INFINITY)), radiance, shines }
    }
}
