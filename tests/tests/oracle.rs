//! Means, variances, contributions and weights of every strategy against the oracle.

use std::sync::Arc;

use glam::DVec3;
use mislab_renderer::{Heuristic, OneSampleWeights, Scene, Settings, Strategy};
use mislab_tests::experiment::{highlight, independent, keyhole, measure, veach};
use mislab_tests::oracle::{LUMINANCE, Point, World};
use mislab_tests::statistics::Family;

const EYE: DVec3 = DVec3::new(0.0, 2.0, 15.0);

/// Samples of each measurement, unless its distribution asks for more.
const SAMPLES: u32 = 1 << 19;
/// Most samples of a measurement.
const MOST_SAMPLES: u32 = 1 << 22;
/// A quantity is tested where the skewness of its estimate, known exactly, is below this: else the
/// normal distribution is no judge of it.
const SKEWNESS: f64 = 0.1;
/// Relative errors of single precision and of the keyhole, counted as if they were noise.
const ROUNDING: f64 = 3e-5;
/// Resolution of a variance in units of the squared mean: the film adds up squares in single precision.
const SQUARE_ROUNDING: f64 = 1e-7;

/// Every strategy, heuristic, weight and c. Veach's weights at c = 0 and 1 appear once: there they
/// are the two single techniques whatever the heuristic (`identities.rs` has them bit for bit).
fn all_settings() -> Vec<(String, Settings)> {
    let base = independent(1, 1, [32, 32]);
    let mut all = Vec::new();
    for strategy in [Strategy::Light, Strategy::Bsdf] {
        all.push((strategy.name().to_owned(), Settings { strategy, ..base.clone() }));
    }
    for heuristic in Heuristic::ALL {
        all.push((
            format!("mis_all {}", heuristic.name()),
            Settings { strategy: Strategy::MisAll, heuristic, ..base.clone() },
        ));
        for weights in OneSampleWeights::ALL {
            for light_prob in [0.0, 0.1, 0.5, 0.9, 1.0] {
                let single = light_prob == 0.0 || light_prob == 1.0;
                if weights == OneSampleWeights::Veach && single && heuristic != Heuristic::Balance {
                    continue;
                }
                all.push((
                    format!("mis {} {} c={light_prob}", heuristic.name(), weights.name()),
                    Settings { strategy: Strategy::Mis, heuristic, weights, light_prob, ..base.clone() },
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

fn shape_of(scene: &Scene, material: &str) -> usize {
    let index = scene.materials.iter().position(|m| m.name == material).expect("the material exists");
    scene.shapes.iter().position(|s| s.material == Some(index)).expect("a shape has the material")
}

/// Points of the default scene: the highlights of all lights on all plates, between highlights, and
/// floor and wall lit, half shadowed and near a light.
fn points(scene: &Scene) -> Vec<(String, DVec3)> {
    let mut points = Vec::new();
    for plate in ["plate1", "plate2", "plate3", "plate4"] {
        let shape = shape_of(scene, plate);
        for (i, light) in scene.light_shapes().enumerate() {
            points.push((format!("{plate} at light {}", i + 1), highlight(scene, shape, light, EYE)));
        }
    }
    let mid = |a: &(String, DVec3), b: &(String, DVec3)| (a.1 + b.1) / 2.0;
    for (plate, first) in [("plate2", 4), ("plate3", 8), ("plate4", 12)] {
        let between = mid(&points[first + 2], &points[first + 3]);
        points.push((format!("{plate} between lights 3 and 4"), between));
    }
    let y = -4.14615;
    points.push(("floor in front".to_owned(), DVec3::new(0.7, y, 7.0)));
    points.push(("floor left".to_owned(), DVec3::new(-5.5, y, 4.0)));
    points.push(("floor in a penumbra".to_owned(), DVec3::new(4.6, y, 1.0)));
    points.push(("wall beside the smallest light".to_owned(), DVec3::new(-3.4, 0.3, -2.0)));
    points.push(("wall beside the largest light".to_owned(), DVec3::new(2.4, 0.9, -2.0)));
    points.push(("wall above".to_owned(), DVec3::new(0.2, 5.0, -2.0)));
    points.push(("wall behind the plates' edge".to_owned(), DVec3::new(-4.3, -3.0, -2.0)));
    points
}

#[test]
fn every_strategy_has_the_mean_and_variance_of_the_oracle() {
    let scene = veach();
    let world = World::new(&scene);
    let mut families = Families::new();
    for (number, (label, target)) in points(&scene).into_iter().enumerate() {
        let point = world.point(EYE, target);
        let start = std::time::Instant::now();
        let view = keyhole(&scene, EYE, target);
        for (i, (name, settings)) in all_settings().into_iter().enumerate() {
            let settings = Settings { seed: (1000 * number + i) as u32, ..settings };
            compare(&mut families, &format!("{label}, {name}"), &view, &point, &settings);
        }
        println!("{label}: {:.3?} nodes {} L {:.5}", start.elapsed(), point.node_count(), point.radiance().x);
    }
    families.judge([500, 500, 400, 400]);
}
