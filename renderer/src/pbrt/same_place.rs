//! Surfaces that are listed twice.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};

use glam::Vec3;
use mislab_kernel::request::scene::{Geometry, Material, Shape};

use super::log::{Log, Pos};

/// What pbrt-v3 does instead.
const IN_PBRT: &str = "whatever their order (in pbrt-v3 that depends on its tree)";

/// Warns of each light that is where another one is and emits to the same side, of which the renderer shows the brighter one,
/// and of each other surface that is where one of another material is: the one that reflects more is seen.
pub(super) fn warn_of_twins(shapes: &[Shape], materials: &[Material], places: &[Pos], log: &mut Log) {
    let mut sizes: HashMap<usize, u32> = HashMap::new();
    for shape in shapes {
        *sizes.entry(triangles(shape)).or_default() += 1;
    }
    let mut lights: HashMap<[u64; 2], &str> = HashMap::new();
    let mut surfaces: HashMap<[u64; 2], Option<&Material>> = HashMap::new();
    for (shape, at) in shapes.iter().zip(places) {
        // To look at each triangle of a large mesh takes a while.
        if sizes.get(&triangles(shape)) == Some(&1) {
            continue;
        }
        if let Some(light) = &shape.light {
            let Some(twin) = lights.insert(place(shape, true), &light.name) else { continue };
            log.warn(*at, format!("{} is where {twin} is: the brighter one is seen, {IN_PBRT}", light.name));
        } else {
            let material = shape.material.and_then(|index| materials.get(index));
            let Some(twin) = surfaces.insert(place(shape, false), material) else { continue };
            if material.map(|material| &material.bsdf) != twin.map(|twin| &twin.bsdf) {
                let [this, twin] = [material, twin].map(|m| m.map_or("no material", |m| &m.name));
                let message =
                    format!("this surface of {this} is where one of {twin} is: the one that reflects more is seen");
                log.warn(*at, format!("{message}, {IN_PBRT}"));
            }
        }
    }
}

fn triangles(shape: &Shape) -> usize {
    match &shape.geometry {
        Geometry::Sphere { .. } => 0,
        Geometry::Mesh { positions: _, triangles } => triangles.len(),
    }
}

/// The same for the same surface, in whatever order its triangles and their corners are listed; `sided`: if it faces the
/// same way.
fn place(shape: &Shape, sided: bool) -> [u64; 2] {
    let numbers = |v: Vec3| (v + 0.0).to_array().map(f32::to_bits);
    match &shape.geometry {
        Geometry::Sphere { center, radius } => {
            [hash((numbers(*center), radius.to_bits())), u64::from(sided && shape.reverse_orientation)]
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
                if !sided {
                    corners.sort_unstable();
                }
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
