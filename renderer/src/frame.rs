//! An immutable snapshot of a picture in progress, and how values come out of its sums.

use std::sync::Arc;

use mislab_kernel::film::{COUNT, LUMINANCE, Tile, WEIGHT};
use mislab_kernel::geometry::grid::BLOCK;
use mislab_kernel::lanes::{Level, PACKET, dispatch};
use mislab_kernel::request::{PixelRect, Request, Strategy};
use mislab_kernel::world::BuiltScene;

use crate::layer::Channel;

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
/// layer can be worked out from it, now or later, at full precision. To keep one delays nothing and costs
/// [`Self::bytes`] of memory.
#[derive(Debug)]
pub struct Frame {
    pub(crate) request: Arc<Request>,
    pub(crate) scene: Arc<BuiltScene>,
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

    /// The scene as it was rendered: what camera rays and shadow rays of this frame met.
    pub fn scene(&self) -> &Arc<BuiltScene> {
        &self.scene
    }

    /// Memory of its sums in bytes, which it keeps while it is held: 51 MB for both techniques at 800 x 800.
    pub fn bytes(&self) -> usize {
        // Sums are pairs of floats: four of a technique, which counts its samples too, the square of the luminance
        // and, where a light is seen, three of its emission.
        let techniques = match self.request.settings.estimator.strategy {
            Strategy::Light | Strategy::Bsdf => 1,
            Strategy::MisAll | Strategy::Mis => 2,
        };
        let floats = |tile: &Tile| 2 + techniques * 9 + if tile.emission(0, 0).is_some() { 6 } else { 0 };
        self.tiles.iter().map(|tile| tile.block_count() * PACKET * floats(tile) * size_of::<f32>()).sum()
    }

    /// Writes channels one after the other: `bounds().area()` values each, row by row from the top
    /// left. Undefined values (no sample of the technique carried light; variance of a single
    /// sample, or of luminances whose squares add up to more than an f32 holds) are NaN.
    ///
    /// # Panics
    /// If `out` has another length.
    pub fn resolve(&self, channels: &[Channel], out: &mut [f32]) {
        self.resolve_rect(channels, self.bounds, out);
    }

    /// The same for a part of the picture, in coordinates of the full image: `rect.area()` values of each channel. Only
    /// the blocks of pixels that it touches are worked out.
    ///
    /// # Panics
    /// If `rect` is not inside [`Self::bounds`], or `out` has another length.
    pub fn resolve_rect(&self, channels: &[Channel], rect: PixelRect, out: &mut [f32]) {
        let area = rect.area();
        assert_eq!(out.len(), channels.len() * area, "one value per channel and pixel of the rectangle");
        if area == 0 {
            return;
        }
        assert_eq!(intersection(rect, self.bounds), rect, "the rectangle is inside the frame");
        let level = Level::new();
        // Tile by tile, so that all channels of a tile are worked out while its sums are in the cache.
        for tile in &self.tiles {
            for (plane, &channel) in out.chunks_exact_mut(area).zip(channels) {
                // Dispatched so that the plain loops inside are vectorised for this machine.
                dispatch!(level, _simd => resolve_tile(tile, channel, rect, plane));
            }
        }
    }

    /// The same for chosen pixels of the full image, in any order: `pixels.len()` values of each channel, in the order
    /// of `pixels`. However many of them share a block, it is worked out once.
    ///
    /// # Panics
    /// If a pixel is not inside [`Self::bounds`], or `out` has another length.
    pub fn resolve_pixels(&self, channels: &[Channel], pixels: &[[u32; 2]], out: &mut [f32]) {
        assert_eq!(out.len(), channels.len() * pixels.len(), "one value per channel and pixel");
        if pixels.is_empty() {
            return;
        }
        let mut places: Vec<Place> = Vec::with_capacity(pixels.len());
        for (index, &pixel) in pixels.iter().enumerate() {
            // Neighbours are mostly in the same tile.
            let last = places.last().map(|place| place.tile).filter(|&t| contains(self.tiles[t].bounds, pixel));
            let tile = last.or_else(|| self.tiles.iter().position(|tile| contains(tile.bounds, pixel)));
            let tile = tile.expect("the pixel is inside the frame");
            let (block, lane) = self.tiles[tile].locate(pixel[0], pixel[1]);
            places.push(Place { tile, block, lane, index });
        }
        places.sort_unstable_by_key(|place| (place.tile, place.block));
        let level = Level::new();
        for group in places.chunk_by(|a, b| (a.tile, a.block) == (b.tile, b.block)) {
            let (tile, block) = (&self.tiles[group[0].tile], group[0].block);
            for (plane, &channel) in out.chunks_exact_mut(pixels.len()).zip(channels) {
                let mut values = [0.0; PACKET];
                dispatch!(level, _simd => resolve_block(tile, channel, block, &mut values));
                for place in group {
                    plane[place.index] = values[place.lane];
                }
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
        let tile = self.tiles.iter().find(|tile| contains(tile.bounds, [x, y]))?;
        let (block, lane) = tile.locate(x, y);
        let mut values = [0.0; PACKET];
        resolve_block(tile, channel, block, &mut values);
        Some(values[lane])
    }
}

/// Where a pixel is: tile of the frame, block of the tile, lane of the block; and its index among those asked for.
struct Place {
    tile: usize,
    block: usize,
    lane: usize,
    index: usize,
}

fn contains(rect: PixelRect, [x, y]: [u32; 2]) -> bool {
    (rect.min[0]..rect.max[0]).contains(&x) && (rect.min[1]..rect.max[1]).contains(&y)
}

/// The pixels of both; an area of 0 where there are none.
fn intersection(a: PixelRect, b: PixelRect) -> PixelRect {
    PixelRect { min: [0, 1].map(|i| a.min[i].max(b.min[i])), max: [0, 1].map(|i| a.max[i].min(b.max[i])) }
}

/// The pixels that a tile has of `rect`, into the plane of that rectangle.
#[inline(always)]
fn resolve_tile(tile: &Tile, channel: Channel, rect: PixelRect, out: &mut [f32]) {
    let part = intersection(tile.bounds, rect);
    if part.area() == 0 {
        return;
    }
    let width = rect.width() as usize;
    let mut y = part.min[1];
    while y < part.max[1] {
        // All blocks of a row of blocks that hold a pixel of the part.
        let [first, last] = [part.min[0], part.max[0] - 1].map(|x| tile.locate(x, y).0);
        let [_, top] = tile.block_corner(first);
        let rows = y..part.max[1].min(top + BLOCK[1]);
        for block in first..=last {
            let mut values = [0.0; PACKET];
            resolve_block(tile, channel, block, &mut values);
            let [left, _] = tile.block_corner(block);
            let columns = part.min[0].max(left)..part.max[0].min(left + BLOCK[0]);
            for y in rows.clone() {
                let to = (y - rect.min[1]) as usize * width + (columns.start - rect.min[0]) as usize;
                let from = ((y - top) * BLOCK[0] + columns.start - left) as usize;
                let count = columns.len();
                out[to..to + count].copy_from_slice(&values[from..from + count]);
            }
        }
        y = rows.end;
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
