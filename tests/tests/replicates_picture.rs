//! What a sample is worth over a whole picture with lights in view.

use std::sync::Arc;

use mislab_renderer::study::Replicated;
use mislab_renderer::{Estimator, Request, SamplerKind, Strategy, pbrt};

/// At the rims of the lamps a few pixels hold three times the noise of all others together, which no strategy changes: they are left out, and the two
/// estimates of independent samples are of one number.
#[test]
fn rims_of_lights_do_not_decide() {
    let file = pbrt::embedded_scene();
    let scene = Arc::new(file.scene);
    let mut sum = [0.0; 2];
    for seed in 0..3 {
        let mut settings = file.settings.clone();
        settings.estimator = Estimator { strategy: Strategy::Light, ..Estimator::default() };
        settings.sampling.sampler.kind = SamplerKind::Independent;
        settings.sampling.seed = 1000 * seed;
        let request = Request { scene: scene.clone(), settings };
        let found = Replicated::measure(&request, 1, &mut || true).expect("it can be rendered").expect("it is lit");
        sum = [sum[0] + found.independent.absolute / 3.0, sum[1] + found.pattern.absolute / 3.0];
    }
    let [independent, pattern] = sum;
    println!("{independent} by samples, {pattern} by replicates");
    // With the rims it is 33; without 8: single seeds have been seen to differ by a tenth, by replicates by a fourth.
    assert!((5.0..12.0).contains(&independent), "{independent}");
    assert!((0.6..1.6).contains(&(pattern / independent)), "{independent} by samples, {pattern} by replicates");
}
