//! Shapes, moved to world space, and their emission.

use std::sync::Arc;

use glam::{DMat4, DVec3, Vec3};
use mislab_kernel::request::scene::Geometry;

use super::limits::{MAX_TRIANGLES, MAX_VERTICES};
use super::log::{Log, Pos, shown};
use super::params::{At, Params};
use super::parser::Folders;
use super::ply;
use super::transform::{swaps_handedness, uniform_scale};
use crate::error::Error;

/// Largest coordinate or radius: what the renderer multiplies them to must stay finite.
const MAX_LENGTH: f32 = 1e15;
/// Smallest radius, by the same token.
const MIN_RADIUS: f32 = 1e-15;

/// A surface in world space and [`crate::Shape::reverse_orientation`] for it.
pub(super) struct Surface {
    pub geometry: Geometry,
    pub reverse_orientation: bool,
}

/// Where a shape is and which way its normals point.
pub(super) struct Placement<'a> {
    pub world_from_object: &'a DMat4,
    /// pbrt's `ReverseOrientation`.
    pub reverse: bool,
    pub folders: &'a Folders,
}

/// The surface of a `Shape`; `None` (with a warning) if its type is unknown or nothing is left of it.
pub(super) fn read_shape(
    kind: &str,
    mut params: Params,
    at: Pos,
    place: &Placement<'_>,
    log: &mut Log,
) -> Result<Option<Surface>, Error> {
    let surface = match kind {
        "sphere" => Some(sphere(&mut params, at, place, log)?),
        "trianglemesh" => {
            let Some(points) = params.points("P", log)? else {
                return Err(log.error(at, "trianglemesh without \"point P\", its vertices"));
            };
            let Some(triangles) = params.triangles("indices", points.len(), log)? else {
                return Err(log.error(at, "trianglemesh without \"integer indices\", three for each triangle"));
            };
            mesh(points, triangles, at, place, log)?
        }
        "plymesh" => {
            let Some(At { value: name, at }) = params.text("filename", log)? else {
                return Err(log.error(at, "plymesh without \"string filename\""));
            };
            let ply = place
                .folders
                .find(&name, log)
                .and_then(|path| ply::read(&path))
                .map_err(|message| log.error(at, format!("plymesh: {message}")))?;
            mesh(ply.points, ply.triangles, at, place, log)?
        }
        _ => {
            let message = format!(
                "Shape {} is not supported, expected sphere, trianglemesh or plymesh; it is left out",
                shown(kind)
            );
            log.warn_once(&format!("shape {kind}"), at, message);
            params.forget();
            return Ok(None);
        }
    };
    params.finish(log);
    Ok(surface)
}

fn sphere(params: &mut Params, at: Pos, place: &Placement<'_>, log: &mut Log) -> Result<Surface, Error> {
    let At { value: radius, at: radius_at } = params.float("radius", log)?.unwrap_or(At { value: 1.0, at });
    if radius <= 0.0 {
        return Err(log.error(radius_at, format!("sphere of radius {radius}, expected a number above 0")));
    }
    let part = [
        params.float("zmin", log)?.filter(|z| z.value > -radius),
        params.float("zmax", log)?.filter(|z| z.value < radius),
        params.float("phimax", log)?.filter(|phi| phi.value < 360.0),
    ];
    if let Some(cut) = part.into_iter().flatten().next() {
        log.warn(cut.at, "part of a sphere (zmin, zmax, phimax): the whole sphere is used");
    }
    let Some(scale) = uniform_scale(place.world_from_object) else {
        return Err(log.error(
            at,
            "sphere under a transformation that is not uniform, expected the same scale in all directions and no shear",
        ));
    };
    let center = world_point(place.world_from_object, DVec3::ZERO, at, log)?;
    let radius = (radius * scale) as f32;
    if !(MIN_RADIUS..=MAX_LENGTH).contains(&radius) {
        let message = format!("sphere of radius {radius:e} in world space, expected {MIN_RADIUS:e} to {MAX_LENGTH:e}");
        return Err(log.error(at, message));
    }
    // The normal of a sphere is outward whatever the transformation: pbrt's flip for mirroring ones
    // undoes the flip that mirrored tangents bring. (Intersections of pbrt-v3 flip once too often
    // there, against its own light sampling; the sampling is what is meant.)
    Ok(Surface { geometry: Geometry::Sphere { center, radius }, reverse_orientation: place.reverse })
}

fn mesh(
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    at: Pos,
    place: &Placement<'_>,
    log: &mut Log,
) -> Result<Option<Surface>, Error> {
    if points.len() > MAX_VERTICES || triangles.len() > MAX_TRIANGLES {
        let message = format!(
            "mesh of {} vertices and {} triangles, expected at most {MAX_VERTICES} and {MAX_TRIANGLES}",
            points.len(),
            triangles.len()
        );
        return Err(log.error(at, message));
    }
    let mut positions = Vec::with_capacity(points.len());
    for p in points {
        positions.push(world_point(place.world_from_object, p, at, log)?);
    }
    let count = triangles.len();
    let triangles: Vec<[u32; 3]> = triangles.into_iter().filter(|t| has_area(&positions, *t)).collect();
    if triangles.len() < count {
        log.warn(at, format!("{} of {count} triangles have no area and are left out", count - triangles.len()));
    }
    if triangles.is_empty() {
        log.warn(at, "mesh without triangles, left out");
        return Ok(None);
    }
    // The geometric normal is the cross product of edges in world space. A mirroring transformation
    // turns it against the mirrored object-space normal, so pbrt flips it back.
    let reverse_orientation = place.reverse ^ swaps_handedness(place.world_from_object);
    let geometry = Geometry::Mesh { positions: Arc::new(positions), triangles: Arc::new(triangles) };
    Ok(Some(Surface { geometry, reverse_orientation }))
}

/// A normal can be computed and is a direction.
fn has_area(positions: &[Vec3], [a, b, c]: [u32; 3]) -> bool {
    let [a, b, c] = [a, b, c].map(|i| positions[i as usize].as_dvec3());
    // In double precision: the square of a tiny area must not vanish.
    (b - a).cross(c - a).length_squared() > 0.0
}

fn world_point(world_from_object: &DMat4, p: DVec3, at: Pos, log: &Log) -> Result<Vec3, Error> {
    let world = world_from_object.transform_point3(p).as_vec3();
    if world.abs().max_element() <= MAX_LENGTH && world.is_finite() {
        return Ok(world);
    }
    Err(log.error(at, format!("point {world} in world space, expected numbers of at most {MAX_LENGTH:e}")))
}

/// The radiance of an `AreaLightSource`; `None` (with a warning) if its type is unknown.
pub(super) fn read_area_light(kind: &str, mut params: Params, at: Pos, log: &mut Log) -> Result<Option<Vec3>, Error> {
    if kind != "diffuse" && kind != "area" {
        log.warn(at, format!("AreaLightSource {} is not supported, expected diffuse; it is left out", shown(kind)));
        params.forget();
        return Ok(None);
    }
    let l = params.rgb("L", log)?.map_or(Vec3::ONE, |v| v.value);
    let scale = params.rgb("scale", log)?.map_or(Vec3::ONE, |v| v.value);
    let radiance = l * scale;
    if !radiance.is_finite() {
        return Err(log.error(at, "L times scale is too large"));
    }
    if params.boolean("twosided", log)? == Some(true) {
        log.warn(at, "twosided is not used: area lights emit along the normal only");
    }
    params.finish(log);
    Ok(Some(radiance))
}
