//! The exact numbers of a pixel: the integrand over all directions, at some points of the pixel, from coarse to fine.

use std::sync::Arc;

use eframe::egui::Context;
use mislab_renderer::inspect::{Accuracy, Seen, Table};
use mislab_renderer::{Estimator, Strategy};

use super::place::{Facts, Place, luminance};
use crate::picture::background::{Background, Effort};

/// Gauss points of one axis of the pixel in each round, and how exactly to integrate over directions at each of them. The last
/// is for edges, which pass through the pixel whatever is done; and what is tabulated is asked some hundred times.
const ROUNDS: [(usize, Accuracy); 4] = [
    (1, Accuracy { relative_error: 1e-2, evaluations: 10_000 }),
    (2, Accuracy { relative_error: 1e-3, evaluations: 30_000 }),
    (4, Accuracy { relative_error: 1e-3, evaluations: 20_000 }),
    (8, Accuracy { relative_error: 1e-3, evaluations: 10_000 }),
];
/// A pixel that is known so well needs no further round.
const ENOUGH: f64 = 2e-3;

/// The integrand at some points of a pixel.
pub struct PixelTables {
    /// Which pixel.
    pub place: Place,
    /// What is seen at its centre.
    pub facts: Facts,
    /// How many points of the pixel.
    pub count: usize,
    /// By how much means and standard deviations may be off, relative to them: how much the last round changed, and what
    /// the quadrature over directions leaves. Infinite after the first round.
    pub tolerance: f64,
    /// The luminance of the pixel itself, whatever is estimated.
    pub truth: f64,
    parts: Vec<Part>,
    round: usize,
}

/// One point of the pixel.
struct Part {
    /// Its share of the pixel.
    share: f64,
    /// Luminance that comes from there without reflection.
    emitted: f64,
    /// What is reflected; `None` where nothing is.
    table: Option<Table>,
}

impl Part {
    /// What it adds to the luminance of the pixel.
    fn radiance(&self) -> f64 {
        let reflected = self.table.as_ref().map_or(0.0, |table| luminance(table.radiance().as_vec3()));
        self.share * (self.emitted + reflected)
    }
}

/// Luminance of one sample of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exact {
    /// Mean.
    pub mean: f64,
    /// Variance.
    pub variance: f64,
    /// Probability that the technique whose samples vary more carries light: with few such samples nothing is known yet.
    pub lit: f64,
}

impl PixelTables {
    /// One round after `before`; `None` once nobody wants it.
    fn new(place: &Place, round: usize, before: Option<&Self>, goes_on: &mut dyn FnMut() -> bool) -> Option<Self> {
        let (side, accuracy) = ROUNDS[round];
        let mut parts = Vec::with_capacity(side * side);
        let mut error = 0.0f64;
        for (y, row) in gauss(side) {
            for (x, column) in gauss(side) {
                if !goes_on() {
                    return None;
                }
                let (emitted, table) = match place.look([x, y]) {
                    Seen::Nothing => (0.0, None),
                    Seen::Light(radiance) => (luminance(radiance), None),
                    Seen::Surface(point) => (luminance(point.emitted()), Some(point.tabulate(&accuracy))),
                };
                error = error.max(table.as_ref().map_or(0.0, Table::relative_error));
                parts.push(Part { share: row * column, emitted, table });
            }
        }
        let facts = before.map_or_else(|| Facts::of(place), |before| before.facts.clone());
        let truth = parts.iter().map(Part::radiance).sum();
        let count = side * side;
        let mut tables = Self { place: place.clone(), facts, count, tolerance: f64::INFINITY, truth, parts, round };
        if let Some(before) = before {
            tables.tolerance = error + tables.change(before);
        }
        Some(tables)
    }

    /// Largest relative difference of what the strategies have for mean and standard deviation.
    fn change(&self, before: &Self) -> f64 {
        let each = Strategy::ALL.into_iter().map(|strategy| {
            let estimator = Estimator { strategy, ..Estimator::default() };
            let [new, old] = [self, before].map(|tables| tables.sample(&estimator));
            let relative =
                |new: f64, old: f64| if new == old { 0.0 } else { (new - old).abs() / new.abs().max(old.abs()) };
            // A deviation far below the mean does not matter to anybody.
            let deviation = |exact: Exact| exact.variance.sqrt().max(1e-6 * exact.mean);
            relative(new.mean, old.mean).max(relative(deviation(new), deviation(old)))
        });
        each.fold(0.0, f64::max)
    }

    /// The round that is to follow, if any.
    fn next_round(&self) -> Option<usize> {
        let next = self.round + 1;
        (next < ROUNDS.len() && self.tolerance > ENOUGH).then_some(next)
    }

    /// Whether no round is to follow.
    pub fn is_final(&self) -> bool {
        self.next_round().is_none()
    }

    /// How one sample of the estimator, anywhere in the pixel, is distributed: the mean over the pixel, and by the law of
    /// total variance the mean of the variances plus the variance of the means.
    pub fn sample(&self, estimator: &Estimator) -> Exact {
        let (mut mean, mut inner, mut lit) = (0.0, 0.0, 0.0);
        let mut means = Vec::with_capacity(self.parts.len());
        for Part { share, emitted, table } in &self.parts {
            let mut here = *emitted;
            if let Some(table) = table {
                let sampled = table.moments(estimator);
                here += sampled.total.mean;
                inner += share * sampled.total.variance;
                let worse = if sampled.light.second >= sampled.bsdf.second { sampled.light } else { sampled.bsdf };
                lit += share * if worse.second > 0.0 { worse.lit } else { 0.0 };
            }
            mean += share * here;
            means.push((*share, here));
        }
        let between: f64 = means.into_iter().map(|(share, here)| share * (here - mean).powi(2)).sum();
        Exact { mean, variance: inner + between, lit }
    }
}

/// Gauss points of [0, 1] and their weights.
fn gauss(n: usize) -> Vec<(f64, f64)> {
    let half: &[(f64, f64)] = match n {
        1 => return vec![(0.5, 1.0)],
        2 => &[(0.577_350_269_189_625_8, 1.0)],
        4 => &[(0.339_981_043_584_856_3, 0.652_145_154_862_546_1), (0.861_136_311_594_052_6, 0.347_854_845_137_453_9)],
        _ => &[
            (0.183_434_642_495_649_8, 0.362_683_783_378_362),
            (0.525_532_409_916_329, 0.313_706_645_877_887_3),
            (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
            (0.960_289_856_497_536_3, 0.101_228_536_290_376_3),
        ],
    };
    half.iter().flat_map(|&(x, w)| [(0.5 - 0.5 * x, 0.5 * w), (0.5 + 0.5 * x, 0.5 * w)]).collect()
}

/// Works them out beside the pictures.
pub struct TablesJob(Background<Ask, Arc<PixelTables>>);

#[derive(Clone)]
struct Ask {
    place: Place,
    round: usize,
}

impl PartialEq for Ask {
    fn eq(&self, other: &Self) -> bool {
        self.place.is_same(&other.place) && self.round == other.round
    }
}

impl Default for TablesJob {
    fn default() -> Self {
        Self(Background::new("pixel"))
    }
}

impl TablesJob {
    /// What is known of the pixel so far or, before anything is, of the one before: see [`PixelTables::place`]. Goes on
    /// with the next round; with a `moving` mouse only with the first.
    pub fn of(&mut self, ctx: &Context, place: &Place, moving: bool) -> Option<Arc<PixelTables>> {
        let known = self.0.known().filter(|tables| tables.place.is_same(place)).cloned();
        let round = known.as_ref().map_or(Some(0), |tables| tables.next_round());
        let Some(round) = round.filter(|round| *round == 0 || !moving) else { return known };
        let before = known.clone();
        let ask = Ask { place: place.clone(), round };
        let effort = if round == 0 { Effort::Brief } else { Effort::Aside };
        let found = self.0.of(ctx, ask, effort, move |ask, goes_on| {
            PixelTables::new(&ask.place, ask.round, before.as_deref(), goes_on).map(Arc::new)
        });
        found.or_else(|| self.0.known().cloned())
    }

    /// Gives up what is being worked out.
    pub fn rest(&mut self) {
        self.0.rest();
    }
}

#[cfg(test)]
pub mod tests {
    use super::super::place::Surface;
    use super::*;
    use mislab_renderer::kernel::world::BuiltScene;
    use mislab_renderer::pbrt::embedded_scene;

    /// Veach's scene, small, at the pixel where plate 3 shows light 2.
    pub fn place() -> Place {
        let file = embedded_scene();
        let mut settings = file.settings;
        settings.image.resolution = [100, 100];
        let square = &mislab_renderer::plane::Square::all(&file.scene)[9];
        let projector = mislab_renderer::projection::Projector::new(&file.scene.camera, settings.image.resolution);
        let pixel = projector.project(square.point()).expect("in front of the camera").map(|v| v as u32);
        let built = BuiltScene::new(&file.scene, &settings).expect("the shipped scene can be built");
        Place { scene: Arc::new(file.scene), built: Arc::new(built), settings, pixel }
    }

    /// The first round of it.
    pub fn first(place: &Place) -> PixelTables {
        PixelTables::new(place, 0, None, &mut || true).expect("wanted")
    }

    /// All rounds of it.
    pub fn tables(place: &Place) -> PixelTables {
        let mut tables = first(place);
        while let Some(round) = tables.next_round() {
            tables = PixelTables::new(place, round, Some(&tables), &mut || true).expect("wanted");
        }
        tables
    }

    #[test]
    fn gauss_points_integrate_polynomials() {
        for n in [1, 2, 4, 8] {
            for power in 0..2 * n as i32 {
                let sum: f64 = gauss(n).into_iter().map(|(x, w)| w * x.powi(power)).sum();
                assert!((sum - 1.0 / f64::from(power + 1)).abs() < 1e-14, "{n} points, x^{power}: {sum}");
            }
        }
    }

    #[test]
    fn the_first_round_is_the_librarys_moments_at_the_centre() {
        let place = place();
        let first = first(&place);
        let table = place.point().expect("a plate").tabulate(&ROUNDS[0].1);
        for strategy in Strategy::ALL {
            let estimator = Estimator { strategy, ..place.settings.estimator };
            let (exact, moments) = (first.sample(&estimator), table.moments(&estimator).total);
            assert_eq!((exact.mean, exact.variance), (moments.mean, moments.variance), "{strategy:?}");
        }
        assert_eq!(first.facts.surface().expect("a plate").name, "plate3");
        assert_eq!(first.facts.surface().and_then(Surface::highlight).expect("lights").name, "light2");
    }

    /// Mean and variance over the pixel against 20 000 independent samples, at 5 standard errors: 8 comparisons, so that
    /// chance alone fails one of 200 000 seeds.
    #[test]
    fn samples_of_the_pixel_have_the_exact_mean_and_variance() {
        use mislab_renderer::SamplerKind;
        use mislab_renderer::kernel::lanes::Lanewise;
        let mut place = place();
        let tables = tables(&place);
        assert!(tables.tolerance < 0.02, "{}", tables.tolerance);
        place.settings.sampling.sampler.kind = SamplerKind::Independent;
        for strategy in Strategy::ALL {
            place.settings.estimator.strategy = strategy;
            let exact = tables.sample(&place.settings.estimator);
            let n = 20_000;
            let values: Vec<f64> = (0..n)
                .map(|i| {
                    let how = Lanewise::best();
                    f64::from(
                        mislab_renderer::inspect::replay(how, &place.built, &place.settings, place.pixel, i).luminance,
                    )
                })
                .collect();
            let n = f64::from(n);
            let mean = values.iter().sum::<f64>() / n;
            let central = |k: i32| values.iter().map(|v| (v - mean).powi(k)).sum::<f64>() / n;
            let (variance, fourth) = (central(2), central(4));
            let mean_error = 5.0 * (variance / n).sqrt() + 1e-3 * mean;
            assert!((mean - exact.mean).abs() < mean_error, "{strategy:?}: {mean}, exact {}", exact.mean);
            let error = 5.0 * ((fourth - variance * variance) / n).sqrt() + 1e-2 * variance;
            assert!((variance - exact.variance).abs() < error, "{strategy:?}: {variance}, exact {}", exact.variance);
        }
    }
}
