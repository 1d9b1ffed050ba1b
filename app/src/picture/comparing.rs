//! Two pictures against each other, worked out: the planes of what is shown, and what is sure of each part in a sentence.

use std::sync::Arc;

use mislab_renderer::blind::Dark;
use mislab_renderer::metrics::ratio::{Noise, Pixels, Ratio};
use mislab_renderer::metrics::{Errors, Reference, Region};
use mislab_renderer::study::{Against, Cells};
use mislab_renderer::{Frame, Layer, Lockstep, PixelRect};

use crate::look::versus::Versus;
use crate::picture::content::Content;
use crate::picture::dark::Darks;
use crate::picture::planes::{Planes, UNLIT};
use crate::picture::variance::{self, luminance};
use crate::state::view::VarianceUnit;

/// Side of the blocks that ratios are shown for, in pixels: those of single pixels are mostly noise themselves.
const BLOCK: usize = 8;

/// What is asked of two pictures of the same pixels.
pub struct Question {
    /// A and B, with the same pixels. Of files there are no variances.
    pub contents: [Content; 2],
    /// Those pixels, and the size of the full image.
    pub pixels: (PixelRect, [u32; 2]),
    /// What their pixels are.
    pub dark: [Darks; 2],
    /// Which number of both.
    pub versus: Versus,
    /// What they have alike.
    pub equal: Lockstep,
    /// What errors are measured against, of the same pixels. Without one the errors are not asked for.
    pub reference: Option<Arc<Against>>,
    /// The squares of their pixels, as far as they are known.
    pub cells: Option<Arc<Cells>>,
    /// A part of its own, in pixels of the full image, within the frames.
    pub part: Option<PixelRect>,
}

/// What came of it.
pub struct Answer {
    /// The numbers.
    pub planes: Arc<Planes>,
    /// What is sure of the whole.
    pub whole: String,
    /// The same of each square, in their order.
    pub squares: Vec<String>,
    /// The same of the part.
    pub part: Option<String>,
}

impl Question {
    /// Works it out: a hundredth of a second or so for each 100 000 pixels. `None`: errors without a reference, or a file without colours.
    pub fn answer(&self) -> Option<Answer> {
        let (bounds, image) = self.pixels;
        let [a, b] = self.contents.each_ref().map(|content| Side::of(content, unit(self.equal)));
        let sides = [a?, b?].map(|side| side.without(&self.dark, bounds, image));
        let noise = || Pixels::noise(&sides[0].noise(), &sides[1].noise(), bounds.width() as usize);
        let lit = sides.each_ref().map(|side| side.mean.as_slice());
        let (pixels, data) = match self.versus {
            Versus::Difference => (noise(), difference(&sides)),
            Versus::Variances => {
                let pixels = noise();
                let data = blocks(&pixels, lit, bounds);
                (pixels, data)
            }
            Versus::Errors => {
                let reference = self.reference.as_ref()?;
                let [a, b] = sides.each_ref().map(|side| reference.pixel_errors(side.rgb()));
                let pixels = Pixels::errors(&a, &b);
                let data = blocks(&pixels, lit, bounds);
                (pixels, data)
            }
        };
        let mut planes = Planes::new(self.versus, bounds, image, data);
        for dark in self.dark.iter().flatten() {
            match self.versus {
                // What cannot be sampled is no noise, but an error.
                Versus::Errors => planes.mark_unlit(dark),
                Versus::Variances | Versus::Difference => planes.mark(dark),
            }
        }
        let what = if self.versus == Versus::Errors { "" } else { per(self.equal) };
        let is_of_file = self.contents.iter().any(|content| content.frame().is_none());
        let sentence = |place: &str, region: &Region<'_>| {
            let found = if is_of_file && self.versus == Versus::Difference {
                means(&sides, region)
            } else {
                Ratio::of(&pixels, region).map(|ratio| format!("{}{what}", ratio.sentence()))
            };
            format!("{place}: {}", found.as_deref().unwrap_or("nothing to compare yet"))
        };
        let part = self.part.map(|part| {
            let region = Region::Rect { width: bounds.width() as usize, rect: relative(part, bounds) };
            sentence("In the part", &region)
        });
        let squares = self.cells.iter().flat_map(|cells| &cells.squares).map(|square| {
            let place = format!("{} \u{d7} {}", square.plate, square.light);
            sentence(&place, &Region::Pixels(&square.pixels))
        });
        let squares = squares.collect();
        Some(Answer { planes: Arc::new(planes), whole: sentence("Over all", &Region::All), squares, part })
    }
}

/// What variances are counted in where that is equal.
fn unit(equal: Lockstep) -> VarianceUnit {
    match equal {
        Lockstep::Spp => VarianceUnit::Relative,
        Lockstep::Rays => VarianceUnit::PerRay,
        Lockstep::CpuSeconds => VarianceUnit::PerSecond,
    }
}

fn per(equal: Lockstep) -> &'static str {
    match equal {
        Lockstep::Spp => "; variance per sample",
        Lockstep::Rays => "; variance per ray",
        Lockstep::CpuSeconds => "; variance per second",
    }
}

/// The same pixels counted from the first one of `bounds`.
fn relative(part: PixelRect, bounds: PixelRect) -> PixelRect {
    let shift = |at: [u32; 2]| [0, 1].map(|i| at[i] - bounds.min[i]);
    PixelRect { min: shift(part.min), max: shift(part.max) }
}

/// One of the two pictures, as far as noise is concerned.
struct Side {
    /// Red, green and blue, one after the other.
    colours: Vec<f32>,
    /// Their luminance.
    mean: Vec<f32>,
    variance: Vec<f32>,
    cost: f64,
}

impl Side {
    /// `None` of a file without colours.
    fn of(content: &Content, unit: VarianceUnit) -> Option<Self> {
        match content {
            Content::Frame(frame) => Some(Self::of_frame(frame, unit)),
            Content::File(file) => {
                let planes = file.planes(Layer::Picture, "").ok()?;
                let colours = planes.channels().collect::<Vec<_>>().concat();
                let area = planes.bounds().area();
                let mean = (0..area).map(|i| luminance([0, 1, 2].map(|c| f64::from(colours[c * area + i]))) as f32);
                Some(Self { mean: mean.collect(), colours, variance: vec![f32::NAN; area], cost: 1.0 })
            }
        }
    }

    fn of_frame(frame: &Frame, unit: VarianceUnit) -> Self {
        let area = frame.bounds().area();
        let mut data = vec![0.0; variance::CHANNELS.len() * area];
        frame.resolve(&variance::CHANNELS, &mut data);
        let luminances = (0..area).map(|i| luminance([0, 1, 2].map(|c| f64::from(data[c * area + i]))) as f32);
        let mean: Vec<f32> = luminances.collect();
        let mut variance = data.split_off(3 * area);
        for (variance, mean) in variance.iter_mut().zip(&mean) {
            *variance = beyond_rounding(*variance, *mean);
        }
        Self { colours: data, mean, variance, cost: variance::cost(unit, frame) }
    }

    fn rgb(&self) -> [&[f32]; 3] {
        let area = self.mean.len();
        [0, 1, 2].map(|c| &self.colours[c * area..(c + 1) * area])
    }

    /// Without the pixels that one of the pictures cannot sample.
    fn without(mut self, dark: &[Darks; 2], bounds: PixelRect, image: [u32; 2]) -> Self {
        let width = bounds.width() as usize;
        for dark in dark.iter().flatten() {
            for (pixel, variance) in self.variance.iter_mut().enumerate() {
                let [x, y] = [pixel % width + bounds.min[0] as usize, pixel / width + bounds.min[1] as usize];
                if dark[y * image[0] as usize + x] == Dark::Blind {
                    *variance = f32::NAN;
                }
            }
        }
        self
    }

    fn noise(&self) -> Noise<'_> {
        Noise { mean: &self.mean, variance: &self.variance, cost: self.cost }
    }
}

/// 0 where a variance is what rounding leaves of that of equal samples, as those of a lamp: the difference of two numbers of seven digits.
fn beyond_rounding(variance: f32, mean: f32) -> f32 {
    const ROUNDING: f32 = 5e-7;
    if variance < ROUNDING * mean * mean { 0.0 } else { variance }
}

/// Mean luminances of both, and how far pixels are apart; what is not a number in either is left out.
fn means([a, b]: &[Side; 2], region: &Region<'_>) -> Option<String> {
    let errors = Errors::of(&[&a.mean], &Reference::Exact(&[&b.mean]), region);
    let (a, b, apart) = (errors.mean()?, errors.reference_mean()?, errors.mse()?.sqrt());
    Some(format!("mean luminance of A {a:.4}, of B {b:.4}; root mean square of A \u{2212} B {apart:.1e}"))
}

fn difference([a, b]: &[Side; 2]) -> Vec<f32> {
    let data = a.mean.iter().zip(&b.mean).map(|(a, b)| if *a == 0.0 && *b == 0.0 { f32::NAN } else { a - b });
    data.collect()
}

/// log2 of the ratio of the sums over each block. NaN where nothing is known, where one of errors is negative by chance, and where all that
/// a picture has is pixels without light yet: that is not a noise of 0. [`UNLIT`] where both pictures are exact: lamps, and what a mirror
/// shows of them.
fn blocks(pixels: &Pixels, means: [&[f32]; 2], bounds: PixelRect) -> Vec<f32> {
    let [width, height] = [bounds.width() as usize, bounds.height() as usize];
    let mut data = vec![f32::NAN; bounds.area()];
    for top in (0..height).step_by(BLOCK) {
        for left in (0..width).step_by(BLOCK) {
            let rows = top..(top + BLOCK).min(height);
            let columns = left..(left + BLOCK).min(width);
            let places = rows.flat_map(|y| columns.clone().map(move |x| y * width + x));
            let known = places.filter(|&at| pixels.at(at).iter().all(|v| v.is_finite()));
            let (mut sums, mut lit) = ([0.0; 2], [false; 2]);
            for at in known.clone() {
                let values = pixels.at(at);
                for side in [0, 1] {
                    sums[side] += values[side];
                    lit[side] |= values != [0.0; 2] && means[side][at] > 0.0;
                }
            }
            let [a, b] = sums;
            for at in known {
                data[at] = match (a, b) {
                    (0.0, 0.0) if means.iter().all(|mean| mean[at] > 0.0) => UNLIT,
                    (0.0, 0.0) => f32::NAN,
                    (a, b) if a < 0.0 || b < 0.0 => f32::NAN,
                    (a, b) if (a == 0.0 && !lit[0]) || (b == 0.0 && !lit[1]) => f32::NAN,
                    // Beyond a factor of a million the colour is the same.
                    (a, b) => (a / b).log2().clamp(-20.0, 20.0) as f32,
                };
            }
        }
    }
    data
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_is_no_noise() {
        assert_eq!(
            [1e-7, 1e-5, f32::NAN].map(|v| beyond_rounding(v, 1.0).to_bits()),
            [0.0, 1e-5, f32::NAN].map(f32::to_bits)
        );
        assert_eq!(beyond_rounding(1e-7, 0.1), 1e-7, "it is relative to the mean square");
    }

    /// Six blocks in a row: A has no light yet; both are exact; A is not; both are noisy; nothing is known; a lamp, and beside it a
    /// surface where A has no light yet.
    #[test]
    fn no_light_yet_is_no_noise_of_zero() {
        let bounds = PixelRect { min: [0, 0], max: [48, 8] };
        let beside_lamp = |pixel: usize| pixel % 48 >= 44;
        let plane = |blocks: [f64; 6], beside: f64| -> Vec<f64> {
            (0..384).map(|at| if beside_lamp(at) { beside } else { blocks[at % 48 / BLOCK] }).collect()
        };
        let a = plane([0.0, 0.0, 2.0, 8.0, f64::NAN, 0.0], 0.0);
        let b = plane([3.0, 0.0, 0.0, 2.0, f64::NAN, 0.0], 5.0);
        let lit = |blocks, beside| plane(blocks, beside).into_iter().map(|v| v as f32).collect::<Vec<f32>>();
        let means = [lit([0.0, 1.0, 1.0, 1.0, 1.0, 1.0], 0.0), lit([1.0; 6], 1.0)];
        let found = blocks(&Pixels::errors(&a, &b), [&means[0], &means[1]], bounds);
        let of_blocks = [0, 8, 16, 24, 32, 40].map(|x| found[5 * 48 + x]);
        assert!([0, 4, 5].iter().all(|i| of_blocks[*i].is_nan()), "{of_blocks:?}");
        assert_eq!(of_blocks[1..4], [UNLIT, 20.0, 2.0], "{of_blocks:?}");
    }
}
