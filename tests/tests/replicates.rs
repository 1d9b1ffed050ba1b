//! What a sample of a pattern is worth, measured over replicates, against the oracle's exact variance.

use std::num::NonZeroU32;

use mislab_renderer::study::Replicated;
use mislab_renderer::study::replicates::REPLICATES;
use mislab_renderer::{Estimator, Request, SamplerKind, Strategy};
use mislab_tests::experiment::{independent, keyhole, veach};
use mislab_tests::oracle::{LUMINANCE, World};
use mislab_tests::places::{EYE, places};

const SIDE: u32 = 64;

fn request(kind: SamplerKind) -> Request {
    let (_, scene, target) =
        places(&veach()).into_iter().find(|(name, ..)| name == "plate3 at light 2").expect("the place exists");
    let mut settings = independent(16, 5, [SIDE, SIDE]);
    settings.estimator = Estimator { strategy: Strategy::MisAll, ..Estimator::default() };
    settings.sampling.sampler.kind = kind;
    settings.sampling.sampler.strata = [4, 4];
    settings.sampling.spp = NonZeroU32::new(16);
    Request { scene: keyhole(&scene, EYE, target), settings }
}

fn measured(kind: SamplerKind) -> Replicated {
    let found = Replicated::measure(&request(kind), 1, &mut || true);
    found.expect("it can be rendered").expect("something is hit")
}

#[test]
fn independent_samples_are_worth_what_the_layer_says_and_strata_more() {
    let about = request(SamplerKind::Independent);
    let (_, scene, target) =
        places(&veach()).into_iter().find(|(name, ..)| name == "plate3 at light 2").expect("the place exists");
    let exact = World::new(&scene).point(EYE, target).sample(&about.settings, LUMINANCE).total.variance();
    // Means of 16 samples are nearly normal: a variance with so many degrees of freedom has that relative standard error.
    let error = (2.0 / f64::from(SIDE * SIDE * (REPLICATES - 1))).sqrt();
    let independent = measured(SamplerKind::Independent);
    let stratified = measured(SamplerKind::Stratified);
    println!("exact {exact}, {independent:?}, {stratified:?}, standard error {error}");
    for found in [independent.pattern, independent.independent] {
        assert!((found.absolute / exact - 1.0).abs() < 5.0 * error, "{found:?} is not {exact}");
    }
    let gain = stratified.pattern.absolute / exact;
    assert!(gain < 1.0 - 5.0 * error, "strata help: {gain}");
    assert_eq!(stratified.spp, 16);
}

#[test]
fn it_is_given_up() {
    let found = Replicated::measure(&request(SamplerKind::Stratified), 1, &mut || false);
    assert_eq!(found.expect("giving up is no error"), None);
}
