//! Shapes, moved to world space, and their emission.

use std::cmp::Ordering;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DMat3, DMat4, DVec3, Vec3};
use mislab_kernel::request::scene::{Camera, Geometry, Shape};

use super::limits::{MAX_TRIANGLES, MAX_VERTICES};
use super::log::{Log, Pos, shown};
use super::params::{At, Params};
use super::parser::Folders;
use super::ply::{self, Ply};
use super::transform::{swaps_handedness, uniform_scale};
use crate::error::Error;
use crate::near::suggestion;

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
    pub is_light: bool,
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
        "sphere" => sphere(&mut params, at, place, log)?,
        "trianglemesh" => {
            let Some(points) = params.points("P", log)? else {
                return Err(log.error(at, "trianglemesh without \"point P\", its vertices"));
            };
            let Some(triangles) = params.triangles("indices", points.len(), log)? else {
                return Err(log.error(at, "trianglemesh without \"integer indices\", three for each triangle"));
            };
            let normals = params.normals("N", points.len(), log)?;
            mesh(Mesh { points, normals, triangles }, at, place, log)?
        }
        "plymesh" => {
            let Some(At { value: name, at }) = params.text("filename", log)? else {
                return Err(log.error(at, "plymesh without \"string filename\""));
            };
            let read = place.folders.find(&name, at, log).and_then(|path| ply::read(&path));
            let Ply { points, normals, no_normal, triangles } =
                read.map_err(|message| log.error(at, format!("plymesh: {message}")))?;
            if let Some(vertex) = no_normal {
                let message = format!("plymesh {}: the normal of vertex {vertex} is no number", shown(&name));
                let instead = "all normals are left out, the order of the vertices decides which side is in front";
                log.warn(at, format!("{message}; {instead}"));
            }
            mesh(Mesh { points, normals, triangles }, at, place, log)?
        }
        _ => {
            let guess = suggestion(kind, &["sphere", "trianglemesh", "plymesh"]);
            let expected = "expected sphere, trianglemesh or plymesh";
            let message = format!("Shape {} is not supported, {expected}{guess}; it is left out", shown(kind));
            log.warn_once(&format!("shape {kind}"), at, message);
            params.forget();
            return Ok(None);
        }
    };
    params.finish(log);
    Ok(surface)
}

fn sphere(params: &mut Params, at: Pos, place: &Placement<'_>, log: &mut Log) -> Result<Option<Surface>, Error> {
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
        let rings = if place.is_light { LIGHT_RINGS } else { RINGS };
        let ellipsoid = ellipsoid(radius, rings);
        let message = format!(
            "sphere under a transformation that is not uniform: the ellipsoid is made of {} triangles",
            ellipsoid.triangles.len()
        );
        log.warn(at, message);
        return mesh(ellipsoid, at, place, log);
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
    Ok(Some(Surface { geometry: Geometry::Sphere { center, radius }, reverse_orientation: place.reverse }))
}

/// Rings of triangles of an ellipsoid, and of one that is a light: each triangle is a light to choose from.
const RINGS: u32 = 96;
const LIGHT_RINGS: u32 = 12;

/// A sphere about the origin as a mesh whose triangles face outwards. It has the area of the sphere, which is what a light's
/// power goes by.
fn ellipsoid(radius: f64, rings: u32) -> Mesh {
    let columns = 2 * rings;
    let point = |ring: u32, column: u32| {
        let (sin, cos) = (f64::from(ring) / f64::from(rings) * PI).sin_cos();
        let (y, x) = (f64::from(column) / f64::from(columns) * TAU).sin_cos();
        DVec3::new(sin * x, sin * y, cos)
    };
    let mut points: Vec<DVec3> =
        (0..=rings).flat_map(|ring| (0..columns).map(move |column| (ring, column))).map(|(r, c)| point(r, c)).collect();
    let mut triangles = Vec::new();
    for ring in 0..rings {
        for column in 0..columns {
            let at = |ring: u32, column: u32| ring * columns + column % columns;
            let [a, b] = [at(ring, column), at(ring, column + 1)];
            let [c, d] = [at(ring + 1, column), at(ring + 1, column + 1)];
            // At the poles one of the two has no area.
            triangles.extend((ring > 0).then_some([a, c, b]));
            triangles.extend((ring + 1 < rings).then_some([b, c, d]));
        }
    }
    let corners = |t: &[u32; 3]| t.map(|i| points[i as usize]);
    let area: f64 = triangles.iter().map(corners).map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum();
    let size = radius * (4.0 * PI / area).sqrt();
    points.iter_mut().for_each(|p| *p *= size);
    Mesh { points, normals: None, triangles }
}

/// A mesh in object space.
struct Mesh {
    points: Vec<DVec3>,
    /// One for each point.
    normals: Option<Vec<DVec3>>,
    triangles: Vec<[u32; 3]>,
}

fn mesh(mesh: Mesh, at: Pos, place: &Placement<'_>, log: &mut Log) -> Result<Option<Surface>, Error> {
    let Mesh { points, normals, triangles } = mesh;
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
    let mut triangles: Vec<[u32; 3]> = triangles.into_iter().filter(|t| has_area(&positions, *t)).collect();
    if triangles.len() < count {
        log.warn(at, format!("{} of {count} triangles have no area and are left out", count - triangles.len()));
    }
    if triangles.is_empty() {
        log.warn(at, "mesh without triangles, left out");
        return Ok(None);
    }
    // The geometric normal is the cross product of edges in world space. A mirroring transformation
    // turns it against the mirrored object-space normal, so pbrt flips it back.
    let by_winding = place.reverse ^ swaps_handedness(place.world_from_object);
    let reverse_orientation = match normals {
        None => by_winding,
        Some(normals) => face_normals(&positions, &normals, &mut triangles, by_winding, place.world_from_object),
    };
    let geometry = Geometry::Mesh { positions: Arc::new(positions), triangles: Arc::new(triangles) };
    Ok(Some(Surface { geometry, reverse_orientation }))
}

/// Turns triangles so that they face as the normals at their vertices do, and says whether all of them are to be taken the
/// other way round. As in pbrt-v3's light samples, normals leave nothing to say for the order of the vertices and
/// `ReverseOrientation`, unless they lie in the triangle's plane or cancel out (`by_winding`).
fn face_normals(
    positions: &[Vec3],
    normals: &[DVec3],
    triangles: &mut [[u32; 3]],
    by_winding: bool,
    world_from_object: &DMat4,
) -> bool {
    // Normals stay perpendicular to surfaces, also under mirroring and uneven scales.
    let to_world = DMat3::from_mat4(*world_from_object).inverse().transpose();
    let is_behind = |[a, b, c]: [u32; 3]| {
        let shading = to_world * (normals[a as usize] + normals[b as usize] + normals[c as usize]);
        let side = cross(positions, [a, b, c]).dot(shading);
        match side.partial_cmp(&0.0) {
            Some(Ordering::Less) => true,
            Some(Ordering::Greater) => false,
            Some(Ordering::Equal) | None => by_winding,
        }
    };
    if triangles.iter().all(|t| is_behind(*t)) {
        return true;
    }
    for triangle in triangles {
        if is_behind(*triangle) {
            triangle.swap(1, 2);
        }
    }
    false
}

/// A normal can be computed and is a direction.
fn has_area(positions: &[Vec3], triangle: [u32; 3]) -> bool {
    cross(positions, triangle).length_squared() > 0.0
}

/// The normal of a triangle, twice its area long. In double precision: the square of a tiny area must not vanish.
fn cross(positions: &[Vec3], [a, b, c]: [u32; 3]) -> DVec3 {
    let [a, b, c] = [a, b, c].map(|i| positions[i as usize].as_dvec3());
    (b - a).cross(c - a)
}

fn world_point(world_from_object: &DMat4, p: DVec3, at: Pos, log: &Log) -> Result<Vec3, Error> {
    let world = world_from_object.transform_point3(p).as_vec3();
    if world.abs().max_element() <= MAX_LENGTH && world.is_finite() {
        return Ok(world);
    }
    Err(log.error(at, format!("point {world} in world space, expected numbers of at most {MAX_LENGTH:e}")))
}

/// The least angle, in radians, that the radius of a sphere light may fill as seen from the eye. Directions are known to
/// 6e-8: of those drawn towards a light of this size 2 in 10 000 miss it by rounding.
const LEAST_ANGLE: f64 = 5e-5;

/// Gives a sphere light that is too small to aim at in single precision a larger radius and the same power, which is seen in
/// no pixel: the irradiance from a sphere, `pi L (r / d)^2 cos`, depends on its power alone.
pub(super) fn enlarge(shape: &mut Shape, camera: &Camera, at: Pos, log: &mut Log) {
    let (Geometry::Sphere { center, radius }, Some(light)) = (&mut shape.geometry, &mut shape.light) else { return };
    let distance = (center.as_dvec3() - camera.world_from_camera.w_axis.truncate()).length();
    let least = (LEAST_ANGLE * distance) as f32;
    if *radius >= least {
        return;
    }
    let message = format!(
        "sphere light of radius {radius:e}, {distance:.4} from the eye: single precision cannot aim at less than {least:.2e}, \
         which it is given with the same power"
    );
    log.warn(at, message);
    let shrunk = (f64::from(*radius) / f64::from(least)).powi(2);
    (*radius, light.radiance) = (least, (light.radiance.as_dvec3() * shrunk).as_vec3());
}

/// The radiance of an `AreaLightSource`; `None` (with a warning) if its type is unknown.
pub(super) fn read_area_light(kind: &str, mut params: Params, at: Pos, log: &mut Log) -> Result<Option<Vec3>, Error> {
    if kind != "diffuse" && kind != "area" {
        log.warn(at, format!("AreaLightSource {} is not supported, expected diffuse; it is left out", shown(kind)));
        params.forget();
        return Ok(None);
    }
    let l = params.rgb("L", log)?.map_or(Vec3::ONE, |v| v.value);
    let scale = if params.kind("scale") == Some("float") {
        log.found_v4();
        log.warn_dialect(at, "\"float scale\" is pbrt-v4's; L is multiplied by it", "\"float scale\" as a factor of L");
        params.float("scale", log)?.map_or(Vec3::ONE, |v| Vec3::splat(v.value.max(0.0) as f32))
    } else {
        params.rgb("scale", log)?.map_or(Vec3::ONE, |v| v.value)
    };
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
