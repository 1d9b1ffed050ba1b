//! Lights that are listed twice.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};

use glam::Vec3;
use mislab_kernel::request::scene::{Geometry, Shape};

use super::log::{Log, Pos};

/// Warns of each light that is where another one is and emits to the same side. The renderer shows the brighter one.
pub(super) fn warn_of_twins(shapes: &[Shape], places: &[Pos], log: &mut Log) {
    let mut lights: HashMap<[u64; 2], &str> = HashMap::new();
    for (shape, at) in shapes.iter().zip(places) {
        let Some(light) = &shape.light else { continue };
        let Some(twin) = lights.insert(place(shape), &light.name) else { continue };
        let message = format!(
            "{} is where {twin} is: the brighter one is seen, whatever their order (in pbrt-v3 that depends on its tree)",
            light.name
        );
        log.warn(*at, message);
    }
}

/// The same for the same surface that faces the same way, in whatever order its triangles and their corners are listed.
fn place(shape: &Shape) -> [u64; 2] {
    let numbers = |v: Vec3| (v + 0.0).to_array().map(f32::to_bits);
    match &shape.geometry {
        Geometry::Sphere { center, radius } => {
            [hash((numbers(*center), radius.to_bits())), u64::from(shape.reverse_orientation)]
        }
        Geometry::Mesh { positions, triangles } => {
            let all = triangles.iter().map(|triangle| {
                let mut corners = triangle.map(|i| numbers(positions[i as usize]));
                if shape.reverse_orientation {
                    corners.swap(1, 2);
                }
                // Turning a triangle about itself changes nothing.
                let first = (0..3).min_by_key(|&i| corners[i]).unwrap_or(0);
                corners.rotate_left(first);
                hash(corners)
            });
            [all.fold(0, u64::wrapping_add), triangles.len() as u64 + 2]
        }
    }
}

fn hash(value: impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}
