//! The oracle: what a correct renderer must find at one surface point, by quadrature in f64.
//!
//! It reads the same scene data as the renderer and nothing else of it: rays, BSDFs, densities,
//! weights and estimators are written here a second time, one number after the other, from the
//! formulas of Veach (1997) and Heitz (2014, 2018) and in their textbook form. The integrand f and
//! both densities are tabulated over the directions of every light; all moments of every strategy
//! follow from that table:
//!
//! ```text
//! light, bsdf    E Y^k = int p_t (f / p_t)^k
//! mis_all        Y = X_L + X_B independent,  E X_t^k = int p_t (w_t f / p_t)^k
//! mis            E Y^k = sum over t of  int c_t p_t (w_t f / (c_t p_t))^k
//! ```

use std::f64::consts::PI;

use glam::DVec3;
use mislab_kernel::request::scene::{self, Reflectance, Scene};
use mislab_renderer::{Geometry, Heuristic, OneSampleWeights, Settings, Strategy};

use crate::quadrature::{self, Domain};

/// Rec. 709 luminance.
pub const LUMINANCE: DVec3 = DVec3::new(0.212_671, 0.715_160, 0.072_169);

/// GGX widths below this are mirrors, by the renderer's documentation.
const MIRROR_ALPHA: f64 = 1e-3;
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

/// Scattering of a surface: Lambert and GGX or mirror lobes.
#[derive(Debug)]
pub struct Lobes {
    kd: DVec3,
    ks: DVec3,
    alpha: f64,
    fresnel: Fresnel,
    /// Probability that a BSDF sample is drawn from the specular lobe.
    specular_prob: f64,
}

#[derive(Debug)]
enum Fresnel {
    One,
    Dielectric { index: f64 },
    Metal { eta: DVec3, k: DVec3 },
}

impl Lobes {
    /// Those of a material; without one, none.
    pub fn new(material: Option<&scene::Bsdf>) -> Self {
        let none = Self { kd: DVec3::ZERO, ks: DVec3::ZERO, alpha: 1.0, fresnel: Fresnel::One, specular_prob: 0.0 };
        match material {
            None => none,
            Some(scene::Bsdf::Matte { kd }) => Self { kd: kd.as_dvec3(), ..none },
            Some(scene::Bsdf::Conductor { reflectance, alpha }) => {
                let (ks, fresnel) = match reflectance {
                    Reflectance::Constant(r) => (r.as_dvec3(), Fresnel::One),
                    Reflectance::Fresnel { eta, k } => {
                        (DVec3::ONE, Fresnel::Metal { eta: eta.as_dvec3(), k: k.as_dvec3() })
                    }
                };
                Self { ks, alpha: f64::from(*alpha), fresnel, specular_prob: 1.0, ..none }
            }
            Some(scene::Bsdf::Plastic { kd, ks, alpha, swapped_indices }) => {
                let (kd, ks) = (kd.as_dvec3(), ks.as_dvec3());
                let specular_prob = match (kd == DVec3::ZERO, ks == DVec3::ZERO) {
                    (false, false) => 0.5,
                    (true, false) => 1.0,
                    _ => 0.0,
                };
                let index = if *swapped_indices { 1.0 / 1.5 } else { 1.5 };
                Self { kd, ks, alpha: f64::from(*alpha), fresnel: Fresnel::Dielectric { index }, specular_prob }
            }
        }
    }

    /// True where the specular lobe is a delta.
    pub fn is_mirror(&self) -> bool {
        self.specular_prob > 0.0 && self.alpha < MIRROR_ALPHA
    }

    /// What the delta of a mirror carries, per channel, at this cosine of incidence.
    pub fn mirror(&self, cos: f64) -> DVec3 {
        self.ks * self.fresnel(cos)
    }

    /// Probability that a BSDF sample is drawn from the specular lobe: 1, 0 or, with both, 1/2.
    pub fn specular_prob(&self) -> f64 {
        self.specular_prob
    }

    fn fresnel(&self, cos: f64) -> DVec3 {
        match self.fresnel {
            Fresnel::One => DVec3::ONE,
            Fresnel::Dielectric { index } => DVec3::splat(fresnel_complex(cos, index, 0.0)),
            Fresnel::Metal { eta, k } => DVec3::new(
                fresnel_complex(cos, eta.x, k.x),
                fresnel_complex(cos, eta.y, k.y),
                fresnel_complex(cos, eta.z, k.z),
            ),
        }
    }

    /// BSDF times cosine, and the density of the BSDF technique, per solid angle; without a mirror's delta.
    pub fn evaluate(&self, n: DVec3, wo: DVec3, wi: DVec3) -> (DVec3, f64) {
        let (cos_o, cos_i) = (n.dot(wo), n.dot(wi));
        if cos_o <= 0.0 || cos_i <= 0.0 {
            return (DVec3::ZERO, 0.0);
        }
        let mut bsdf = self.kd / PI;
        let mut pdf = (1.0 - self.specular_prob) * cos_i / PI;
        if self.specular_prob > 0.0 && !self.is_mirror() {
            let a2 = self.alpha * self.alpha;
            let h = (wo + wi).normalize();
            let cos_h = n.dot(h);
            let tan2 = |cos: f64| 1.0 / (cos * cos) - 1.0;
            // Trowbridge-Reitz, and Smith's Lambda (Heitz 2014, eqs. 71, 72).
            let d =
                1.0 / (PI * a2 * cos_h.powi(4) * (1.0 + n.cross(h).length_squared() / (cos_h * cos_h * a2)).powi(2));
            let lambda = |cos: f64| ((1.0 + a2 * tan2(cos)).sqrt() - 1.0) / 2.0;
            let g1 = 1.0 / (1.0 + lambda(cos_o));
            let g2 = 1.0 / (1.0 + lambda(cos_o) + lambda(cos_i));
            bsdf += self.ks * self.fresnel(wo.dot(h)) * (d * g2 / (4.0 * cos_o * cos_i));
            // Visible normals: D_v(h) = G1 max(0, wo.h) D / cos_o, and dh = dw / (4 wo.h).
            let visible_normals = g1 * wo.dot(h) * d / cos_o;
            pdf += self.specular_prob * visible_normals / (4.0 * wo.dot(h));
        }
        (bsdf * cos_i, pdf)
    }
}

/// Unpolarised Fresnel reflectance for an index `eta + i k`, in complex numbers throughout.
fn fresnel_complex(cos: f64, eta: f64, k: f64) -> f64 {
    type C = (f64, f64);
    let mul = |a: C, b: C| (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0);
    let div = |a: C, b: C| {
        let d = b.0 * b.0 + b.1 * b.1;
        ((a.0 * b.0 + a.1 * b.1) / d, (a.1 * b.0 - a.0 * b.1) / d)
    };
    let sqrt = |a: C| {
        let m = a.0.hypot(a.1);
        let re = ((m + a.0) / 2.0).max(0.0).sqrt();
        let im = ((m - a.0) / 2.0).max(0.0).sqrt();
        (re, if a.1 < 0.0 { -im } else { im })
    };
    let n = (eta, k);
    let sin2 = 1.0 - cos * cos;
    let s2 = div((sin2, 0.0), mul(n, n));
    // Cosine inside, by Snell's law.
    let cos_t = sqrt((1.0 - s2.0, -s2.1));
    let ratio = |a: C, b: C| {
        let q = div((a.0 - b.0, a.1 - b.1), (a.0 + b.0, a.1 + b.1));
        q.0 * q.0 + q.1 * q.1
    };
    let perpendicular = ratio((cos, 0.0), mul(n, cos_t));
    let parallel = ratio(mul(n, (cos, 0.0)), cos_t);
    (perpendicular + parallel) / 2.0
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
        let cells = if lobes.specular_prob > 0.0 && lobes.alpha < 0.015 { 64 } else { 8 };
        let nodes = quadrature::nodes(&charts, cells, TOLERANCE);
        let atom = lobes.is_mirror().then(|| {
            let mirrored = n * (2.0 * n.dot(wo)) - wo;
            let f = lobes.ks * lobes.fresnel(n.dot(wo)) * world.radiance(p, mirrored, None);
            Atom { f, pmf: lobes.specular_prob }
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
        let mut total = Moments([0.0; ORDER + 1]);
        for k in 0..=ORDER {
            total.0[k] = match settings.estimator.strategy {
                // Two independent samples, added.
                Strategy::MisAll => (0..=k).map(|j| binomial(k, j) * light.moments.0[j] * bsdf.moments.0[k - j]).sum(),
                // One sample of either kind.
                _ if k == 0 => 1.0,
                _ => light.moments.0[k] + bsdf.moments.0[k],
            };
        }
        Sample { total, light, bsdf }
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

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).map(|i| (n - i) as f64 / (i + 1) as f64).product()
}

/// Highest moment that is kept.
const ORDER: usize = 6;

/// Raw moments E Y^k, k = 0 to 6.
#[derive(Clone, Copy, Debug)]
pub struct Moments([f64; ORDER + 1]);

impl Moments {
    /// E Y.
    pub fn mean(&self) -> f64 {
        self.0[1]
    }

    /// E (Y - E Y)^k.
    fn central(&self, k: usize) -> f64 {
        (0..=k).map(|j| binomial(k, j) * self.0[j] * (-self.mean()).powi((k - j) as i32)).sum()
    }

    /// Variance of one sample.
    pub fn variance(&self) -> f64 {
        self.central(2).max(0.0)
    }

    /// Skewness of the mean of `n` samples: how far it is from a normal distribution.
    pub fn skewness_of_mean(&self, n: f64) -> f64 {
        self.central(3) / self.central(2).powf(1.5) / n.sqrt()
    }

    /// Standard error of the variance as estimated from `n` samples.
    pub fn standard_error_of_variance(&self, n: f64) -> f64 {
        let (m2, m4) = (self.central(2), self.central(4));
        ((m4 - m2 * m2 * (n - 3.0) / (n - 1.0)) / n).max(0.0).sqrt()
    }

    /// Skewness of the variance as estimated from many (`n`) samples: that of the mean of (Y - E Y)^2.
    pub fn skewness_of_variance(&self, n: f64) -> f64 {
        let (m2, m4, m6) = (self.central(2), self.central(4), self.central(6));
        let third = m6 - 3.0 * m4 * m2 + 2.0 * m2.powi(3);
        third / (m4 - m2 * m2).powf(1.5) / n.sqrt()
    }
}

/// One technique's part of a sample.
#[derive(Clone, Copy, Debug)]
pub struct Contribution {
    /// Moments of its contribution.
    pub moments: Moments,
    /// Probability that it is drawn and meets a light.
    pub carries: f64,
    weight: f64,
    weight2: f64,
}

impl Default for Contribution {
    fn default() -> Self {
        let mut moments = Moments([0.0; ORDER + 1]);
        moments.0[0] = 1.0;
        Self { moments, carries: 0.0, weight: 0.0, weight2: 0.0 }
    }
}

impl Contribution {
    /// Adds draws of probability `prob` and density `p`, made with probability c.
    fn add(&mut self, c: f64, prob: f64, p: f64, weight: f64, y: f64) {
        if c == 0.0 || prob == 0.0 {
            return;
        }
        let value = weight * y / (c * p);
        let mut power = c * prob;
        self.carries += power;
        self.weight += power * weight;
        self.weight2 += power * weight * weight;
        for moment in &mut self.moments.0[1..] {
            power *= value;
            *moment += power;
        }
    }

    /// Mean weight of the samples that carry light, and the standard deviation of one such weight.
    pub fn weight(&self) -> (f64, f64) {
        let mean = self.weight / self.carries;
        (mean, (self.weight2 / self.carries - mean * mean).max(0.0).sqrt())
    }
}

/// How one sample is distributed.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// The sample itself.
    pub total: Moments,
    /// Its part by the light technique.
    pub light: Contribution,
    /// Its part by the BSDF technique.
    pub bsdf: Contribution,
}
