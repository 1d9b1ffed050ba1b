//! The numbers of a square: relative error, its uncertainty, and which files share the cross.

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::regions::Square;
use crate::metrics::RELMSE_EPSILON;

/// A converged picture in two halves that share no sample, each of three channels.
#[derive(Clone, Debug)]
pub struct Reference {
    /// Red, green and blue of each half.
    pub halves: [[Vec<f64>; 3]; 2],
}

impl Reference {
    /// relMSE of `picture` in each of [`Square::ALL`]: the mean over its pixels and channels of
    ///
    /// `(x - r1) (x - r2) / (r^2 + epsilon)`, `r = (r1 + r2) / 2`
    ///
    /// with r1 and r2 the halves of the reference. Their errors are independent of each other and of x's, so that the
    /// product expects the squared error of x alone: the reference's own noise does not add to it, as it does in
    /// `(x - r)^2`. It may be negative by chance where x is nearly exact. `None` for a square without pixels.
    pub fn rel_mse(&self, picture: [&[f32]; 3], squares: &[Option<Square>]) -> [Option<f64>; 4] {
        self.mean(squares, |channel, pixel, r1, r2| {
            let x = f64::from(picture[channel][pixel]);
            (x - r1) * (x - r2)
        })
    }

    /// The reference's own relMSE in each square: half the difference of its halves, squared, is the variance of their mean.
    pub fn own_rel_mse(&self, squares: &[Option<Square>]) -> [Option<f64>; 4] {
        self.mean(squares, |_, _, r1, r2| ((r1 - r2) / 2.0).powi(2))
    }

    fn mean(
        &self,
        squares: &[Option<Square>],
        squared_error: impl Fn(usize, usize, f64, f64) -> f64,
    ) -> [Option<f64>; 4] {
        Square::ALL.map(|square| {
            let (mut sum, mut count) = (0.0, 0_u64);
            for pixel in (0..squares.len()).filter(|&p| squares[p] == Some(square)) {
                for channel in 0..3 {
                    let [r1, r2] = [0, 1].map(|half| self.halves[half][channel][pixel]);
                    let r = (r1 + r2) / 2.0;
                    sum += squared_error(channel, pixel, r1, r2) / (r * r + RELMSE_EPSILON);
                    count += 1;
                }
            }
            (count > 0).then(|| sum / count as f64)
        })
    }
}

/// Mean and standard error over independent replicates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Arithmetic mean.
    pub mean: f64,
    /// Sample standard deviation over the square root of `replicates`.
    pub standard_error: f64,
    /// How many, at least 2.
    pub replicates: usize,
}

impl Estimate {
    /// Of at least two values.
    pub fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
        Self { mean, standard_error: (variance / n).sqrt(), replicates: values.len() }
    }

    /// Probability of a difference at least this large if `self`'s expected value were not above `best`'s: Welch's t test,
    /// one-sided.
    pub fn p_value_above(&self, best: &Self) -> f64 {
        let (v1, v2) = (self.standard_error.powi(2), best.standard_error.powi(2));
        if v1 + v2 == 0.0 {
            return if self.mean > best.mean { 0.0 } else { 1.0 };
        }
        let degrees =
            (v1 + v2).powi(2) / (v1 * v1 / (self.replicates as f64 - 1.0) + v2 * v2 / (best.replicates as f64 - 1.0));
        match StudentsT::new(0.0, 1.0, degrees) {
            Ok(t) => t.sf((self.mean - best.mean) / (v1 + v2).sqrt()),
            // Errors so small that their fourth powers vanish: as good as none.
            Err(_) => f64::from(u8::from(self.mean <= best.mean)),
        }
    }
}

/// The crosses of one square: the smallest error, and every other that is not above it at `significance`.
pub fn crosses(estimates: &[Option<Estimate>], significance: f64) -> Vec<bool> {
    let best = estimates.iter().flatten().min_by(|a, b| a.mean.total_cmp(&b.mean)).copied();
    let cross = |e: &Option<Estimate>| match (e, best) {
        (Some(e), Some(best)) => *e == best || e.p_value_above(&best) >= significance,
        _ => false,
    };
    estimates.iter().map(cross).collect()
}

/// Significance of one of `comparisons` tests, so that `family` is the probability of any false alarm among them (Šidák).
pub fn sidak(family: f64, comparisons: u32) -> f64 {
    1.0 - (1.0 - family).powf(1.0 / f64::from(comparisons))
}
