//! The parts of a picture that get numbers of their own: each plate under the light that is brightest on it.

use std::num::NonZeroU32;
use std::sync::Arc;

use mislab_kernel::request::scene::Scene;
use mislab_kernel::request::{ImageSettings, PixelRect, Request};

use crate::engine::Renderer;
use crate::error::Error;
use crate::metrics::Region;
use crate::table::reference::{LUMINANCE, Plan, part, rgb};
use crate::table::regions::visible_materials;

/// A part of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Part {
    /// All of it.
    #[default]
    Whole,
    /// A square: index into [`Cells::squares`].
    Square(usize),
    /// A rectangle of the full image.
    Rect(PixelRect),
}

/// The pixels of one plate that one light is brightest on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Square {
    /// The plate's material.
    pub plate: String,
    /// The light.
    pub light: String,
    /// Indices into planes of the picture.
    pub pixels: Vec<u32>,
}

/// All squares of a picture, plate by plate; none where a scene has no glossy surface or no light.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cells {
    /// The pixels of the picture, in coordinates of the full image.
    pub bounds: PixelRect,
    /// Those that have pixels.
    pub squares: Vec<Square>,
}

/// Samples per pixel of each light alone: enough to see which is brighter.
const SPP: u32 = 16;
/// Squares of a few pixels have no mean worth the name.
const LEAST_PIXELS: usize = 8;

impl Cells {
    /// Renders each light alone and looks which plate each pixel shows. `None` if `goes_on` says no.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn of(
        renderer: &Renderer,
        scene: &Arc<Scene>,
        image: ImageSettings,
        goes_on: &mut dyn FnMut() -> bool,
    ) -> Result<Option<Self>, Error> {
        let lit = |i: &usize| scene.shapes[*i].light.as_ref().is_some_and(|l| l.on && l.radiance.max_element() > 0.0);
        let lights: Vec<usize> = scene.light_shapes().filter(lit).collect();
        let mut settings = Plan { image, spp: 2 * SPP, seed: 0 }.half(0);
        settings.sampling.spp = NonZeroU32::new(SPP);
        let bounds = settings.pixel_bounds();
        let mut brightest: Vec<Option<(usize, f64)>> = vec![None; bounds.area()];
        for &light in &lights {
            let mut alone = Scene::clone(scene);
            for other in lights.iter().filter(|other| **other != light) {
                if let Some(other) = &mut alone.shapes[*other].light {
                    other.on = false;
                }
            }
            let request = Request { scene: Arc::new(alone), settings: settings.clone() };
            let mut stopped = false;
            let frame = renderer.render(&request, &mut |_| {
                stopped |= !goes_on();
                !stopped
            });
            if stopped {
                return Ok(None);
            }
            let planes = rgb(&*frame?);
            for (pixel, best) in brightest.iter_mut().enumerate() {
                let y: f64 = planes.iter().zip(LUMINANCE).map(|(plane, w)| w * f64::from(plane[pixel])).sum();
                if y > best.map_or(0.0, |(_, y)| y) {
                    *best = Some((light, y));
                }
            }
        }
        let materials = part(&visible_materials(scene, image.resolution), image.resolution[0], bounds);
        Ok(Some(Self { bounds, squares: sorted(scene, &lights, &materials, &brightest) }))
    }

    /// A picture without squares.
    pub fn none(bounds: PixelRect) -> Self {
        Self { bounds, squares: Vec::new() }
    }

    /// The pixels of a part; of a rectangle those inside the picture.
    ///
    /// # Panics
    /// If there is no such square.
    pub fn region(&self, part: Part) -> Region<'_> {
        match part {
            Part::Whole => Region::All,
            Part::Square(index) => Region::Pixels(&self.squares[index].pixels),
            Part::Rect(rect) => {
                let Self { bounds: PixelRect { min, max }, .. } = *self;
                let within = |at: [u32; 2]| [0, 1].map(|axis| at[axis].clamp(min[axis], max[axis]) - min[axis]);
                let rect = PixelRect { min: within(rect.min), max: within(rect.max) };
                Region::Rect { width: self.bounds.width() as usize, rect }
            }
        }
    }

    /// The whole, then the squares.
    pub fn parts(&self) -> impl Iterator<Item = Part> {
        std::iter::once(Part::Whole).chain((0..self.squares.len()).map(Part::Square))
    }
}

/// Pixels by plate and light, in the scene's order of both.
fn sorted(
    scene: &Scene,
    lights: &[usize],
    materials: &[Option<usize>],
    brightest: &[Option<(usize, f64)>],
) -> Vec<Square> {
    let plates = (0..scene.materials.len()).filter(|&m| scene.materials[m].bsdf.alpha().is_some());
    let square = |plate: usize, light: usize| {
        let here = |pixel: &usize| materials[*pixel] == Some(plate) && brightest[*pixel].is_some_and(|b| b.0 == light);
        Square {
            plate: scene.materials[plate].name.clone(),
            light: scene.shapes[light].light.as_ref().map_or_else(String::new, |l| l.name.clone()),
            pixels: (0..materials.len()).filter(here).map(|pixel| pixel as u32).collect(),
        }
    };
    let all = plates.flat_map(|plate| lights.iter().map(move |&light| (plate, light)));
    all.map(|(plate, light)| square(plate, light)).filter(|square| square.pixels.len() >= LEAST_PIXELS).collect()
}
