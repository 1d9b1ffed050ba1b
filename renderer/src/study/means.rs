//! Means: is a picture biased, or noisy? The mean over many pixels is known far better than any of them.
//!
//! A square's mean is compared with the reference's: z = (x - r) / sqrt(se_x^2 + se_r^2), and twice the normal tail beyond |z| is the
//! probability of so large a difference without bias. The standard error takes the samples of a pixel as independent, which is more than
//! that of stratified ones: the test errs on the side of "unbiased so far".

use statrs::distribution::{ContinuousCDF as _, Normal};

use super::cells::{Cells, Part};
use crate::frame::Frame;
use crate::layer::Channel;
use crate::table::reference::{LUMINANCE, rgb};

/// The mean luminance of a part of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mean {
    /// Luminance, as radiance.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// Over so many pixels.
    pub pixels: usize,
    /// (sum of samples)^2 / sum of their squares: as many samples of equal brightness would give that error.
    pub bright: f64,
}

/// Fewer samples with light in them say nothing of a mean.
const LEAST_BRIGHT: f64 = 20.0;

impl Mean {
    /// Mean of a frame in each of `parts`; `None` with a single sample per pixel, which has no variance.
    pub fn of_frame(frame: &Frame, cells: &Cells, parts: &[Part]) -> Option<Vec<Self>> {
        let spp = f64::from(frame.spp());
        let (planes, variance) = (rgb(frame), frame.channel(Channel::VarianceY));
        let one = |part: &Part| {
            let (mut sum, mut variances, mut squares, mut count) = (0.0, 0.0, 0.0, 0.0);
            cells.region(*part).each(variance.len(), |pixel| {
                let y: f64 = planes.iter().zip(LUMINANCE).map(|(plane, w)| w * f64::from(plane[pixel])).sum();
                let v = f64::from(variance[pixel]);
                if y.is_finite() && v.is_finite() {
                    sum += y;
                    variances += v / spp;
                    squares += v * (spp - 1.0) + spp * y * y;
                    count += 1.0;
                }
            });
            Self {
                value: sum / count,
                standard_error: f64::sqrt(variances) / count,
                pixels: count as usize,
                bright: if squares > 0.0 { (spp * sum).powi(2) / squares } else { 0.0 },
            }
        };
        (frame.spp() > 1).then(|| parts.iter().map(one).collect())
    }

    /// Probability of so large a difference from `reference` without bias; `None` where too few samples carried light to tell.
    ///
    /// Where light is rare, a mean that is too small comes with a variance that is too small, both in proportion to what was
    /// hit: the variance is taken at the reference's mean if that is larger.
    pub fn p_value(&self, reference: &Self) -> Option<f64> {
        if self.bright < LEAST_BRIGHT {
            return None;
        }
        let own = self.standard_error.powi(2) * (reference.value / self.value).max(1.0);
        let error = (own + reference.standard_error.powi(2)).sqrt();
        let z = (self.value - reference.value).abs() / error;
        let normal = Normal::new(0.0, 1.0).ok()?;
        (error > 0.0).then(|| (2.0 * normal.sf(z)).min(1.0))
    }

    /// 1 / (variance of the mean x seconds of processor time): how much is known after a second.
    pub fn efficiency(&self, cpu_seconds: f64) -> Option<f64> {
        let work = self.standard_error.powi(2) * cpu_seconds;
        (work > 0.0).then(|| work.recip())
    }
}

/// p-values of a family of tests, each as the probability that *any* of them would be as small without bias: 1 - (1 - p)^n (Šidák).
pub fn p_values(family: &[Option<f64>]) -> Vec<Option<f64>> {
    let tests = family.iter().flatten().count() as f64;
    // As written, all digits of a small p would be lost.
    family.iter().map(|p| p.map(|p| -(tests * (-p).ln_1p()).exp_m1())).collect()
}
