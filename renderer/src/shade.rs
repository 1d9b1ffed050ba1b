//! Where no light can reach, proven: each light is below the horizon, turns its back, or is hidden behind a single primitive.
//!
//! The points that a convex light cannot see past a convex primitive are convex, too: for each point of the light they are what is behind
//! the primitive. So a part of a plane is in shadow where its corners are, behind the same primitive.

use glam::DVec3;
use mislab_kernel::request::scene::{Geometry, Scene, Shape};
use mislab_kernel::world::projection::{Projector, Ray};

use crate::table::regions::Primitive;

/// Of more pairs of a light and something in its way none is looked at, which would take too long for every pixel: then nothing is
/// known to be in shadow.
const MOST_PAIRS: usize = 256;
/// What is nearer to the plane of a facet than this, in lengths of its first edge, is on it and not behind it.
const ON_PLANE: f64 = 1e-4;

/// Lights and what can be in their way, seen from one camera.
pub struct Shade<'a> {
    scene: &'a Scene,
    projector: Projector,
    lights: Vec<Body>,
    occluders: Vec<Body>,
}

/// Something convex.
enum Body {
    Ball { center: DVec3, radius: f64 },
    Facet { corners: Vec<DVec3>, normal: DVec3 },
}

impl<'a> Shade<'a> {
    /// Of an image of that many pixels.
    pub fn new(scene: &'a Scene, resolution: [u32; 2]) -> Self {
        let (lights, others): (Vec<&Shape>, Vec<&Shape>) = scene.shapes.iter().partition(|shape| emits(shape));
        let bodies = |shapes: Vec<&Shape>| shapes.into_iter().flat_map(Body::of).collect::<Vec<_>>();
        let (lights, mut occluders) = (bodies(lights), bodies(others));
        if lights.len() * occluders.len() > MOST_PAIRS {
            occluders.clear();
        }
        Self { scene, projector: Projector::new(&scene.camera, resolution), lights, occluders }
    }

    /// True where it is sure that no light reaches anything of a primitive that the pixel in this column and row may show.
    pub fn covers(&self, primitive: Primitive, [x, y]: [usize; 2]) -> bool {
        let ray = |dx: f64, dy: f64| self.projector.ray([x as f64 + dx, y as f64 + dy]);
        let centre = ray(0.5, 0.5);
        let corners = [ray(0.0, 0.0), ray(1.0, 0.0), ray(0.0, 1.0), ray(1.0, 1.0)];
        match &self.scene.shapes[primitive.shape as usize].geometry {
            Geometry::Sphere { center, radius } => {
                self.covers_ball(center.as_dvec3(), f64::from(*radius), &[&[centre], &corners[..]].concat())
            }
            Geometry::Mesh { positions, triangles } => {
                let abc = triangles[primitive.triangle as usize].map(|i| positions[i as usize].as_dvec3());
                // Most pixels are lit at their centres.
                self.covers_plane(abc, &[centre]) && self.covers_plane(abc, &corners)
            }
        }
    }

    /// The same of the part of a plane between the rays, seen from their side.
    fn covers_plane(&self, [a, b, c]: [DVec3; 3], rays: &[Ray]) -> bool {
        let normal = (b - a).cross(c - a);
        let normal = normal * normal.dot(self.projector.eye - a).signum();
        let points: Vec<DVec3> = rays
            .iter()
            .map(|ray| ray.origin + normal.dot(a - ray.origin) / normal.dot(ray.direction) * ray.direction)
            .collect();
        // A ray that misses the plane hits it behind the eye, or nowhere.
        let in_front = |(ray, p): (&Ray, &DVec3)| ray.direction.dot(*p - ray.origin) > 0.0 && p.is_finite();
        rays.iter().zip(&points).all(in_front)
            && self.lights.iter().all(|light| {
                light.most(normal, a) <= 0.0
                    || points.iter().all(|p| light.turns_its_back_on(*p))
                    || self.occluders.iter().any(|occluder| points.iter().all(|p| occluder.hides(light, *p)))
            })
    }

    /// The same of the part of a sphere between the rays: its horizon only.
    fn covers_ball(&self, center: DVec3, radius: f64, rays: &[Ray]) -> bool {
        let normals: Vec<DVec3> = rays.iter().map(|ray| ball_normal(ray, center, radius)).collect();
        // No normal of this part is farther from the first one.
        let angle = 2.0 * normals.iter().map(|normal| normal.angle_between(normals[0])).fold(0.0, f64::max);
        let outside = center.distance(self.projector.eye) > radius;
        outside
            && self.lights.iter().all(|light| {
                let farthest = light.corners().map(|corner| corner.distance(center)).fold(0.0, f64::max);
                light.most(normals[0], center) + angle * farthest <= radius
            })
    }
}

/// Where a ray hits the sphere, or passes it, seen from its centre; of unit length.
fn ball_normal(ray: &Ray, center: DVec3, radius: f64) -> DVec3 {
    let nearest = (center - ray.origin).dot(ray.direction) / ray.direction.length_squared();
    let t = ray.hit_sphere(center, radius).unwrap_or(nearest);
    (ray.origin + t * ray.direction - center).normalize()
}

fn emits(shape: &Shape) -> bool {
    shape.light.as_ref().is_some_and(|light| light.on && light.radiance != glam::Vec3::ZERO)
}

impl Body {
    /// A sphere, or the triangles of a mesh; two that follow each other and make a parallelogram are one.
    fn of(shape: &Shape) -> Vec<Self> {
        let (positions, triangles) = match &shape.geometry {
            Geometry::Sphere { center, radius } => {
                return vec![Self::Ball { center: center.as_dvec3(), radius: f64::from(*radius) }];
            }
            Geometry::Mesh { positions, triangles } => (positions, triangles),
        };
        let mut bodies = Vec::new();
        let mut rest = triangles.iter().map(|triangle| triangle.map(|i| positions[i as usize].as_dvec3())).peekable();
        while let Some([a, b, c]) = rest.next() {
            let normal = (b - a).cross(c - a).normalize() * if shape.reverse_orientation { -1.0 } else { 1.0 };
            let corners = match rest.peek().and_then(|next| parallelogram([a, b, c], *next)) {
                Some(corners) => {
                    rest.next();
                    corners.to_vec()
                }
                None => vec![a, b, c],
            };
            bodies.push(Self::Facet { corners, normal });
        }
        bodies
    }

    fn corners(&self) -> impl Iterator<Item = DVec3> {
        let (center, corners) = match self {
            Self::Ball { center, radius: _ } => (Some(*center), [].as_slice()),
            Self::Facet { corners, normal: _ } => (None, corners.as_slice()),
        };
        corners.iter().copied().chain(center)
    }

    fn radius(&self) -> f64 {
        match self {
            Self::Ball { center: _, radius } => *radius,
            Self::Facet { .. } => 0.0,
        }
    }

    /// How far along a direction it reaches from a point, in lengths of the direction.
    fn most(&self, direction: DVec3, from: DVec3) -> f64 {
        let along = self.corners().map(|corner| direction.dot(corner - from)).fold(f64::NEG_INFINITY, f64::max);
        along + self.radius() * direction.length()
    }

    /// The same of its nearest point.
    fn least(&self, direction: DVec3, from: DVec3) -> f64 {
        -self.most(-direction, from)
    }

    fn turns_its_back_on(&self, p: DVec3) -> bool {
        match self {
            // From outside one that emits inwards shows its far side, were its near one not in between.
            Self::Ball { .. } => false,
            Self::Facet { corners, normal } => normal.dot(p - corners[0]) <= 0.0,
        }
    }

    /// True if every line from the point to the light passes through it.
    fn hides(&self, light: &Self, p: DVec3) -> bool {
        match self {
            Self::Facet { corners, normal } => {
                let from_plane = normal.dot(p - corners[0]);
                let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
                let edges = corners.iter().zip(corners.iter().cycle().skip(1));
                from_plane.abs() > ON_PLANE * corners[0].distance(corners[1])
                    && light.least(*normal * -from_plane.signum(), corners[0]) >= 0.0
                    && edges.into_iter().all(|(a, b)| {
                        let inwards = (*a - p).cross(*b - p);
                        light.least(inwards * inwards.dot(middle - p).signum(), p) >= 0.0
                    })
            }
            Self::Ball { center, radius } => {
                let axis = *center - p;
                let opening = (radius / axis.length()).asin();
                let inside = |corner: DVec3| {
                    let to = corner - p;
                    to.angle_between(axis) + (light.radius() / to.length()).asin() <= opening
                };
                light.least(axis, *center) >= 0.0 && light.corners().all(inside)
            }
        }
    }
}

/// The corners in turn of the parallelogram that two triangles make.
fn parallelogram(first: [DVec3; 3], second: [DVec3; 3]) -> Option<[DVec3; 4]> {
    let alone = |of: [DVec3; 3], other: [DVec3; 3]| {
        let mut corners = of.into_iter().enumerate().filter(|(_, corner)| !other.contains(corner));
        let (i, corner) = corners.next()?;
        corners.next().is_none().then_some((corner, [of[(i + 1) % 3], of[(i + 2) % 3]]))
    };
    let ((from, [a, b]), (to, _)) = (alone(first, second)?, alone(second, first)?);
    let gap = (from + to).distance(a + b);
    (gap <= 1e-5 * a.distance(b)).then_some([from, a, to, b])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ball(center: [f64; 3], radius: f64) -> Body {
        Body::Ball { center: center.into(), radius }
    }

    /// A square of side 2 at the height 1, seen from the origin.
    fn square(height: f64) -> Body {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| DVec3::new(x, y, height));
        Body::Facet { corners: corners.to_vec(), normal: DVec3::Z }
    }

    #[test]
    fn only_what_is_wholly_behind_is_hidden() {
        let origin = DVec3::ZERO;
        for (occluder, what) in
            [(square(1.0), "a square"), (ball([0.0, 0.0, 2.0], 2.0_f64.sqrt()), "a ball of 45 degrees")]
        {
            assert!(occluder.hides(&ball([0.0, 0.0, 5.0], 1.0), origin), "behind {what}");
            assert!(occluder.hides(&square(3.0), origin), "a square behind {what}");
            assert!(!occluder.hides(&ball([0.0, 4.0, 5.0], 1.0), origin), "past the edge of {what}");
            assert!(!occluder.hides(&ball([0.0, 0.0, 0.5], 0.1), origin), "in front of {what}");
            assert!(!occluder.hides(&ball([0.0, 0.0, -5.0], 1.0), origin), "on the other side of {what}");
        }
        assert!(!square(0.0).hides(&ball([0.0, 0.0, 5.0], 1.0), DVec3::ZERO), "a surface is not in its own way");
        assert!(!ball([0.0, 0.0, 0.5], 1.0).hides(&ball([0.0, 0.0, 5.0], 1.0), origin), "from the inside");
    }

    #[test]
    fn two_triangles_in_turn_make_a_parallelogram() {
        let [a, b, c, d] = [[0.0, 0.0], [2.0, 0.0], [3.0, 1.0], [1.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        assert_eq!(parallelogram([a, b, c], [a, c, d]), Some([b, c, d, a]));
        assert_eq!(parallelogram([a, b, c], [a, c, 2.0 * d]), None, "a kite");
        assert_eq!(parallelogram([a, b, c], [a, b, c]), None, "the same twice");
    }
}
