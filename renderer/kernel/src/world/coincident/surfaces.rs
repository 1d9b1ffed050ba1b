//! Surfaces in one place that are no lights, such as a mesh listed twice, with other materials, or a rug in the plane of a
//! floor.
//!
//! Where a ray hits the nearest of them is as it is; which of them it is there is asked again, for camera rays alone: no
//! other ray asks what a surface is made of, and whatever lies in one plane blocks the same.

use std::cmp::{Ordering, Reverse};

use glam::{DVec3, Vec3};

use super::{SAME, by_reflectance, by_value, overlapping};
use crate::bsdf::BuiltMaterial;
use crate::geometry::BuiltGeometry;
use crate::geometry::shape::{Ball, Facet};
use crate::lanes::{Single, V3};
use crate::stop::{Stop, Stopped};

/// Most primitives that are looked at, the largest ones; what is left over in a scene of very many stays as it is.
const MOST: usize = 1 << 20;
/// And most of them that are compared with others of which they share only a part.
const MOST_OVERLAPS: usize = 1 << 12;

/// Which primitives share a place with others of another shape: a matter of shapes alone.
#[derive(Debug, Default)]
pub(in crate::world) struct Shared {
    /// Primitives in the same place, alone where it only overlaps with others.
    places: Vec<Vec<u32>>,
    /// Places in one plane that overlap.
    overlaps: Vec<[usize; 2]>,
}

impl Shared {
    /// Those of `geometry` that lie within about `epsilon` of each other.
    ///
    /// # Errors
    /// If it is stopped.
    pub(in crate::world) fn find(geometry: &BuiltGeometry, epsilon: f32, stop: Stop<'_>) -> Result<Self, Stopped> {
        let ids = 0..geometry.len() as u32;
        if !several_shapes(geometry, ids) {
            return Ok(Self::default());
        }
        let placed = by_place(geometry, stop)?;
        let mut places: Vec<&[Placed]> = placed.chunk_by(|a, b| a.place == b.place).collect();
        places.sort_unstable_by_key(|place| (Reverse(place[0].area), place[0].place));
        let overlaps = overlaps(geometry, &places, epsilon);
        let mut shares: Vec<bool> = places.iter().map(|place| several_shapes(geometry, ids_of(place))).collect();
        overlaps.iter().flatten().for_each(|&place| shares[place] = true);
        // Numbered anew without those that share nothing.
        let numbers: Vec<usize> = shares
            .iter()
            .scan(0, |next, shares| {
                let number = *next;
                *next += usize::from(*shares);
                Some(number)
            })
            .collect();
        let overlaps = overlaps.iter().map(|pair| pair.map(|place| numbers[place])).collect();
        let shared = places.iter().zip(&shares).filter(|(_, shares)| **shares);
        Ok(Self { places: shared.map(|(place, _)| ids_of(place).collect()).collect(), overlaps })
    }

    /// The primitives that share a place.
    pub(in crate::world) fn primitives(&self) -> impl Iterator<Item = u32> {
        self.places.iter().flatten().copied()
    }
}

/// A primitive and where it is.
struct Placed {
    /// About its area, as bits: those of numbers that are not negative are in order.
    area: u32,
    /// The same for those in the same place.
    place: u64,
    id: u32,
}

/// The largest [`MOST`] primitives, by place.
fn by_place(geometry: &BuiltGeometry, stop: Stop<'_>) -> Result<Vec<Placed>, Stopped> {
    let mut placed = Vec::with_capacity(geometry.len());
    for id in 0..geometry.len() as u32 {
        stop.check_in_turn(id as usize)?;
        let (area, place) = match primitive(geometry, id) {
            Primitive::Facet(facet) => (facet.area, hash(facet.corners())),
            Primitive::Ball(Ball { center, radius, .. }) => {
                (radius * radius, hash([*center, Vec3::splat(*radius)].into_iter()))
            }
        };
        placed.push(Placed { area: area.to_bits(), place, id });
    }
    if placed.len() > MOST {
        placed.select_nth_unstable_by_key(MOST, |primitive| Reverse(primitive.area));
        placed.truncate(MOST);
    }
    stop.check()?;
    placed.sort_unstable_by_key(|primitive| (primitive.place, primitive.id));
    stop.check()?;
    Ok(placed)
}

fn ids_of(place: &[Placed]) -> impl Iterator<Item = u32> {
    place.iter().map(|primitive| primitive.id)
}

enum Primitive<'a> {
    Facet(&'a Facet),
    Ball(&'a Ball),
}

fn primitive(geometry: &BuiltGeometry, id: u32) -> Primitive<'_> {
    let facets = &geometry.facets;
    match facets.get(id as usize) {
        Some(facet) => Primitive::Facet(facet),
        None => Primitive::Ball(&geometry.balls[id as usize - facets.len()]),
    }
}

fn shape(geometry: &BuiltGeometry, id: u32) -> u32 {
    match primitive(geometry, id) {
        Primitive::Facet(facet) => facet.shape,
        Primitive::Ball(ball) => ball.shape,
    }
}

fn several_shapes(geometry: &BuiltGeometry, ids: impl Iterator<Item = u32>) -> bool {
    let mut shapes = ids.map(|id| shape(geometry, id));
    let first = shapes.next();
    shapes.any(|shape| Some(shape) != first)
}

/// A number for some points that does not depend on their order: other points have another one, but for once in 2^64 pairs.
fn hash(points: impl Iterator<Item = Vec3>) -> u64 {
    points.map(mixed).fold(0, u64::wrapping_add)
}

/// All bits of a point in all bits of a number (the end of SplitMix64, twice).
fn mixed(point: Vec3) -> u64 {
    // + 0.0: -0 is no other place.
    let [x, y, z] = (point + 0.0).to_array().map(|v| u64::from(v.to_bits()));
    let mix = |v: u64| {
        let v = (v ^ (v >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let v = (v ^ (v >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        v ^ (v >> 31)
    };
    mix(mix(x | y << 32).wrapping_add(z).wrapping_add(0x9e37_79b9_7f4a_7c15))
}

/// The pairs of places, of the first [`MOST_OVERLAPS`], that lie in one plane, overlap and are not all of one shape.
fn overlaps(geometry: &BuiltGeometry, places: &[&[Placed]], epsilon: f32) -> Vec<[usize; 2]> {
    let facet = |place: usize| geometry.facets.get(places[place][0].id as usize);
    let flat: Vec<usize> = (0..places.len().min(MOST_OVERLAPS)).filter(|&place| facet(place).is_some()).collect();
    let boxes: Vec<(Vec3, Vec3)> = flat
        .iter()
        .filter_map(|&place| facet(place))
        .map(|facet| {
            let corners = facet.corners();
            let (min, max) =
                corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)));
            (min - SAME * epsilon, max + SAME * epsilon)
        })
        .collect();
    let mut pairs = overlapping(&boxes);
    for pair in &mut pairs {
        *pair = pair.map(|i| flat[i]);
    }
    pairs.retain(|[a, b]| {
        let of_several = || several_shapes(geometry, ids_of(places[*a]).chain(ids_of(places[*b])));
        facet(*a).zip(facet(*b)).is_some_and(|(a, b)| overlap(a, b, f64::from(SAME * epsilon))) && of_several()
    });
    pairs
}

/// True if two facets lie in one plane, to within `margin`, and overlap by more than that.
fn overlap(a: &Facet, b: &Facet, margin: f64) -> bool {
    // The plane of the larger one is known better.
    let (large, small) = if a.area >= b.area { (a, b) } else { (b, a) };
    let (normal, p0) = (large.normal.as_dvec3(), large.p0.as_dvec3());
    if small.corners().any(|corner| normal.dot(corner.as_dvec3() - p0).abs() > margin) {
        return false;
    }
    let extent = |facet: &Facet, axis: DVec3| {
        let along = facet.corners().map(|corner| axis.dot(corner.as_dvec3() - p0));
        along.fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), v| (min.min(v), max.max(v)))
    };
    // Convex figures are apart if a line along one of their edges is between them.
    [large, small].into_iter().all(|facet| {
        let Facet { e1, e2, quad, .. } = *facet;
        let edges = [Some(e1), Some(e2), (!quad).then_some(e2 - e1)];
        edges.into_iter().flatten().all(|edge| {
            let axis = normal.cross(edge.as_dvec3()).normalize_or_zero();
            let ((a, b), (c, d)) = (extent(large, axis), extent(small, axis));
            b.min(d) - a.max(c) > margin
        })
    })
}

/// Which primitives are in front of others where they share a place, as their materials are.
#[derive(Debug, Default)]
pub(in crate::world) struct Fronts(
    /// A primitive, and one in front of it; sorted by the first, and of one the foremost first.
    Vec<[u32; 2]>,
);

impl Fronts {
    /// By what the shapes are made of, see [`by_reflectance`].
    pub(in crate::world) fn new(shared: &Shared, geometry: &BuiltGeometry, materials: &[BuiltMaterial]) -> Self {
        let by_material = |a: u32, b: u32| {
            let material = |id: u32| &materials[shape(geometry, id) as usize];
            by_reflectance(material(a), material(b))
        };
        // Of the same material the one whose numbers are larger, so that no order matters at all.
        let order = |a: &u32, b: &u32| by_material(*a, *b).then_with(|| by_numbers(geometry, *a, *b));
        let foremost = |place: &Vec<u32>| place.iter().copied().max_by(order);
        let best: Vec<Option<u32>> = shared.places.iter().map(foremost).collect();
        let mut rivals: Vec<Vec<u32>> = best.iter().map(|best| best.iter().copied().collect()).collect();
        for &[a, b] in &shared.overlaps {
            rivals[a].extend(best[b]);
            rivals[b].extend(best[a]);
        }
        let mut fronts = Vec::new();
        for (place, rivals) in shared.places.iter().zip(&mut rivals) {
            rivals.sort_unstable_by(|a, b| order(b, a));
            for &id in place {
                let in_front = rivals.iter().filter(|rival| by_material(**rival, id) == Ordering::Greater);
                fronts.extend(in_front.map(|rival| [id, *rival]));
            }
        }
        fronts.sort_by_key(|[id, _]| *id);
        Self(fronts)
    }

    /// True if nothing is in front of anything.
    #[inline(always)]
    pub(in crate::world) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// What is in front where a ray hits primitive `id`: another one that it hits there, or itself.
    pub(in crate::world) fn at(&self, geometry: &BuiltGeometry, id: u32, origin: Vec3, dir: Vec3) -> u32 {
        let first = self.0.partition_point(|[other, _]| *other < id);
        let hits = |front: u32| match primitive(geometry, front) {
            Primitive::Facet(facet) => facet.intersect(Single, V3::splat(Single, origin), V3::splat(Single, dir)).1,
            // Balls share all of their place.
            Primitive::Ball(_) => true,
        };
        let fronts = self.0[first..].iter().take_while(|[other, _]| *other == id);
        fronts.map(|[_, front]| *front).find(|&front| hits(front)).unwrap_or(id)
    }
}

fn by_numbers(geometry: &BuiltGeometry, a: u32, b: u32) -> Ordering {
    match (primitive(geometry, a), primitive(geometry, b)) {
        (Primitive::Facet(a), Primitive::Facet(b)) => {
            by_value(a.p0, b.p0).then_with(|| by_value(a.e1, b.e1)).then_with(|| by_value(a.e2, b.e2))
        }
        (Primitive::Ball(_), _) | (_, Primitive::Ball(_)) => Ordering::Equal,
    }
}
