//! The oracle: what a correct renderer must find at one surface point, by quadrature in f64.
//!
//! It reads the same scene data as the renderer and nothing else of it: rays, BSDFs, densities,
//! weights and estimators are written here a second time, one number after the other, from the
//! formulas of Veach (1997) and Heitz (2014, 2018) and in their textbook form. The integrand f and
//! both densities are tabulated over the directions of every light; all moments of every strategy
//! follow from that table (`moments.rs`).

use std::f64::consts::PI;

use glam::DVec3;
use mislab_kernel::request::scene::{self, Scene};
use mislab_renderer::{Geometry, Heuristic, OneSampleWeights, Settings, Strategy};

use crate::lobes::Lobes;
use crate::moments::{Contribution, Sample};
use crate::quadrature::{self, Domain};

/// Rec. 709 luminance.
pub const LUMINANCE: DVec3 = DVec3::new(0.212_671, 0.715_160, 0.072_169);

/// Rays do not meet the surface they start from.
const T_MIN: f64 = 1e-7;
/// Refinement limit of the quadrature, relative to each total.
const TOLERANCE: f64 = 1e-6;

/// A scene in f64.
#[derive(Debug)]
pub struct World {
    bodies: Vec<Body>,
    lights: Vec<Emitter>,
    materials: Vec<scene::Bsdf>,
}

#[derive(Debug)]
struct Body {
    surface: Surface,
    material: Option<usize>,
    /// Index into the lights.
    light: Option<usize>,
}

#[derive(Clone, Copy, Debug)]
enum Surface {
    Sphere { center: DVec3, radius: f64, inward: bool },
    Triangle { a: DVec3, b: DVec3, c: DVec3, flip: bool },
}

/// What one choice of the light technique draws from: a sphere, a triangle or a parallelogram of two.
#[derive(Debug)]
struct Emitter {
    bodies: Vec<usize>,
    radiance: DVec3,
}

struct Hit {
    t: f64,
    body: usize,
    /// On the side that emits.
    front: bool,
    normal: DVec3,
}

impl World {
    /// Reads a scene. Lights are spheres, single triangles or parallelograms of two triangles.
    pub fn new(scene: &Scene) -> Self {
        let mut world = Self {
            bodies: Vec::new(),
            lights: Vec::new(),
            materials: scene.materials.iter().map(|m| m.bsdf.clone()).collect(),
        };
        for shape in &scene.shapes {
            let first = world.bodies.len();
            let mut add = |surface| world.bodies.push(Body { surface, material: shape.material, light: None });
            match &shape.geometry {
                Geometry::Sphere { center, radius } => add(Surface::Sphere {
                    center: center.as_dvec3(),
                    radius: f64::from(*radius),
                    inward: shape.reverse_orientation,
                }),
                Geometry::Mesh { positions, triangles } => {
                    for t in triangles.iter() {
                        let [a, b, c] = t.map(|i| positions[i as usize].as_dvec3());
                        add(Surface::Triangle { a, b, c, flip: shape.reverse_orientation });
                    }
                }
            }
            if let Some(light) = shape.light.as_ref().filter(|l| l.on && l.radiance != glam::Vec3::ZERO) {
                let bodies: Vec<usize> = (first..world.bodies.len()).collect();
                let equal_areas =
                    bodies.windows(2).all(|w| (world.bodies[w[0]].area() - world.bodies[w[1]].area()).abs() < 1e-9);
                assert!(bodies.len() <= 2 && equal_areas, "the oracle knows mesh lights of one parallelogram only");
                for &body in &bodies {
                    world.bodies[body].light = Some(world.lights.len());
                }
                world.lights.push(Emitter { bodies, radiance: light.radiance.as_dvec3() });
            }
        }
        world
    }

    fn nearest(&self, origin: DVec3, dir: DVec3) -> Option<Hit> {
        let hits = self.bodies.iter().enumerate().filter_map(|(body, b)| b.hit(body, origin, dir));
        hits.min_by(|a, b| a.t.total_cmp(&b.t))
    }

    /// The point that the ray from `eye` through `target` meets first.
    ///
    /// # Panics
    /// If it meets nothing, or a light.
    pub fn point(&self, eye: DVec3, target: DVec3) -> Point {
        let dir = (target - eye).normalize();
        let hit = self.nearest(eye, dir).expect("the ray meets something");
        let body = &self.bodies[hit.body];
        assert!(body.light.is_none(), "the ray meets a surface that does not emit");
        let normal = if hit.normal.dot(dir) > 0.0 { -hit.normal } else { hit.normal };
        let p = eye + dir * hit.t;
        let material = body.material.map(|m| self.materials[m].clone());
        Point::new(self, p, normal, -dir, Lobes::new(material.as_ref()))
    }
}

impl Body {
    fn area(&self) -> f64 {
        match self.surface {
            Surface::Sphere { radius, .. } => 4.0 * PI * radius * radius,
            Surface::Triangle { a, b, c, .. } => (b - a).cross(c - a).length() / 2.0,
        }
    }

    fn hit(&self, body: usize, origin: DVec3, dir: DVec3) -> Option<Hit> {
        match self.surface {
            Surface::Sphere { center, radius, inward } => {
                let oc = origin - center;
                let b = oc.dot(dir);
                let disc = b * b - (oc.length_squared() - radius * radius);
                if disc < 0.0 {
                    return None;
                }
                let t = [-b - disc.sqrt(), -b + disc.sqrt()].into_iter().find(|&t| t > T_MIN)?;
                let outward = (oc + dir * t) / radius;
                let normal = if inward { -outward } else { outward };
                Some(Hit { t, body, front: normal.dot(dir) < 0.0, normal })
            }
            Surface::Triangle { a, b, c, flip } => {
                // Moeller and Trumbore.
                let (e1, e2) = (b - a, c - a);
                let p = dir.cross(e2);
                let det = e1.dot(p);
                let s = origin - a;
                let u = s.dot(p) / det;
                let q = s.cross(e1);
                let v = dir.dot(q) / det;
                let t = e2.dot(q) / det;
                let normal = e1.cross(e2).normalize() * if flip { -1.0 } else { 1.0 };
                // The tolerance closes the seam between two triangles.
                let inside = u >= -1e-12 && v >= -1e-12 && u + v <= 1.0 + 1e-12;
                (inside && t > T_MIN).then(|| Hit { t, body, front: normal.dot(dir) < 0.0, normal })
            }
        }
    }

    /// Density over solid angle of sampling this body from `p`, at `dir`.
    fn pdf(&self, p: DVec3, dir: DVec3) -> f64 {
        match self.surface {
            Surface::Sphere { center, radius, inward } => {
                let to = center - p;
                let inside = to.length() < radius;
                if inside != inward {
                    return 0.0;
                }
                let solid_angle = solid_angle_of_sphere(to.length(), radius);
                let along = to.dot(dir);
                let in_cone = along > 0.0 && (to - dir * along).length() <= radius;
                if inside || in_cone { 1.0 / solid_angle } else { 0.0 }
            }
            Surface::Triangle { .. } => match self.hit(0, p, dir) {
                Some(hit) if hit.front => hit.t * hit.t / (hit.normal.dot(dir).abs() * self.area()),
                _ => 0.0,
            },
        }
    }
}

fn solid_angle_of_sphere(distance: f64, radius: f64) -> f64 {
    if distance < radius {
        return 4.0 * PI;
    }
    let sin = radius / distance;
    2.0 * PI * (1.0 - (1.0 - sin * sin).sqrt())
}

/// One direction of the table.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// Solid angle it stands for.
    dw: f64,
    f: DVec3,
    p_light: f64,
    p_bsdf: f64,
}

/// A mirror's one direction: the integral of f over its delta, and the probability to draw it.
#[derive(Clone, Copy, Debug)]
struct Atom {
    f: DVec3,
    pmf: f64,
}

/// A surface point seen from one direction, with the table of its integrand.
#[derive(Debug)]
pub struct Point {
    /// Where.
    pub position: DVec3,
    /// Unit normal towards the viewer.
    pub normal: DVec3,
    /// Cosine of the viewing direction.
    pub cos_view: f64,
    nodes: Vec<Node>,
    atom: Option<Atom>,
}

/// The directions in which one body of a light lies.
struct Chart<'a> {
    world: &'a World,
    lobes: &'a Lobes,
    p: DVec3,
    n: DVec3,
    wo: DVec3,
    body: usize,
}

impl Chart<'_> {
    /// Direction of a point of the unit square, and solid angle per area of the square.
    fn direction(&self, [u, v]: [f64; 2]) -> (DVec3, f64) {
        match self.world.bodies[self.body].surface {
            Surface::Sphere { center, radius, .. } => {
                let to = center - self.p;
                let solid_angle = solid_angle_of_sphere(to.length(), radius);
                let axis = if to.length() > 0.0 { to.normalize() } else { DVec3::Z };
                let (s, t) = axis.any_orthonormal_pair();
                // 1 - cos grows with the square of the angle: uniform in u over the cone.
                let one_minus_cos = u * solid_angle / (2.0 * PI);
                let sin = (one_minus_cos * (2.0 - one_minus_cos)).sqrt();
                let (sin_phi, cos_phi) = (2.0 * PI * v).sin_cos();
                (axis * (1.0 - one_minus_cos) + (s * cos_phi + t * sin_phi) * sin, solid_angle)
            }
            Surface::Triangle { a, b, c, .. } => {
                // Duffy's map; dA = 2 A (1 - u) du dv.
                let to = a + (b - a) * u + (c - a) * (v * (1.0 - u)) - self.p;
                let normal = (b - a).cross(c - a);
                let dir = to.normalize();
                (dir, (1.0 - u) * normal.dot(dir).abs() / to.length_squared())
            }
        }
    }
}

/// Number of [`Domain::features`] of a chart.
const FEATURES: usize = 15;

impl Domain<FEATURES> for Chart<'_> {
    type Node = Node;

    fn node(&self, at: [f64; 2], weight: f64) -> Option<Node> {
        let (wi, per_area) = self.direction(at);
        let dw = weight * per_area;
        if self.n.dot(wi) <= 0.0 {
            return None;
        }
        let radiance = self.world.radiance(self.p, wi, Some(self.body));
        if radiance == DVec3::ZERO {
            return None;
        }
        let (bsdf_cos, p_bsdf) = self.lobes.evaluate(self.n, self.wo, wi);
        let f = bsdf_cos * radiance;
        (f != DVec3::ZERO && dw > 0.0).then(|| Node { dw, f, p_light: self.world.p_light(self.p, wi), p_bsdf })
    }

    fn features(&self, node: &Node) -> [f64; FEATURES] {
        let (l, b) = (node.p_light, node.p_bsdf);
        let y = LUMINANCE.dot(node.f);
        let y2 = y * y / (l + b);
        // Where heuristics jump, for the values of c that are asked for: q_L = 0.1, 1, 10 times q_B.
        let step = |c: f64, ratio: f64| if c * l > ratio * (1.0 - c) * b { y2 } else { 0.0 };
        [
            y,
            y * y / l,
            y * y / b,
            y2,
            y * b / (l + b),
            l,
            step(0.5, 0.1),
            step(0.5, 1.0),
            step(0.5, 10.0),
            step(0.1, 0.1),
            step(0.1, 1.0),
            step(0.1, 10.0),
            step(0.9, 0.1),
            step(0.9, 1.0),
            step(0.9, 10.0),
        ]
        .map(|x| x * node.dw)
    }
}

impl World {
    /// Lobes of the scene's material with this number; without one, none.
    pub fn lobes(&self, material: Option<usize>) -> Lobes {
        Lobes::new(material.map(|m| &self.materials[m]))
    }

    /// Distance to what a ray meets first, and the radiance that comes back; infinity and 0 if it meets nothing.
    pub fn look(&self, origin: DVec3, dir: DVec3) -> (f64, DVec3) {
        let t = self.nearest(origin, dir).map_or(f64::INFINITY, |hit| hit.t);
        (t, self.radiance(origin, dir, None))
    }

    /// Radiance that arrives at `p` from direction `wi`; if `from` is given, from that body only.
    fn radiance(&self, p: DVec3, wi: DVec3, from: Option<usize>) -> DVec3 {
        match self.nearest(p, wi) {
            Some(hit) if hit.front && from.is_none_or(|body| body == hit.body) => {
                self.bodies[hit.body].light.map_or(DVec3::ZERO, |light| self.lights[light].radiance)
            }
            _ => DVec3::ZERO,
        }
    }

    /// Density of the light technique, per solid angle: the mean over all lights of each one's own.
    pub fn p_light(&self, p: DVec3, wi: DVec3) -> f64 {
        let of = |light: &Emitter| {
            // The triangles of a parallelogram share its draws equally.
            light.bodies.iter().map(|&b| self.bodies[b].pdf(p, wi)).sum::<f64>() / light.bodies.len() as f64
        };
        self.lights.iter().map(of).sum::<f64>() / self.lights.len() as f64
    }
}

impl Point {
    fn new(world: &World, p: DVec3, n: DVec3, wo: DVec3, lobes: Lobes) -> Self {
        let charts: Vec<Chart<'_>> = (0..world.bodies.len())
            .filter(|&b| world.bodies[b].light.is_some())
            .map(|body| Chart { world, lobes: &lobes, p, n, wo, body })
            .collect();
        // Narrow lobes must not slip between the nodes of the first, coarse grid.
        let cells = if lobes.is_narrow() { 64 } else { 8 };
        let nodes = quadrature::nodes(&charts, cells, TOLERANCE);
        let atom = lobes.is_mirror().then(|| {
            let mirrored = n * (2.0 * n.dot(wo)) - wo;
            let f = lobes.mirror(n.dot(wo)) * world.radiance(p, mirrored, None);
            Atom { f, pmf: lobes.specular_prob() }
        });
        Self { position: p, normal: n, cos_view: n.dot(wo), nodes, atom }
    }

    /// Size of the table.
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// The integral of f itself, per channel.
    pub fn radiance(&self) -> DVec3 {
        self.nodes.iter().map(|node| node.f * node.dw).sum::<DVec3>() + self.atom.map_or(DVec3::ZERO, |a| a.f)
    }

    /// What a sample by `settings` must be distributed like. `functional` turns colours into the
    /// number that is looked at: [`LUMINANCE`], or one channel's unit vector.
    pub fn sample(&self, settings: &Settings, functional: DVec3) -> Sample {
        let c = f64::from(settings.estimator.light_prob);
        let (c_light, c_bsdf, n_light, n_bsdf) = match settings.estimator.strategy {
            Strategy::Light => (1.0, 0.0, 1.0, 0.0),
            Strategy::Bsdf => (0.0, 1.0, 0.0, 1.0),
            Strategy::MisAll => (1.0, 1.0, 1.0, 1.0),
            Strategy::Mis => match settings.estimator.weights {
                OneSampleWeights::Veach => (c, 1.0 - c, c, 1.0 - c),
                OneSampleWeights::Tutorial => (c, 1.0 - c, 1.0, 1.0),
            },
        };
        let weights =
            |node: &Node| heuristic(settings.estimator.heuristic, n_light * node.p_light, n_bsdf * node.p_bsdf);
        let mut light = Contribution::default();
        let mut bsdf = Contribution::default();
        for node in &self.nodes {
            let (w_light, w_bsdf) = weights(node);
            let y = functional.dot(node.f);
            light.add(c_light, node.p_light * node.dw, node.p_light, w_light, y);
            bsdf.add(c_bsdf, node.p_bsdf * node.dw, node.p_bsdf, w_bsdf, y);
        }
        if let Some(atom) = self.atom.filter(|atom| atom.f != DVec3::ZERO) {
            // No light sample meets the one direction of a mirror: weight 1.
            bsdf.add(c_bsdf, atom.pmf, atom.pmf, 1.0, functional.dot(atom.f));
        }
        Sample::new(settings.estimator.strategy, light, bsdf)
    }
}

/// Weights of the light and of the BSDF technique, from what the heuristic sees of each.
pub fn heuristic(kind: Heuristic, a: f64, b: f64) -> (f64, f64) {
    match kind {
        Heuristic::Balance => (a / (a + b), b / (a + b)),
        Heuristic::Power => (a * a / (a * a + b * b), b * b / (a * a + b * b)),
        Heuristic::Cutoff => {
            let keep = |x: f64| if x < 0.1 * a.max(b) { 0.0 } else { x };
            let (a, b) = (keep(a), keep(b));
            (a / (a + b), b / (a + b))
        }
        Heuristic::Maximum if a >= b => (1.0, 0.0),
        Heuristic::Maximum => (0.0, 1.0),
    }
}
