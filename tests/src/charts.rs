//! Coordinates on the sphere of directions in which a density is spread over the whole unit square.
//!
//! A grid over the sphere cannot resolve a narrow lobe or a small light: all of it is one cell. Each chart
//! here maps the unit square to directions, with its Jacobian, and directions back. All in f64.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};

/// What the density is checked in.
#[derive(Clone, Debug)]
pub enum Chart {
    /// The whole sphere around the third column of `frame`: 1 - cos by angle.
    Sphere {
        /// Columns: two axes across and the pole.
        frame: DMat3,
    },
    /// A cone around the third column, up to a quarter beyond its rim, where nothing may be: 1 - cos by angle.
    Cone {
        /// Columns: two axes across and the axis of the cone.
        frame: DMat3,
        /// 1 - cos of its rim, up to 1.6.
        one_minus_cos: f64,
    },
    /// The lower side of microfacets: normals h of the upper hemisphere, shrunk across by alpha, as points of a
    /// hemisphere (1 - cos by angle).
    Normal {
        /// Width of the distribution.
        alpha: f64,
    },
    /// The directions that normals as in [`Self::Normal`] reflect `wo` to.
    Lobe {
        /// Columns: two axes across and the surface's normal.
        frame: DMat3,
        /// The viewer's direction in that frame.
        wo: DVec3,
        /// Width of the distribution.
        alpha: f64,
    },
    /// The points `p0 + s e1 + t e2` of a plane seen from the origin, s and t from -1/8 to 9/8.
    Facet {
        /// Corner.
        p0: DVec3,
        /// First edge.
        e1: DVec3,
        /// Second edge.
        e2: DVec3,
    },
    /// No directions at all: the points (x, y) of the unit square.
    Flat,
}

/// How much of a cone's chart lies inside it; a whole number of cells with 10, 50 and 100 rows.
const INSIDE_CONE: f64 = 0.8;

/// Columns: two axes across and the unit vector `n`. Exact where n is +z.
pub fn frame(n: DVec3) -> DMat3 {
    let (t, b) = n.any_orthonormal_pair();
    DMat3::from_cols(t, b, n)
}

/// Direction around +z with this 1 - cos, at a turn v of the circle.
fn around_z(one_minus_cos: f64, v: f64) -> DVec3 {
    let (sin, cos) = (TAU * v).sin_cos();
    let r = (one_minus_cos * (2.0 - one_minus_cos)).max(0.0).sqrt();
    DVec3::new(r * cos, r * sin, 1.0 - one_minus_cos)
}

/// The inverse: 1 - cos without cancellation, and the turn.
fn place_around_z(d: DVec3) -> [f64; 2] {
    let sin2 = d.x * d.x + d.y * d.y;
    let one_minus_cos = if d.z > 0.0 { sin2 / (1.0 + d.z) } else { 1.0 - d.z };
    let v = d.y.atan2(d.x) / TAU;
    [one_minus_cos, if v < 0.0 { v + 1.0 } else { v }]
}

/// Normal of the shrunk hemisphere's point (u, v), and its solid angle per unit of (u, v).
fn normal(alpha: f64, [u, v]: [f64; 2]) -> (DVec3, f64) {
    let m = around_z(u, v);
    let h = DVec3::new(m.x * alpha, m.y * alpha, m.z);
    // Slopes x / z scale by alpha, and dw = cos^3 d slope.
    let length = h.length();
    (h / length, TAU * alpha * alpha / length.powi(3))
}

fn place_normal(alpha: f64, h: DVec3) -> Option<[f64; 2]> {
    (h.z > 0.0).then(|| place_around_z(DVec3::new(h.x / alpha, h.y / alpha, h.z).normalize()))
}

impl Chart {
    /// Short name.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Sphere { .. } => "sphere",
            Self::Cone { .. } => "cone",
            Self::Normal { .. } => "normals",
            Self::Lobe { .. } => "lobe",
            Self::Facet { .. } => "facet",
            Self::Flat => "square",
        }
    }

    /// The direction at a point of the square, and the solid angle per unit of area there; 0 where there is none.
    pub fn direction(&self, at: [f64; 2]) -> (DVec3, f64) {
        match *self {
            Self::Sphere { frame } => (frame * around_z(2.0 * at[0], at[1]), 4.0 * PI),
            Self::Cone { frame, one_minus_cos } => {
                let scale = one_minus_cos / INSIDE_CONE;
                (frame * around_z(at[0] * scale, at[1]), TAU * scale)
            }
            Self::Normal { alpha } => normal(alpha, at),
            Self::Lobe { frame, wo, alpha } => {
                let (h, density) = normal(alpha, at);
                let cos = wo.dot(h);
                // dwi = 4 (wo . h) dh
                (frame * (h * (2.0 * cos) - wo), 4.0 * cos.max(0.0) * density)
            }
            Self::Facet { p0, e1, e2 } => {
                let point = p0 + e1 * (at[0] * 1.25 - 0.125) + e2 * (at[1] * 1.25 - 0.125);
                let distance = point.length();
                // dw = cos dA / distance^2
                (point / distance, 1.25 * 1.25 * e1.cross(e2).dot(point).abs() / distance.powi(3))
            }
            Self::Flat => (DVec3::new(at[0], at[1], 0.0), 1.0),
        }
    }

    /// Where a direction lies in the square; `None` outside the chart.
    pub fn place(&self, d: DVec3) -> Option<[f64; 2]> {
        let at = match *self {
            Self::Sphere { frame } => {
                let [h, v] = place_around_z(frame.transpose() * d);
                [h / 2.0, v]
            }
            Self::Cone { frame, one_minus_cos } => {
                let [h, v] = place_around_z(frame.transpose() * d);
                [h / one_minus_cos * INSIDE_CONE, v]
            }
            Self::Normal { alpha } => place_normal(alpha, d)?,
            Self::Lobe { frame, wo, alpha } => place_normal(alpha, (frame.transpose() * d + wo).normalize())?,
            Self::Facet { p0, e1, e2 } => {
                let n = e1.cross(e2);
                let t = p0.dot(n) / d.dot(n);
                let q = d * t - p0;
                let s = q.cross(e2).dot(n) / n.dot(n);
                let r = e1.cross(q).dot(n) / n.dot(n);
                if t <= 0.0 {
                    return None;
                }
                [(s + 0.125) / 1.25, (r + 0.125) / 1.25]
            }
            Self::Flat => [d.x, d.y],
        };
        // Rounding may put the turn at 1, and a half vector at the equator.
        let at = [at[0], at[1].min(1.0 - 1e-15)];
        let whole = !matches!(self, Self::Cone { .. } | Self::Facet { .. });
        let at = if whole { [at[0].min(1.0 - 1e-15), at[1]] } else { at };
        (0.0..1.0).contains(&at[0]).then_some(at).filter(|at| (0.0..1.0).contains(&at[1]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn charts_invert_and_their_jacobians_are_areas() {
        let n = DVec3::new(0.3, -0.5, 0.6).normalize();
        let charts = [
            Chart::Sphere { frame: frame(n) },
            Chart::Cone { frame: frame(n), one_minus_cos: 0.3 },
            Chart::Cone { frame: frame(n), one_minus_cos: 1e-6 },
            Chart::Normal { alpha: 0.2 },
            Chart::Lobe { frame: frame(n), wo: DVec3::new(0.6, 0.0, 0.8), alpha: 0.1 },
            Chart::Lobe { frame: frame(n), wo: DVec3::new(0.6, 0.0, 0.8), alpha: 1.0 },
            Chart::Facet { p0: n, e1: DVec3::new(1.0, 0.2, 0.0), e2: DVec3::new(0.0, 0.3, 2.0) },
        ];
        for chart in &charts {
            for i in 0..100 {
                let at = [f64::from(i % 10) / 10.5 + 0.03, f64::from(i / 10) / 10.5 + 0.03];
                let (d, density) = chart.direction(at);
                if density == 0.0 {
                    continue;
                }
                assert!((d.length() - 1.0).abs() < 1e-12, "{chart:?} at {at:?}: {d}");
                let back = chart.place(d).expect("inside the chart");
                let off = (back[0] - at[0]).abs().max((back[1] - at[1]).abs());
                assert!(off < 1e-8, "{chart:?}: {at:?} comes back as {back:?}");
                // The image of a small square, by central differences.
                let step = 1e-5;
                let along = |k: usize| {
                    let mut ends = [at, at];
                    ends[0][k] += step;
                    ends[1][k] -= step;
                    (chart.direction(ends[0]).0 - chart.direction(ends[1]).0) / (2.0 * step)
                };
                let area = along(0).cross(along(1)).length();
                assert!((area / density - 1.0).abs() < 1e-4, "{chart:?} at {at:?}: {density}, expected {area}");
            }
        }
    }
}
