//! Means against a grown reference: a biased estimator is called biased, unbiased ones are not, and references grow to what they say.

use std::num::NonZeroU32;
use std::sync::Arc;

use mislab_renderer::study::reference::Wish;
use mislab_renderer::study::{Against, Mean, News, Part, grow, p_values};
use mislab_renderer::{
    Estimator, ImageSettings, OneSampleWeights, Renderer, Request, Sampling, Scene, Settings, Strategy, pbrt,
};

const IMAGE: ImageSettings = ImageSettings { resolution: [48; 2], crop: [0.0, 1.0, 0.0, 1.0] };
/// All tests of a picture together.
const SIGNIFICANCE: f64 = 0.01;

/// Veach's plates, the mirror among them made rough: no light sample ever meets a mirror's one direction, and that is a bias.
fn scene() -> Arc<Scene> {
    let mut scene = pbrt::embedded_scene().scene;
    for alpha in scene.materials.iter_mut().filter_map(|material| material.bsdf.alpha_mut()) {
        *alpha = alpha.max(0.01);
    }
    Arc::new(scene)
}

fn reference(scene: &Arc<Scene>) -> Arc<Against> {
    let mut best = None;
    grow(scene, IMAGE, [1, 4096], 1, &mut |news| {
        if let News::Better(better) = news {
            best = Some(better);
        }
        Wish::GoOn
    })
    .expect("the scene can be rendered");
    best.expect("it was reported")
}

/// The smallest corrected p-value over all parts of pictures of that many seeds, seed by seed.
fn smallest_p(scene: &Arc<Scene>, against: &Against, estimator: Estimator, seeds: u32) -> Vec<f64> {
    let renderer = Renderer::new(1, || {});
    let references: Vec<Mean> = against.cells.parts().map(|part| against.mean(part)).collect();
    let one = |seed: u32| {
        let sampling = Sampling { spp: NonZeroU32::new(64), seed: 1000 + seed, ..Sampling::default() };
        let request = Request { scene: Arc::clone(scene), settings: Settings { estimator, sampling, image: IMAGE } };
        let frame = renderer.render(&request, &mut |_| true).expect("it can be rendered");
        let parts: Vec<Part> = against.cells.parts().collect();
        let means = Mean::of_frame(&frame, &against.cells, &parts).expect("64 samples have a variance");
        let single: Vec<_> = means.iter().zip(&references).map(|(mean, r)| mean.p_value(r)).collect();
        p_values(&single).into_iter().flatten().fold(1.0, f64::min)
    };
    (0..seeds).map(one).collect()
}

/// With c = 0 the tutorial's weights lose what they leave to light samples; at any c between 0 and 1 they do not.
#[test]
fn only_a_biased_estimator_is_called_biased() {
    let scene = scene();
    let against = reference(&scene);
    assert!(against.cells.squares.len() >= 8, "plates and lights are told apart: {}", against.cells.squares.len());
    let tutorial = |light_prob: f32| Estimator {
        strategy: Strategy::Mis,
        weights: OneSampleWeights::Tutorial,
        light_prob,
        ..Estimator::default()
    };
    let biased = smallest_p(&scene, &against, tutorial(0.0), 20);
    assert!(biased.iter().all(|p| *p < SIGNIFICANCE), "{biased:?}");
    let mirrors = Arc::new(pbrt::embedded_scene().scene);
    let light = Estimator { strategy: Strategy::Light, ..Estimator::default() };
    let dark = smallest_p(&mirrors, &reference(&mirrors), light, 1);
    assert!(dark[0] < SIGNIFICANCE, "light samples never meet a mirror's direction: {dark:?}");
    // All of these tests together are one family of 1 %.
    let seeds = 20;
    let estimators =
        Strategy::ALL.map(|strategy| Estimator { strategy, ..Estimator::default() }).into_iter().chain([tutorial(0.1)]);
    for estimator in estimators {
        let found = smallest_p(&scene, &against, estimator, seeds);
        let least = found.iter().copied().fold(1.0, f64::min);
        let family = -(f64::from(5 * seeds) * (-least).ln_1p()).exp_m1();
        assert!(family > SIGNIFICANCE, "{estimator:?}: {least} is {family} over all");
    }
}

/// The noise of a reference with twice the samples is half, and more than half where points are stratified: never more.
#[test]
fn a_reference_grows_until_it_is_not_wanted() {
    let scene = scene();
    let (mut noise, mut spp) = (Vec::new(), Vec::new());
    grow(&scene, IMAGE, [1, 4096], 1, &mut |news| {
        if let News::Better(better) = news {
            noise.push(better.noise(Part::Whole).expect("rendered").rel_mse().expect("pixels"));
            spp.push(better.spp.expect("known"));
        }
        if spp.last() == Some(&512) { Wish::Stop } else { Wish::GoOn }
    })
    .expect("the scene can be rendered");
    assert_eq!(spp, [64, 128, 256, 512]);
    assert!(noise.is_sorted_by(|a, b| *b < 0.8 * a), "{noise:?}");
}
