//! From a scene's parameters to the form that packets of rays work on.

pub mod camera;
mod coincident;
pub mod culling;
pub mod projection;
mod view;

use std::sync::{Arc, OnceLock};

use glam::{DVec3, Vec3};

use crate::bsdf::BuiltMaterial;
use crate::geometry::shape::{Ball, Facet};
use crate::geometry::{BuiltGeometry, grid};
use crate::light::{BuiltLight, LightShape, Lights};
use crate::request::scene::{self, Scene};
use crate::request::{Invalid, Settings};
use crate::stop::{Stop, Stopped};
use camera::Pinhole;
use culling::{Culled, Patches};
pub use view::{CameraHit, View};

/// Most triangles of one scene, a guard against running out of memory.
pub const MAX_TRIANGLES: usize = 50_000_000;

/// A scene ready to be rendered at one resolution.
#[derive(Debug)]
pub struct BuiltScene {
    /// Where rays start.
    pub camera: Pinhole,
    /// Everything opaque that does not emit.
    pub geometry: Arc<BuiltGeometry>,
    /// What `geometry` was made from.
    opaque: Vec<Opaque>,
    /// Everything that emits.
    pub lights: Lights,
    /// Which of all these matter to a patch of the image.
    pub patches: Patches,
    /// The answers for all patches asked about so far, row by row.
    culled: Arc<Vec<OnceLock<Culled>>>,
    /// How many patches there are in a row.
    columns: usize,
    /// How far rays are kept off the surface they start from.
    pub epsilon: f32,
    /// By shape.
    materials: Vec<BuiltMaterial>,
    /// Some surface has two lobes to choose from.
    pub has_two_lobes: bool,
    /// Some light's surface scatters as well.
    lights_scatter: bool,
}

/// A shape of the scene as far as geometry is concerned.
#[derive(Clone, Debug)]
struct Opaque {
    index: usize,
    reverse_orientation: bool,
    geometry: scene::Geometry,
}

impl Opaque {
    /// True if the same primitives come of both.
    fn is(&self, other: &Self) -> bool {
        same_primitives(&self.geometry, &other.geometry)
            && self.index == other.index
            && self.reverse_orientation == other.reverse_orientation
    }
}

/// Why there is no built scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Unbuilt {
    /// It cannot be rendered.
    Invalid(Invalid),
    /// Nobody wants it any more.
    Stopped,
}

impl From<Invalid> for Unbuilt {
    fn from(invalid: Invalid) -> Self {
        Self::Invalid(invalid)
    }
}

impl From<Stopped> for Unbuilt {
    fn from(Stopped: Stopped) -> Self {
        Self::Stopped
    }
}

impl BuiltScene {
    /// Checks the scene and builds it.
    ///
    /// # Errors
    /// [`Invalid`] names the shape or material whose numbers cannot be rendered.
    pub fn new(scene: &Scene, settings: &Settings) -> Result<Self, Invalid> {
        Self::with_known(scene, settings, &[], Stop::NEVER).map_err(|unbuilt| match unbuilt {
            Unbuilt::Invalid(invalid) => invalid,
            Unbuilt::Stopped => unreachable!("nobody stops it"),
        })
    }

    /// The same, with geometry shared with one of these if it has just the same shapes: the tree over a
    /// large mesh takes a second, an edit of a material, a light or the camera should not. What patches see is shared, too,
    /// unless a shape, a light's shape or the camera changes.
    ///
    /// # Errors
    /// As [`Self::new`], or [`Unbuilt::Stopped`].
    pub fn with_known(
        scene: &Scene,
        settings: &Settings,
        known: &[Arc<Self>],
        stop: Stop<'_>,
    ) -> Result<Self, Unbuilt> {
        settings.check().map_err(Invalid)?;
        let camera = Pinhole::new(&scene.camera, settings.image.resolution)?;
        for material in &scene.materials {
            check_material(material)?;
        }
        let (mut opaque, mut lights) = (Vec::new(), Vec::new());
        let mut materials = Vec::with_capacity(scene.shapes.len());
        for (index, shape) in scene.shapes.iter().enumerate() {
            let material = match shape.material {
                None => BuiltMaterial::BLACK,
                Some(m) => BuiltMaterial::new(
                    &scene
                        .materials
                        .get(m)
                        .ok_or_else(|| {
                            Invalid(format!(
                                "shape {index} has material {m}, expected one of {}",
                                scene.materials.len()
                            ))
                        })?
                        .bsdf,
                ),
            };
            materials.push(material);
            let emits = emission(shape);
            if let Some(light) = emits
                && !(light.radiance.is_finite() && light.radiance.min_element() >= 0.0)
            {
                let message = "expected finite numbers >= 0";
                return Err(Invalid(format!("light {} has radiance {}, {message}", light.name, light.radiance)).into());
            }
            match emits {
                Some(light) => {
                    let (facets, ball) = primitives(index, &shape.geometry, shape.reverse_orientation, stop)?;
                    let shapes = facets.into_iter().map(LightShape::Facet).chain(ball.map(LightShape::Ball));
                    lights.extend(shapes.map(|shape| BuiltLight { shape, radiance: light.radiance, material }));
                }
                None => opaque.push(Opaque {
                    index,
                    reverse_orientation: shape.reverse_orientation,
                    geometry: shape.geometry.clone(),
                }),
            }
            check_count(lights.len())?;
        }
        coincident::drop_dimmer(&mut lights, stop)?;
        coincident::drop_hidden(&mut opaque, &lights);
        let same = |other: &&Arc<Self>| {
            other.opaque.len() == opaque.len() && opaque.iter().zip(&other.opaque).all(|(a, b)| a.is(b))
        };
        let geometry = match known.iter().find(same) {
            Some(known) => known.geometry.clone(),
            None => {
                let (mut facets, mut balls) = (Vec::new(), Vec::new());
                for shape in &opaque {
                    let (more, ball) = primitives(shape.index, &shape.geometry, shape.reverse_orientation, stop)?;
                    facets.extend(more);
                    balls.extend(ball);
                    check_count(facets.len() + lights.len())?;
                }
                Arc::new(BuiltGeometry::new(facets, balls, stop)?)
            }
        };
        let epsilon = ray_epsilon(&geometry, &lights, camera.origin);
        coincident::raise(&mut lights, &geometry, epsilon);
        let lights_scatter = lights.iter().any(|l| l.material.scatters());
        let lights = if all_outside(&geometry, &lights, epsilon) {
            Lights::new(lights, stop)?.seen_from_outside()
        } else {
            Lights::new(lights, stop)?
        };
        let [columns, rows] = settings.image.resolution.map(|pixels| pixels.div_ceil(grid::SIDE) as usize);
        // What a patch sees is a matter of shapes and camera alone.
        let sees_the_same = |other: &&Arc<Self>| {
            Arc::ptr_eq(&other.geometry, &geometry)
                && other.camera == camera
                && other.epsilon == epsilon
                && other.lights_scatter == lights_scatter
                && other.lights.has_shapes_of(&lights)
                && (other.columns, other.culled.len()) == (columns, columns * rows)
        };
        let culled = match known.iter().find(sees_the_same) {
            Some(known) => known.culled.clone(),
            None => Arc::new(vec![OnceLock::new(); columns * rows]),
        };
        Ok(Self {
            camera,
            patches: Patches::new(&geometry, &lights, camera.origin, epsilon),
            culled,
            columns,
            geometry,
            opaque,
            has_two_lobes: materials.iter().any(BuiltMaterial::has_two_lobes),
            lights_scatter,
            lights,
            epsilon,
            materials,
        })
    }

    /// True if geometry built for one of two scenes serves the other, too: the same shapes are opaque and emit nothing.
    pub fn same_geometry(a: &Scene, b: &Scene) -> bool {
        let alike = |(a, b): (&scene::Shape, &scene::Shape)| match (emission(a), emission(b)) {
            (Some(_), Some(_)) => true,
            (None, None) => a.reverse_orientation == b.reverse_orientation && same_primitives(&a.geometry, &b.geometry),
            (Some(_), None) | (None, Some(_)) => false,
        };
        a.shapes.len() == b.shapes.len() && a.shapes.iter().zip(&b.shapes).all(alike)
    }

    /// The same scene, in which every primitive is asked for every ray: to compare with.
    #[must_use]
    pub fn without_lists(mut self) -> Self {
        self.patches.forget();
        self.culled = Arc::new(vec![OnceLock::new(); self.culled.len()]);
        self
    }

    /// True if what patches see is asked once for both.
    pub fn sees_with(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.culled, &other.culled)
    }

    /// What can matter to the patch whose first pixel is (x, y).
    pub fn culled(&self, [x, y]: [u32; 2]) -> Culled {
        let ask = || self.patches.cull(&self.camera, [x, y], [x, y].map(|min| min + grid::SIDE));
        let at = (y / grid::SIDE) as usize * self.columns + (x / grid::SIDE) as usize;
        self.culled.get(at).map_or_else(ask, |known| *known.get_or_init(ask))
    }

    /// What a shape is made of; `None` if it reflects nothing.
    #[inline(always)]
    pub fn material(&self, shape: u32) -> Option<&BuiltMaterial> {
        self.materials.get(shape as usize).filter(|material| material.scatters())
    }
}

/// The light of a shape that emits.
fn emission(shape: &scene::Shape) -> Option<&scene::Light> {
    shape.light.as_ref().filter(|light| light.on && light.radiance != Vec3::ZERO)
}

/// True if the same primitives come of both. Meshes have to be the same object: to compare a million
/// vertices would take as long as to look at them again.
fn same_primitives(a: &scene::Geometry, b: &scene::Geometry) -> bool {
    match (a, b) {
        (
            scene::Geometry::Mesh { positions: a, triangles: b },
            scene::Geometry::Mesh { positions: c, triangles: d },
        ) => Arc::ptr_eq(a, c) && Arc::ptr_eq(b, d),
        (scene::Geometry::Sphere { .. }, scene::Geometry::Sphere { .. }) => a == b,
        (scene::Geometry::Mesh { .. }, scene::Geometry::Sphere { .. })
        | (scene::Geometry::Sphere { .. }, scene::Geometry::Mesh { .. }) => false,
    }
}

fn check_material(material: &scene::Material) -> Result<(), Invalid> {
    let name = &material.name;
    let check = |what: &str, v: Vec3, max: f32| {
        if v.is_finite() && v.min_element() >= 0.0 && v.max_element() <= max {
            Ok(())
        } else {
            Err(Invalid(format!("material {name}: {what} {v}, expected numbers in [0, {max}]")))
        }
    };
    if let Some(alpha) = material.bsdf.alpha()
        && !(0.0..=1.0).contains(&alpha)
    {
        return Err(Invalid(format!("material {name}: roughness {alpha}, expected a number in [0, 1]")));
    }
    match &material.bsdf {
        scene::Bsdf::Matte { kd } => check("diffuse reflectance", *kd, 1.0),
        scene::Bsdf::Conductor { reflectance: scene::Reflectance::Constant(r), .. } => check("reflectance", *r, 1.0),
        scene::Bsdf::Conductor { reflectance: scene::Reflectance::Fresnel { eta, k }, .. } => {
            // Beyond, squares of squares overflow.
            check("index eta", *eta, 1e9)?;
            check("absorption k", *k, 1e9)
        }
        scene::Bsdf::Plastic { kd, ks, .. } => {
            check("diffuse reflectance", *kd, 1.0)?;
            check("specular reflectance", *ks, 1.0)
        }
    }
}

fn check_count(triangles: usize) -> Result<(), Invalid> {
    if triangles > MAX_TRIANGLES {
        return Err(Invalid(format!("more than {MAX_TRIANGLES} triangles, expected fewer")));
    }
    Ok(())
}

/// The primitives of shape `index`: facets of a mesh, or one sphere.
fn primitives(
    index: usize,
    geometry: &scene::Geometry,
    reverse: bool,
    stop: Stop<'_>,
) -> Result<(Vec<Facet>, Option<Ball>), Unbuilt> {
    match geometry {
        scene::Geometry::Sphere { center, radius } => {
            if !(center.is_finite() && radius.is_finite() && *radius > 0.0 && radius * radius > 0.0) {
                return Err(Invalid(format!(
                    "shape {index}: sphere at {center} with radius {radius}, expected finite numbers and a radius > 0"
                ))
                .into());
            }
            let ball = Ball { center: *center, radius: *radius, inward: reverse, shape: index as u32 };
            Ok((Vec::new(), Some(ball)))
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
            let mut facets = Vec::with_capacity(triangles.len());
            let mut i = 0;
            while i < triangles.len() {
                stop.check_in_turn(facets.len())?;
                let [a, b, c] = triangles[i];
                let (pa, pb, pc) = (corner(a)?, corner(b)?, corner(c)?);
                let quad = match triangles.get(i + 1) {
                    Some(&next) => parallelogram(triangles[i], next, |i| corner(i).ok()),
                    None => None,
                };
                // Triangles without area cannot be seen.
                match quad {
                    Some([p0, p1, p2]) => {
                        facets.extend(Facet::new(p0, p1, p2, true, reverse, index as u32));
                        i += 2;
                    }
                    None => {
                        facets.extend(Facet::new(pa, pb, pc, false, reverse, index as u32));
                        i += 1;
                    }
                }
            }
            Ok((facets, None))
        }
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

/// True if it is plain that no surface that reflects reaches into a ball light. Not asked of large scenes.
fn all_outside(geometry: &BuiltGeometry, lights: &[BuiltLight], epsilon: f32) -> bool {
    if geometry.has_tree() || lights.iter().any(|light| light.material.scatters()) {
        return false;
    }
    lights.iter().all(|light| {
        let LightShape::Ball(light) = light.shape else { return true };
        // Points of surfaces are worked out to about a millionth of the scene's extent, which is what `epsilon` is.
        let (center, reach) = (light.center.as_dvec3(), f64::from(light.radius) * 1.001 + 10.0 * f64::from(epsilon));
        let facets = geometry.facets.iter().all(|facet| {
            let height = facet.normal.as_dvec3().dot(center - facet.p0.as_dvec3());
            let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            for corner in facet.corners() {
                (min, max) = (min.min(corner.as_dvec3()), max.max(corner.as_dvec3()));
            }
            height.abs() > reach || (center.clamp(min, max) - center).length() > reach
        });
        facets
            && geometry.balls.iter().all(|ball| {
                let apart = (ball.center.as_dvec3() - center).length();
                (apart - f64::from(ball.radius)).abs() > reach
            })
    })
}

/// Offset for rays that leave a surface: ten f32 roundings at the size of the scene, seen from the
/// camera. No more, since it moves the edges of shadows by as much.
fn ray_epsilon(geometry: &BuiltGeometry, lights: &[BuiltLight], eye: Vec3) -> f32 {
    let (min, max) = geometry.bounds();
    let mut extent = eye.abs().max_element();
    for v in [min, max] {
        if v.is_finite() {
            extent = extent.max(v.abs().max_element()).max((v - eye).length());
        }
    }
    for light in lights {
        if let LightShape::Ball(b) = light.shape {
            extent = extent.max(b.center.abs().max_element() + b.radius);
        }
    }
    1e-6 * extent
}
