//! Means, variances, contributions and weights of every strategy against the oracle.

use std::sync::Arc;

use glam::DVec3;
use mislab_renderer::{Estimator, Heuristic, OneSampleWeights, Sampling, Scene, Settings, Strategy};
use mislab_tests::depth::depth;
use mislab_tests::experiment::{independent, keyhole, measure, veach};
use mislab_tests::oracle::{LUMINANCE, Point, World};
use mislab_tests::places::{EYE, places, variants};
use mislab_tests::statistics::Family;

/// Samples of each measurement, unless its distribution asks for more.
const SAMPLES: u32 = 1 << 19;
/// Most samples of a measurement.
const MOST_SAMPLES: u32 = 1 << 22;
/// A quantity is tested where the skewness of its estimate, known exactly, is below this: else the
/// normal distribution is no judge of it.
const SKEWNESS: f64 = 0.1;
/// Relative errors of single precision and of the keyhole, counted as if they were noise.
const ROUNDING: f64 = 3e-5;
/// Resolution of a variance in units of the squared mean: the film adds up squares in single
/// precision (1e-7), and a few in a million directions at the rim of a small light miss it by rounding.
const SQUARE_ROUNDING: f64 = 1e-5;

/// Every strategy, heuristic, weight and c. Veach's weights at c = 0 and 1 appear once: there they
/// are the two single techniques whatever the heuristic (`identities.rs` has them bit for bit).
fn all_settings() -> Vec<(String, Settings)> {
    let base = independent(1, 1, [32, 32]);
    let mut all = Vec::new();
    for strategy in [Strategy::Light, Strategy::Bsdf] {
        all.push((
            strategy.name().to_owned(),
            Settings { estimator: Estimator { strategy, ..base.estimator }, ..base.clone() },
        ));
    }
    for heuristic in Heuristic::ALL {
        all.push((
            format!("mis_all {}", heuristic.name()),
            Settings {
                estimator: Estimator { strategy: Strategy::MisAll, heuristic, ..base.estimator },
                ..base.clone()
            },
        ));
        for weights in OneSampleWeights::ALL {
            for light_prob in [0.0, 0.1, 0.5, 0.9, 1.0] {
                let single = light_prob == 0.0 || light_prob == 1.0;
                if weights == OneSampleWeights::Veach && single && heuristic != Heuristic::Balance {
                    continue;
                }
                all.push((
                    format!("mis {} {} c={light_prob}", heuristic.name(), weights.name()),
                    Settings {
                        estimator: Estimator { strategy: Strategy::Mis, heuristic, weights, light_prob },
                        ..base.clone()
                    },
                ));
            }
        }
    }
    all
}

/// What is tested, family by family.
struct Families {
    mean: Family,
    parts: Family,
    variance: Family,
    weight: Family,
}

impl Families {
    fn new() -> Self {
        Self {
            mean: Family::new("means"),
            parts: Family::new("contributions of the techniques"),
            variance: Family::new("variances"),
            weight: Family::new("mean weights"),
        }
    }

    fn judge(self, [mean, parts, variance, weight]: [usize; 4]) {
        // All are printed before the first can fail.
        let results = [(self.mean, mean), (self.parts, parts), (self.variance, variance), (self.weight, weight)]
            .map(|(family, least)| std::panic::catch_unwind(move || family.judge(least)));
        for result in results {
            if let Err(panic) = result {
                std::panic::resume_unwind(panic);
            }
        }
    }
}

/// One point, one setting.
fn compare(families: &mut Families, label: &str, scene: &Arc<Scene>, point: &Point, settings: &Settings) {
    let expected = point.sample(settings, LUMINANCE);
    let total = &expected.total;
    let (mean, sd) = (total.mean(), total.variance().sqrt());
    if sd <= 1e-7 * mean {
        // The same value every time (a mirror), or nothing at all: no statistics needed.
        let measured = measure(scene, settings, 1 << 12);
        assert!((measured.mean - mean).abs() <= ROUNDING * mean, "{label}: {} instead of {mean}", measured.mean);
        assert!(measured.variance <= SQUARE_ROUNDING * mean * mean, "{label}: variance {}", measured.variance);
        return;
    }
    // As many samples as the mean needs to be normal.
    let needed = (total.skewness_of_mean(1.0) / SKEWNESS).powi(2);
    let samples =
        if needed > f64::from(SAMPLES) { (needed * 1.1).min(f64::from(MOST_SAMPLES)) as u32 } else { SAMPLES };
    let measured = measure(scene, settings, samples);
    let n = measured.n;
    if total.skewness_of_mean(n) < SKEWNESS {
        families.mean.test(label, measured.mean, mean, (sd / n.sqrt()).hypot(ROUNDING * mean));
    }
    if total.skewness_of_variance(n) < SKEWNESS {
        let rounding = 2.0 * ROUNDING * total.variance() + SQUARE_ROUNDING * mean * mean;
        let error = total.standard_error_of_variance(n).hypot(rounding);
        families.variance.test(label, measured.variance, total.variance(), error);
    }
    let parts = [("light", measured.light, expected.light), ("bsdf", measured.bsdf, expected.bsdf)];
    for (i, (name, mean, part)) in parts.into_iter().enumerate() {
        let moments = &part.moments;
        if part.carries == 0.0 || moments.mean() == 0.0 {
            // A technique that is never drawn, or whose weights are all 0, adds nothing at all.
            assert_eq!(mean, 0.0, "{label}: {name} adds something");
        } else if moments.skewness_of_mean(n) < SKEWNESS {
            let error = (moments.variance() / n).sqrt().hypot(ROUNDING * moments.mean());
            families.parts.test(format!("{label}, {name}"), mean, moments.mean(), error);
        }
        // Pixels in which many samples carry, so that the mean over pixels is that over samples.
        let carrying = part.carries * measured.spp;
        if carrying > 50.0 {
            let (weight, deviation) = part.weight();
            let (mean, pixels) = measured.weights[i];
            let error = deviation / (carrying * pixels).sqrt() * (1.0 + 1.0 / carrying);
            families.weight.test(format!("{label}, weight of {name}"), mean, weight, error.hypot(ROUNDING));
        }
    }
}

#[test]
fn every_strategy_has_the_mean_and_variance_of_the_oracle() {
    let scene = veach();
    let points = places(&scene);
    assert!(points.len() >= 40, "{} points", points.len());
    let mut families = Families::new();
    let mut biased = 0;
    for (number, (label, scene, target)) in points.into_iter().enumerate() {
        let point = World::new(&scene).point(EYE, target);
        let view = keyhole(&scene, EYE, target);
        for (i, (name, settings)) in all_settings().into_iter().enumerate() {
            // The ordinary run takes every other setting at each point, and so each at half of the points.
            if depth((number + i) % 2 == 1, false) {
                continue;
            }
            let settings =
                Settings { sampling: Sampling { seed: (1000 * number + i) as u32, ..settings.sampling }, ..settings };
            compare(&mut families, &format!("{label}, {name}"), &view, &point, &settings);
            // The tutorial's weights at c = 0 and 1 leave out a part, and that is what is expected of them.
            let truth = point.radiance().dot(LUMINANCE);
            let expected = point.sample(&settings, LUMINANCE).total.mean();
            let fair = settings.estimator.bias().is_none();
            let mirror = settings.estimator.strategy == Strategy::Light
                || settings.estimator.strategy == Strategy::Mis && settings.estimator.light_prob == 1.0;
            if !fair && expected < 0.98 * truth {
                biased += 1;
            }
            let dark = truth == 0.0 && expected == 0.0;
            assert!(
                !fair || mirror || dark || (expected / truth - 1.0).abs() < 1e-4,
                "{label}, {name}: {expected}, {truth}"
            );
        }
    }
    println!("{biased} settings are biased by more than 2 %, as they should be");
    assert!(biased > 40, "only {biased} settings are biased");
    families.judge(depth([650, 950, 600, 720], [1300, 1900, 1200, 1440]));
}

#[test]
fn other_materials_and_lights_agree_with_the_oracle_too() {
    let mut families = Families::new();
    let mut colours = Family::new("means per channel");
    for (number, (label, scene, target)) in variants().into_iter().enumerate() {
        let point = World::new(&scene).point(EYE, target);
        let view = keyhole(&scene, EYE, target);
        let base = independent(1, 7000 + number as u32, [32, 32]);
        for (name, settings) in [
            (
                "light",
                Settings { estimator: Estimator { strategy: Strategy::Light, ..base.estimator }, ..base.clone() },
            ),
            ("bsdf", Settings { estimator: Estimator { strategy: Strategy::Bsdf, ..base.estimator }, ..base.clone() }),
            (
                "mis_all",
                Settings { estimator: Estimator { strategy: Strategy::MisAll, ..base.estimator }, ..base.clone() },
            ),
            (
                "mis_all cutoff",
                Settings { estimator: Estimator { heuristic: Heuristic::Cutoff, ..base.estimator }, ..base.clone() },
            ),
            (
                "mis c=0.3 power",
                Settings {
                    estimator: Estimator {
                        strategy: Strategy::Mis,
                        light_prob: 0.3,
                        heuristic: Heuristic::Power,
                        ..base.estimator
                    },
                    ..base.clone()
                },
            ),
        ] {
            compare(&mut families, &format!("{label}, {name}"), &view, &point, &settings);
        }
        // Colours: the same samples, channel by channel.
        let settings = Settings { sampling: Sampling { seed: 8000 + number as u32, ..base.sampling }, ..base };
        let measured = measure(&view, &settings, SAMPLES);
        for (channel, unit) in [("R", DVec3::X), ("G", DVec3::Y), ("B", DVec3::Z)] {
            let expected = point.sample(&settings, unit).total;
            if expected.skewness_of_mean(measured.n).abs() < SKEWNESS {
                let error = (expected.variance() / measured.n).sqrt().hypot(ROUNDING * expected.mean());
                colours.test(format!("{label}, {channel}"), unit.dot(measured.mean_rgb), expected.mean(), error);
            }
        }
    }
    let colours = std::panic::catch_unwind(|| colours.judge(45));
    families.judge([70, 80, 60, 80]);
    assert!(colours.is_ok(), "see the means per channel above");
}
