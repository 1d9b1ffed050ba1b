//! A scene as plain data: what a scene file says and what the panels edit.
//!
//! The renderer works on a [`crate::world::BuiltScene`] made from it. All numbers are in world
//! space; lengths are in the scene's unit, radiances in W / (m^2 sr) per channel (Rec. 709).

use std::sync::Arc;

use glam::{DMat4, Vec3};
use serde::{Deserialize, Serialize};

/// A perspective pinhole camera, pbrt's convention: in camera space +x points right in the image,
/// +y up, +z forward (left-handed).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// Camera space to world space; affine, may mirror.
    pub world_from_camera: DMat4,
    /// Full angle over the shorter image axis, in degrees, in (0, 180).
    pub fov_deg: f64,
    /// Left, right, bottom, top of the image on the plane z = 1 / tan(fov/2) of camera space.
    /// `None`: [-1, 1] over the shorter axis, the longer one by the aspect ratio.
    pub screen_window: Option<[f64; 4]>,
}

impl Camera {
    /// Left, right, bottom and top of an image of that many pixels, see [`Self::screen_window`].
    pub fn screen(&self, resolution: [u32; 2]) -> [f64; 4] {
        self.screen_window.unwrap_or_else(|| {
            let aspect = f64::from(resolution[0]) / f64::from(resolution[1]);
            let (x, y) = (aspect.max(1.0), (1.0 / aspect).max(1.0));
            [-x, x, -y, y]
        })
    }
}

/// Files have what is unusual only, and are those of before where it is not.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands over references")]
fn is_false(v: &bool) -> bool {
    !*v
}

/// How a surface scatters light. Reflection only; both sides of a surface scatter alike.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Bsdf {
    /// Lambert: `kd / pi`. Reflectance per channel in [0, 1].
    Matte {
        /// Diffuse reflectance.
        kd: Vec3,
    },
    /// A mirror (`alpha` = 0, a Dirac delta) or a GGX reflector of width `alpha`.
    Conductor {
        /// How much is reflected by angle.
        reflectance: Reflectance,
        /// GGX width in [0, 1]; 0 is a perfect mirror.
        alpha: f32,
    },
    /// pbrt's plastic: Lambert `kd` plus GGX `ks` under a dielectric Fresnel term (index 1.5).
    /// BSDF samples choose between the two lobes with probability 1/2.
    Plastic {
        /// Diffuse reflectance.
        kd: Vec3,
        /// Specular reflectance, multiplied by the Fresnel term.
        ks: Vec3,
        /// GGX width in [0, 1]; 0 makes the coat a perfect mirror.
        alpha: f32,
        /// The Fresnel term has its two indices swapped, as pbrt-v3's source has: that of light from inside of the coat.
        #[serde(default, skip_serializing_if = "is_false")]
        swapped_indices: bool,
    },
}

impl Bsdf {
    /// GGX width, for surfaces that have one.
    pub fn alpha(&self) -> Option<f32> {
        match self {
            Self::Matte { .. } => None,
            Self::Conductor { alpha, .. } | Self::Plastic { alpha, .. } => Some(*alpha),
        }
    }

    /// The GGX width for editing, for surfaces that have one.
    pub fn alpha_mut(&mut self) -> Option<&mut f32> {
        match self {
            Self::Matte { .. } => None,
            Self::Conductor { alpha, .. } | Self::Plastic { alpha, .. } => Some(alpha),
        }
    }
}

/// Fresnel reflectance of a conductor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reflectance {
    /// The same at every angle (pbrt's mirror `Kr`).
    Constant(Vec3),
    /// Unpolarised Fresnel reflectance of a metal with complex index `eta + i k`, per channel.
    Fresnel {
        /// Real part of the index.
        eta: Vec3,
        /// Imaginary part (absorption).
        k: Vec3,
    },
}

/// A named surface description. Names are unique; unnamed ones of the file get `material1` ...
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Name in the scene file.
    pub name: String,
    /// Scattering.
    pub bsdf: Bsdf,
}

/// The surface of a [`Shape`], in world space.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Geometry {
    /// A full sphere.
    Sphere {
        /// Centre.
        center: Vec3,
        /// Radius, > 0.
        radius: f32,
    },
    /// Triangles. The geometric normal is `(b - a) x (c - a)`, normalised.
    Mesh {
        /// Vertices.
        positions: Arc<Vec<Vec3>>,
        /// Three indices into `positions` each.
        triangles: Arc<Vec<[u32; 3]>>,
    },
}

impl PartialEq for Geometry {
    /// Meshes that are the same object are not looked at: scenes are compared at every edit.
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Sphere { center: a, radius: r }, Self::Sphere { center: b, radius: s }) => (a, r) == (b, s),
            (Self::Mesh { positions: a, triangles: t }, Self::Mesh { positions: b, triangles: u }) => {
                (Arc::ptr_eq(a, b) || a == b) && (Arc::ptr_eq(t, u) || t == u)
            }
            (Self::Sphere { .. }, Self::Mesh { .. }) | (Self::Mesh { .. }, Self::Sphere { .. }) => false,
        }
    }
}

/// Emission of a shape: every point radiates `radiance` into the hemisphere of its outward normal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Light {
    /// Name for panels: `light1` ... in the order of the file.
    pub name: String,
    /// Emitted radiance per channel while on.
    pub radiance: Vec3,
    /// Off: the shape stays as a black or reflecting body.
    pub on: bool,
}

/// One surface of the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shape {
    /// Where it is.
    pub geometry: Geometry,
    /// Normals (and emission) point the other way: into a sphere.
    pub reverse_orientation: bool,
    /// Index into [`Scene::materials`]; `None` absorbs everything (the surface of a light).
    pub material: Option<usize>,
    /// Emission, if it is a light.
    pub light: Option<Light>,
}

/// A whole scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// Short name for titles: the file's stem.
    pub name: String,
    /// Where it is seen from.
    pub camera: Camera,
    /// Surface descriptions, referred to by index.
    pub materials: Vec<Material>,
    /// Surfaces.
    pub shapes: Vec<Shape>,
}

impl Scene {
    /// The material of that name.
    pub fn material(&self, name: &str) -> Option<&Material> {
        self.materials.iter().find(|m| m.name == name)
    }

    /// The material of that name, for editing.
    pub fn material_mut(&mut self, name: &str) -> Option<&mut Material> {
        self.materials.iter_mut().find(|m| m.name == name)
    }

    /// Indices into [`Scene::shapes`] of all lights, in the order of the file.
    pub fn light_shapes(&self) -> impl Iterator<Item = usize> + '_ {
        self.shapes.iter().enumerate().filter(|(_, s)| s.light.is_some()).map(|(i, _)| i)
    }

    /// Gives the sphere light `shape` the radius `radius`, its power that of `original`'s
    /// (power = 4 pi^2 r^2 L, so L falls with the square of the radius). Working from the original
    /// rather than from the last value, a slider moved back and forth ends on the same bits.
    pub fn set_light_radius(&mut self, original: &Self, shape: usize, radius: f32) {
        let (Geometry::Sphere { radius: r0, .. }, Some(light0)) =
            (&original.shapes[shape].geometry, &original.shapes[shape].light)
        else {
            return;
        };
        let scale = (*r0 / radius) * (*r0 / radius);
        let shape = &mut self.shapes[shape];
        if let (Geometry::Sphere { radius: r, .. }, Some(light)) = (&mut shape.geometry, &mut shape.light) {
            *r = radius;
            light.radiance = light0.radiance * scale;
        }
    }
}
