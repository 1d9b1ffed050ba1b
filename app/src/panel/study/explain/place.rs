//! What is explained: a pixel of a scene as it was rendered, and what is seen there.

use std::sync::Arc;

use glam::Vec3;
use mislab_renderer::inspect::{Inspector, Point, Seen};
use mislab_renderer::kernel::film::LUMINANCE;
use mislab_renderer::kernel::world::BuiltScene;
use mislab_renderer::{Frame, Geometry, Scene, Settings};

/// A pixel of a picture.
#[derive(Clone)]
pub struct Place {
    /// The scene as data: names and materials.
    pub scene: Arc<Scene>,
    /// The scene as it was rendered.
    pub built: Arc<BuiltScene>,
    /// How.
    pub settings: Settings,
    /// Column and row in the full image.
    pub pixel: [u32; 2],
}

impl Place {
    /// A pixel of a frame; `None` outside.
    pub fn of(frame: &Frame, pixel: [u32; 2]) -> Option<Self> {
        let bounds = frame.bounds();
        let inside = (0..2).all(|i| (bounds.min[i]..bounds.max[i]).contains(&pixel[i]));
        let request = frame.request();
        inside.then(|| Self {
            scene: request.scene.clone(),
            built: frame.scene().clone(),
            settings: request.settings.clone(),
            pixel,
        })
    }

    /// Whether the same is seen there, whatever is estimated and sampled.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.scene, &other.scene)
            && self.settings.image == other.settings.image
            && self.pixel == other.pixel
    }

    /// What the camera sees at a point of the pixel, in [0, 1] from its upper left corner.
    pub fn look(&self, [x, y]: [f64; 2]) -> Seen<'_> {
        let [column, row] = self.pixel.map(f64::from);
        Inspector::new(&self.built, &self.settings).at_pixel((column + x) as f32, (row + y) as f32)
    }

    /// The surface at its centre.
    pub fn point(&self) -> Option<Point<'_>> {
        self.look([0.5; 2]).point()
    }
}

/// What is seen at the centre of a pixel.
#[derive(Clone, Debug, PartialEq)]
pub enum Facts {
    /// Nothing.
    Nothing,
    /// A light that reflects nothing.
    Light,
    /// A surface.
    Surface(Surface),
}

/// A surface point.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Name of its material, or of the light that it belongs to.
    pub name: String,
    /// Index of its material, if it has one.
    pub material: Option<usize>,
    /// GGX width of its lobe; `None` without one.
    pub alpha: Option<f32>,
    /// Unit normal on the viewer's side.
    pub normal: Vec3,
    /// Unit direction towards the viewer.
    pub wo: Vec3,
    /// The direction in which a mirror would reflect: about the peak of its lobe.
    pub mirrored: Vec3,
    /// Lights that are on, in the order of the scene.
    pub lights: Vec<LightSeen>,
}

/// A light as seen from a point.
#[derive(Clone, Debug, PartialEq)]
pub struct LightSeen {
    /// Index of its shape.
    pub shape: usize,
    /// Its name.
    pub name: String,
    /// Unit direction towards its middle.
    pub centre: Vec3,
    /// Distance to its middle, in scene units.
    pub distance: f64,
    /// Angle between its middle and its edge, in radians; 0 of what is no sphere.
    pub radius: f64,
    /// Angle between its middle and the mirror's direction, in radians.
    pub off: f64,
}

impl Facts {
    /// Looks at the centre of the pixel.
    pub fn of(place: &Place) -> Self {
        let point = match place.look([0.5; 2]) {
            Seen::Nothing => return Self::Nothing,
            Seen::Light(_) => return Self::Light,
            Seen::Surface(point) => point,
        };
        let shape = place.scene.shapes.get(point.shape());
        let material = shape.and_then(|shape| shape.material);
        let named = material.and_then(|index| place.scene.materials.get(index)).map(|material| material.name.clone());
        let lamp = || shape.and_then(|shape| shape.light.as_ref()).map(|light| light.name.clone());
        let (position, mirrored) = (point.position(), point.mirrored());
        let lights = place.scene.light_shapes().filter_map(|index| light(&place.scene, index, position, mirrored));
        Self::Surface(Surface {
            name: named.or_else(lamp).unwrap_or_else(|| "a black surface".into()),
            material,
            alpha: point.alpha(),
            normal: point.normal(),
            wo: point.wo(),
            mirrored,
            lights: lights.collect(),
        })
    }

    /// The surface, if there is one.
    #[cfg(test)]
    pub fn surface(&self) -> Option<&Surface> {
        match self {
            Self::Surface(surface) => Some(surface),
            Self::Nothing | Self::Light => None,
        }
    }
}

impl Surface {
    /// The light whose highlight this is: the one whose edge is nearest to the mirror's direction.
    pub fn highlight(&self) -> Option<&LightSeen> {
        self.lights.iter().min_by(|a, b| (a.off - a.radius).total_cmp(&(b.off - b.radius)))
    }
}

fn light(scene: &Scene, index: usize, from: Vec3, mirrored: Vec3) -> Option<LightSeen> {
    let shape = &scene.shapes[index];
    let light = shape.light.as_ref().filter(|light| light.on)?;
    let (middle, size) = match &shape.geometry {
        Geometry::Sphere { center, radius } => (*center, f64::from(*radius)),
        Geometry::Mesh { positions, .. } => {
            (positions.iter().copied().sum::<Vec3>() / positions.len().max(1) as f32, 0.0)
        }
    };
    let distance = f64::from((middle - from).length());
    let centre = (middle - from).normalize_or_zero();
    let radius = (size / distance).clamp(0.0, 1.0).asin();
    Some(LightSeen { shape: index, name: light.name.clone(), centre, distance, radius, off: angle(centre, mirrored) })
}

/// Angle between two directions, exact also where it is small. In radians.
pub fn angle(a: Vec3, b: Vec3) -> f64 {
    let (a, b) = (a.as_dvec3(), b.as_dvec3());
    a.cross(b).length().atan2(a.dot(b))
}

/// Luminance of a colour.
pub fn luminance(colour: Vec3) -> f64 {
    colour.to_array().into_iter().zip(LUMINANCE).map(|(c, share)| f64::from(c) * f64::from(share)).sum()
}
