//! The study's window against the oracle, against itself and against the film.

use std::num::NonZeroU32;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use mislab_renderer::build::BuiltScene;
use mislab_renderer::inspect::{Accuracy, Estimator, Inspector, Moments, Point, Table, Technique, replay};
use mislab_renderer::kernel::Lanewise;
use mislab_renderer::sampler::RUN;
use mislab_renderer::{
    Bsdf, Channel, Frame, Heuristic, OneSampleWeights, Request, SamplerKind, SamplerSettings, Scene, Settings,
    Strategy, progressive,
};
use mislab_tests::experiment::{independent, keyhole, veach};
use mislab_tests::oracle::{LUMINANCE, World};
use mislab_tests::places::{EYE, places};

/// Largest relative difference to the oracle.
const CLOSE: f64 = 1e-4;
/// Side of the picture through the keyhole.
const SIDE: u32 = 32;

/// Every strategy, heuristic, weight and c.
fn estimators() -> Vec<Settings> {
    let base = independent(1, 1, [SIDE, SIDE]);
    let of = |strategy| Settings { strategy, ..base.clone() };
    let mut all = vec![of(Strategy::Light), of(Strategy::Bsdf)];
    for heuristic in Heuristic::ALL {
        all.push(Settings { heuristic, ..of(Strategy::MisAll) });
        for weights in OneSampleWeights::ALL {
            for light_prob in [0.0, 0.1, 0.5, 0.9, 1.0] {
                all.push(Settings { heuristic, weights, light_prob, ..of(Strategy::Mis) });
            }
        }
    }
    all
}

fn name(s: &Settings) -> String {
    format!("{} {} {} c={}", s.strategy.name(), s.heuristic.name(), s.weights.name(), s.light_prob)
}

/// Asks about what the middle of a keyhole picture shows.
fn through_keyhole<R>(scene: &Scene, target: DVec3, ask: impl FnOnce(&Point<'_>) -> R) -> R {
    let settings = independent(1, 1, [SIDE, SIDE]);
    let built = BuiltScene::new(&keyhole(scene, EYE, target), &settings).expect("the scene can be built");
    let middle = SIDE as f32 / 2.0;
    let seen = Inspector::new(&built, &settings).at_pixel(middle, middle);
    ask(&seen.point().expect("a surface is seen"))
}

/// The largest deviation of its kind so far.
struct Worst {
    what: &'static str,
    deviation: f64,
    label: String,
    count: usize,
}

impl Worst {
    fn new(what: &'static str) -> Self {
        Self { what, deviation: 0.0, label: String::new(), count: 0 }
    }

    /// A deviation, in units of what is allowed.
    fn note(&mut self, found: f64, expected: f64, allowed: f64, label: impl FnOnce() -> String) {
        self.count += 1;
        let deviation = if found == expected { 0.0 } else { (found - expected).abs() / allowed };
        if deviation.is_nan() || deviation > self.deviation {
            (self.deviation, self.label) = (deviation, format!("{}: {found}, expected {expected}", label()));
        }
    }

    fn judge(&self) {
        println!(
            "{}: {} compared, worst {:.3} of what is allowed: {}",
            self.what, self.count, self.deviation, self.label
        );
    }

    fn holds(&self) -> bool {
        self.deviation <= 1.0
    }
}

#[test]
fn moments_agree_with_the_oracle_at_every_point() {
    let mut worst = ["means", "variances", "parts' means", "parts' variances", "weights", "colours"].map(Worst::new);
    for (label, scene, target) in places(&veach()) {
        let point = World::new(&scene).point(EYE, target);
        let start = std::time::Instant::now();
        let table = through_keyhole(&scene, target, |point| point.tabulate(&Accuracy::default()));
        println!(
            "{label}: {} directions, {:.1e}, {:.1} ms",
            table.evaluations(),
            table.relative_error(),
            start.elapsed().as_secs_f64() * 1e3
        );
        for settings in estimators() {
            let found = table.moments(&Estimator::from(&settings));
            let expected = point.sample(&settings, LUMINANCE);
            let scale = expected.total.mean();
            let label = |part: &str| format!("{label}, {}, {part}", name(&settings));
            // A variance is the difference of E Y^2 and the mean's square: where it is far below that, it is known to 1e-6
            // of the square only, by the oracle as well.
            let allowed = |variance: f64, mean: f64| CLOSE * variance + 1e-6 * mean * mean;
            let [means, variances, part_means, part_variances, weights, colours] = &mut worst;
            let (mean, variance) = (expected.total.mean(), expected.total.variance());
            means.note(found.total.mean, mean, CLOSE * mean, || label("mean"));
            variances.note(found.total.variance, variance, allowed(variance, mean), || label("variance"));
            let parts: [(&str, Moments, _); 2] =
                [("light", found.light, expected.light), ("bsdf", found.bsdf, expected.bsdf)];
            for (name, found, expected) in parts {
                let (mean, variance) = (expected.moments.mean(), expected.moments.variance());
                // Of a part that hardly counts its share of the whole is asked.
                part_means.note(found.mean, mean, CLOSE * mean + 1e-7 * scale, || label(name));
                let least = allowed(variance, mean) + 1e-6 * expected_variance_share(scale);
                part_variances.note(found.variance, variance, least, || label(name));
                if expected.carries > 1e-6 {
                    weights.note(found.weight, expected.weight().0, CLOSE, || label(name));
                }
            }
            let red = point.sample(&settings, DVec3::X).total.mean();
            colours.note(found.total.radiance.x, red, CLOSE * red, || label("red"));
        }
    }
    worst.iter().for_each(Worst::judge);
    assert!(worst.iter().all(Worst::holds), "see above");
}

fn expected_variance_share(scale: f64) -> f64 {
    1e-6 * scale * scale
}
