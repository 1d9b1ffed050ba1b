//! The directions in which one light lies, as points of the unit square.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};
use mislab_kernel::light::{BuiltLight, LightShape};

/// Directions this close to the rim of a sphere light, in units of its radius, are moved inwards: single precision may
/// see them miss it. A light of radius 0.03 at distance 15 is known to 5e-5 of its radius.
const RIM: f64 = 1e-4;
/// The same for the edges of a facet, in units of the edges.
const EDGE: f64 = 1e-5;

/// Directions towards one light from one point.
#[derive(Clone, Copy)]
pub(super) enum Chart {
    /// A cone around `axis`: at (r, v) the directions with `1 - cos = one_minus_cos r^2` and azimuth `2 pi v`. Smooth at
    /// the axis, unlike `1 - cos` itself.
    Cone { axis: DVec3, across: [DVec3; 2], one_minus_cos: f64, inside: bool },
    /// A parallelogram, or a triangle by Duffy's map, as seen from the point.
    Facet { to: DVec3, edges: [DVec3; 2], quad: bool },
}

impl Chart {
    /// The directions of a light; `None` where it turns its back.
    pub fn new(light: &BuiltLight, p: Vec3) -> Option<Self> {
        let p = p.as_dvec3();
        match &light.shape {
            LightShape::Ball(ball) => {
                let to = ball.center.as_dvec3() - p;
                let (distance, radius) = (to.length(), f64::from(ball.radius));
                let inside = distance < radius;
                if inside != ball.inward {
                    return None;
                }
                let axis = if distance > 0.0 { to / distance } else { DVec3::Z };
                let (s, t) = axis.any_orthonormal_pair();
                let sin2 = (radius / distance).powi(2);
                let one_minus_cos = if inside { 2.0 } else { sin2 / (1.0 + (1.0 - sin2).max(0.0).sqrt()) };
                Some(Self::Cone { axis, across: [s, t], one_minus_cos, inside })
            }
            LightShape::Facet(facet) => {
                let to = facet.p0.as_dvec3() - p;
                let edges = [facet.e1.as_dvec3(), facet.e2.as_dvec3()];
                (facet.normal.as_dvec3().dot(to) < 0.0).then_some(Self::Facet { to, edges, quad: facet.quad })
            }
        }
    }

    /// Unit direction at a point of the square, and solid angle per area of the square there.
    pub fn direction(&self, [u, v]: [f64; 2]) -> (DVec3, f64) {
        match *self {
            Self::Cone { axis, across: [s, t], one_minus_cos, inside } => {
                let r = if inside { u } else { u.min(1.0 - RIM) };
                let h = one_minus_cos * r * r;
                let sin = (h * (2.0 - h)).max(0.0).sqrt();
                let (sin_phi, cos_phi) = (TAU * v).sin_cos();
                (axis * (1.0 - h) + (s * cos_phi + t * sin_phi) * sin, 2.0 * TAU * one_minus_cos * u)
            }
            Self::Facet { to, edges: [e1, e2], quad } => {
                let (mut b, stretch) = if quad { ([u, v], 1.0) } else { ([u, v * (1.0 - u)], 1.0 - u) };
                b = b.map(|b| b.clamp(EDGE, 1.0 - EDGE));
                if !quad {
                    let excess = (b[0] + b[1] - (1.0 - EDGE)).max(0.0);
                    b = b.map(|b| b - 0.5 * excess);
                }
                let to = to + e1 * b[0] + e2 * b[1];
                let dir = to.normalize();
                (dir, stretch * e1.cross(e2).dot(dir).abs() / to.length_squared())
            }
        }
    }

    /// Solid angle of the light, whatever lies before it.
    pub fn solid_angle(&self) -> f64 {
        match *self {
            Self::Cone { one_minus_cos, .. } => TAU * one_minus_cos,
            Self::Facet { to, edges: [e1, e2], quad } => {
                let half = triangle(to, to + e1, to + e2);
                if quad { half + triangle(to + e1, to + e1 + e2, to + e2) } else { half }
            }
        }
    }

    /// Cells to begin with, along u and v, where a light can be given about that many.
    pub fn grid(&self, cells: usize) -> [usize; 2] {
        match self {
            Self::Cone { .. } if cells >= 12 => [3, 4],
            Self::Facet { .. } if cells >= 12 => [3, 3],
            Self::Cone { .. } if cells >= 3 => [1, 3],
            Self::Cone { .. } | Self::Facet { .. } => [1, 1],
        }
    }
}

/// Solid angle of a triangle seen from the origin (van Oosterom and Strackee 1983).
fn triangle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let (x, y, z) = (a.length(), b.length(), c.length());
    let below = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
    2.0 * a.dot(b.cross(c)).abs().atan2(below)
}
