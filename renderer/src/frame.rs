//! An immutable snapshot of a picture in progress, and the layers in it.

use std::sync::Arc;

use mislab_kernel::film::{COUNT, LUMINANCE, Tile, WEIGHT};
use mislab_kernel::geometry::grid::BLOCK;
use mislab_kernel::lanes::{Level, PACKET, dispatch};
use mislab_kernel::request::PixelRect;
use mislab_kernel::request::Request;

/// One image of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Layer {
    /// The estimate itself: visible emission plus both contributions.
    Picture,
    /// Weighted contribution of the light technique.
    Light,
    /// Weighted contribution of the BSDF technique.
    Bsdf,
    /// Mean MIS weight of the light samples that carried light.
    WeightLight,
    /// Mean MIS weight of the BSDF samples that carried light.
    WeightBsdf,
    /// Light technique's share of the reflected luminance.
    ShareLight,
    /// Variance of the luminance of one sample.
    Variance,
}

impl Layer {
    /// All layers, in the order shown to users.
    pub const ALL: [Self; 7] =
        [Self::Picture, Self::Light, Self::Bsdf, Self::WeightLight, Self::WeightBsdf, Self::ShareLight, Self::Variance];

    /// The channels of the layer: three for colour, one for a quantity.
    pub fn channels(self) -> &'static [Channel] {
        use Channel::*;
        match self {
            Self::Picture => &[R, G, B],
            Self::Light => &[LightR, LightG, LightB],
            Self::Bsdf => &[BsdfR, BsdfG, BsdfB],
            Self::WeightLight => &[WeightLightY],
            Self::WeightBsdf => &[WeightBsdfY],
            Self::ShareLight => &[ShareLightY],
            Self::Variance => &[VarianceY],
        }
    }
}

/// One plane of numbers of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "named after their layer and colour")]
pub enum Channel {
    R,
    G,
    B,
    LightR,
    LightG,
    LightB,
    BsdfR,
    BsdfG,
    BsdfB,
    WeightLightY,
    WeightBsdfY,
    ShareLightY,
    VarianceY,
}

impl Channel {
    /// All channels.
    pub const ALL: [Self; 13] = {
        use Channel::*;
        [R, G, B, LightR, LightG, LightB, BsdfR, BsdfG, BsdfB, WeightLightY, WeightBsdfY, ShareLightY, VarianceY]
    };

    /// Name in EXR files.
    pub fn exr_name(self) -> &'static str {
        match self {
            Self::R => "R",
            Self::G => "G",
            Self::B => "B",
            Self::LightR => "light.R",
            Self::LightG => "light.G",
            Self::LightB => "light.B",
            Self::BsdfR => "bsdf.R",
            Self::BsdfG => "bsdf.G",
            Self::BsdfB => "bsdf.B",
            Self::WeightLightY => "w_light.Y",
            Self::WeightBsdfY => "w_bsdf.Y",
            Self::ShareLightY => "share_light.Y",
            Self::VarianceY => "variance.Y",
        }
    }
}

/// How much work a frame took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameStats {
    /// Secondary rays traced (`mis_all`: two per camera ray).
    pub paths: u64,
    /// Wall-clock seconds spent rendering, pauses left out.
    pub render_seconds: f64,
    /// Processor time spent rendering, summed over threads.
    pub cpu_seconds: f64,
    /// Worker threads.
    pub threads: usize,
    /// SIMD level the kernel ran at.
    pub simd: &'static str,
    /// Samples whose contribution was not a finite number; counted and left out of the sums.
    pub invalid_samples: u64,
}

impl FrameStats {
    /// Millions of secondary rays per wall-clock second.
    pub fn mpaths_per_second(&self) -> f64 {
        if self.render_seconds > 0.0 { self.paths as f64 / self.render_seconds * 1e-6 } else { 0.0 }
    }
}

/// An immutable snapshot of a picture after a whole number of passes. It shares its accumulators
/// with the renderer (which copies before it writes), so that making one costs nothing, and any
/// layer can be worked out from it, now or later, at full precision.
#[derive(Debug)]
pub struct Frame {
    pub(crate) request: Arc<Request>,
    pub(crate) generation: u64,
    pub(crate) spp: u32,
    pub(crate) bounds: PixelRect,
    pub(crate) stats: FrameStats,
    pub(crate) tiles: Vec<Arc<Tile>>,
}

impl Frame {
    /// The scene and settings it was made with.
    pub fn request(&self) -> &Arc<Request> {
        &self.request
    }

    /// Version of the settings; grows with every submit and restart.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// Complete passes, at least 1.
    pub fn spp(&self) -> u32 {
        self.spp
    }

    /// The pixels it holds, in coordinates of the full image.
    pub fn bounds(&self) -> PixelRect {
        self.bounds
    }

    /// How much work it took.
    pub fn stats(&self) -> FrameStats {
        self.stats
    }

    /// Writes channels one after the other: `bounds().area()` values each, row by row from the top
    /// left. Undefined values (no sample of the technique carried light; variance of a single
    /// sample, or of luminances whose squares add up to more than an f32 holds) are NaN.
    ///
    /// # Panics
    /// If `out` has another length.
    pub fn resolve(&self, channels: &[Channel], out: &mut [f32]) {
        let area = self.bounds.area();
        assert_eq!(out.len(), channels.len() * area, "one value per channel and pixel of the frame");
        let level = Level::new();
        // Tile by tile, so that all channels of a tile are worked out while its sums are in the cache.
        for tile in &self.tiles {
            for (plane, &channel) in out.chunks_exact_mut(area).zip(channels) {
                // Dispatched so that the plain loops inside are vectorised for this machine.
                dispatch!(level, _simd => resolve_tile(tile, channel, self.bounds, plane));
            }
        }
    }

    /// One channel as by [`Self::resolve`].
    pub fn channel(&self, channel: Channel) -> Vec<f32> {
        let mut out = vec![0.0; self.bounds.area()];
        self.resolve(&[channel], &mut out);
        out
    }

    /// One value at a pixel of the full image; `None` outside [`Self::bounds`].
    pub fn pixel(&self, x: u32, y: u32, channel: Channel) -> Option<f32> {
        let inside = |r: &PixelRect| (r.min[0]..r.max[0]).contains(&x) && (r.min[1]..r.max[1]).contains(&y);
        let tile = self.tiles.iter().find(|tile| inside(&tile.bounds))?;
        let (block, lane) = tile.locate(x, y);
        let mut values = [0.0; PACKET];
        resolve_block(tile, channel, block, &mut values);
        Some(values[lane])
    }
}

#[inline(always)]
fn resolve_tile(tile: &Tile, channel: Channel, bounds: PixelRect, out: &mut [f32]) {
    let width = bounds.width() as usize;
    for block in 0..tile.block_count() {
        let mut values = [0.0; PACKET];
        resolve_block(tile, channel, block, &mut values);
        let [x0, y0] = tile.block_corner(block);
        let columns = tile.bounds.min[0].max(x0)..tile.bounds.max[0].min(x0 + BLOCK[0]);
        for row in 0..BLOCK[1] {
            let y = y0 + row;
            if y < tile.bounds.min[1] || y >= tile.bounds.max[1] {
                continue;
            }
            let to = (y - bounds.min[1]) as usize * width + (columns.start - bounds.min[0]) as usize;
            let from = (row * BLOCK[0] + columns.start - x0) as usize;
            let count = columns.len();
            out[to..to + count].copy_from_slice(&values[from..from + count]);
        }
    }
}

/// The values of one channel at the pixels of a block, from the sums of the film. Plain
/// loops over whole blocks: the compiler makes vectors of them.
#[inline(always)]
fn resolve_block(tile: &Tile, channel: Channel, block: usize, values: &mut [f32; PACKET]) {
    let spp = f64::from(tile.samples);
    let result = match channel {
        Channel::R => scaled(&total(tile, block, 0), spp),
        Channel::G => scaled(&total(tile, block, 1), spp),
        Channel::B => scaled(&total(tile, block, 2), spp),
        Channel::LightR => scaled(&tile.light(block, 0), spp),
        Channel::LightG => scaled(&tile.light(block, 1), spp),
        Channel::LightB => scaled(&tile.light(block, 2), spp),
        Channel::BsdfR => scaled(&tile.bsdf(block, 0), spp),
        Channel::BsdfG => scaled(&tile.bsdf(block, 1), spp),
        Channel::BsdfB => scaled(&tile.bsdf(block, 2), spp),
        // 0 / 0 where no sample carried light: undefined, as it should be.
        Channel::WeightLightY => quotient(&tile.light(block, WEIGHT), &tile.light(block, COUNT)),
        Channel::WeightBsdfY => quotient(&tile.bsdf(block, WEIGHT), &tile.bsdf(block, COUNT)),
        Channel::ShareLightY => {
            let light = luminance([tile.light(block, 0), tile.light(block, 1), tile.light(block, 2)]);
            let bsdf = luminance([tile.bsdf(block, 0), tile.bsdf(block, 1), tile.bsdf(block, 2)]);
            quotient(&light, &plus(&light, &bsdf))
        }
        Channel::VarianceY => {
            let sum = luminance([total(tile, block, 0), total(tile, block, 1), total(tile, block, 2)]);
            let squares = tile.luminance2(block);
            // A single sample has none. (What rounding leaves of its square, over 0, would be infinite.)
            if tile.samples < 2 {
                *values = [f32::NAN; PACKET];
                return;
            }
            let mut variance = [0.0; PACKET];
            for i in 0..PACKET {
                let rest = squares[i] - sum[i] * sum[i] / spp;
                // No `max`, which makes 0 of a NaN: squares may add up to more than single precision holds.
                variance[i] = if rest < 0.0 { 0.0 } else { rest } / (spp - 1.0);
            }
            variance
        }
    };
    for i in 0..PACKET {
        // One NaN for all: the sign of 0 / 0 depends on whether it was worked out by the compiler.
        values[i] = if result[i].is_nan() { f32::NAN } else { result[i] as f32 };
    }
}

type Block = [f64; PACKET];

#[inline(always)]
fn total(tile: &Tile, block: usize, channel: usize) -> Block {
    let reflected = plus(&tile.light(block, channel), &tile.bsdf(block, channel));
    match tile.emission(block, channel) {
        Some(emission) => plus(&reflected, &emission),
        None => reflected,
    }
}

#[inline(always)]
fn plus(a: &Block, b: &Block) -> Block {
    let mut sum = [0.0; PACKET];
    for i in 0..PACKET {
        sum[i] = a[i] + b[i];
    }
    sum
}

#[inline(always)]
fn scaled(a: &Block, spp: f64) -> Block {
    // A division costs several multiplications, and its f64 rounding is lost in the f32 result.
    let per_sample = 1.0 / spp;
    let mut mean = [0.0; PACKET];
    for i in 0..PACKET {
        mean[i] = a[i] * per_sample;
    }
    mean
}

#[inline(always)]
fn quotient(a: &Block, b: &Block) -> Block {
    let mut q = [0.0; PACKET];
    for i in 0..PACKET {
        q[i] = a[i] / b[i];
    }
    q
}

#[inline(always)]
fn luminance(rgb: [Block; 3]) -> Block {
    let mut y = [0.0; PACKET];
    for i in 0..PACKET {
        y[i] = f64::from(LUMINANCE[0]) * rgb[0][i]
            + f64::from(LUMINANCE[1]) * rgb[1][i]
            + f64::from(LUMINANCE[2]) * rgb[2][i];
    }
    y
}
