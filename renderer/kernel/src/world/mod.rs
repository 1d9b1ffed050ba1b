//! From a scene's parameters to the form that packets of rays work on.

pub mod camera;
mod check;
mod coincident;
pub mod culling;
mod primitives;
pub mod projection;
mod view;

use std::sync::{Arc, OnceLock};

use glam::{DVec3, Vec3};

use crate::bsdf::BuiltMaterial;
use crate::geometry::{BuiltGeometry, grid};
use crate::light::{BuiltLight, LightShape, Lights};
use crate::request::scene::{self, Scene};
use crate::request::{Invalid, Settings};
use crate::stop::{Stop, Stopped};
use camera::Pinhole;
pub use check::check;
use coincident::{Fronts, Shared};
use culling::{Culled, Patches};
pub use primitives::MAX_TRIANGLES;
use primitives::Walk;
pub use view::{CameraHit, View};

/// A scene ready to be rendered at one resolution.
#[derive(Debug)]
pub struct BuiltScene {
    /// Where rays start.
    pub camera: Pinhole,
    /// Everything opaque that does not emit.
    pub geometry: Arc<BuiltGeometry>,
    /// What `geometry` was made from.
    opaque: Vec<Opaque>,
    /// Which of it coincides.
    shared: Arc<Shared>,
    /// And which is in front there.
    fronts: Fronts,
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
    shape: scene::Shape,
}

impl Opaque {
    /// True if the same primitives come of both.
    fn is(&self, other: &Self) -> bool {
        self.index == other.index && same_primitives(&self.shape, &other.shape)
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

impl Unbuilt {
    /// Of work that nobody stops.
    fn unstopped(self) -> Invalid {
        match self {
            Self::Invalid(invalid) => invalid,
            Self::Stopped => unreachable!("nobody stops it"),
        }
    }
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
        Self::with_known(scene, settings, &[], Stop::NEVER).map_err(Unbuilt::unstopped)
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
        let camera = check::check_but_shapes(scene, settings)?;
        let mut walk = Walk::new(stop);
        let (mut opaque, mut lights) = (Vec::new(), Vec::new());
        let mut materials = Vec::with_capacity(scene.shapes.len());
        for (index, shape) in scene.shapes.iter().enumerate() {
            let material = shape.material.and_then(|m| scene.materials.get(m));
            let material = material.map_or(BuiltMaterial::BLACK, |material| BuiltMaterial::new(&material.bsdf));
            materials.push(material);
            match emission(shape) {
                Some(light) => {
                    let radiance = light.radiance;
                    walk.visit(index, shape, |shape| lights.push(BuiltLight { shape, radiance, material }))?;
                }
                None => opaque.push(Opaque { index, shape: shape.clone() }),
            }
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
                for Opaque { index, shape } in &opaque {
                    walk.visit(*index, shape, |primitive| match primitive {
                        LightShape::Facet(facet) => facets.push(facet),
                        LightShape::Ball(ball) => balls.push(ball),
                    })?;
                }
                Arc::new(BuiltGeometry::new(facets, balls, stop)?)
            }
        };
        let epsilon = ray_epsilon(&geometry, &lights, camera.origin);
        let same_places = |other: &&Arc<Self>| Arc::ptr_eq(&other.geometry, &geometry) && other.epsilon == epsilon;
        let shared = match known.iter().find(same_places) {
            Some(known) => known.shared.clone(),
            None => Arc::new(Shared::find(&geometry, epsilon, stop)?),
        };
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
            patches: Patches::new(&geometry, &lights, camera.origin, epsilon).with_contested(shared.primitives()),
            fronts: Fronts::new(&shared, &geometry, &materials),
            shared,
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
            (None, None) => same_primitives(a, b),
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
fn same_primitives(a: &scene::Shape, b: &scene::Shape) -> bool {
    let same_geometry = match (&a.geometry, &b.geometry) {
        (
            scene::Geometry::Mesh { positions: a, triangles: b },
            scene::Geometry::Mesh { positions: c, triangles: d },
        ) => Arc::ptr_eq(a, c) && Arc::ptr_eq(b, d),
        (a @ scene::Geometry::Sphere { .. }, b @ scene::Geometry::Sphere { .. }) => a == b,
        (scene::Geometry::Mesh { .. }, scene::Geometry::Sphere { .. })
        | (scene::Geometry::Sphere { .. }, scene::Geometry::Mesh { .. }) => false,
    };
    same_geometry && a.reverse_orientation == b.reverse_orientation
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
