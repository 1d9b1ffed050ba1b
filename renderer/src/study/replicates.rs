//! The variance of a pattern: of the samples of a pixel as they are drawn, strata and all.
//!
//! The layer of variances takes the samples of a pixel as independent; stratified ones are not, and the mean of a whole pattern is known
//! better than that says. How well is measured: over R small pictures of one pattern of n samples with seeds of their own, n times the
//! sample variance of the R means of a pixel is what one sample of the pattern is worth.

use std::num::NonZeroU32;
use std::sync::Arc;

use mislab_kernel::request::{Request, SamplerKind};

use crate::engine::Renderer;
use crate::error::Error;
use crate::layer::Channel;
use crate::table::reference::{LUMINANCE, part, rgb};
use crate::table::regions::visible_materials;

/// Pictures with seeds of their own.
pub const REPLICATES: u32 = 8;
/// The longer side of the small pictures, in pixels.
const SIDE: u32 = 64;
/// Samples per pixel of a pattern without strata, and the most of one that has them.
const SPP: [u32; 2] = [16, 64];

/// Variance of the luminance of one sample, averaged over the pixels that show one surface alone and that anything was hit in. At the rim of a
/// light a pixel holds more noise than all others together, whatever the strategy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// As it is, in squared radiance.
    pub absolute: f64,
    /// Over the squared mean of the pixel.
    pub relative: f64,
}

/// What the samples of a pixel are worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Replicated {
    /// As if they were independent: what the layer shows.
    pub independent: Spread,
    /// Measured over the replicates.
    pub pattern: Spread,
    /// Samples of one pattern.
    pub spp: u32,
}

impl Replicated {
    /// Renders the replicates of `request`, small and on `threads` of low priority; blocks. `None` if `goes_on` says no, or nothing
    /// was hit.
    ///
    /// # Errors
    /// [`Error::Invalid`] if it cannot be rendered.
    pub fn measure(
        request: &Request,
        threads: usize,
        goes_on: &mut dyn FnMut() -> bool,
    ) -> Result<Option<Self>, Error> {
        let renderer = Renderer::in_background(threads);
        let mut settings = request.settings.clone();
        settings.image.resolution = small(settings.image.resolution);
        let sampler = settings.sampling.sampler;
        let spp = match sampler.kind {
            SamplerKind::Stratified | SamplerKind::PaddedStratified => {
                sampler.strata[0].saturating_mul(sampler.strata[1]).clamp(2, SPP[1])
            }
            SamplerKind::Lattice | SamplerKind::Sobol | SamplerKind::Independent | SamplerKind::PaddedSobol => SPP[0],
        };
        settings.sampling.spp = NonZeroU32::new(spp);
        let area = settings.pixel_bounds().area();
        // Of each pixel the sum of the means, of their squares, and of the variances.
        let mut sums = vec![[0.0; 3]; area];
        for replicate in 0..REPLICATES {
            let mut settings = settings.clone();
            settings.sampling.seed = settings.sampling.seed.wrapping_add(1 + replicate);
            let mut stopped = false;
            let frame = renderer.render(&Request { scene: Arc::clone(&request.scene), settings }, &mut |_| {
                stopped |= !goes_on();
                !stopped
            });
            if stopped {
                return Ok(None);
            }
            let frame = frame?;
            let (planes, variance) = (rgb(&frame), frame.channel(Channel::VarianceY));
            for (pixel, sum) in sums.iter_mut().enumerate() {
                let y: f64 = planes.iter().zip(LUMINANCE).map(|(plane, w)| w * f64::from(plane[pixel])).sum();
                let values = [y, y * y, f64::from(variance[pixel])];
                sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
            }
        }
        let (image, bounds) = (settings.image, settings.pixel_bounds());
        let materials = part(&visible_materials(&request.scene, image.resolution), image.resolution[0], bounds);
        Ok(averaged(sums.iter().zip(materials).filter_map(|(sums, material)| material.map(|_| sums)), spp))
    }
}

fn averaged<'a>(sums: impl Iterator<Item = &'a [f64; 3]>, spp: u32) -> Option<Replicated> {
    let count = f64::from(REPLICATES);
    let (mut pixels, mut independent, mut pattern) = (0.0, [0.0; 2], [0.0; 2]);
    for [sum, squares, variances] in sums {
        let mean = sum / count;
        let own = variances / count;
        let between = f64::from(spp) * (squares - sum * mean).max(0.0) / (count - 1.0);
        if mean > 0.0 && own.is_finite() && between.is_finite() {
            pixels += 1.0;
            for (into, value) in [(&mut independent, own), (&mut pattern, between)] {
                into[0] += value;
                into[1] += value / (mean * mean);
            }
        }
    }
    let spread = |[absolute, relative]: [f64; 2]| Spread { absolute: absolute / pixels, relative: relative / pixels };
    (pixels > 0.0).then(|| Replicated { independent: spread(independent), pattern: spread(pattern), spp })
}

/// The same shape with a longer side of [`SIDE`] at most.
fn small(resolution: [u32; 2]) -> [u32; 2] {
    let longer = resolution[0].max(resolution[1]).max(SIDE);
    resolution.map(|side| (u64::from(side) * u64::from(SIDE) / u64::from(longer)).max(1) as u32)
}
