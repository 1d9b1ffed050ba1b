//! Errors of a picture by blocks of pixels: what is kept of it so that any rectangle of blocks has its curve afterwards.

use mislab_kernel::request::PixelRect;

use crate::metrics::{Errors, Region};

/// The finest blocks, in pixels a side.
const SIDE: u32 = 8;
/// A picture has at most so many blocks a side: 120 kB of numbers.
const MOST: u32 = 100;

/// Sums of a picture's squared errors over blocks of its pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Blocks {
    bounds: PixelRect,
    sums: Vec<Sums>,
}

/// Of one block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Sums {
    /// Squared errors over the square of the reference.
    relative: f32,
    squared: f32,
    /// Values that were compared.
    values: f32,
}

impl Blocks {
    /// Of a picture of `bounds`, from its errors in each rectangle of its planes.
    pub(crate) fn new(bounds: PixelRect, errors: impl Fn(&Region<'_>) -> Errors) -> Self {
        let side = side(bounds);
        let width = bounds.width() as usize;
        let sums = |min: [u32; 2]| {
            let max = [(min[0] + side).min(bounds.width()), (min[1] + side).min(bounds.height())];
            let errors = errors(&Region::Rect { width, rect: PixelRect { min, max } });
            let values = errors.compared as f64;
            let sum = |mean: Option<f64>| (mean.unwrap_or(0.0) * values) as f32;
            Sums { relative: sum(errors.rel_mse()), squared: sum(errors.mse()), values: values as f32 }
        };
        let corners = |length: u32| (0..length).step_by(side as usize);
        let all = corners(bounds.height()).flat_map(|y| corners(bounds.width()).map(move |x| [x, y]));
        Self { bounds, sums: all.map(sums).collect() }
    }

    /// relMSE and MSE over the blocks that touch a rectangle of the full image; NaN where it holds no value.
    pub fn over(&self, rect: PixelRect) -> [f64; 2] {
        let across = self.bounds.width().div_ceil(side(self.bounds));
        let [columns, rows] = [0, 1].map(|axis| range(rect, self.bounds, axis));
        let blocks = rows.flat_map(|y| columns.clone().map(move |x| (y * across + x) as usize));
        let sum = blocks.map(|block| self.sums[block]).fold([0.0; 3], |[relative, squared, values], sums| {
            [relative + f64::from(sums.relative), squared + f64::from(sums.squared), values + f64::from(sums.values)]
        });
        [sum[0] / sum[2], sum[1] / sum[2]]
    }
}

/// The rectangle of all blocks of a picture of `bounds` that touch `rect`, both in pixels of the full image; `None` if none does.
pub fn whole_blocks(rect: PixelRect, bounds: PixelRect) -> Option<PixelRect> {
    if (0..2).any(|axis| rect.min[axis] >= bounds.max[axis] || rect.max[axis] <= bounds.min[axis]) {
        return None;
    }
    let ends = [0, 1].map(|axis| {
        let (blocks, from) = (range(rect, bounds, axis), bounds.min[axis]);
        let end = |block: u32| (from + block * side(bounds)).min(bounds.max[axis]);
        [end(blocks.start), end(blocks.end)]
    });
    let rect = PixelRect { min: ends.map(|[min, _]| min), max: ends.map(|[_, max]| max) };
    (rect.area() > 0).then_some(rect)
}

/// Pixels a side of the blocks of a picture.
fn side(bounds: PixelRect) -> u32 {
    SIDE * bounds.width().max(bounds.height()).div_ceil(SIDE * MOST).max(1)
}

/// The blocks along an axis that touch a rectangle.
fn range(rect: PixelRect, bounds: PixelRect, axis: usize) -> std::ops::Range<u32> {
    let within = |at: u32| at.clamp(bounds.min[axis], bounds.max[axis]) - bounds.min[axis];
    within(rect.min[axis]) / side(bounds)..within(rect.max[axis]).div_ceil(side(bounds))
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn rect(min: [u32; 2], max: [u32; 2]) -> PixelRect {
        PixelRect { min, max }
    }

    #[test]
    fn rectangles_grow_to_whole_blocks_of_the_crop() {
        let bounds = rect([3, 5], [63, 45]);
        assert_eq!(whole_blocks(rect([10, 14], [12, 22]), bounds), Some(rect([3, 13], [19, 29])));
        assert_eq!(whole_blocks(rect([60, 0], [900, 900]), bounds), Some(rect([59, 5], [63, 45])), "the rest of it");
        assert_eq!(whole_blocks(rect([63, 0], [900, 900]), bounds), None, "outside");
        let large = rect([0, 0], [1601, 10]);
        assert_eq!(
            whole_blocks(rect([0, 0], [1, 1]), large),
            Some(rect([0, 0], [24, 10])),
            "at most 100 blocks a side"
        );
    }
}
