//! Lights where an opaque surface is, such as a lamp in the plane of a ceiling. Which of the two a ray meets first would be a
//! matter of rounding, another one for camera rays and for shadow rays, so it is decided once and for all rays: a flat
//! light is raised a little above the surface, on the side that it emits from, and a sphere in the place of a sphere light
//! is left out.

use std::collections::HashSet;

use glam::Vec3;

use super::Opaque;
use crate::geometry::BuiltGeometry;
use crate::geometry::list::List;
use crate::geometry::shape::Facet;
use crate::lanes::{Single, V3};
use crate::light::{BuiltLight, LightShape};
use crate::request::scene;

/// How far a light is raised, in units of `epsilon`: more than shadow rays end before a light, and several times what
/// distances are off by rounding, at any angle.
const RAISE: f32 = 4.0;
/// Distances up to so many epsilon are none.
const SAME: f32 = 2.0;
/// How far above the light the question is asked.
const ABOVE: f32 = 16.0;
/// About how many questions are asked of a scene, and at least one of each shape.
const QUESTIONS: usize = 1 << 12;
/// Most questions in a row over a facet.
const MOST_IN_ROW: usize = 8;

/// Leaves out the spheres that are where a sphere light is: the light is in front.
pub(super) fn drop_hidden(opaque: &mut Vec<Opaque>, lights: &[BuiltLight]) {
    let key = |center: Vec3, radius: f32| [center.x, center.y, center.z, radius].map(f32::to_bits);
    let balls: HashSet<[u32; 4]> = lights
        .iter()
        .filter_map(|light| match light.shape {
            LightShape::Ball(ball) => Some(key(ball.center, ball.radius)),
            LightShape::Facet(_) => None,
        })
        .collect();
    opaque.retain(|shape| match shape.geometry {
        scene::Geometry::Sphere { center, radius } => !balls.contains(&key(center, radius)),
        scene::Geometry::Mesh { .. } => true,
    });
}

/// Raises the flat lights of each shape of which one lies in the plane of a surface right where it is. `epsilon` is what
/// shadow rays keep off.
pub(super) fn raise(lights: &mut [BuiltLight], geometry: &BuiltGeometry, epsilon: f32) {
    let facets = lights.iter().filter(|light| facet(light).is_some()).count();
    if facets == 0 || geometry.is_empty() {
        return;
    }
    let in_row = (QUESTIONS / facets).isqrt().clamp(1, MOST_IN_ROW);
    let every = facets.div_ceil(QUESTIONS);
    let everything = List::all(geometry.len());
    let coincides = |light: &BuiltLight| {
        facet(light).is_some_and(|facet| lies_on_surface(facet, geometry, &everything, epsilon, in_row))
    };
    let same_shape = |a: &BuiltLight, b: &BuiltLight| facet(a).zip(facet(b)).is_some_and(|(a, b)| a.shape == b.shape);
    for shape in lights.chunk_by_mut(same_shape) {
        if shape.iter().step_by(every).any(coincides) {
            for light in shape {
                if let LightShape::Facet(facet) = &mut light.shape {
                    facet.p0 += facet.normal * (RAISE * epsilon);
                }
            }
        }
    }
}

fn facet(light: &BuiltLight) -> Option<&Facet> {
    match &light.shape {
        LightShape::Facet(facet) => Some(facet),
        LightShape::Ball(_) => None,
    }
}

/// True if a ray down to a point of the facet, of a grid of `in_row` in a row, meets something else there.
fn lies_on_surface(facet: &Facet, geometry: &BuiltGeometry, list: &List, epsilon: f32, in_row: usize) -> bool {
    let at = |i: usize| (i as f32 + 0.5) / in_row as f32;
    let down = V3::splat(Single, -facet.normal);
    (0..in_row * in_row).any(|k| {
        let (mut u, mut v) = (at(k / in_row), at(k % in_row));
        if !facet.quad && u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let point = facet.p0 + facet.e1 * u + facet.e2 * v;
        let from = V3::splat(Single, point + facet.normal * (ABOVE * epsilon));
        let distance = geometry.nearest(Single, from, down, list).t;
        (distance - ABOVE * epsilon).abs() <= SAME * epsilon
    })
}
