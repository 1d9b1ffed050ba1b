//! The c of least variance.

use mislab_kernel::request::{Estimator, Heuristic, OneSampleWeights, Strategy};

use super::table::Table;

/// The probability of the light technique with which one sample of the one-sample model has least variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Best {
    /// c, in [0, 1].
    pub c: f32,
    /// Variance of the luminance of one sample there.
    pub variance: f64,
}

/// Values of c that are tried before the search.
const TRIALS: usize = 32;
/// A mean that is off by more than this is another one's.
const SAME: f64 = 1e-5;

impl Table {
    /// The best c among those that leave the mean as it is (the ends may not, see [`Self::moments`]); `None` where no
    /// light comes from.
    ///
    /// With the tutorial's weights the second moment is `A / c + B / (1 - c)`, least at `sqrt A / (sqrt A + sqrt B)`. With
    /// Veach's it is searched for: convex in c with the balance heuristic (`f^2 / (c p_L + (1 - c) p_B)` is), and with the
    /// others first tried at 33 places.
    pub fn best_c(&self, heuristic: Heuristic, weights: OneSampleWeights) -> Option<Best> {
        let truth = self.true_mean();
        if truth <= 0.0 {
            return None;
        }
        let at = |c: f32| Estimator { strategy: Strategy::Mis, heuristic, weights, light_prob: c };
        // Infinite where the mean is another one.
        let second = |c: f64| {
            let [mean, second] = self.mean_and_second(&at(c as f32));
            let biased = (c <= 0.0 || c >= 1.0) && (mean - truth).abs() > SAME * truth;
            if biased { f64::INFINITY } else { second }
        };
        let c = match weights {
            OneSampleWeights::Tutorial => {
                let half = self.moments(&at(0.5));
                let [a, b] = [half.light.second, half.bsdf.second].map(f64::sqrt);
                a / (a + b)
            }
            OneSampleWeights::Veach => {
                let trials: Vec<f64> = (0..=TRIALS).map(|k| second(k as f64 / TRIALS as f64)).collect();
                let least = (0..=TRIALS).min_by(|&a, &b| trials[a].total_cmp(&trials[b])).unwrap_or(0);
                let around = [least.saturating_sub(1), (least + 1).min(TRIALS)].map(|k| k as f64 / TRIALS as f64);
                let found = golden_section(&second, around);
                if second(found) <= trials[least] { found } else { least as f64 / TRIALS as f64 }
            }
        };
        let c = c as f32;
        Some(Best { c, variance: self.moments(&at(c)).total.variance })
    }
}

/// Where a function that falls and then rises is least.
fn golden_section(value: &impl Fn(f64) -> f64, [mut a, mut b]: [f64; 2]) -> f64 {
    let ratio = (5.0f64.sqrt() - 1.0) / 2.0;
    let (mut x, mut y) = (b - ratio * (b - a), a + ratio * (b - a));
    let (mut at_x, mut at_y) = (value(x), value(y));
    for _ in 0..24 {
        if at_x < at_y {
            (b, y, at_y) = (y, x, at_x);
            x = b - ratio * (b - a);
            at_x = value(x);
        } else {
            (a, x, at_x) = (x, y, at_y);
            y = a + ratio * (b - a);
            at_y = value(y);
        }
    }
    0.5 * (a + b)
}
