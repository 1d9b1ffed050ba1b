//! How far pictures are apart: the measures, over planes of floats. Two files compared are in `compare`, the noise of two
//! pictures in [`ratio`].

mod compare;
pub mod ratio;
mod resample;

pub use compare::{Comparison, Difference, Maximum, compare, compare_resampled};
use mislab_kernel::request::PixelRect;

/// The constant in [`rel_mse`]'s denominator: keeps black pixels from counting without bound.
pub const RELMSE_EPSILON: f64 = 1e-2;

/// Relative squared error of one value: `(a - b)^2 / (b^2 + epsilon)`, `b` being the reference
/// (Rousselle et al. 2011; epsilon as in the image viewer tev).
pub fn rel_mse(a: f64, b: f64) -> f64 {
    relative((a - b) * (a - b), b)
}

/// A squared error over the square of the reference.
fn relative(squared: f64, reference: f64) -> f64 {
    squared / (reference * reference + RELMSE_EPSILON)
}

/// What a picture is measured against: the same channels and pixels.
#[derive(Clone, Copy, Debug)]
pub enum Reference<'a> {
    /// One picture, taken as exact: its own noise counts as error.
    Exact(&'a [&'a [f32]]),
    /// A converged picture in two halves r1 and r2 that share no sample. `(x - r1) (x - r2)` takes the place of
    /// `(x - r)^2`, r being their mean: their errors are independent of each other and of x's, so that the product expects the
    /// squared error of x alone. It may be negative by chance where x is nearly exact.
    Halves([&'a [&'a [f64]]; 2]),
}

impl Reference<'_> {
    fn at(&self, channel: usize, pixel: usize) -> [f64; 2] {
        match self {
            Self::Exact(planes) => [f64::from(planes[channel][pixel]); 2],
            Self::Halves(halves) => halves.map(|planes| planes[channel][pixel]),
        }
    }
}

/// The pixels that count, of planes stored row by row.
#[derive(Clone, Copy, Debug)]
pub enum Region<'a> {
    /// All.
    All,
    /// Those of a rectangle; `min` and `max` count from the first pixel of the plane.
    Rect {
        /// Width of the plane in pixels.
        width: usize,
        /// The part of it.
        rect: PixelRect,
    },
    /// Those where it is true; one value per pixel.
    Mask(&'a [bool]),
    /// Those of these indices into the planes.
    Pixels(&'a [u32]),
}

impl Region<'_> {
    /// Calls `visit` with the index of each pixel of a plane of `len`, in their order.
    pub(crate) fn each(&self, len: usize, mut visit: impl FnMut(usize)) {
        match *self {
            Self::All => (0..len).for_each(visit),
            Self::Rect { width, rect } => {
                for y in rect.min[1]..rect.max[1] {
                    for x in rect.min[0]..rect.max[0] {
                        visit(y as usize * width + x as usize);
                    }
                }
            }
            Self::Mask(mask) => {
                assert_eq!(mask.len(), len, "one value of the mask per pixel");
                (0..len).filter(|&pixel| mask[pixel]).for_each(visit);
            }
            Self::Pixels(pixels) => pixels.iter().for_each(|&pixel| visit(pixel as usize)),
        }
    }
}

/// Sums over the values of planes, in double precision: pixel by pixel, at each the channels in turn. All of them are over
/// one set of pixels: those whose values are finite in every channel of the picture and of the reference. What is undefined
/// elsewhere is counted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Errors {
    /// Values of the pixels that are compared.
    pub compared: u64,
    /// Values undefined alike in both: both NaN, or the same infinity.
    pub both_undefined: u64,
    /// Values undefined in the picture only.
    pub undefined_in_picture: u64,
    /// Values undefined in the reference only.
    pub undefined_in_reference: u64,
    /// Values undefined in both, in different ways.
    pub undefined_differently: u64,
    /// Largest difference, and the index of its pixel in a plane.
    pub maximum: Option<(f64, usize)>,
    sum: f64,
    reference_sum: f64,
    squared: f64,
    relative: f64,
}

impl Errors {
    /// Of `picture`, one plane per channel, in a region.
    ///
    /// # Panics
    /// If planes differ in length, the reference has fewer channels, or the region reaches beyond the planes.
    pub fn of(picture: &[&[f32]], reference: &Reference<'_>, region: &Region<'_>) -> Self {
        let mut errors = Self::default();
        region.each(picture.first().map_or(0, |plane| plane.len()), |pixel| {
            let values =
                || picture.iter().enumerate().map(|(c, plane)| (f64::from(plane[pixel]), reference.at(c, pixel)));
            if values().all(|(x, halves)| x.is_finite() && mean_of(halves).is_finite()) {
                for (x, [r1, r2]) in values() {
                    let r = mean_of([r1, r2]);
                    errors.sum += x;
                    errors.reference_sum += r;
                    errors.count(r, (x - r1) * (x - r2), (x - r).abs(), pixel);
                }
            } else {
                values().for_each(|(x, halves)| errors.count_undefined(x, mean_of(halves)));
            }
        });
        errors
    }

    /// Of the mean of the halves: half their difference, squared, is the variance of their mean.
    ///
    /// # Panics
    /// As [`Self::of`].
    pub fn of_halves(halves: [&[&[f64]]; 2], region: &Region<'_>) -> Self {
        let mut errors = Self::default();
        region.each(halves[0].first().map_or(0, |plane| plane.len()), |pixel| {
            for (first, second) in halves[0].iter().zip(halves[1]) {
                let (r1, r2) = (first[pixel], second[pixel]);
                let half = (r1 - r2) / 2.0;
                errors.count((r1 + r2) / 2.0, half * half, half.abs(), pixel);
            }
        });
        errors
    }

    fn count_undefined(&mut self, x: f64, r: f64) {
        match (x.is_finite(), r.is_finite()) {
            (true, true) => {}
            (false, true) => self.undefined_in_picture += 1,
            (true, false) => self.undefined_in_reference += 1,
            (false, false) if x == r || (x.is_nan() && r.is_nan()) => self.both_undefined += 1,
            (false, false) => self.undefined_differently += 1,
        }
    }

    /// One value with reference r.
    fn count(&mut self, r: f64, squared: f64, difference: f64, pixel: usize) {
        self.squared += squared;
        self.relative += relative(squared, r);
        self.compared += 1;
        if self.maximum.is_none_or(|(largest, _)| difference > largest) {
            self.maximum = Some((difference, pixel));
        }
    }

    /// Counts other values in: of another channel, or of another part of the same planes.
    pub fn merge(&mut self, other: &Self) {
        self.sum += other.sum;
        self.reference_sum += other.reference_sum;
        self.squared += other.squared;
        self.relative += other.relative;
        self.compared += other.compared;
        self.both_undefined += other.both_undefined;
        self.undefined_in_picture += other.undefined_in_picture;
        self.undefined_in_reference += other.undefined_in_reference;
        self.undefined_differently += other.undefined_differently;
        if let Some((difference, pixel)) = other.maximum
            && self.maximum.is_none_or(|(largest, _)| difference > largest)
        {
            self.maximum = Some((difference, pixel));
        }
    }

    /// Values undefined in one only, or in different ways.
    pub fn undefined_mismatch(&self) -> u64 {
        self.undefined_in_picture + self.undefined_in_reference + self.undefined_differently
    }

    /// Mean of the picture; `None` if no pixel is compared.
    pub fn mean(&self) -> Option<f64> {
        mean(self.sum, self.compared)
    }

    /// The same of the reference.
    pub fn reference_mean(&self) -> Option<f64> {
        mean(self.reference_sum, self.compared)
    }

    /// Mean squared error.
    pub fn mse(&self) -> Option<f64> {
        mean(self.squared, self.compared)
    }

    /// Mean of squared errors over the square of the reference: [`rel_mse`].
    pub fn rel_mse(&self) -> Option<f64> {
        mean(self.relative, self.compared)
    }
}

/// Squared error of each pixel over the square of the reference, the mean of its channels; NaN where a value is undefined. Its
/// mean over a region is the relMSE of that, so that single ones may be negative by chance.
///
/// # Panics
/// If planes differ in length, or the reference has fewer channels.
pub fn pixel_errors(picture: &[&[f32]], reference: &Reference<'_>) -> Vec<f64> {
    let pixels = 0..picture.first().map_or(0, |plane| plane.len());
    let error = |pixel: usize| {
        let each = picture.iter().enumerate().map(|(channel, plane)| {
            let (x, [r1, r2]) = (f64::from(plane[pixel]), reference.at(channel, pixel));
            relative((x - r1) * (x - r2), mean_of([r1, r2]))
        });
        let sum = each.sum::<f64>();
        if sum.is_finite() { sum / picture.len() as f64 } else { f64::NAN }
    };
    pixels.map(error).collect()
}

fn mean_of([r1, r2]: [f64; 2]) -> f64 {
    (r1 + r2) / 2.0
}

fn mean(sum: f64, count: u64) -> Option<f64> {
    (count > 0).then(|| sum / count as f64)
}
