//! The accumulator: for a tile of pixels, what every picture and layer is worked out from.
//!
//! Sums are kept as pairs of floats, the running sum and what rounding has kept from it so far, which goes in with
//! the next sample (Kahan 1965): a plain f32 sum is a quarter of a percent off after 262 144 samples. Pixels are
//! stored in blocks of 8 x 4, lane by lane, as the kernel works on them; rows are put together only when somebody looks.

use crate::estimator::{Contribution, Reflected};
use crate::geometry::grid::{BLOCK, PATCH, SIDE};
use crate::lanes::{Lanes, Mask, PACKET, Real, Uint, V3};
use crate::request::{PerTechnique, PixelRect, Strategy};

/// Rec. 709 luminance of a colour.
pub const LUMINANCE: [f32; 3] = [0.212_671, 0.715_160, 0.072_169];

/// Channels of a technique's sums: weighted contribution, weight.
const TECHNIQUE: usize = 4;
/// Index of the weight among what is known of a technique.
pub const WEIGHT: usize = 3;
/// Index of the number of samples that carry light, after the sums.
pub const COUNT: usize = 4;

/// Sums of `channels` quantities over the samples of every pixel of a tile.
///
/// Laid out as `[block][channel][lane]`. `carry` holds what is missing in `sum`; it means
/// nothing while there is a single sample, so that a first pass need not touch it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Sums {
    channels: usize,
    sum: Vec<f32>,
    carry: Vec<f32>,
}

impl Sums {
    fn prepare(&mut self, channels: usize, blocks: usize) {
        let len = channels * blocks * PACKET;
        if self.sum.len() != len {
            // Zeroed pages cost nothing until they are touched.
            *self = Self { channels, sum: vec![0.0; len], carry: vec![0.0; len] };
        }
    }

    /// Makes this a copy of `from`, without allocating if it has its size.
    fn copy(&mut self, from: &Self, samples: u32) {
        self.prepare(from.channels, from.sum.len() / (from.channels * PACKET));
        self.sum.copy_from_slice(&from.sum);
        if samples > 1 {
            self.carry.copy_from_slice(&from.carry);
        }
    }

    /// Adds one number to each of the first `C` channels of the lanes at `lane` of `block`, `here` only: the others are
    /// left as they are, to the bit, as if the packet had been skipped. (To add a zero would not do that: after
    /// a number far above the sum, the carry may be more than half a unit of it.) `sample` counts from 0.
    #[inline(always)]
    fn add<L: Lanes, const C: usize>(
        &mut self,
        l: L,
        (block, lane): (usize, usize),
        sample: u32,
        here: L::M,
        x: [L::F; C],
    ) {
        let zero = l.f(0.0);
        let at = block * self.channels * PACKET + lane;
        let to = at..at + (C - 1) * PACKET + L::N;
        let sums = &mut self.sum[to.clone()];
        if sample == 0 {
            for (channel, x) in x.into_iter().enumerate() {
                here.select(x, zero).store(&mut sums[channel * PACKET..]);
            }
            return;
        }
        let carries = &mut self.carry[to];
        for (channel, x) in x.into_iter().enumerate() {
            let (sum, carry) = (&mut sums[channel * PACKET..], &mut carries[channel * PACKET..]);
            let carried = if sample > 1 { l.load(carry) } else { zero };
            let x = here.select(x + carried, zero);
            let old = l.load(sum);
            let new = old + x;
            new.store(sum);
            here.select(x - (new - old), carried).store(carry);
        }
    }

    /// Sums of one channel over `samples` samples, lane by lane.
    #[inline(always)]
    fn block(&self, samples: u32, block: usize, channel: usize) -> [f64; PACKET] {
        let at = (block * self.channels + channel) * PACKET;
        let mut out = [0.0; PACKET];
        for (out, &sum) in out.iter_mut().zip(&self.sum[at..at + PACKET]) {
            *out = f64::from(sum);
        }
        if samples > 1 {
            for (out, &carry) in out.iter_mut().zip(&self.carry[at..at + PACKET]) {
                *out += f64::from(carry);
            }
        }
        out
    }
}

/// What a technique adds up to.
#[derive(Clone, Debug, Default, PartialEq)]
struct TechniqueSums {
    /// See [`TECHNIQUE`].
    sums: Sums,
    /// Number of samples that carry light, `[block][lane]`.
    counts: Vec<u32>,
}

impl TechniqueSums {
    fn prepare(&mut self, blocks: usize) {
        self.sums.prepare(TECHNIQUE, blocks);
        self.counts.resize(blocks * PACKET, 0);
    }

    fn copy(&mut self, from: &Self, samples: u32) {
        self.sums.copy(&from.sums, samples);
        self.counts.clone_from(&from.counts);
    }

    /// Adds what the technique contributes to sample number `sample` of the lanes at `at`, where that is `valid`; its
    /// weight only if it is `weighted`.
    #[inline(always)]
    fn add<L: Lanes>(
        &mut self,
        l: L,
        at: (usize, usize),
        sample: u32,
        x: &Contribution<L>,
        valid: L::M,
        weighted: bool,
    ) {
        let carries = x.lit & valid;
        // Where nothing carries, only the first two samples must write.
        if sample <= 1 || carries.any() {
            let V3 { x: r, y: g, z: b } = x.value;
            if weighted {
                self.sums.add(l, at, sample, carries, [r, g, b, x.weight]);
            } else {
                self.sums.add(l, at, sample, carries, [r, g, b]);
            }
            let counts = &mut self.counts[at.0 * PACKET + at.1..];
            let old = if sample == 0 { l.u(0) } else { l.load_u(counts) };
            carries.select_u(old + l.u(1), old).store(counts);
        }
    }

    /// By pixel of a block. With `weighted` false, each weight was 1.
    #[inline(always)]
    fn block(&self, samples: u32, block: usize, channel: usize, weighted: bool) -> [f64; PACKET] {
        if channel == COUNT || (channel == WEIGHT && !weighted) {
            let mut out = [0.0; PACKET];
            for (out, &count) in out.iter_mut().zip(&self.counts[block * PACKET..]) {
                *out = f64::from(count);
            }
            return out;
        }
        self.sums.block(samples, block, channel)
    }
}

/// One sample of each pixel of a packet.
#[derive(Clone, Copy)]
pub struct Sample<L: Lanes> {
    /// What the surfaces seen reflect, by technique.
    pub reflected: Reflected<L>,
    /// Radiance of lights seen directly, 0 elsewhere.
    pub emitted: V3<L>,
    /// True where one is seen.
    pub emits: L::M,
}

impl<L: Lanes> Sample<L> {
    /// Nothing seen.
    #[inline(always)]
    pub fn nothing(l: L) -> Self {
        Self { reflected: Reflected::none(l), emitted: V3::all(l.f(0.0)), emits: l.m(false) }
    }
}

/// What is to be added of a sample once its techniques are.
#[derive(Clone, Copy)]
pub struct Rest<L: Lanes> {
    /// Square of its luminance.
    square: L::F,
    /// False where it is not a finite number.
    valid: L::M,
    emitted: V3<L>,
    emits: L::M,
}

impl<L: Lanes> Rest<L> {
    /// Nothing.
    #[inline(always)]
    pub fn nothing(l: L) -> Self {
        Self { square: l.f(0.0), valid: l.m(true), emitted: V3::all(l.f(0.0)), emits: l.m(false) }
    }

    /// `a` where true, `b` elsewhere.
    #[inline(always)]
    pub fn select(m: L::M, a: &Self, b: &Self) -> Self {
        Self {
            square: m.select(a.square, b.square),
            valid: (m & a.valid) | (!m & b.valid),
            emitted: V3::select(m, a.emitted, b.emitted),
            emits: (m & a.emits) | (!m & b.emits),
        }
    }
}

/// All samples so far of the pixels of one tile.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    /// Pixels of the tile inside the picture, in coordinates of the full image.
    pub bounds: PixelRect,
    /// First block's corner and the number of blocks per row and column: `bounds` widened to
    /// whole patches at its top and left, to whole blocks elsewhere.
    origin: [u32; 2],
    blocks: [u32; 2],
    /// Samples per pixel in the sums.
    pub samples: u32,
    /// Adds up the picture only, no layers: to measure what they cost. Such a tile cannot be shown.
    pub bare: bool,
    /// Which techniques the strategy draws; the other's sums mean nothing.
    draws: PerTechnique<bool>,
    light: TechniqueSums,
    bsdf: TechniqueSums,
    /// Directly visible emission; empty while no light has been seen.
    emission: Option<Sums>,
    luminance2: Sums,
}

impl Tile {
    /// Width and height of a full tile in pixels: about 6000 paths, a tenth of a millisecond.
    pub const SIZE: [u32; 2] = [800, 8];

    /// Cuts a picture into tiles.
    pub fn cut(bounds: PixelRect) -> Vec<PixelRect> {
        let mut tiles = Vec::new();
        // Aligned to the full image, so that a crop computes the same packets.
        let mut y = bounds.min[1] / Self::SIZE[1] * Self::SIZE[1];
        while y < bounds.max[1] {
            let mut x = bounds.min[0] / Self::SIZE[0] * Self::SIZE[0];
            while x < bounds.max[0] {
                tiles.push(PixelRect {
                    min: [x.max(bounds.min[0]), y.max(bounds.min[1])],
                    max: [(x + Self::SIZE[0]).min(bounds.max[0]), (y + Self::SIZE[1]).min(bounds.max[1])],
                });
                x += Self::SIZE[0];
            }
            y += Self::SIZE[1];
        }
        tiles
    }

    /// An empty tile for `strategy`, on the buffers of `recycled` if it has any.
    pub fn new(bounds: PixelRect, strategy: Strategy, recycled: Option<Self>) -> Self {
        let origin = [0, 1].map(|i| bounds.min[i] / SIDE * SIDE);
        let blocks = [0, 1].map(|i| (bounds.max[i] - origin[i]).div_ceil(BLOCK[i]));
        let count = (blocks[0] * blocks[1]) as usize;
        let (mut light, mut bsdf, mut luminance2) = match recycled {
            Some(tile) => (tile.light, tile.bsdf, tile.luminance2),
            None => (TechniqueSums::default(), TechniqueSums::default(), Sums::default()),
        };
        let draws = strategy.draws();
        if draws.light {
            light.prepare(count);
        }
        if draws.bsdf {
            bsdf.prepare(count);
        }
        luminance2.prepare(1, count);
        Self { bounds, origin, blocks, samples: 0, bare: false, draws, light, bsdf, emission: None, luminance2 }
    }

    /// A copy of this tile, on the buffers of `recycled` if it has any.
    pub fn copy(&self, recycled: Option<Self>) -> Self {
        let Some(mut copy) = recycled else { return self.clone() };
        if self.draws.light {
            copy.light.copy(&self.light, self.samples);
        }
        if self.draws.bsdf {
            copy.bsdf.copy(&self.bsdf, self.samples);
        }
        copy.luminance2.copy(&self.luminance2, self.samples);
        let (light, bsdf, luminance2) = (copy.light, copy.bsdf, copy.luminance2);
        Self { light, bsdf, luminance2, emission: self.emission.clone(), ..*self }
    }

    /// Corner of a block in the full image.
    #[inline(always)]
    pub fn block_corner(&self, block: usize) -> [u32; 2] {
        let (row, column) = (block as u32 / self.blocks[0], block as u32 % self.blocks[0]);
        self.corner_at([column, row])
    }

    /// The same by the block's column and row, which may be one beyond the last.
    #[inline(always)]
    pub fn corner_at(&self, [column, row]: [u32; 2]) -> [u32; 2] {
        [self.origin[0] + column * BLOCK[0], self.origin[1] + row * BLOCK[1]]
    }

    /// Number of the block in a column and row.
    #[inline(always)]
    pub fn block_index(&self, [column, row]: [u32; 2]) -> usize {
        (row * self.blocks[0] + column) as usize
    }

    /// Patches of up to [`PATCH`] blocks: for each its first block's column and row, and
    /// those after its last.
    pub fn patches(&self) -> Vec<[[u32; 2]; 2]> {
        let [columns, rows] = self.blocks;
        let mut patches = Vec::with_capacity((columns.div_ceil(PATCH[0]) * rows.div_ceil(PATCH[1])) as usize);
        for y in (0..rows).step_by(PATCH[1] as usize) {
            for x in (0..columns).step_by(PATCH[0] as usize) {
                patches.push([[x, y], [(x + PATCH[0]).min(columns), (y + PATCH[1]).min(rows)]]);
            }
        }
        patches
    }

    /// Number of blocks.
    #[inline(always)]
    pub fn block_count(&self) -> usize {
        (self.blocks[0] * self.blocks[1]) as usize
    }

    /// Block and lane of a pixel inside `bounds`.
    pub fn locate(&self, x: u32, y: u32) -> (usize, usize) {
        let [dx, dy] = [x - self.origin[0], y - self.origin[1]];
        let [width, height] = BLOCK;
        let block = (dy / height) * self.blocks[0] + dx / width;
        (block as usize, ((dy % height) * width + dx % width) as usize)
    }

    /// False where one technique draws all samples: their weights are 1.
    #[inline(always)]
    fn is_weighted(&self) -> bool {
        self.draws == PerTechnique::BOTH
    }

    /// Sums of the light technique over all samples, one value per pixel of `block`.
    #[inline(always)]
    pub fn light(&self, block: usize, channel: usize) -> [f64; PACKET] {
        self.sums(self.draws.light, &self.light, block, channel)
    }

    /// The same of the BSDF technique.
    #[inline(always)]
    pub fn bsdf(&self, block: usize, channel: usize) -> [f64; PACKET] {
        self.sums(self.draws.bsdf, &self.bsdf, block, channel)
    }

    /// Zeros where the technique draws nothing. No closure: one compiled out of line would be so without vectors.
    #[inline(always)]
    fn sums(&self, draws: bool, technique: &TechniqueSums, block: usize, channel: usize) -> [f64; PACKET] {
        if draws { technique.block(self.samples, block, channel, self.is_weighted()) } else { [0.0; PACKET] }
    }

    /// The same of the directly visible emission; `None` where no light has been seen.
    #[inline(always)]
    pub fn emission(&self, block: usize, channel: usize) -> Option<[f64; PACKET]> {
        // Its buffers start as zeros, so the carries always mean something.
        self.emission.as_ref().map(|e| e.block(2, block, channel))
    }

    /// Sums of the squared luminance of samples.
    #[inline(always)]
    pub fn luminance2(&self, block: usize) -> [f64; PACKET] {
        self.luminance2.block(self.samples, block, 0)
    }

    /// Adds what the techniques contribute to sample number `index` of the lanes at `lane` of `block`. Returns what is
    /// left to be added by [`Self::finish`]: a technique's sums need its own samples in their order only.
    #[inline(always)]
    pub fn add<L: Lanes>(&mut self, l: L, at: (usize, usize), index: u32, sample: &Sample<L>) -> Rest<L> {
        let Sample { reflected, emitted, emits } = *sample;
        let mut total = reflected.light.value + reflected.bsdf.value;
        if emits.any() {
            total = total + emitted;
        }
        let y = luminance(l, total);
        let square = y * y;
        let valid = square.le(l.f(f32::MAX));
        if self.bare {
            let technique = if self.draws.light { &mut self.light } else { &mut self.bsdf };
            technique.sums.add(l, at, index, valid, [total.x, total.y, total.z]);
        } else {
            let weighted = self.is_weighted();
            if self.draws.light {
                self.light.add(l, at, index, &reflected.light, valid, weighted);
            }
            if self.draws.bsdf {
                self.bsdf.add(l, at, index, &reflected.bsdf, valid, weighted);
            }
        }
        Rest { square, valid, emitted, emits }
    }

    /// Adds the rest of sample number `index`, and returns how many of the lanes were not finite numbers: those are left
    /// out of all sums.
    #[inline(always)]
    pub fn finish<L: Lanes>(&mut self, l: L, at: (usize, usize), index: u32, rest: &Rest<L>) -> u32 {
        let Rest { square, valid, emitted, emits } = *rest;
        if !self.bare {
            self.luminance2.add(l, at, index, valid, [square]);
            if emits.any() || self.emission.is_some() {
                let blocks = self.block_count();
                let emission = self.emission.get_or_insert_with(|| {
                    let mut sums = Sums::default();
                    sums.prepare(3, blocks);
                    sums
                });
                // The buffer starts as zeros, whenever that was: count as if every sample came before.
                let seen = emits & valid;
                if seen.any() {
                    emission.add(l, at, index.max(2), seen, [emitted.x, emitted.y, emitted.z]);
                }
            }
        }
        if valid.all() { 0 } else { L::N as u32 - valid.bits().count_ones() }
    }
}

/// Luminance of a colour.
#[inline(always)]
pub fn luminance<L: Lanes>(l: L, c: V3<L>) -> L::F {
    c.x.mul_add(l.f(LUMINANCE[0]), c.y.mul_add(l.f(LUMINANCE[1]), c.z * LUMINANCE[2]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::Contribution;
    use crate::lanes::Single;
    use crate::sampler::hash::mix_one;

    /// A contribution of a heavy-tailed distribution: mostly small, now and then 1e4 times as much.
    fn value(counter: u32) -> f32 {
        let u = (mix_one(counter) >> 8) as f32 / 16_777_216.0;
        if u < 1e-3 { 3.0 + 1e7 * u } else { u * u }
    }

    #[test]
    fn sums_are_exact_to_1e_7_after_four_million_samples() {
        let bounds = PixelRect { min: [0, 0], max: BLOCK };
        let mut tile = Tile::new(bounds, Strategy::MisAll, None);
        let mut exact = [0.0f64; 9];
        const SAMPLES: u32 = 1 << 22;
        for index in 0..SAMPLES {
            let [a, b, e] = [0, 1, 2].map(|i| value(3 * index + i));
            // Every other sample carries by the BSDF technique, every fourth sees a light.
            let (carries, emits) = (index % 2 == 1, index % 4 == 3);
            let light = Contribution { value: V3 { x: a, y: 2.0 * a, z: 0.1 }, weight: a.min(1.0), lit: true };
            let bsdf = Contribution { value: V3 { x: 0.3, y: b, z: b }, weight: 0.7, lit: carries };
            let emitted = if emits { V3 { x: e, y: e, z: 1e-3 } } else { V3 { x: 0.0, y: 0.0, z: 0.0 } };
            let sample = Sample::<Single> { reflected: Reflected { light, bsdf }, emitted, emits };
            let rest = tile.add(Single, (0, 5), index, &sample);
            assert_eq!(tile.finish(Single, (0, 5), index, &rest), 0, "valid samples");
            let once = |on: bool, x: f32| if on { f64::from(x) } else { 0.0 };
            for (sum, x) in exact.iter_mut().zip([
                f64::from(a),
                f64::from(2.0 * a),
                f64::from(0.1f32),
                f64::from(a.min(1.0)),
                once(carries, b),
                once(carries, 0.7),
                once(carries, 1.0),
                once(emits, e),
                once(emits, 1e-3),
            ]) {
                *sum += x;
            }
        }
        tile.samples = SAMPLES;
        let emission = |channel| tile.emission(0, channel).expect("a light was seen")[5];
        let found = [
            tile.light(0, 0)[5],
            tile.light(0, 1)[5],
            tile.light(0, 2)[5],
            tile.light(0, WEIGHT)[5],
            tile.bsdf(0, 1)[5],
            tile.bsdf(0, WEIGHT)[5],
            tile.bsdf(0, COUNT)[5],
            emission(0),
            emission(2),
        ];
        for (i, (found, exact)) in found.into_iter().zip(exact).enumerate() {
            assert!((found - exact).abs() < 1e-7 * exact, "sum {i}: {found}, exactly {exact}");
        }
        // A plain sum in single precision would not do.
        let plain = (0..SAMPLES).fold(0.0f32, |sum, index| sum + value(3 * index));
        assert!((f64::from(plain) - exact[0]).abs() > 1e-6 * exact[0], "{plain}: the test cannot fail");
    }
}
