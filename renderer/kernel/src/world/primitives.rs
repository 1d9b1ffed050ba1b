//! The primitives of a scene's shapes, one after the other: what scenes are built from, and what finds bad shapes.

use glam::Vec3;

use super::Unbuilt;
use crate::geometry::shape::{Ball, Facet};
use crate::light::LightShape;
use crate::request::Invalid;
use crate::request::scene;
use crate::stop::Stop;

/// Most triangles of one scene, a guard against running out of memory.
pub const MAX_TRIANGLES: usize = 50_000_000;

/// A walk over the shapes of one scene.
pub(super) struct Walk<'a> {
    /// How many primitives there were so far.
    count: usize,
    stop: Stop<'a>,
}

impl<'a> Walk<'a> {
    /// A walk that `stop` may end.
    pub(super) fn new(stop: Stop<'a>) -> Self {
        Self { count: 0, stop }
    }

    /// Hands over the primitives of shape `index`: facets of a mesh, or one sphere.
    ///
    /// # Errors
    /// [`Unbuilt::Invalid`] for numbers that cannot be rendered and beyond [`MAX_TRIANGLES`], or if it is stopped.
    pub(super) fn visit(
        &mut self,
        index: usize,
        shape: &scene::Shape,
        mut take: impl FnMut(LightShape),
    ) -> Result<(), Unbuilt> {
        let reverse = shape.reverse_orientation;
        match &shape.geometry {
            scene::Geometry::Sphere { center, radius } => {
                if !(center.is_finite() && radius.is_finite() && *radius > 0.0 && radius * radius > 0.0) {
                    return Err(Invalid(format!(
                        "shape {index}: sphere at {center} with radius {radius}, expected finite numbers and a radius > 0"
                    ))
                    .into());
                }
                self.count_one()?;
                take(LightShape::Ball(Ball { center: *center, radius: *radius, inward: reverse, shape: index as u32 }));
                Ok(())
            }
            scene::Geometry::Mesh { positions, triangles } => {
                if let Some(p) = positions.iter().find(|p| !p.is_finite() || p.abs().max_element() > 1e15) {
                    return Err(Invalid(format!("shape {index}: vertex at {p}, expected numbers below 1e15")).into());
                }
                let corner = |i: u32| {
                    positions.get(i as usize).copied().ok_or_else(|| {
                        Invalid(format!(
                            "shape {index}: triangle refers to vertex {i}, expected one of {}",
                            positions.len()
                        ))
                    })
                };
                let mut i = 0;
                while i < triangles.len() {
                    let [a, b, c] = triangles[i];
                    let (pa, pb, pc) = (corner(a)?, corner(b)?, corner(c)?);
                    let quad = match triangles.get(i + 1) {
                        Some(&next) => parallelogram(triangles[i], next, |i| corner(i).ok()),
                        None => None,
                    };
                    let facet = match quad {
                        Some([p0, p1, p2]) => Facet::new(p0, p1, p2, true, reverse, index as u32),
                        None => Facet::new(pa, pb, pc, false, reverse, index as u32),
                    };
                    i += if quad.is_some() { 2 } else { 1 };
                    self.stop.check_in_turn(self.count)?;
                    self.count_one()?;
                    // Triangles without area cannot be seen.
                    if let Some(facet) = facet {
                        take(LightShape::Facet(facet));
                    }
                }
                Ok(())
            }
        }
    }

    fn count_one(&mut self) -> Result<(), Invalid> {
        self.count += 1;
        if self.count > MAX_TRIANGLES {
            return Err(Invalid(format!("more than {MAX_TRIANGLES} triangles, expected fewer")));
        }
        Ok(())
    }
}

/// Two triangles of the same winding that make up a parallelogram exactly: its corner and the
/// corner's two neighbours. Halves the work on the usual rectangles; a light made of one counts
/// as one light.
fn parallelogram(a: [u32; 3], b: [u32; 3], corner: impl Fn(u32) -> Option<Vec3>) -> Option<[Vec3; 3]> {
    // The vertex of each triangle that the other one lacks; the shared edge is the diagonal.
    let lone_a = (0..3).find(|&i| !b.contains(&a[i]))?;
    let lone_b = (0..3).find(|&i| !a.contains(&b[i]))?;
    let [p, q, r] = [a[lone_a], a[(lone_a + 1) % 3], a[(lone_a + 2) % 3]];
    let [s, r2, q2] = [b[lone_b], b[(lone_b + 1) % 3], b[(lone_b + 2) % 3]];
    if (q, r) != (q2, r2) || q == r {
        return None;
    }
    let (p, q, r, s) = (corner(p)?, corner(q)?, corner(r)?, corner(s)?);
    (q - p == s - r && r - p == s - q).then_some([p, q, r])
}
