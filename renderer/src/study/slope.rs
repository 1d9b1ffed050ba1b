//! The slope of an error curve on logarithmic axes, and how well it is known.

use statrs::distribution::{ContinuousCDF as _, StudentsT};

/// A slope and its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Power of the samples that the error goes with.
    pub slope: f64,
    /// Lower and upper end of the interval that holds the true slope 95 times in 100.
    pub interval: [f64; 2],
}

/// Least squares over the logarithms of the mean errors. `errors` holds, for each of the ascending sample counts `at`, one value
/// for each replicate; replicates must be independent of each other. A mean that is not positive has no logarithm
/// and is left out. `None` with fewer than two points, points without two replicates, or where nothing but one error was ever
/// found: no sample has hit a light.
///
/// The interval is Student's, by the jackknife over replicates (Tukey 1958): it needs no model of the errors, whose
/// logarithms are far from normal where bright samples are rare.
pub fn fit(at: &[u32], errors: &[Vec<f64>]) -> Option<Fit> {
    let replicates = errors.iter().map(Vec::len).min()?;
    if replicates < 2 {
        return None;
    }
    if errors.iter().flatten().all(|error| *error == errors[0][0]) {
        return None;
    }
    let sums: Vec<f64> = errors.iter().map(|errors| errors.iter().sum()).collect();
    let n = replicates as f64;
    let slope = line(at, sums.iter().map(|sum| sum / n))?;
    let without = |left_out: usize| line(at, errors.iter().zip(&sums).map(|(e, sum)| (sum - e[left_out]) / (n - 1.0)));
    let others: Vec<f64> = (0..replicates).map(without).collect::<Option<_>>()?;
    let mean = others.iter().sum::<f64>() / n;
    let variance = others.iter().map(|slope| (slope - mean).powi(2)).sum::<f64>() * (n - 1.0) / n;
    let quantile = StudentsT::new(0.0, 1.0, n - 1.0).ok()?.inverse_cdf(0.975);
    let half = quantile * variance.sqrt();
    Some(Fit { slope, interval: [slope - half, slope + half] })
}

/// Slope of the least-squares line through the logarithms.
fn line(at: &[u32], means: impl Iterator<Item = f64>) -> Option<f64> {
    let points: Vec<[f64; 2]> =
        at.iter().zip(means).filter(|(_, mean)| *mean > 0.0).map(|(&x, y)| [f64::from(x).ln(), y.ln()]).collect();
    let n = points.len() as f64;
    let mean = |axis: usize| points.iter().map(|p| p[axis]).sum::<f64>() / n;
    let [x0, y0] = [mean(0), mean(1)];
    let (mut xx, mut xy) = (0.0, 0.0);
    for [x, y] in &points {
        xx += (x - x0) * (x - x0);
        xy += (x - x0) * (y - y0);
    }
    (points.len() >= 2).then(|| xy / xx)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_has_its_power() {
        let at = [1, 2, 4, 8, 16];
        let errors: Vec<Vec<f64>> = at.iter().map(|&n| vec![3.0 / f64::from(n).powf(1.5); 4]).collect();
        let Fit { slope, interval: [low, high] } = fit(&at, &errors).expect("five points");
        assert!((slope + 1.5).abs() < 1e-12 && (high - low).abs() < 1e-9, "{slope}, {low} to {high}");
    }

    #[test]
    fn points_without_error_are_left_out() {
        let errors = vec![vec![4.0, 4.0], vec![2.0, 2.0], vec![-1e-9, 1e-9], vec![-1.0, -1.0]];
        let found = fit(&[1, 2, 4, 8], &errors).expect("two points are left");
        assert!((found.slope + 1.0).abs() < 1e-12, "{found:?}");
        assert_eq!(fit(&[1, 2], &[vec![1.0, 1.0], vec![0.0, 0.0]]), None);
        assert_eq!(fit(&[1, 2], &[vec![1.0], vec![0.5]]), None, "of one replicate nothing is known");
        assert_eq!(fit(&[1, 2], &[vec![0.5; 3], vec![0.5; 3]]), None, "all black");
        assert_eq!(fit(&[], &[]), None);
    }

    /// 95 of 100 intervals hold the true slope, with errors spread as those of renders are.
    #[test]
    fn intervals_cover_the_slope() {
        let at = [1, 2, 4, 8, 16, 32, 64];
        let mut state = 1_u64;
        // Splitmix64 (Steele et al. 2014); a gamma variate of order 4, spread by one half.
        let mut uniform = || {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = state;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut gamma = || -(0..4).map(|_| (1.0 - uniform()).ln()).sum::<f64>() / 4.0;
        let rounds = 2000;
        let mut inside = 0;
        for _ in 0..rounds {
            let errors: Vec<Vec<f64>> = at.iter().map(|&n| (0..8).map(|_| gamma() / f64::from(n)).collect()).collect();
            let Fit { interval: [low, high], .. } = fit(&at, &errors).expect("seven points");
            inside += u32::from(low <= -1.0 && -1.0 <= high);
        }
        // Four standard deviations of a share of 2000 are 2 %.
        assert!((0.93..0.97).contains(&(f64::from(inside) / f64::from(rounds))), "{inside} of {rounds}");
    }
}
