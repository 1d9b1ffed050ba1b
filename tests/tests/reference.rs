//! The default scene against an image and variances that an independent renderer found.
//!
//! Both noises count everywhere: the reference's own standard error and ours. `tests/data` holds the
//! image, its standard errors, a map of regions (four plates, floor, wall, lights, all two pixels
//! off their edges) and the variance of one sample by region and strategy.

use std::path::Path;
use std::sync::Arc;

use mislab_renderer::{Channel, Estimator, Scene, Settings, Strategy};
use mislab_tests::experiment::{independent, render, veach};
use mislab_tests::image::Image;
use mislab_tests::oracle::LUMINANCE;
use mislab_tests::statistics::{Family, z_limit};

const SIDE: usize = 400;
/// Systematic difference allowed: the reference is known to be exact to this.
const SYSTEMATIC: f64 = 1e-3;
/// Samples per pixel of each of two renderings.
const SPP: u32 = 160;
/// Samples per pixel of both.
const TOTAL_SPP: f64 = 2.0 * SPP as f64;
/// Half the side of the window over which variances of neighbours are averaged.
const WINDOW: usize = 4;
/// Pixels are tested one by one where their noise is below this part of their value. Noise of
/// positive numbers goes with skewness: a pixel beyond sees too few events to be nearly normal.
const PIXEL_NOISE: f64 = 0.1;
/// Standard errors of the reference's variances are estimates from 8 batches. Student's t with 7
/// degrees of freedom reaches about 1.6 times as far as a normal distribution at the limit here.
const SMALL_BATCH: f64 = 1.6;

const REGIONS: [(&str, f32); 6] =
    [("plate1", 1.0), ("plate2", 2.0), ("plate3", 3.0), ("plate4", 4.0), ("floor", 5.0), ("wall", 6.0)];

struct Reference {
    mean: Vec<f64>,
    /// Standard error of `mean`. The scene is grey, so that the channels' errors are the same noise.
    error: Vec<f64>,
    region: Vec<f32>,
    variances: serde_json::Value,
}

fn reference() -> Reference {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
    let image = Image::read(&data.join("veach4_conductor_400.exr"));
    assert_eq!((image.width, image.height), (SIDE, SIDE), "size of the reference");
    let text = std::fs::read_to_string(data.join("veach4_conductor_400.json")).expect("the data are in the repository");
    let json: serde_json::Value = serde_json::from_str(&text).expect("the data are sound");
    Reference {
        mean: luminance([image.channel("R"), image.channel("G"), image.channel("B")]),
        error: luminance([image.channel("stderr.R"), image.channel("stderr.G"), image.channel("stderr.B")]),
        region: image.channel("region.Y").to_vec(),
        variances: json["variance_of_one_sample"]["strategies"].clone(),
    }
}

fn luminance([r, g, b]: [&[f32]; 3]) -> Vec<f64> {
    let weigh = |i: usize| LUMINANCE.dot([r[i], g[i], b[i]].map(f64::from).into());
    (0..r.len()).map(weigh).collect()
}

/// Two independent renderings of one strategy, together.
struct Ours {
    mean: Vec<f64>,
    /// Variance of one sample.
    variance: Vec<f64>,
    /// Half the difference of the two renderings' variances.
    variance_error: Vec<f64>,
}

fn ours(scene: &Arc<Scene>, strategy: Strategy, light_prob: f32) -> Ours {
    let [a, b] = [11, 12].map(|seed| {
        let base = independent(SPP, seed, [SIDE as u32, SIDE as u32]);
        let settings = Settings { estimator: Estimator { strategy, light_prob, ..base.estimator }, ..base };
        let frame = render(scene, &settings);
        assert_eq!(frame.stats().invalid_samples, 0, "invalid samples");
        let [r, g, b] = [Channel::R, Channel::G, Channel::B].map(|c| frame.channel(c));
        (luminance([&r, &g, &b]), frame.channel(Channel::VarianceY))
    });
    let pixels = 0..SIDE * SIDE;
    Ours {
        mean: pixels.clone().map(|i| (a.0[i] + b.0[i]) / 2.0).collect(),
        variance: pixels.clone().map(|i| f64::from(a.1[i] + b.1[i]) / 2.0).collect(),
        variance_error: pixels.map(|i| f64::from(a.1[i] - b.1[i]) / 2.0).collect(),
    }
}

/// Mean of `values` over the pixels of the same region in a window around each pixel: an estimate
/// of a pixel's variance that hardly depends on that pixel's own samples. (With its own variance, a
/// pixel that missed all bright samples would seem dark and precise at once.)
fn smoothed(values: &[f64], region: &[f32]) -> Vec<f64> {
    let around = |i: usize| i.saturating_sub(WINDOW)..(i + WINDOW + 1).min(SIDE);
    (0..SIDE * SIDE)
        .map(|i| {
            let (mut sum, mut count) = (0.0, 0.0);
            for y in around(i / SIDE) {
                for x in around(i % SIDE) {
                    if region[y * SIDE + x] == region[i] {
                        sum += values[y * SIDE + x];
                        count += 1.0;
                    }
                }
            }
            sum / count
        })
        .collect()
}

/// Scores of the pixels of one strategy.
struct Pixels {
    z: Vec<f32>,
    tested: usize,
}

/// z of every pixel that can be tested alone. Means are compared on the scale of their power 2/3,
/// on which sums of rare events are symmetric (Anscombe's transform for counts).
fn pixel_scores(ours: &Ours, reference: &Reference) -> Pixels {
    let smooth = smoothed(&ours.variance, &reference.region);
    let mut pixels = Pixels { z: vec![0.0; SIDE * SIDE], tested: 0 };
    for (i, smooth) in smooth.into_iter().enumerate() {
        let (mean, expected) = (ours.mean[i], reference.mean[i]);
        // The larger of both, for the edges of shadows and of mirrored lights.
        let noise = (smooth.max(ours.variance[i]) / TOTAL_SPP).sqrt();
        let testable = REGIONS.iter().any(|&(_, code)| code == reference.region[i]);
        if !testable || noise > PIXEL_NOISE * expected {
            continue;
        }
        pixels.tested += 1;
        let difference = (mean - expected).abs();
        if difference > SYSTEMATIC * expected {
            let beyond = expected + (1.0 - SYSTEMATIC * expected / difference) * (mean - expected);
            let error = noise.hypot(reference.error[i]);
            let power = |x: f64| x.powf(2.0 / 3.0);
            let z = (power(beyond) - power(expected)) / (2.0 / 3.0 * expected.powf(-1.0 / 3.0) * error);
            pixels.z[i] = z as f32;
        }
    }
    pixels
}

/// Writes what a failed strategy looks like, and says where.
fn dump(name: &str, ours: &Ours, reference: &Reference, z: &[f32]) -> String {
    let single = |values: &[f64]| values.iter().map(|&v| v as f32).collect::<Vec<_>>();
    let difference = ours.mean.iter().zip(&reference.mean).map(|(a, b)| (a - b) as f32).collect();
    let channels = [
        ("ours.Y", single(&ours.mean)),
        ("reference.Y", single(&reference.mean)),
        ("difference.Y", difference),
        ("variance.Y", single(&ours.variance)),
        ("z.Y", z.to_vec()),
    ];
    let channels = channels.into_iter().map(|(name, values)| (name.to_owned(), values)).collect();
    let image = Image { width: SIDE, height: SIDE, channels };
    image.dump(&format!("reference_{}", name.replace([' ', '='], "_"))).display().to_string()
}

#[test]
fn every_strategy_agrees_with_the_reference() {
    let reference = reference();
    let scene = Arc::new(veach());
    let mut means = Family::new("region means against the reference");
    let mut variances = Family::new("region variances against the reference");
    let mut failures = Vec::new();
    for (name, strategy, c) in [
        ("light", Strategy::Light, 0.5),
        ("bsdf", Strategy::Bsdf, 0.5),
        ("mis_all", Strategy::MisAll, 0.5),
        ("mis c=0.1", Strategy::Mis, 0.1),
        ("mis c=0.5", Strategy::Mis, 0.5),
        ("mis c=0.9", Strategy::Mis, 0.9),
    ] {
        let mut ours = ours(&scene, strategy, c);
        for (place, code) in REGIONS {
            let pixels: Vec<usize> = (0..SIDE * SIDE).filter(|&i| reference.region[i] == code).collect();
            let count = pixels.len() as f64;
            let mean_of = |value: &dyn Fn(usize) -> f64| pixels.iter().map(|&i| value(i)).sum::<f64>() / count;
            let label = format!("{name}, {place}");
            if strategy == Strategy::Light && place == "plate1" {
                // No light sample ever meets the one direction of a mirror. Nothing more to test here.
                assert!(pixels.iter().all(|&i| ours.mean[i] == 0.0), "light sampling shows something in the mirror");
                for i in pixels {
                    ours.mean[i] = reference.mean[i];
                }
                continue;
            }
            let expected = mean_of(&|i| reference.mean[i]);
            let noise2 = mean_of(&|i| ours.variance[i] / TOTAL_SPP) + mean_of(&|i| reference.error[i].powi(2));
            let error = (noise2 / count).sqrt();
            means.test_within(&label, mean_of(&|i| ours.mean[i]), expected, SYSTEMATIC * expected, error);

            let stated = |key: &str| reference.variances[name][place][key].as_f64().expect("a number in the reference");
            let noise = (mean_of(&|i| ours.variance_error[i].powi(2)) / count).sqrt();
            let error = noise.hypot(SMALL_BATCH * stated("stderr"));
            let (variance, expected) = (mean_of(&|i| ours.variance[i]), stated("variance"));
            variances.test_within(&label, variance, expected, SYSTEMATIC * expected, error);
        }
        for i in (0..SIDE * SIDE).filter(|&i| reference.region[i] >= 10.0) {
            // Lights, seen directly.
            let difference = (ours.mean[i] - reference.mean[i]).abs();
            assert!(difference <= 1e-5 * reference.mean[i], "{name}: light at pixel {}, {}", i % SIDE, i / SIDE);
        }
        // BSDF samples meet a light so rarely that no pixel's mean is nearly normal.
        if strategy != Strategy::Bsdf {
            let pixels = pixel_scores(&ours, &reference);
            let limit = z_limit(pixels.tested);
            let failed = pixels.z.iter().filter(|z| z.abs() > limit as f32).count();
            let largest = pixels.z.iter().fold(0.0f32, |a, z| a.max(z.abs()));
            println!("{name}: {} pixels tested, limit |z| <= {limit:.2}, largest {largest:.2}", pixels.tested);
            let least = if c < 0.5 { 8_000 } else { 100_000 };
            assert!(pixels.tested > least, "{name}: only {} pixels could be tested", pixels.tested);
            if failed > 0 {
                let place = dump(name, &ours, &reference, &pixels.z);
                let worst = (0..SIDE * SIDE).max_by(|&a, &b| pixels.z[a].abs().total_cmp(&pixels.z[b].abs()));
                let at = worst.expect("there are pixels");
                failures.push(format!(
                    "{name}: {failed} pixels beyond |z| = {limit:.2}, the largest {largest:.2} at {}, {}: \
                     {:.4e}, expected {:.4e} +- {:.1e}, variance {:.3e}; see {place}",
                    at % SIDE,
                    at / SIDE,
                    ours.mean[at],
                    reference.mean[at],
                    reference.error[at],
                    ours.variance[at],
                ));
            }
        }
    }
    // All are judged before the first can fail.
    let results = [means, variances].map(|family| std::panic::catch_unwind(move || family.judge(35)));
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    assert!(results.iter().all(Result::is_ok), "see the region means and variances above");
}
