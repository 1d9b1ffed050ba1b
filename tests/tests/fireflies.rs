//! Outliers found by replay, against all samples of the picture.

use std::num::NonZeroU32;
use std::sync::Arc;

use glam::DVec3;
use mislab_kernel::lanes::Lanewise;
use mislab_kernel::world::BuiltScene;
use mislab_renderer::inspect::{
    Fireflies, Outlier, Search, Technique, fireflies, replay, suspects_of_frame, suspects_of_layers,
};
use mislab_renderer::snapshot::Contents;
use mislab_renderer::{
    Channel, Estimator, Frame, ImageSettings, SamplerKind, SamplerSettings, Sampling, Settings, Strategy,
};
use mislab_tests::experiment::{render, veach};
use mislab_tests::oracle::{self, LUMINANCE};

const SIZE: [u32; 2] = [40, 32];
const SPP: u32 = 16;

fn settings(strategy: Strategy, kind: SamplerKind) -> Settings {
    Settings {
        estimator: Estimator { strategy, light_prob: 0.3, ..Estimator::default() },
        sampling: Sampling {
            sampler: SamplerSettings { kind, strata: [4, 4], jitter: true },
            spp: NonZeroU32::new(SPP),
            seed: 3,
        },
        image: ImageSettings { resolution: SIZE, crop: [0.0, 0.9, 0.1, 1.0] },
    }
}

/// A picture and its samples.
struct Picture {
    frame: Arc<Frame>,
    built: BuiltScene,
    settings: Settings,
}

impl Picture {
    fn new(settings: Settings) -> Self {
        let scene = Arc::new(veach());
        let frame = render(&scene, &settings);
        Self { built: BuiltScene::new(&scene, &settings).expect("the scene can be built"), frame, settings }
    }

    fn search(&self, count: usize, threads: usize) -> Search<'_> {
        Search {
            scene: &self.built,
            settings: &self.settings,
            spp: SPP,
            how: Lanewise::best(),
            count,
            threads,
            most_samples: u64::MAX,
        }
    }

    /// Those that the frame's sums lead to.
    fn found(&self, count: usize, threads: usize) -> Fireflies {
        fireflies(&self.search(count, threads), suspects_of_frame(&self.frame), &|| true).expect("nobody stops it")
    }

    /// Pixel, index and value of all outliers, by looking at every sample: the brightest first.
    fn all(&self) -> Vec<([u32; 2], u32, f64)> {
        let bounds = self.settings.pixel_bounds();
        let mut all = Vec::new();
        for y in bounds.min[1]..bounds.max[1] {
            for x in bounds.min[0]..bounds.max[0] {
                let (mut squares, mut brightest) = (0.0, (0, 0.0));
                for index in 0..SPP {
                    let sample = replay(Lanewise::best(), &self.built, &self.settings, [x, y], index);
                    squares += f64::from(sample.luminance).powi(2);
                    for ray in sample.rays.iter().filter(|ray| ray.lit) {
                        let value = LUMINANCE.dot(ray.value.as_dvec3());
                        if value > brightest.1 {
                            brightest = (index, value);
                        }
                    }
                }
                let (index, value) = brightest;
                if value > 0.0 && value * value > 0.500_001 * squares {
                    all.push(([x, y], index, value));
                }
            }
        }
        all.sort_by(|a, b| b.2.total_cmp(&a.2).then(a.0.cmp(&b.0)));
        all
    }
}

fn short(outliers: &[Outlier]) -> Vec<([u32; 2], u32, f64)> {
    outliers.iter().map(|o| (o.pixel, o.index, o.value)).collect()
}

/// The brightest are the brightest of all samples: pixels, samples and values (to rounding).
fn same(found: &[Outlier], all: &[([u32; 2], u32, f64)], label: &str) {
    let found = short(found);
    assert_eq!(found.len(), all.len(), "{label}");
    for (a, b) in found.iter().zip(all) {
        assert_eq!((a.0, a.1), (b.0, b.1), "{label}: {found:?}, expected {all:?}");
        assert!((a.2 - b.2).abs() <= 1e-6 * b.2, "{label}: {a:?}, expected {b:?}");
    }
}

#[test]
fn the_outliers_found_are_the_brightest_of_all_samples() {
    for (i, strategy) in Strategy::ALL.into_iter().enumerate() {
        let picture = Picture::new(settings(strategy, SamplerKind::ALL[i]));
        let all = picture.all();
        println!("{}: {} outliers, {:?}", strategy.name(), all.len(), all.first());
        assert!(all.len() > 12, "{}: {} outliers", strategy.name(), all.len());
        for count in [1, 7, 12, all.len() + 5] {
            let found = picture.found(count, 2);
            let label = format!("{} {count}", strategy.name());
            same(&found.outliers, &all[..count.min(all.len())], &label);
            assert!(found.complete && found.different == 0, "{label}: {found:?}");
        }
        let few = picture.found(1, 1);
        let pixels = picture.settings.pixel_bounds().area();
        assert!(few.examined * 4 < pixels, "{} of {pixels} pixels for one outlier", few.examined);
        assert_eq!(picture.found(7, 1).outliers, picture.found(7, 3).outliers, "at any number of threads");
    }
}

#[test]
fn the_layers_of_a_saved_picture_lead_to_the_same_outliers() {
    for (strategy, kind) in [(Strategy::Bsdf, SamplerKind::Independent), (Strategy::Mis, SamplerKind::Stratified)] {
        let picture = Picture::new(settings(strategy, kind));
        let mut contents = Contents::from_frame(&picture.frame);
        let (all, bounds) = (picture.all(), contents.bounds);
        let found = |contents: &Contents| {
            let layer = |channel: Channel| {
                let named = contents.layers.iter().find(|(name, _)| name == channel.exr_name());
                named.map(|(_, values)| values.as_slice())
            };
            let suspects = suspects_of_layers(bounds, SPP, &layer)?;
            fireflies(&picture.search(9, 2), suspects, &|| true)
        };
        let right = found(&contents).expect("all layers are there");
        same(&right.outliers, &all[..9], strategy.name());
        assert!(right.complete && right.different == 0, "{right:?}");
        // An outlier is planted that no sample has.
        let [x, y] = [0, 1].map(|axis| all[0].0[axis] - bounds.min[axis]);
        let at = (y * bounds.width() + x) as usize;
        for (name, values) in &mut contents.layers {
            if ["R", "G", "B", "bsdf.R", "bsdf.G", "bsdf.B"].contains(&name.as_str()) {
                values[at] = 1e3;
            }
            if name == "variance.Y" {
                // As if one sample had it all.
                values[at] = 1e6 * SPP as f32;
            }
        }
        let planted = found(&contents).expect("all layers are there");
        assert_eq!(planted.different, 1, "the pixel's samples do not add up to it");
        contents.layers.retain(|(name, _)| name != "variance.Y");
        assert!(found(&contents).is_none(), "a layer is missing");
    }
}

#[test]
fn an_outlier_says_what_the_pixel_is_with_and_without_it() {
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-5 * b.abs() + 1e-12;
    for strategy in Strategy::ALL {
        let picture = Picture::new(settings(strategy, SamplerKind::Independent));
        for outlier in picture.found(20, 2).outliers {
            let label = format!("{}: {outlier:?}", strategy.name());
            let [x, y] = outlier.pixel;
            let of = |channel| f64::from(picture.frame.pixel(x, y, channel).expect("a pixel of the picture"));
            let mean = DVec3::from_array([Channel::R, Channel::G, Channel::B].map(of));
            assert!((outlier.mean - mean).length() <= 1e-5 * mean.length(), "{label}, expected {mean}");
            let n = f64::from(SPP);
            let share = outlier.value / (n * LUMINANCE.dot(mean));
            assert!(close(outlier.share_of_pixel, share), "{label}, expected {share}");
            // What this sample adds in all: with mis_all there is another ray.
            let sample = f64::from(outlier.sample.luminance);
            let without = (n * LUMINANCE.dot(mean) - sample) / (n - 1.0);
            let found = LUMINANCE.dot(outlier.mean_without);
            assert!((found - without).abs() <= 1e-5 * LUMINANCE.dot(mean), "{label}, expected {without}");
            let ray = &outlier.sample.rays[outlier.ray];
            assert!(ray.lit && close(LUMINANCE.dot(ray.value.as_dvec3()), outlier.value), "{label}");
            let (l, b) = (f64::from(ray.p_light), f64::from(ray.p_bsdf));
            let weights = oracle::heuristic(picture.settings.estimator.heuristic, l, b);
            let (weight, p) = match ray.technique {
                Technique::Light => (weights.0, l),
                Technique::Bsdf => (weights.1, b),
            };
            let expected = LUMINANCE.dot(ray.f.as_dvec3()) * weight / p;
            assert!(close(outlier.under_mis_all, expected), "{label}, expected {expected}");
            if strategy == Strategy::MisAll {
                assert!(close(outlier.under_mis_all, outlier.value), "{label}");
            }
        }
    }
}

#[test]
fn a_search_can_be_bounded_and_given_up() {
    let picture = Picture::new(settings(Strategy::Bsdf, SamplerKind::Stratified));
    let suspects = suspects_of_frame(&picture.frame);
    assert_eq!(fireflies(&picture.search(5, 2), suspects.clone(), &|| false), None);
    let search = Search { most_samples: u64::from(SPP) * 3, ..picture.search(500, 1) };
    let found = fireflies(&search, suspects, &|| true).expect("nobody stops it");
    assert!(!found.complete && found.examined == 3 && found.outliers.len() <= 3, "{found:?}");
    assert!(
        fireflies(&picture.search(5, 0), Vec::new(), &|| true).is_some_and(|f| f.complete && f.outliers.is_empty())
    );
}
