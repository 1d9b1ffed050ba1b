//! Error curves as far as they are known.

use statrs::distribution::{ContinuousCDF as _, StudentsT};

use super::cells::Part;
use super::points::{Found, Plan};
use super::slope::{Fit, fit};
use crate::table::quality::mean_and_error;

/// What is drawn over the samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Measure {
    /// Mean of `(x - r)^2 / (r^2 + epsilon)`, with [`crate::metrics::RELMSE_EPSILON`].
    #[default]
    RelMse,
    /// Square root of the mean of `(x - r)^2`.
    Rmse,
}

impl Measure {
    /// Both.
    pub const ALL: [Self; 2] = [Self::RelMse, Self::Rmse];

    /// From the relMSE and the MSE that [`super::points::errors`] gives.
    pub fn of(self, [rel_mse, mse]: [f64; 2]) -> f64 {
        match self {
            Self::RelMse => rel_mse,
            Self::Rmse => mse.max(0.0).sqrt(),
        }
    }

    /// Slope on logarithmic axes of independent samples.
    pub fn slope(self) -> f64 {
        match self {
            Self::RelMse => -1.0,
            Self::Rmse => -0.5,
        }
    }

    /// The mean square that it comes from, and its power.
    fn square(self) -> (usize, f64) {
        match self {
            Self::RelMse => (0, 1.0),
            Self::Rmse => (1, 0.5),
        }
    }
}

/// A point of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Value {
    /// Mean over the replicates.
    pub error: f64,
    /// 95 % interval by Student's distribution, on the logarithmic axis; `None` with one replicate.
    pub interval: Option<[f64; 2]>,
    /// Processor seconds, mean over the replicates.
    pub cpu_seconds: f64,
    /// How many replicates.
    pub replicates: usize,
}

/// All pictures measured so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Curves {
    /// What they are pictures of.
    pub plan: Plan,
    /// For each curve and point, the pictures.
    found: Vec<Vec<Vec<Found>>>,
}

impl Curves {
    /// Nothing yet.
    pub fn new(plan: Plan) -> Self {
        let found = vec![vec![Vec::new(); plan.at.len()]; plan.estimators.len()];
        Self { plan, found }
    }

    /// Adds a picture.
    ///
    /// # Panics
    /// If the plan has no such point.
    pub fn add(&mut self, found: Found) {
        self.found[found.curve][found.point].push(found);
    }

    /// Pictures so far.
    pub fn count(&self) -> usize {
        self.found.iter().flatten().map(Vec::len).sum()
    }

    /// All that there will be.
    pub fn total(&self) -> usize {
        self.plan.estimators.len() * self.plan.at.len() * self.plan.replicates as usize
    }

    /// The mean squares of a point in a part: one for each picture that has pixels there.
    pub(crate) fn squares(&self, [curve, point]: [usize; 2], part: Part, measure: Measure) -> Vec<f64> {
        let of = |found: &Found| found.errors_in(part).map(|errors| errors[measure.square().0]);
        self.found[curve][point].iter().filter_map(of).filter(|square| !square.is_nan()).collect()
    }

    /// Processor seconds of a picture, mean over those so far.
    pub(crate) fn cpu_seconds(&self, curve: usize, point: usize) -> f64 {
        let found = &self.found[curve][point];
        found.iter().map(|found| found.cpu_seconds).sum::<f64>() / found.len() as f64
    }

    /// A point of a curve. `None` without pictures, or where their mean is not positive.
    pub fn value(&self, curve: usize, point: usize, part: Part, measure: Measure) -> Option<Value> {
        let squares = self.squares([curve, point], part, measure);
        let power = measure.square().1;
        let (mean, error) = mean_and_error(&squares);
        let interval = (squares.len() > 1).then(|| {
            let t = StudentsT::new(0.0, 1.0, (squares.len() - 1) as f64).map_or(f64::NAN, |t| t.inverse_cdf(0.975));
            let factor = (power * t * error / mean).exp();
            let centre = mean.powf(power);
            [centre / factor, centre * factor]
        });
        (mean > 0.0).then(|| Value {
            error: mean.powf(power),
            interval,
            cpu_seconds: self.cpu_seconds(curve, point),
            replicates: squares.len(),
        })
    }

    /// Slope of a curve and its 95 % interval, over the points that have two pictures or more.
    pub fn slope(&self, curve: usize, part: Part, measure: Measure) -> Option<Fit> {
        let points = (0..self.plan.at.len()).map(|point| self.squares([curve, point], part, measure));
        let (at, squares): (Vec<u32>, Vec<Vec<f64>>) =
            self.plan.at.iter().copied().zip(points).filter(|(_, squares)| squares.len() > 1).unzip();
        // Replicates are paired over the points.
        let count = squares.iter().map(Vec::len).min()?;
        let squares: Vec<Vec<f64>> = squares.iter().map(|squares| squares[..count].to_vec()).collect();
        let Fit { slope, interval } = fit(&at, &squares)?;
        let power = measure.square().1;
        Some(Fit { slope: power * slope, interval: interval.map(|end| power * end) })
    }

    /// For spreadsheets: a head line, then one line for each point of each part, under its name.
    pub fn to_csv(&self, parts: &[(Part, String)]) -> String {
        let mut out = String::from(
            "strategy,heuristic,weights,light_prob,part,spp,rays,cpu_seconds,rel_mse,rel_mse_low,rel_mse_high,rmse,rmse_low,rmse_high,replicates\n",
        );
        for (curve, estimator) in self.plan.estimators.iter().enumerate() {
            for (part, part_name) in parts {
                for (point, spp) in self.plan.at.iter().enumerate() {
                    let [rel_mse, rmse] = Measure::ALL.map(|measure| self.value(curve, point, *part, measure));
                    let Some(some) = rel_mse.or(rmse) else { continue };
                    let numbers = |value: Option<Value>| {
                        let [low, high] = value.and_then(|v| v.interval).unwrap_or([f64::NAN; 2]);
                        let all = [value.map_or(f64::NAN, |v| v.error), low, high];
                        all.map(|v| if v.is_finite() { v.to_string() } else { String::new() }).join(",")
                    };
                    let (heuristic, weights) = (estimator.heuristic.name(), estimator.weights.name());
                    let (name, c) = (estimator.strategy.name(), estimator.light_prob);
                    let rays = u64::from(*spp) * u64::from(estimator.strategy.rays_per_sample());
                    out += &format!(
                        "{name},{heuristic},{weights},{c},{part_name},{spp},{rays},{},{},{},{}\n",
                        some.cpu_seconds,
                        numbers(rel_mse),
                        numbers(rmse),
                        some.replicates
                    );
                }
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mislab_kernel::request::Estimator;

    fn halving(replicates: u32) -> Curves {
        let plan = Plan { estimators: vec![Estimator::default()], at: vec![1, 2, 4, 8], replicates, by_block: false };
        let mut curves = Curves::new(plan);
        for point in 0..4 {
            for replicate in 0..replicates {
                let spread = 1.0 + 0.1 * f64::from(replicate);
                let mse = spread * 0.5_f64.powi(point);
                let (curve, point) = (0, point as usize);
                curves.add(Found { curve, point, cpu_seconds: 1.0, errors: vec![[mse, 4.0 * mse]], blocks: None });
            }
        }
        curves
    }

    #[test]
    fn slopes_of_both_measures_belong_together() {
        let curves = halving(3);
        for measure in Measure::ALL {
            let Fit { slope, interval: [low, high] } = curves.slope(0, Part::Whole, measure).expect("four points");
            assert!((slope - measure.slope()).abs() < 1e-12 && low <= slope && slope <= high, "{measure:?}: {slope}");
        }
    }

    /// Of 1, 1.1, 1.2: mean 1.1, standard error 0.1 / sqrt(3), t of two degrees of freedom 4.302653.
    #[test]
    fn bands_are_students() {
        let value = halving(3).value(0, 0, Part::Whole, Measure::RelMse).expect("three pictures");
        let [low, high] = value.interval.expect("more than one");
        assert!((value.error - 1.1).abs() < 1e-12);
        let factor = (4.302_653 * 0.1 / 3.0_f64.sqrt() / 1.1).exp();
        assert!((high / 1.1 - factor).abs() < 1e-6 && (1.1 / low - factor).abs() < 1e-6, "{low} to {high}");
        let rmse = halving(3).value(0, 0, Part::Whole, Measure::Rmse).expect("three pictures");
        assert!((rmse.error - 4.4_f64.sqrt()).abs() < 1e-12, "{}", rmse.error);
        assert_eq!(halving(1).value(0, 0, Part::Whole, Measure::RelMse).expect("one").interval, None);
    }

    #[test]
    fn every_point_gets_three_pictures_before_any_gets_more() {
        let curves = halving(4);
        let order: Vec<[usize; 3]> = curves.plan.order().collect();
        assert_eq!(order.len(), curves.total());
        assert!(order[..12].iter().all(|[_, _, replicate]| *replicate < 3), "{order:?}");
        assert!(order[..12].is_sorted_by_key(|[_, point, _]| *point), "cheap ones first: {order:?}");
    }
}
