//! The variance of the one-sample model over c, exact, and where it is least.

use std::sync::Arc;

use eframe::egui::Context;
use mislab_renderer::inspect::least;
use mislab_renderer::{Estimator, Heuristic, OneSampleWeights, Strategy};

use super::tables::PixelTables;
use crate::picture::background::{Background, Effort};

/// Places along the axis in each round, denser towards both ends, where the curves are steep; and steps of the search for
/// the least, each of which leaves 0.62 of the interval.
const ROUNDS: [(usize, usize); 2] = [(9, 0), (25, 12)];
/// A mean that is off by more than this is another one's.
const SAME: f64 = 1e-4;

/// Relative variances of the one-sample model; those of both weights in the order of [`OneSampleWeights::ALL`].
#[derive(Clone, Debug, PartialEq)]
pub struct Curves {
    /// c, rising from 0 to 1.
    pub c: Vec<f64>,
    /// At each c; `None` where the mean is another one.
    pub variances: [Vec<Option<f64>>; 2],
    /// c and the variance there, where that is least.
    pub best: [Option<[f64; 2]>; 2],
}

impl Curves {
    /// The curve of these weights, and its least.
    pub fn of(&self, weights: OneSampleWeights) -> (&[Option<f64>], Option<[f64; 2]>) {
        let index = OneSampleWeights::ALL.iter().position(|each| *each == weights).unwrap_or(0);
        (&self.variances[index], self.best[index])
    }
}

/// So many places from 0 to 1, denser towards both ends.
pub fn places(count: usize) -> Vec<f64> {
    (0..count).map(|i| 0.5 - 0.5 * (std::f64::consts::PI * i as f64 / (count - 1) as f64).cos()).collect()
}

/// Variances of one ray's luminance over the squared mean.
pub struct OverC {
    /// What it was made of.
    pub tables: Arc<PixelTables>,
    /// Of one sample of the one-sample model.
    pub curves: Curves,
    /// Of light samples alone, of BSDF samples alone, and of both at equal rays.
    pub others: [Option<f64>; 3],
    heuristic: Heuristic,
    round: usize,
}

/// The variance of one ray over the squared mean; `None` where the mean is another one, or 0.
pub fn relative(tables: &PixelTables, truth: f64, estimator: &Estimator) -> Option<f64> {
    let exact = tables.sample(estimator);
    let same = truth > 0.0 && (exact.mean - truth).abs() <= SAME * truth;
    same.then(|| exact.variance * f64::from(estimator.strategy.rays_per_sample()) / (truth * truth))
}

impl OverC {
    fn new(About { tables, heuristic, round }: &About, goes_on: &mut dyn FnMut() -> bool) -> Option<Self> {
        let (truth, heuristic, (count, steps)) = (tables.truth, *heuristic, ROUNDS[*round]);
        let c = places(count);
        let mut variances = [Vec::new(), Vec::new()];
        let mut best = [None; 2];
        for ((curve, best), weights) in variances.iter_mut().zip(&mut best).zip(OneSampleWeights::ALL) {
            let at = |c: f64| {
                let estimator = Estimator { strategy: Strategy::Mis, heuristic, weights, light_prob: c as f32 };
                relative(tables, truth, &estimator)
            };
            for &c in &c {
                curve.push(goes_on().then(|| at(c))?);
            }
            let tried: Vec<[f64; 2]> = c.iter().zip(&*curve).filter_map(|(c, v)| Some([*c, (*v)?])).collect();
            if !tried.is_empty() {
                // Nothing is worked out any more once nobody wants it.
                let mut value = |c: f64| goes_on().then(|| at(c)).flatten().unwrap_or(f64::INFINITY);
                *best = Some(least(&tried, steps, &mut value));
            }
        }
        if !goes_on() {
            return None;
        }
        let [light, bsdf, both] = [Strategy::Light, Strategy::Bsdf, Strategy::MisAll]
            .map(|strategy| relative(tables, truth, &Estimator { strategy, heuristic, ..Estimator::default() }));
        let others = [light, bsdf, both];
        let curves = Curves { c, variances, best };
        Some(Self { tables: tables.clone(), curves, others, heuristic, round: *round })
    }

    /// Whether nothing finer will come.
    pub fn is_fine(&self) -> bool {
        self.round + 1 == ROUNDS.len() && self.tables.is_final()
    }
}

/// Works them out beside the pictures.
pub struct OverCJob(Background<About, Arc<OverC>>);

#[derive(Clone)]
struct About {
    tables: Arc<PixelTables>,
    heuristic: Heuristic,
    round: usize,
}

impl PartialEq for About {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.tables, &other.tables) && (self.heuristic, self.round) == (other.heuristic, other.round)
    }
}

impl Default for OverCJob {
    fn default() -> Self {
        Self(Background::new("curve over c"))
    }
}

impl OverCJob {
    /// Of a pixel; until they are known, those that were before.
    pub fn of(&mut self, ctx: &Context, tables: &Arc<PixelTables>, heuristic: Heuristic) -> Option<Arc<OverC>> {
        let of_these = |over_c: &&Arc<OverC>| Arc::ptr_eq(&over_c.tables, tables) && over_c.heuristic == heuristic;
        let round = match self.0.known().filter(of_these) {
            None => 0,
            Some(over_c) if over_c.round + 1 < ROUNDS.len() => over_c.round + 1,
            Some(over_c) => return Some(over_c.clone()),
        };
        let effort = if round == 0 && tables.count == 1 { Effort::Brief } else { Effort::Aside };
        let about = About { tables: tables.clone(), heuristic, round };
        let found = self.0.of(ctx, about, effort, |about, goes_on| OverC::new(about, goes_on).map(Arc::new));
        found.or_else(|| self.0.known().cloned())
    }

    /// Gives up what is being worked out.
    pub fn rest(&mut self) {
        self.0.rest();
    }
}

#[cfg(test)]
mod tests {
    use super::super::tables::tests::{first, place};
    use super::*;
    use mislab_renderer::inspect::Accuracy;

    /// At the centre of a pixel the least of the curves is the library's best c.
    #[test]
    fn the_least_of_the_curves_is_the_librarys_best_c() {
        let place = place();
        let tables = Arc::new(first(&place));
        let accuracy = Accuracy { relative_error: 1e-2, evaluations: 10_000 };
        let table = place.point().expect("a plate").tabulate(&accuracy);
        let about = About { tables, heuristic: Heuristic::Balance, round: 1 };
        let over_c = OverC::new(&about, &mut || true).expect("wanted");
        let truth = over_c.tables.truth;
        for (best, weights) in over_c.curves.best.iter().zip(OneSampleWeights::ALL) {
            let [c, variance] = best.expect("light arrives");
            let library = table.best_c(Heuristic::Balance, weights).expect("light arrives");
            assert!((c - f64::from(library.c)).abs() < 1e-3, "{weights:?}: {c}, the library's {}", library.c);
            let expected = library.variance / (truth * truth);
            assert!((variance - expected).abs() < 1e-4 * expected, "{weights:?}: {variance}, {expected}");
        }
        let [light, bsdf, both] = over_c.others.map(|v| v.expect("a rough plate"));
        let veach = &over_c.curves.variances[0];
        assert_eq!(OneSampleWeights::ALL[0], OneSampleWeights::Veach);
        assert!((veach[0].expect("unbiased") - bsdf).abs() < 1e-6 * bsdf, "at c = 0 it is BSDF samples alone");
        assert!(
            (veach[veach.len() - 1].expect("unbiased") - light).abs() < 1e-6 * light,
            "at c = 1 light samples alone"
        );
        assert!(both > 0.0);
        let tutorial = &over_c.curves.variances[1];
        assert_eq!([tutorial[0], tutorial[tutorial.len() - 1]], [None, None], "biased at both ends");
    }
}
