//! The c of least variance, and the curve that it is the lowest point of.

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

/// The one-sample model at one c.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtC {
    /// c, in [0, 1].
    pub c: f32,
    /// `E Y^2` of the luminance of one sample with Veach's weights; the variance is this less the squared mean. `None`
    /// where the mean is another one, or there is no light.
    pub veach: Option<f64>,
    /// The same with the tutorial's weights.
    pub tutorial: Option<f64>,
}

/// Values of c that are tried before the search.
const TRIALS: usize = 32;
/// Steps of the search between two of them, each to 0.62 of the one before.
const STEPS: usize = 24;
/// A mean that is off by more than this is another one's.
const SAME: f64 = 1e-5;

impl Table {
    /// Second moments of the one-sample model for each of these c.
    pub fn curve(&self, heuristic: Heuristic, cs: &[f32]) -> Vec<AtC> {
        let truth = self.true_mean();
        let second = |weights, light_prob| {
            self.fair_second(&Estimator { strategy: Strategy::Mis, heuristic, weights, light_prob }, truth)
        };
        let at =
            |&c| AtC { c, veach: second(OneSampleWeights::Veach, c), tutorial: second(OneSampleWeights::Tutorial, c) };
        cs.iter().map(at).collect()
    }

    /// The best c among those that leave the mean as it is (the ends may not, see [`Self::moments`]); `None` where no
    /// light comes from.
    ///
    /// With the tutorial's weights the second moment is `A / c + B / (1 - c)`, least at `sqrt A / (sqrt A + sqrt B)`. With
    /// Veach's and the balance heuristic it is the integral of `f^2 / (c p_L + (1 - c) p_B)`, convex in c: its slope is
    /// brought to 0. With other heuristics it is tried at 33 places and then searched for.
    pub fn best_c(&self, heuristic: Heuristic, weights: OneSampleWeights) -> Option<Best> {
        self.best_c_within(heuristic, weights, TRIALS, STEPS)
    }

    /// The same with so many trials and steps, where it has to be searched for.
    pub(super) fn best_c_within(
        &self,
        heuristic: Heuristic,
        weights: OneSampleWeights,
        trials: usize,
        steps: usize,
    ) -> Option<Best> {
        let truth = self.true_mean();
        if truth <= 0.0 {
            return None;
        }
        let at = |c: f32| Estimator { strategy: Strategy::Mis, heuristic, weights, light_prob: c };
        let c = match (weights, heuristic) {
            (OneSampleWeights::Tutorial, _) => {
                let [a, b] = self.first_and_second(&at(0.5)).map(|[_, second]| second.sqrt());
                a / (a + b)
            }
            (OneSampleWeights::Veach, Heuristic::Balance) => self.level(),
            (OneSampleWeights::Veach, Heuristic::Power) => {
                let nodes = self.squares();
                search(&mut |c| power_second(&nodes, c), trials, steps)
            }
            (OneSampleWeights::Veach, Heuristic::Cutoff | Heuristic::Maximum) => {
                search(&mut |c| self.fair_second(&at(c as f32), truth).unwrap_or(f64::INFINITY), trials, steps)
            }
        };
        let c = c as f32;
        Some(Best { c, variance: self.moments(&at(c)).total.variance })
    }

    /// `E Y^2` of one sample of the one-sample model, unless its mean is not `truth`. Between the ends it is.
    fn fair_second(&self, estimator: &Estimator, truth: f64) -> Option<f64> {
        let [light, bsdf] = self.first_and_second(estimator);
        let [mean, second] = [light[0] + bsdf[0], light[1] + bsdf[1]];
        let inside = estimator.light_prob > 0.0 && estimator.light_prob < 1.0;
        (truth > 0.0 && (inside || (mean - truth).abs() <= SAME * truth)).then_some(second)
    }

    /// Of each direction that matters its share of the integral of f^2, and both densities.
    fn squares(&self) -> Vec<[f64; 3]> {
        self.nodes()
            .map(|node| [node.y * node.y * node.dw, f64::from(node.p[0]), f64::from(node.p[1])])
            .filter(|[square, light, bsdf]| *square != 0.0 && light + bsdf > 0.0)
            .collect()
    }

    /// Where the second moment with Veach's balance heuristic is level or, at an end of [0, 1], rises inwards. Newton's steps
    /// on its slope, and halves of the interval where one would leave it.
    fn level(&self) -> f64 {
        let nodes = self.squares();
        // First and second derivative of the sum of f^2 / q.
        let slopes = |c: f64| {
            let mut slopes = [0.0; 2];
            for &[square, light, bsdf] in &nodes {
                let (per_q, rise) = (1.0 / (c * light + (1.0 - c) * bsdf), light - bsdf);
                let slope = square * per_q * per_q * rise;
                slopes[0] -= slope;
                slopes[1] += 2.0 * slope * per_q * rise;
            }
            slopes
        };
        let (mut low, mut high) = (0.0, 1.0);
        if slopes(low)[0] >= 0.0 {
            return low;
        }
        if slopes(high)[0] <= 0.0 {
            return high;
        }
        let mut c = 0.5;
        for _ in 0..64 {
            let [first, second] = slopes(c);
            if first > 0.0 {
                high = c;
            } else {
                low = c;
            }
            let newton = c - first / second;
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            let step = (next - c).abs();
            c = next;
            if step <= 1e-9 {
                break;
            }
        }
        c
    }
}

/// `E Y^2` with Veach's weights and the power heuristic, `q_t = c_t p_t`: the integral of
/// `f^2 (q_L^3 + q_B^3) / (q_L^2 + q_B^2)^2`. Infinite where a direction is not drawn at all.
fn power_second(squares: &[[f64; 3]], c: f64) -> f64 {
    let of = |[square, light, bsdf]: &[f64; 3]| {
        let (q, r) = (c * light, (1.0 - c) * bsdf);
        let (q2, r2) = (q * q, r * r);
        square * (q2 * q + r2 * r) / ((q2 + r2) * (q2 + r2))
    };
    let second: f64 = squares.iter().map(of).sum();
    if second.is_nan() { f64::INFINITY } else { second }
}

/// Where a function of c is least: among so many equal steps, then between the neighbours of the least of these.
fn search(value: &mut dyn FnMut(f64) -> f64, trials: usize, steps: usize) -> f64 {
    let places = (0..=trials).map(|k| k as f64 / trials as f64);
    let tried: Vec<[f64; 2]> = places.map(|c| [c, value(c)]).collect();
    least(&tried, steps, value)[0]
}

/// Place and value where a function of one variable is least, of which some values have been tried, at rising places: between the
/// neighbours of the least of them, where it is to fall and then rise, by golden section in so many steps.
pub fn least(tried: &[[f64; 2]], steps: usize, value: &mut dyn FnMut(f64) -> f64) -> [f64; 2] {
    let Some(index) = (0..tried.len()).min_by(|&a, &b| tried[a][1].total_cmp(&tried[b][1])) else {
        return [f64::NAN; 2];
    };
    let between = [tried[index.saturating_sub(1)][0], tried[(index + 1).min(tried.len() - 1)][0]];
    let found = golden_section(value, between, steps);
    let found = [found, value(found)];
    if found[1] <= tried[index][1] { found } else { tried[index] }
}

/// Where a function that falls and then rises is least.
fn golden_section(value: &mut dyn FnMut(f64) -> f64, [mut a, mut b]: [f64; 2], steps: usize) -> f64 {
    let ratio = (5.0f64.sqrt() - 1.0) / 2.0;
    let (mut x, mut y) = (b - ratio * (b - a), a + ratio * (b - a));
    let (mut at_x, mut at_y) = (value(x), value(y));
    for _ in 0..steps {
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
