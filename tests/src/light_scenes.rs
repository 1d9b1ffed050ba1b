//! Lights around a point, for tests of their densities and weights.

use glam::{DVec3, Vec3};
use mislab_kernel::bsdf::BuiltMaterial;
use mislab_kernel::geometry::shape::{Ball, Facet};
use mislab_kernel::light::{BuiltLight, LightShape, Lights};
use mislab_kernel::stop::Stop;

use crate::charts::{Chart, frame};

/// Lights as seen from one point.
#[derive(Debug)]
pub struct View {
    /// What it is.
    pub name: String,
    /// The lights.
    pub lights: Lights,
    /// Where they are seen from.
    pub p: Vec3,
}

/// A white light of this shape.
fn light(shape: LightShape) -> BuiltLight {
    BuiltLight { shape, radiance: Vec3::ONE, material: BuiltMaterial::BLACK }
}

/// A sphere that emits outwards, or inwards.
pub fn ball(center: Vec3, radius: f32, inward: bool) -> BuiltLight {
    light(LightShape::Ball(Ball { center, radius, inward, shape: 0 }))
}

/// A parallelogram or triangle that emits to the side of `e1 x e2`, or with `flip` to the other.
///
/// # Panics
/// If the edges span no area.
pub fn facet(p0: Vec3, e1: Vec3, e2: Vec3, quad: bool, flip: bool) -> BuiltLight {
    let facet = Facet::new(p0, p0 + e1, p0 + e2, quad, flip, 0).expect("edges that span an area");
    light(LightShape::Facet(facet))
}

impl View {
    /// Lights seen from a point.
    pub fn new(name: impl Into<String>, p: Vec3, lights: Vec<BuiltLight>) -> Self {
        Self { name: name.into(), lights: Lights::new(lights, Stop::NEVER).expect("nobody stops it"), p }
    }

    /// From the point to this one, as single precision has it.
    fn to(&self, at: Vec3) -> DVec3 {
        (at - self.p).as_dvec3()
    }

    /// Probability that a light drawn does not turn its back.
    pub fn success(&self) -> f64 {
        let faces = |light: &BuiltLight| match light.shape {
            LightShape::Ball(b) => (self.to(b.center).length() < f64::from(b.radius)) == b.inward,
            LightShape::Facet(f) => f.normal.as_dvec3().dot(self.to(f.p0)) < 0.0,
        };
        self.lights.list.iter().filter(|light| faces(light)).count() as f64 / self.lights.list.len() as f64
    }

    /// How far rounding may put a direction outside a sphere's cone, in radians: 6e-8 in the direction and,
    /// in `off^2 <= radius^2`, 1e-7 of the square. The latter grows as the tangent of the cone's angle.
    pub fn rounding(&self) -> f64 {
        let of = |light: &BuiltLight| match light.shape {
            LightShape::Ball(b) => {
                let sin2 = (f64::from(b.radius) / self.to(b.center).length()).powi(2).min(1.0);
                2e-7 * (sin2 / (1.0 - sin2).max(1e-7)).sqrt()
            }
            LightShape::Facet(_) => 0.0,
        };
        5e-7 + self.lights.list.iter().map(of).fold(0.0, f64::max)
    }

    /// The whole sphere, and a chart of its own for light `i`.
    pub fn charts(&self, i: usize) -> Vec<Chart> {
        let sphere = Chart::Sphere { frame: frame(DVec3::new(0.48, -0.6, 0.64)) };
        let own = match self.lights.list[i].shape {
            LightShape::Ball(b) => {
                let to = self.to(b.center);
                let sin = f64::from(b.radius) / to.length();
                let one_minus_cos = sin * sin / (1.0 + (1.0 - sin * sin).max(0.0).sqrt());
                (sin <= 1.0).then(|| Chart::Cone { frame: frame(to.normalize()), one_minus_cos })
            }
            LightShape::Facet(f) => Some(Chart::Facet { p0: self.to(f.p0), e1: f.e1.as_dvec3(), e2: f.e2.as_dvec3() }),
        };
        std::iter::once(sphere).chain(own).collect()
    }
}

/// A direction along no axis.
pub const ASLANT: Vec3 = Vec3::new(0.36, 0.48, -0.8);

/// One sphere seen from outside at this sin^2 = (radius / distance)^2.
///
/// Along an axis single precision holds directions to 1e-7 of the smallest cone. Aslant it holds them to 6e-8,
/// which is too coarse for a table of cones below sin^2 = 1e-6.
pub fn far_balls() -> Vec<View> {
    let mut views = Vec::new();
    for sin2 in [1e-14f64, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 0.3, 0.9, 0.998] {
        let radius = sin2.sqrt() as f32;
        for (axis, to) in [("x", Vec3::X), ("-z", Vec3::NEG_Z), ("aslant", ASLANT)] {
            if axis != "aslant" || sin2 >= 1e-6 {
                views.push(View::new(
                    format!("sphere {axis}, sin^2 {sin2:e}"),
                    Vec3::ZERO,
                    vec![ball(to, radius, false)],
                ));
            }
        }
    }
    views
}

/// One sphere seen from its surface and from inside.
pub fn near_balls() -> Vec<View> {
    let at = |name: &str, to: Vec3, inward| View::new(name, Vec3::ZERO, vec![ball(to, 1.0, inward)]);
    vec![
        at("on a sphere", Vec3::Z, false),
        at("on a sphere, just outside", ASLANT * 1.000_001, false),
        at("inside a sphere, at its centre", Vec3::ZERO, true),
        at("inside a sphere", ASLANT * 0.5, true),
        at("inside a sphere, near its surface", ASLANT * 0.999, true),
        at("inside a sphere that shines outwards", ASLANT * 0.5, false),
        at("before a sphere that shines inwards", ASLANT * 2.0, true),
    ]
}

/// Rectangles and triangles, near and far, and from behind.
pub fn facets() -> Vec<View> {
    let (e1, e2) = (Vec3::new(1.0, 0.2, 0.0), Vec3::new(-0.3, 0.8, 0.4));
    let n = e1.cross(e2).normalize();
    let mut views = Vec::new();
    for (kind, quad) in [("parallelogram", true), ("triangle", false)] {
        for height in [0.02, 0.5, 3.0, 100.0] {
            let p = Vec3::new(0.3, 0.7, -0.2);
            let p0 = p - n * height - e1 * 0.3 - e2 * 0.2;
            views.push(View::new(format!("{kind} at {height}"), p, vec![facet(p0, e1, e2, quad, false)]));
        }
        let p0 = n * 0.5;
        views.push(View::new(format!("{kind} from behind"), Vec3::ZERO, vec![facet(p0, e1, e2, quad, false)]));
        let p0 = n * 0.7 + e1 * 2.0;
        views.push(View::new(format!("{kind} flipped, aside"), Vec3::ZERO, vec![facet(p0, e1, e2, quad, true)]));
    }
    views
}

/// Numbers in [0, 1) that look random.
pub fn random(i: u32, k: u32) -> f32 {
    let mut x = u64::from(i) << 32 | u64::from(k) << 1 | 1;
    for _ in 0..3 {
        x = (x ^ x >> 31).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }
    (x >> 40) as f32 / 16_777_216.0
}

/// So many lights all around the origin, of all kinds; some hide others or turn their backs.
pub fn many(count: u32) -> View {
    let one = |i: u32| {
        let v = |k| Vec3::new(random(i, k), random(i, k + 1), random(i, k + 2)) * 2.0 - 1.0;
        let at = v(0) * 4.0 + v(3).normalize();
        match i % 4 {
            0 | 1 => ball(at, 0.1 + 0.5 * random(i, 9), false),
            2 => facet(at, v(10), v(13), true, false),
            _ => facet(at, v(10), v(13), false, i.is_multiple_of(8)),
        }
    };
    View::new(format!("{count} lights"), Vec3::ZERO, (0..count).map(one).collect())
}

/// Several lights: overlapping, hiding each other, inside each other, many.
pub fn mixtures() -> Vec<View> {
    let (x, y) = (Vec3::X, Vec3::Y);
    let mut views = vec![
        View::new(
            "one sphere hides another",
            Vec3::ZERO,
            vec![ball(ASLANT * 3.0, 0.5, false), ball(ASLANT * 8.0, 2.0, false)],
        ),
        View::new(
            "two spheres overlap",
            Vec3::ZERO,
            vec![
                ball(ASLANT * 3.0, 0.5, false),
                ball(ASLANT * 3.0 + x * 0.4, 0.5, false),
                ball(ASLANT * -5.0, 1.0, false),
            ],
        ),
        View::new(
            "sphere before a rectangle",
            Vec3::ZERO,
            vec![
                facet(Vec3::new(-1.0, -1.0, -4.0), x * 2.0, y * 2.0, true, false),
                ball(Vec3::new(0.2, 0.1, -2.0), 0.3, false),
            ],
        ),
        View::new(
            "sphere in a sphere",
            Vec3::ZERO,
            vec![
                ball(Vec3::new(0.0, 0.3, 0.5), 4.0, true),
                ball(Vec3::new(1.0, 0.3, 1.5), 1.0, false),
                ball(Vec3::new(1.0, 0.3, 1.5), 2.5, false),
            ],
        ),
        View::new(
            "a triangle, its back and a sphere",
            Vec3::ZERO,
            vec![
                facet(Vec3::new(-1.0, -1.0, -2.0), x * 2.0, y * 2.0, false, false),
                facet(Vec3::new(-1.0, -1.0, -2.5), x * 2.0, y * 2.0, false, true),
                ball(Vec3::new(0.5, 0.5, -3.0), 0.7, false),
            ],
        ),
    ];
    views.extend([2, 5, 8, 9, 33, 64].map(many));
    views
}
