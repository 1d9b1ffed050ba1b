//! A great circle of directions through the peak of the lobe, and what the estimator sees along it.

use glam::{DVec3, Vec3};
use mislab_renderer::inspect::{Direction, Point};

use super::place::{LightSeen, Surface};

/// Below this sine two directions leave the plane through them open.
const SAME: f64 = 1e-6;

/// The circle; angles along it are in radians, 0 at the mirror direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle {
    peak: DVec3,
    side: DVec3,
}

impl Circle {
    /// Through the mirror direction and, at positive angles, through `towards`; then turned about the former by `turn`
    /// radians. Where the two are one direction, in the plane of incidence.
    pub fn new(surface: &Surface, towards: Vec3, turn: f64) -> Self {
        let peak = surface.mirrored.as_dvec3().normalize_or(DVec3::Z);
        let across = |to: Vec3| to.as_dvec3() - peak * peak.dot(to.as_dvec3());
        let candidates = [across(towards), across(surface.normal)];
        let side = candidates.into_iter().find(|side| side.length() > SAME);
        let side = side.map_or_else(|| peak.any_orthonormal_vector(), DVec3::normalize);
        Self { peak, side: side * turn.cos() + peak.cross(side) * turn.sin() }
    }

    /// The direction at an angle.
    pub fn direction(&self, angle: f64) -> Vec3 {
        (self.peak * angle.cos() + self.side * angle.sin()).as_vec3().normalize()
    }

    /// The angle of the nearest direction of the circle.
    pub fn angle_of(&self, wi: Vec3) -> f64 {
        let wi = wi.as_dvec3();
        wi.dot(self.side).atan2(wi.dot(self.peak))
    }

    /// How far a direction lies off the circle.
    pub fn distance(&self, wi: Vec3) -> f64 {
        wi.as_dvec3().dot(self.peak.cross(self.side)).clamp(-1.0, 1.0).asin().abs()
    }

    /// Where the circle crosses a round light; `None` if it does not.
    pub fn interval(&self, light: &LightSeen) -> Option<[f64; 2]> {
        let middle = self.angle_of(light.centre);
        let half = (light.radius.cos() / self.cosine(light)).acos();
        (light.radius > 0.0 && half.is_finite()).then_some([middle - half, middle + half])
    }

    /// The radius, as an angle, of a light whose edge the circle crosses at that angle.
    pub fn radius_to(&self, light: &LightSeen, edge: f64) -> f64 {
        (self.cosine(light) * (edge - self.angle_of(light.centre)).cos()).clamp(-1.0, 1.0).acos()
    }

    /// Cosine of the distance of the light's middle.
    fn cosine(&self, light: &LightSeen) -> f64 {
        self.distance(light.centre).cos()
    }

    /// Tangent of the angle between the normal and the half vector at an angle: there GGX has fallen to a quarter when it
    /// is alpha.
    pub fn tilt(&self, surface: &Surface, angle: f64) -> f64 {
        let half = (surface.wo.as_dvec3() + self.direction(angle).as_dvec3()).normalize_or_zero();
        let normal = surface.normal.as_dvec3();
        half.cross(normal).length() / half.dot(normal)
    }

    /// Where the lobe has fallen to a quarter, on both sides.
    pub fn lobe(&self, surface: &Surface, alpha: f64) -> [f64; 2] {
        [-1.0, 1.0].map(|sign| {
            let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_2);
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                let tilt = self.tilt(surface, sign * middle);
                if tilt >= 0.0 && tilt < alpha { low = middle } else { high = middle }
            }
            sign * low
        })
    }
}

/// What the estimator sees at one angle.
#[derive(Clone, Copy, Debug)]
pub struct Sight {
    /// The angle.
    pub angle: f64,
    /// f and both densities.
    pub seen: Direction,
}

/// Along a part of the circle, at `count` angles and at both sides of `edges`, in order.
pub fn along(point: &Point<'_>, circle: &Circle, [low, high]: [f64; 2], count: usize, edges: &[f64]) -> Vec<Sight> {
    let even = (0..count).map(|i| low + (high - low) * i as f64 / (count - 1) as f64);
    let near = 1e-4 * (high - low);
    let beside = edges.iter().flat_map(|edge| [edge - near, edge + near]).filter(|angle| (low..=high).contains(angle));
    let mut angles: Vec<f64> = even.chain(beside).collect();
    angles.sort_by(f64::total_cmp);
    angles.into_iter().map(|angle| Sight { angle, seen: point.direction(circle.direction(angle)) }).collect()
}

#[cfg(test)]
mod tests {
    use super::super::place::Facts;
    use super::super::tables::tests::place;
    use super::*;

    fn surface() -> Surface {
        Facts::of(&place()).surface().expect("a plate").clone()
    }

    #[test]
    fn it_passes_through_the_peak_and_the_light() {
        let surface = surface();
        for light in &surface.lights {
            let circle = Circle::new(&surface, light.centre, 0.0);
            assert!((circle.direction(0.0) - surface.mirrored).length() < 1e-6);
            assert!(circle.distance(light.centre) < 1e-6 && circle.angle_of(light.centre) >= 0.0);
            assert!((circle.angle_of(light.centre) - light.off).abs() < 1e-6);
            let there = circle.direction(circle.angle_of(light.centre));
            assert!((there - light.centre).length() < 1e-6);
            for turn in [0.4, -1.2] {
                let turned = Circle::new(&surface, light.centre, turn);
                assert!((turned.direction(0.0) - surface.mirrored).length() < 1e-6, "it turns about the peak");
                assert!((turned.direction(0.3) - circle.direction(0.3)).length() > 0.05, "it turns");
            }
        }
    }

    #[test]
    fn edges_of_a_light_are_where_rays_begin_to_hit_it() {
        let (place, surface) = (place(), surface());
        let point = place.point().expect("a plate");
        for light in &surface.lights {
            // Off its middle, too: the chord is shorter than the light.
            for turn in [0.0, 0.3 * light.radius / light.off.max(light.radius)] {
                let circle = Circle::new(&surface, light.centre, turn);
                let [low, high] = circle.interval(light).expect("the circle crosses it");
                let hits = |angle: f64| {
                    point.direction(circle.direction(angle)).hit.is_some_and(|hit| hit.shape == light.shape)
                };
                let step = 0.02 * (high - low);
                for (edge, inwards) in [(low, step), (high, -step)] {
                    assert!(hits(edge + inwards) && !hits(edge - inwards), "{}: edge at {edge}", light.name);
                    assert!((circle.radius_to(light, edge) - light.radius).abs() < 1e-9);
                }
            }
        }
    }

    #[test]
    fn the_lobes_edge_is_where_ggx_is_a_quarter_of_its_peak() {
        let surface = surface();
        let light = surface.highlight().expect("lights are on");
        let circle = Circle::new(&surface, light.centre, 0.5);
        for alpha in [0.01, 0.1, 0.3] {
            for edge in circle.lobe(&surface, alpha) {
                assert!((circle.tilt(&surface, edge) - alpha).abs() < 1e-5, "alpha {alpha} at {edge}");
                // D ~ 1 / (cos^4 (1 + tan^2 / alpha^2)^2), without the cosine a quarter.
                let d = (1.0 + (circle.tilt(&surface, edge) / alpha).powi(2)).powi(-2);
                assert!((d - 0.25).abs() < 1e-3);
            }
        }
    }
}
