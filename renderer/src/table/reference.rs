//! The converged picture that errors are measured against, and whose its pixels are.

use std::num::NonZeroU32;
use std::sync::Arc;

use mislab_kernel::request::scene::Scene;
use mislab_kernel::request::{
    Estimator, ImageSettings, PixelRect, SamplerKind, SamplerSettings, Sampling, Settings, Strategy,
};

use super::quality::Reference;
use super::regions::{Groups, Square, visible_materials};
use crate::batch::{Batch, Step, rays};
use crate::error::Error;
use crate::frame::Frame;
use crate::layer::Channel;

/// A reference, and the square of each of its pixels.
pub(crate) struct SortedReference {
    pub(crate) reference: Reference,
    pub(crate) squares: Vec<Option<Square>>,
}

/// How a reference is rendered: in two halves that share no sample.
#[derive(Clone, Copy)]
pub(crate) struct Plan {
    pub(crate) image: ImageSettings,
    /// Camera rays per pixel of both halves together.
    pub(crate) spp: u32,
    /// Of the pictures to be measured: those of the reference are far from it.
    pub(crate) seed: u32,
}

impl Plan {
    /// All lights at once. `None` if `goes_on` says no.
    pub(crate) fn whole(
        &self,
        batch: &mut Batch,
        scene: &Arc<Scene>,
        goes_on: &mut dyn FnMut(&Step<'_>) -> bool,
    ) -> Result<Option<Reference>, Error> {
        let mut halves = Vec::new();
        for half in 0..2 {
            let Some(frame) = batch.render(scene, self.half(half), "reference", goes_on)? else { return Ok(None) };
            halves.push(rgb(&frame).map(|plane| plane.into_iter().map(f64::from).collect()));
        }
        Ok(halves.try_into().ok().map(|halves| Reference { halves }))
    }

    /// Each light alone, the others off. Their sum is the picture; the brightest at a pixel says whose it is.
    pub(crate) fn by_light(
        &self,
        batch: &mut Batch,
        scene: &Scene,
        groups: &Groups,
        goes_on: &mut dyn FnMut(&Step<'_>) -> bool,
    ) -> Result<Option<SortedReference>, Error> {
        let Self { image, .. } = *self;
        let [width, height] = image.resolution;
        let bounds = self.half(0).pixel_bounds();
        let area = bounds.area();
        let mut reference = Reference { halves: std::array::from_fn(|_| std::array::from_fn(|_| vec![0.0; area])) };
        let mut luminance = Vec::new();
        let count = groups.lights().count();
        for (i, light) in groups.lights().enumerate() {
            let mut alone = scene.clone();
            for shape in (0..alone.shapes.len()).filter(|&s| s != light) {
                if let Some(other) = &mut alone.shapes[shape].light {
                    other.on = false;
                }
            }
            let alone = Arc::new(alone);
            let mut sum = vec![0.0; area];
            for half in 0..2 {
                let settings = self.half((2 * i + half) as u32);
                let step = format!("reference {width} x {height}, light {} of {count}", i + 1);
                let Some(frame) = batch.render(&alone, settings, &step, goes_on)? else { return Ok(None) };
                for (channel, values) in rgb(&frame).iter().enumerate() {
                    let total = &mut reference.halves[half][channel];
                    for ((total, sum), &value) in total.iter_mut().zip(&mut sum).zip(values) {
                        *total += f64::from(value);
                        *sum += LUMINANCE[channel] * f64::from(value);
                    }
                }
            }
            luminance.push(sum);
        }
        let materials = part(&visible_materials(scene, image.resolution), width, bounds);
        Ok(Some(SortedReference { reference, squares: groups.squares(&materials, &luminance) }))
    }

    /// Both techniques, points that converge fast, and a seed of its own for each `number`.
    pub(crate) fn half(&self, number: u32) -> Settings {
        Settings {
            estimator: Estimator { strategy: Strategy::MisAll, ..Estimator::default() },
            sampling: Sampling {
                sampler: SamplerSettings { kind: SamplerKind::Lattice, ..Sampling::default().sampler },
                spp: NonZeroU32::new(self.spp / 2),
                seed: self.seed.wrapping_add(1 << 31).wrapping_add(number),
            },
            image: self.image,
        }
    }
}

/// Secondary rays of a reference with so many lights rendered alone (1: all at once).
pub(crate) fn work(image: ImageSettings, spp: u32, lights: usize) -> f64 {
    2.0 * lights as f64 * rays(&Plan { image, spp, seed: 0 }.half(0))
}

/// Luminance of Rec. 709 colours.
pub(crate) const LUMINANCE: [f64; 3] = [0.212_671, 0.715_160, 0.072_169];

/// The picture's planes.
pub(crate) fn rgb(frame: &Frame) -> [Vec<f32>; 3] {
    [Channel::R, Channel::G, Channel::B].map(|channel| frame.channel(channel))
}

/// The values in a rectangle of a plane of this width.
pub(crate) fn part<T: Copy>(plane: &[T], width: u32, rect: PixelRect) -> Vec<T> {
    (rect.min[1]..rect.max[1])
        .flat_map(|y| (rect.min[0]..rect.max[0]).map(move |x| plane[(y * width + x) as usize]))
        .collect()
}
