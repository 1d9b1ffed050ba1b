//! A small patch of the image, and which primitives can matter to it.
//!
//! Most patches of 8 x 8 pixels see a single surface, and nothing can come between that surface
//! and the lights. To ask every primitive anew for every ray would be half of the work of a path.
//! So each primitive is asked once per patch:
//!
//! - *outside*: does it lie wholly beyond one of the four planes through the eye and the sides of
//!   the patch? Then no camera ray hits it.
//! - *covers*: do the rays through the patch's corners all meet the inside of this facet? Then
//!   every ray does, since a facet is convex.
//! - *hidden*: is it farther than a covering facet along the four corner rays? The inverse of
//!   the distance to a plane is linear over the image, so then it is farther along every ray.
//! - *harmless*: for each surface that remains, does the primitive lie below that surface's plane,
//!   where no reflected ray goes; or are all surface points *and* all lights on one side of its own
//!   plane, and so every segment between them?
//!
//! A "yes" takes a primitive off a list, so every "yes" has to be certain: each test carries an
//! allowance for the rounding of its own numbers and of the rays', and what is not a number
//! answers "no". Answers are kept with the built scene
//! (`BuiltScene::culled`); they depend on shapes and camera alone.

use glam::{DVec3, Vec3, Vec4};

use crate::geometry::BuiltGeometry;
use crate::geometry::list::{List, MOST};
use crate::geometry::shape::{Ball, Facet};
use crate::light::{IN_TABLE, LightShape, Lights};
use crate::world::camera::Pinhole;

/// Allowance for rounding: 32 units in the last place of the largest number involved.
const SLACK: f32 = 16.0 * f32::EPSILON;

/// What the rays of a patch may hit. The lists mean nothing for geometry that has a tree, and for
/// more than [`MOST`] lights.
#[derive(Clone, Copy, Debug)]
pub struct Culled {
    /// Primitives of the geometry that camera rays may hit.
    pub surfaces: List,
    /// Every camera ray hits the facet that is the only one of `surfaces`.
    pub covered: bool,
    /// Lights that camera rays may hit, by index.
    pub lights: List,
    /// Primitives of the geometry that may come between a surface of the patch and a light.
    pub occluders: List,
    /// There is a tree of primitives, any of which may do so.
    pub tree: bool,
    /// All lights are balls, and no ray from the surface of the patch hits two of them.
    pub lights_disjoint: bool,
}

impl Culled {
    /// False where nothing can come between a surface of the patch and a light.
    #[inline(always)]
    pub fn may_be_blocked(&self) -> bool {
        self.tree || !self.occluders.is_empty()
    }
}

/// The primitives of a scene in the form that the questions are asked in.
#[derive(Debug)]
pub struct Patches {
    facets: Vec<Plate>,
    balls: Vec<Globe>,
    facet_lights: Vec<(usize, Plate)>,
    ball_lights: Vec<(usize, Globe)>,
    /// How many primitives and lights there are.
    counts: [usize; 2],
    tree: bool,
    /// False where there are too many for lists.
    listed: bool,
    /// A light may stand in the picture as a surface that scatters.
    lights_scatter: bool,
    /// See [`Lights::can_be_disjoint`].
    can_be_disjoint: bool,
    /// Primitives of the geometry, as bits, of which another one may be seen in their place.
    contested: u32,
    epsilon: f32,
}

/// Four points, or a triangle's three and the first again: one coordinate per vector.
#[derive(Clone, Copy, Debug)]
struct Points([Vec4; 3]);

impl Points {
    fn new(points: [Vec3; 4]) -> Self {
        Self([0, 1, 2].map(|axis| Vec4::from_array(points.map(|p| p[axis]))))
    }

    /// `v . p` for each point.
    fn dot(&self, v: Vec3) -> Vec4 {
        self.0[0] * v.x + self.0[1] * v.y + self.0[2] * v.z
    }

    /// The points as seen from `origin`.
    fn from(&self, origin: Vec3) -> Self {
        Self([self.0[0] - origin.x, self.0[1] - origin.y, self.0[2] - origin.z])
    }
}

/// A facet.
#[derive(Clone, Copy, Debug)]
struct Plate {
    facet: Facet,
    corners: Points,
    /// The corners as seen from the eye.
    from_eye: Points,
    /// The largest number in calculations with it: of coordinates and distances from the eye.
    reach: f32,
    /// 1 or -1 where all lights lie on that side of its plane, 0 elsewhere.
    lights_side: f32,
}

/// A sphere.
#[derive(Clone, Copy, Debug)]
struct Globe {
    ball: Ball,
    reach: f32,
}

/// The camera rays of a patch.
struct Beam {
    eye: Vec3,
    /// Directions to the patch's corners, about as long as the middle one's unit.
    rays: Points,
    /// Length of the longest.
    length: f32,
    /// Unit normals of the planes through the eye and the patch's sides, inwards.
    sides: [Vec3; 4],
}

/// What a beam finds of a facet.
#[derive(Clone, Copy)]
struct Look {
    /// Inverse distances along the four rays, in units of their lengths; negative behind the eye.
    inverse: Vec4,
    /// Largest error of `inverse`.
    error: f32,
    /// Every ray hits the facet.
    covers: bool,
}

impl Beam {
    fn new(camera: &Pinhole, min: [u32; 2], max: [u32; 2]) -> Self {
        let corners = [[min[0], min[1]], [max[0], min[1]], [max[0], max[1]], [min[0], max[1]]];
        let rays = corners.map(|[x, y]| camera.ray(f64::from(x), f64::from(y)));
        let middle = rays[0] + rays[1] + rays[2] + rays[3];
        // In double precision: a patch of a narrow view is not much wider than rounding errors.
        let sides = [0, 1, 2, 3].map(|k| {
            let normal = rays[k].cross(rays[(k + 1) % 4]).normalize();
            (normal * normal.dot(middle).signum()).as_vec3()
        });
        let length = rays.iter().map(|ray| ray.length()).fold(0.0, f64::max) as f32;
        Self { eye: camera.origin, rays: Points::new(rays.map(DVec3::as_vec3)), length, sides }
    }

    /// True if no ray hits the facet.
    fn misses_plate(&self, plate: &Plate) -> bool {
        let slack = SLACK * plate.reach;
        self.sides.iter().any(|&side| plate.from_eye.dot(side).cmplt(Vec4::splat(-slack)).all())
    }

    /// True if no ray hits the sphere.
    fn misses_globe(&self, globe: &Globe) -> bool {
        let limit = -(globe.ball.radius + SLACK * globe.reach);
        self.sides.iter().any(|side| side.dot(globe.ball.center - self.eye) < limit)
    }

    fn look(&self, plate: &Plate) -> Look {
        let facet = &plate.facet;
        let to_plane = facet.normal.dot(facet.p0 - self.eye);
        let cos = self.rays.dot(facet.normal);
        let inverse = cos / to_plane;
        let error = SLACK * (self.length + inverse.abs().max_element() * plate.reach) / to_plane.abs();

        // Coordinates in the facet of the points that the rays hit, and their largest error.
        let distance = inverse.recip();
        let from_p0 = self.eye - facet.p0;
        let [u_axis, v_axis] = facet.axes();
        let u = self.rays.dot(u_axis) * distance + u_axis.dot(from_p0);
        let v = self.rays.dot(v_axis) * distance + v_axis.dot(from_p0);
        let relative = 1.0 + error / inverse.abs().min_element() / SLACK;
        let slack = Vec4::splat(SLACK * (u_axis.length() + v_axis.length()) * plate.reach * relative);
        let upper = if facet.quad { u.max(v) } else { u + v };
        let inside = u.min(v).cmpgt(slack) & upper.cmplt(1.0 - slack) & inverse.cmpgt(Vec4::ZERO);
        Look { inverse, error, covers: inside.all() }
    }
}

impl Plate {
    fn new(facet: &Facet, lights: &Lights, eye: Vec3) -> Self {
        let mut corners = [facet.p0; 4];
        for (to, corner) in corners.iter_mut().zip(facet.corners()) {
            *to = corner;
        }
        let sizes = corners.map(|c| c.abs().max_element().max((c - eye).length()));
        let reach = sizes.into_iter().fold(eye.abs().max_element(), f32::max);
        let corners = Points::new(corners);
        let lights_side = lights_side(facet, lights, reach);
        Self { facet: *facet, corners, from_eye: corners.from(eye), reach, lights_side }
    }

    /// True if no segment from these points, which lie in a plane of another facet, to a light
    /// crosses this one.
    fn harmless(&self, surface: &Footprint, epsilon: f32) -> bool {
        // Reflected rays start `epsilon` above the surface and go up.
        if self.corners.from(surface.origin).dot(surface.up).cmple(Vec4::splat(0.5 * epsilon)).all() {
            return true;
        }
        let height = surface.points.from(self.facet.p0).dot(self.facet.normal) * self.lights_side;
        height.cmpgt(Vec4::splat(surface.slack + SLACK * self.reach + epsilon)).all()
    }
}

impl Globe {
    fn new(ball: &Ball, eye: Vec3) -> Self {
        let size = ball.center.abs().max_element().max((ball.center - eye).length()) + ball.radius;
        Self { ball: *ball, reach: size.max(eye.abs().max_element()) }
    }
}

/// What a patch sees of a facet.
struct Footprint {
    /// A point of its plane, and the unit normal on the eye's side.
    origin: Vec3,
    up: Vec3,
    /// Corners of a part of the plane that holds all that is seen of it.
    points: Points,
    /// Largest error of `points`.
    slack: f32,
}

impl Footprint {
    fn new(beam: &Beam, plate: &Plate, look: &Look) -> Self {
        let facet = &plate.facet;
        let up = if facet.normal.dot(beam.eye - facet.p0) < 0.0 { -facet.normal } else { facet.normal };
        if !look.covers {
            return Self { origin: facet.p0, up, points: plate.corners, slack: 0.0 };
        }
        let distance = look.inverse.recip();
        let [x, y, z] = beam.rays.0;
        let points = Points([x * distance + beam.eye.x, y * distance + beam.eye.y, z * distance + beam.eye.z]);
        let relative = SLACK + look.error / look.inverse.min_element();
        Self { origin: facet.p0, up, points, slack: relative * plate.reach }
    }
}

/// The side of the facet's plane on which all lights lie: 1, -1, or 0 if there is none.
fn lights_side(facet: &Facet, lights: &Lights, reach: f32) -> f32 {
    let (n, p0) = (facet.normal.as_dvec3(), facet.p0.as_dvec3());
    let height = |p: Vec3| n.dot(p.as_dvec3() - p0);
    let (mut lowest, mut highest, mut reach) = (f64::INFINITY, f64::NEG_INFINITY, f64::from(reach));
    for light in &lights.list {
        match &light.shape {
            LightShape::Ball(ball) => {
                let (h, r) = (height(ball.center), f64::from(ball.radius));
                (lowest, highest) = (lowest.min(h - r), highest.max(h + r));
                reach = reach.max(ball.center.as_dvec3().abs().max_element() + r);
            }
            LightShape::Facet(light) => {
                for corner in light.corners() {
                    (lowest, highest) = (lowest.min(height(corner)), highest.max(height(corner)));
                    reach = reach.max(corner.as_dvec3().abs().max_element());
                }
            }
        }
    }
    let slack = f64::from(SLACK) * reach;
    if lowest > slack {
        1.0
    } else if highest < -slack {
        -1.0
    } else {
        0.0
    }
}

impl Patches {
    /// Prepares a scene seen from `eye`, whose reflected rays start `epsilon` above their surface.
    pub fn new(geometry: &BuiltGeometry, lights: &Lights, eye: Vec3, epsilon: f32) -> Self {
        let counts = [geometry.facets.len() + geometry.balls.len(), lights.list.len()];
        let listed = !geometry.has_tree() && counts[0] <= MOST && counts[1] <= MOST;
        let mut patches = Self {
            facets: Vec::new(),
            balls: Vec::new(),
            facet_lights: Vec::new(),
            ball_lights: Vec::new(),
            counts,
            tree: geometry.has_tree(),
            listed,
            lights_scatter: lights.list.iter().any(|light| light.material.scatters()),
            can_be_disjoint: lights.can_be_disjoint(),
            contested: 0,
            epsilon,
        };
        if listed {
            patches.facets = geometry.facets.iter().map(|facet| Plate::new(facet, lights, eye)).collect();
            patches.balls = geometry.balls.iter().map(|ball| Globe::new(ball, eye)).collect();
            for (index, light) in lights.list.iter().enumerate() {
                match &light.shape {
                    LightShape::Facet(facet) => patches.facet_lights.push((index, Plate::new(facet, lights, eye))),
                    LightShape::Ball(ball) => patches.ball_lights.push((index, Globe::new(ball, eye))),
                }
            }
        }
        patches
    }

    /// The same where of these primitives others may be seen in their place: none of them covers a patch.
    #[must_use]
    pub fn with_contested(mut self, primitives: impl Iterator<Item = u32>) -> Self {
        self.contested = primitives.filter(|id| (*id as usize) < MOST).fold(0, |bits, id| bits | 1 << id);
        self
    }

    /// Narrows nothing down any more.
    pub fn forget(&mut self) {
        self.listed = false;
    }

    /// Every primitive: what [`Self::cull`] narrows.
    pub fn everything(&self) -> Culled {
        let [primitives, lights] = self.counts.map(List::all);
        Culled {
            surfaces: primitives,
            covered: false,
            lights,
            occluders: primitives,
            tree: self.tree,
            lights_disjoint: false,
        }
    }

    /// The primitives that can matter to camera rays through image points from `min` to `max`, in pixels.
    pub fn cull(&self, camera: &Pinhole, min: [u32; 2], max: [u32; 2]) -> Culled {
        if !self.listed {
            return self.everything();
        }
        let beam = Beam::new(camera, min, max);
        let mut looks = [Look { inverse: Vec4::ZERO, error: 0.0, covers: false }; MOST];
        let mut surfaces = 0u32;
        let mut front: Option<Look> = None;
        for (id, plate) in self.facets.iter().enumerate() {
            if !beam.misses_plate(plate) {
                surfaces |= 1 << id;
                looks[id] = beam.look(plate);
                let nearest = front.map_or(f32::NEG_INFINITY, |f| f.inverse.min_element());
                if looks[id].covers && looks[id].inverse.min_element() > nearest {
                    front = Some(looks[id]);
                }
            }
        }
        if let Some(front) = front {
            for (id, look) in looks.iter().enumerate().take(self.facets.len()) {
                let slack = Vec4::splat(front.error + look.error);
                if (front.inverse - look.inverse).cmpgt(slack).all() {
                    surfaces &= !(1 << id);
                }
            }
        }
        let facets = surfaces;
        for (i, globe) in self.balls.iter().enumerate() {
            if !beam.misses_globe(globe) {
                surfaces |= 1 << (self.facets.len() + i);
            }
        }
        let mut lights = 0u32;
        for (index, plate) in &self.facet_lights {
            lights |= u32::from(!beam.misses_plate(plate)) << index;
        }
        for (index, globe) in &self.ball_lights {
            lights |= u32::from(!beam.misses_globe(globe)) << index;
        }
        let covered = lights == 0 && surfaces.count_ones() == 1 && surfaces & self.contested == 0 && front.is_some();
        // Round surfaces are not worth the thought: anything may be in their way.
        let occluders = if surfaces == facets && (lights == 0 || !self.lights_scatter) {
            self.occluders(&beam, facets, &looks)
        } else {
            List::all(self.counts[0])
        };
        let lights_disjoint = covered && {
            let id = List::of_bits(surfaces).first();
            self.lights_disjoint(&self.facets[id], &Footprint::new(&beam, &self.facets[id], &looks[id]))
        };
        Culled {
            surfaces: List::of_bits(surfaces),
            covered,
            lights: List::of_bits(lights),
            occluders,
            tree: self.tree,
            lights_disjoint,
        }
    }

    /// True if all lights are balls and no ray from a point of the surface hits two of them.
    ///
    /// A ray that is moved so that it starts in the middle of the surface still hits every light that it hit, if the
    /// lights' radii grow by as much as it was moved. From there each of the grown lights fills a cone, and two are
    /// apart if the angle between their axes is larger than the angles of both cones together.
    fn lights_disjoint(&self, plate: &Plate, surface: &Footprint) -> bool {
        if !self.can_be_disjoint {
            return false;
        }
        let [x, y, z] = surface.points.0;
        let points = [0, 1, 2, 3].map(|i| Vec3::new(x[i], y[i], z[i]).as_dvec3());
        let middle = (points[0] + points[1] + points[2] + points[3]) * 0.25;
        let spread = points.iter().map(|p| (*p - middle).length()).fold(0.0, f64::max) + f64::from(surface.slack);
        let mut seen = [(DVec3::ZERO, 0.0, 0.0); IN_TABLE];
        for (i, (_, Globe { ball, reach })) in self.ball_lights.iter().enumerate() {
            let to = ball.center.as_dvec3() - middle;
            let distance = to.length();
            let slack = f64::from(SLACK) * (f64::from(plate.reach.max(*reach)) + distance);
            let sin = (f64::from(ball.radius) + spread + slack) / distance;
            let cos = (1.0 - sin * sin).sqrt();
            let near = &seen[..i];
            let apart = |&(other, other_sin, other_cos): &(DVec3, f64, f64)| {
                (to / distance).dot(other) < cos * other_cos - sin * other_sin
            };
            if !(sin < 1.0 && near.iter().all(apart)) {
                return false;
            }
            seen[i] = (to / distance, sin, cos);
        }
        true
    }

    /// What may come between the surfaces of a patch and the lights.
    fn occluders(&self, beam: &Beam, mut surfaces: u32, looks: &[Look; MOST]) -> List {
        let mut occluders = 0u32;
        while surfaces != 0 {
            let id = surfaces.trailing_zeros() as usize;
            surfaces &= surfaces - 1;
            let surface = Footprint::new(beam, &self.facets[id], &looks[id]);
            for (other, plate) in self.facets.iter().enumerate() {
                if other != id && !plate.harmless(&surface, self.epsilon) {
                    occluders |= 1 << other;
                }
            }
            for (i, Globe { ball, .. }) in self.balls.iter().enumerate() {
                let height = surface.up.dot(ball.center - surface.origin);
                let below = height + ball.radius <= 0.5 * self.epsilon;
                if !below {
                    occluders |= 1 << (self.facets.len() + i);
                }
            }
        }
        List::of_bits(occluders)
    }
}
