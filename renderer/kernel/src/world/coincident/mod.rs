//! Surfaces where another one is, such as a lamp in the plane of a ceiling, or one listed twice. Which of the two a ray
//! hits first would be a matter of rounding or of their order in the file, another one for camera rays and for shadow rays,
//! so it is decided once, for all rays and by value:
//!
//! - A flat light is raised a little above the surface, on the side that it emits from. Seen from behind, the surface is there.
//! - Of two lights that emit to the same side the brighter is in front; of equally bright ones the one that reflects more.
//!   Where they are in the same place to the last bit the other, which nothing could see, is left out; else the brighter is
//!   raised above it.
//! - Two lights back to back are one that emits to both sides.
//! - A sphere in the place of a sphere light is left out.
//! - Of surfaces that do not emit the one that reflects more is in front, seen from either side (`surfaces.rs`).
//!
//! (pbrt-v3 takes for coincident surfaces the one that its tree tests last, and adds both lights up in light samples.)

mod surfaces;

use std::cmp::Ordering;
use std::collections::{HashMap, HashSet};

use glam::{DVec3, Vec3};

use super::Opaque;
use crate::bsdf::BuiltMaterial;
use crate::geometry::BuiltGeometry;
use crate::geometry::list::List;
use crate::geometry::shape::{Ball, Facet};
use crate::lanes::{Single, V3};
use crate::light::{BuiltLight, LightShape};
use crate::request::scene;
use crate::stop::{Stop, Stopped};
pub(super) use surfaces::{Fronts, Shared};

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
/// Most lights that are raised above each other in one place.
const MOST_LEVELS: u32 = 16;
/// Most questions whether a light's point lies on a facet of another light, all lights together; what is left over in a
/// scene of very many stays as it is.
const PAIRS: usize = 1 << 20;

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
    opaque.retain(|opaque| match opaque.shape.geometry {
        scene::Geometry::Sphere { center, radius } => !balls.contains(&key(center, radius)),
        scene::Geometry::Mesh { .. } => true,
    });
}

/// Leaves out the lights that another one, as bright or brighter, hides wholly: it has the same corners and emits to the same
/// side.
///
/// # Errors
/// If it is stopped.
pub(super) fn drop_dimmer(lights: &mut Vec<BuiltLight>, stop: Stop<'_>) -> Result<(), Stopped> {
    let mut brightest: HashMap<[u32; 13], usize> = HashMap::with_capacity(lights.len());
    for (i, light) in lights.iter().enumerate() {
        stop.check_in_turn(i)?;
        let best = brightest.entry(place(&light.shape)).or_insert(i);
        if by_brightness(&lights[*best], light) == Ordering::Less {
            *best = i;
        }
    }
    if brightest.len() < lights.len() {
        let kept: HashSet<usize> = brightest.into_values().collect();
        let mut number = 0..;
        lights.retain(|_| number.next().is_some_and(|i| kept.contains(&i)));
    }
    Ok(())
}

/// Where a light is and which side it emits to, whatever the order of its corners.
fn place(shape: &LightShape) -> [u32; 13] {
    let mut key = [0; 13];
    match shape {
        LightShape::Ball(Ball { center, radius, inward, shape: _ }) => {
            for (bits, v) in key.iter_mut().zip([center.x, center.y, center.z, *radius]) {
                *bits = (v + 0.0).to_bits();
            }
            // No facet has this side.
            key[12] = 2 + u32::from(*inward);
        }
        LightShape::Facet(facet) => {
            // + 0.0: -0 is no other place.
            let mut corners: Vec<Vec3> = facet.corners().map(|p| p + 0.0).collect();
            corners.sort_by(|a, b| by_value(*a, *b));
            for (bits, v) in key.iter_mut().zip(corners.iter().flat_map(Vec3::to_array)) {
                *bits = v.to_bits();
            }
            let [a, b, c] = [0, 1, 2].map(|i| corners[i].as_dvec3());
            key[12] = u32::from((b - a).cross(c - a).dot(facet.normal.as_dvec3()) > 0.0);
        }
    }
    key
}

fn by_value(a: Vec3, b: Vec3) -> Ordering {
    a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z))
}

/// By luminance (Rec. 709), and by red, green and blue where that is equal: a rule that does not depend on any order.
fn by_colour(a: Vec3, b: Vec3) -> Ordering {
    let luminance = |colour: Vec3| colour.as_dvec3().dot(DVec3::new(0.2126, 0.7152, 0.0722));
    luminance(a).total_cmp(&luminance(b)).then(by_value(a, b))
}

/// By what they emit, and by what they reflect where that is equal.
fn by_brightness(a: &BuiltLight, b: &BuiltLight) -> Ordering {
    by_colour(a.radiance, b.radiance).then_with(|| by_reflectance(&a.material, &b.material))
}

/// By what they reflect at normal incidence, and by all their numbers where that is equal.
fn by_reflectance(a: &BuiltMaterial, b: &BuiltMaterial) -> Ordering {
    let numbers = |material: &BuiltMaterial| material.numbers().map(|v| v + 0.0);
    let all = || numbers(a).iter().zip(&numbers(b)).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne());
    by_colour(a.at_normal_incidence(), b.at_normal_incidence()).then_with(|| all().unwrap_or(Ordering::Equal))
}

/// Raises the flat lights of each shape of which one lies in the plane of a surface right where it is, or of a light that is
/// less bright or emits to the other side; and makes a sphere that emits outwards so much larger than one in its place that
/// emits inwards. `epsilon` is what shadow rays keep off.
pub(super) fn raise(lights: &mut [BuiltLight], geometry: &BuiltGeometry, epsilon: f32) {
    grow_outward_balls(lights, epsilon);
    let facets = lights.iter().filter(|light| facet(light).is_some()).count();
    if facets == 0 {
        return;
    }
    let in_row = (QUESTIONS / facets).isqrt().clamp(1, MOST_IN_ROW);
    let every = facets.div_ceil(QUESTIONS);
    let everything = List::all(geometry.len());
    let on_surface = |light: &BuiltLight| {
        facet(light).is_some_and(|facet| lies_on_surface(facet, geometry, &everything, epsilon, in_row))
    };
    let same_shape = |a: &BuiltLight, b: &BuiltLight| facet(a).zip(facet(b)).is_some_and(|(a, b)| a.shape == b.shape);
    let sheets: Vec<&[BuiltLight]> = lights.chunk_by(same_shape).filter(|sheet| facet(&sheet[0]).is_some()).collect();
    let mut levels: Vec<u32> = sheets
        .iter()
        .map(|sheet| u32::from(!geometry.is_empty() && sheet.iter().step_by(every).any(on_surface)))
        .collect();
    stack(&sheets, &mut levels, epsilon);
    let sheets = lights.chunk_by_mut(same_shape).filter(|sheet| facet(&sheet[0]).is_some());
    for (sheet, level) in sheets.zip(levels) {
        for light in sheet {
            if let LightShape::Facet(facet) = &mut light.shape {
                facet.p0 += facet.normal * (level as f32 * RAISE * epsilon);
            }
        }
    }
}

fn grow_outward_balls(lights: &mut [BuiltLight], epsilon: f32) {
    let key = |ball: &Ball| [ball.center.x, ball.center.y, ball.center.z, ball.radius].map(f32::to_bits);
    let ball = |light: &BuiltLight| match light.shape {
        LightShape::Ball(ball) => Some(ball),
        LightShape::Facet(_) => None,
    };
    let inward: HashSet<_> = lights.iter().filter_map(ball).filter(|ball| ball.inward).map(|ball| key(&ball)).collect();
    for light in lights {
        if let LightShape::Ball(ball) = &mut light.shape
            && !ball.inward
            && inward.contains(&key(ball))
        {
            ball.radius += RAISE * epsilon;
        }
    }
}

/// Lifts each of the lights above those that it coincides with and that are less bright or emit to the other side.
fn stack(sheets: &[&[BuiltLight]], levels: &mut [u32], epsilon: f32) {
    let boxes: Vec<(Vec3, Vec3)> = sheets.iter().map(|sheet| sheet_box(sheet, SAME * epsilon)).collect();
    let mut pairs = overlapping(&boxes);
    // From the dimmest up, so that what is below has its level already; then by shape.
    let rank = {
        let mut order: Vec<usize> = (0..sheets.len()).collect();
        order.sort_by(|&a, &b| by_brightness(&sheets[a][0], &sheets[b][0]));
        let mut rank = vec![0; sheets.len()];
        order.iter().enumerate().for_each(|(place, &sheet)| rank[sheet] = place);
        rank
    };
    for pair in &mut pairs {
        pair.sort_unstable_by_key(|&sheet| rank[sheet]);
    }
    pairs.sort_unstable_by_key(|&[below, above]| (rank[above], rank[below]));
    let mut left = PAIRS;
    for [below, above] in pairs {
        let Some(side) = meet(sheets[below], sheets[above], epsilon, &mut left) else { continue };
        let alike = side == Side::Same && by_brightness(&sheets[below][0], &sheets[above][0]) == Ordering::Equal;
        let least = if alike { levels[below] } else { levels[below] + 1 };
        levels[above] = levels[above].max(least).min(MOST_LEVELS);
    }
}

/// A box around lights that form one shape.
fn sheet_box(sheet: &[BuiltLight], margin: f32) -> (Vec3, Vec3) {
    let corners = sheet.iter().filter_map(facet).flat_map(Facet::corners);
    let (min, max) = corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)));
    (min - margin, max + margin)
}

/// The pairs of boxes that overlap, at most about [`PAIRS`] of them looked at: along the first axis each is compared with
/// those that begin before it ends.
fn overlapping(boxes: &[(Vec3, Vec3)]) -> Vec<[usize; 2]> {
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    order.sort_by(|&a, &b| boxes[a].0.x.total_cmp(&boxes[b].0.x));
    let candidates = order.iter().enumerate().flat_map(|(i, &a)| {
        order[i + 1..].iter().take_while(move |&&b| boxes[b].0.x <= boxes[a].1.x).map(move |&b| [a, b])
    });
    let overlap = |[a, b]: &[usize; 2]| boxes[*a].0.cmple(boxes[*b].1).all() && boxes[*b].0.cmple(boxes[*a].1).all();
    candidates.take(PAIRS).filter(overlap).collect()
}

/// Which way two lights in one place face.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Same,
    Opposite,
}

/// How two lights lie on each other, if they do: if a point of one of them lies on the other. `left` questions are left.
fn meet(a: &[BuiltLight], b: &[BuiltLight], epsilon: f32, left: &mut usize) -> Option<Side> {
    lies_on(a, b, epsilon, left).or_else(|| lies_on(b, a, epsilon, left))
}

fn lies_on(upper: &[BuiltLight], lower: &[BuiltLight], epsilon: f32, left: &mut usize) -> Option<Side> {
    /// Points of a light.
    const POINTS: usize = 1 << 8;
    let in_row = (POINTS / upper.len()).isqrt().clamp(1, MOST_IN_ROW);
    for upper in upper.iter().step_by(upper.len().div_ceil(POINTS)).filter_map(facet) {
        let down = V3::splat(Single, -upper.normal);
        for lower in lower.iter().filter_map(facet) {
            *left = left.checked_sub(in_row * in_row)?;
            let hits = grid(upper, in_row).any(|point| {
                let from = V3::splat(Single, point + upper.normal * (ABOVE * epsilon));
                let (distance, inside) = lower.intersect(Single, from, down);
                inside && (distance - ABOVE * epsilon).abs() <= SAME * epsilon
            });
            if hits {
                let same = upper.normal.dot(lower.normal) > 0.0;
                return Some(if same { Side::Same } else { Side::Opposite });
            }
        }
    }
    None
}

fn facet(light: &BuiltLight) -> Option<&Facet> {
    match &light.shape {
        LightShape::Facet(facet) => Some(facet),
        LightShape::Ball(_) => None,
    }
}

/// True if a ray down to a point of the facet, of a grid of `in_row` in a row, hits something else there.
fn lies_on_surface(facet: &Facet, geometry: &BuiltGeometry, list: &List, epsilon: f32, in_row: usize) -> bool {
    let down = V3::splat(Single, -facet.normal);
    grid(facet, in_row).any(|point| {
        let from = V3::splat(Single, point + facet.normal * (ABOVE * epsilon));
        let distance = geometry.nearest(Single, from, down, list).t;
        (distance - ABOVE * epsilon).abs() <= SAME * epsilon
    })
}

/// Points of a facet, `in_row` in a row.
fn grid(facet: &Facet, in_row: usize) -> impl Iterator<Item = Vec3> {
    let at = move |i: usize| (i as f32 + 0.5) / in_row as f32;
    let Facet { p0, e1, e2, quad, .. } = *facet;
    (0..in_row * in_row).map(move |k| {
        let (mut u, mut v) = (at(k / in_row), at(k % in_row));
        if !quad && u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        p0 + e1 * u + e2 * v
    })
}
