//! The numbers of a square: relative error, its uncertainty, and which files share the cross.

use super::regions::Square;
use crate::metrics::{self, Errors, Region};

/// A converged picture in two halves that share no sample, each of three channels.
#[derive(Clone, Debug)]
pub struct Reference {
    /// Red, green and blue of each half.
    pub halves: [[Vec<f64>; 3]; 2],
}

impl Reference {
    /// relMSE of `picture` in each of [`Square::ALL`], against the two halves ([`metrics::Reference::Halves`]): the mean over
    /// its pixels and channels. `None` for a square without pixels.
    pub fn rel_mse(&self, picture: [&[f32]; 3], squares: &[Option<Square>]) -> [Option<f64>; 4] {
        each_square(squares, |region| self.errors(picture, region))
    }

    /// Errors of `picture` in a region.
    pub fn errors(&self, picture: [&[f32]; 3], region: &Region<'_>) -> Errors {
        let [first, second] = self.planes();
        Errors::of(&picture, &metrics::Reference::Halves([&first, &second]), region)
    }

    /// Squared errors of each pixel of `picture`, by [`metrics::pixel_errors`].
    pub fn pixel_errors(&self, picture: [&[f32]; 3]) -> Vec<f64> {
        let [first, second] = self.planes();
        metrics::pixel_errors(&picture, &metrics::Reference::Halves([&first, &second]))
    }

    /// The reference's own relMSE over all pixels.
    pub fn own(&self) -> Option<f64> {
        let [first, second] = self.planes();
        Errors::of_halves([&first, &second], &Region::All).rel_mse()
    }

    /// The reference's own relMSE in each square.
    pub fn own_rel_mse(&self, squares: &[Option<Square>]) -> [Option<f64>; 4] {
        let [first, second] = self.planes();
        each_square(squares, |region| Errors::of_halves([&first, &second], region))
    }

    fn planes(&self) -> [[&[f64]; 3]; 2] {
        self.halves.each_ref().map(|half| half.each_ref().map(Vec::as_slice))
    }
}

fn each_square(squares: &[Option<Square>], errors: impl Fn(&Region<'_>) -> Errors) -> [Option<f64>; 4] {
    Square::ALL.map(|square| {
        let mask: Vec<bool> = squares.iter().map(|&s| s == Some(square)).collect();
        errors(&Region::Mask(&mask)).rel_mse()
    })
}

/// Mean of values and its standard error: sample standard deviation over the square root of their number, at least 2.
pub fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

/// One-sided exact rank test (Mann and Whitney 1947): the probability that so many pairs of a value of `a` and one of `b`
/// have `a` above, if both came from one distribution. Ties count as not above.
///
/// Errors of rendering are heavy-tailed: one bright sample among millions can carry the mean, and a t test then finds
/// nothing different from anything. Ranks do not care how far above a value is.
pub fn p_value_above(a: &[f64], b: &[f64]) -> f64 {
    let above = a.iter().map(|x| b.iter().filter(|y| x > y).count()).sum::<usize>();
    // ways[j][u]: orders of the values seen so far and j of b, in which u pairs have a above.
    let (n, pairs) = (b.len(), a.len() * b.len());
    let mut ways = vec![vec![0.0_f64; pairs + 1]; n + 1];
    for row in &mut ways {
        row[0] = 1.0;
    }
    for _ in a {
        let mut next = vec![vec![0.0; pairs + 1]; n + 1];
        for j in 0..=n {
            for u in 0..=pairs {
                // The largest value is one of a's, above all j of b; or one of b's, above nothing that counts.
                let of_a = if u >= j { ways[j][u - j] } else { 0.0 };
                let of_b = if j > 0 { next[j - 1][u] } else { 0.0 };
                next[j][u] = of_a + of_b;
            }
        }
        ways = next;
    }
    let all: f64 = ways[n].iter().sum();
    ways[n][above..].iter().sum::<f64>() / all
}

/// The crosses of one square, given the errors of each file's replicates: the smallest mean, and every other that is not
/// above it at `significance`. Files without values get none.
pub fn crosses(files: &[&[f64]], significance: f64) -> Vec<bool> {
    let measured = files.iter().filter(|values| values.len() >= 2);
    let best = measured.min_by(|a, b| mean_and_error(a).0.total_cmp(&mean_and_error(b).0));
    let cross = |values: &&[f64]| match best {
        Some(best) if !values.is_empty() => values == best || p_value_above(values, best) >= significance,
        _ => false,
    };
    files.iter().map(cross).collect()
}

/// Significance of one of `comparisons` tests, so that `family` is the probability of any false alarm among them (Šidák).
pub fn sidak(family: f64, comparisons: u32) -> f64 {
    1.0 - (1.0 - family).powf(1.0 / f64::from(comparisons))
}
