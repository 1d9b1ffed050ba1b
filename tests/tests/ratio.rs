//! The noise of one picture over that of another: bands against the oracle's exact variances.

use std::sync::Arc;

use glam::DVec3;
use mislab_renderer::metrics::ratio::{Noise, Pixels, Ratio};
use mislab_renderer::metrics::{Errors, RELMSE_EPSILON, Reference, Region, pixel_errors};
use mislab_renderer::{Channel, Estimator, Frame, PixelRect, Scene, Settings, Strategy};
use mislab_tests::experiment::{independent, keyhole, render, veach};
use mislab_tests::oracle::{LUMINANCE, World};
use mislab_tests::places::{EYE, places};

/// Replicates are squares of this side of one picture, whose pixels all see the same point.
const SIDE: u32 = 24;
const REPLICATES: [u32; 2] = [20, 20];
const SPP: u32 = 16;

struct Side {
    mean: Vec<f32>,
    variance: Vec<f32>,
    cost: f64,
}

impl Side {
    fn of(frame: &Frame) -> Self {
        let [r, g, b, variance] = [Channel::R, Channel::G, Channel::B, Channel::VarianceY].map(|c| frame.channel(c));
        let luminance = |i: usize| LUMINANCE.dot(DVec3::new(f64::from(r[i]), f64::from(g[i]), f64::from(b[i]))) as f32;
        let cost = f64::from(frame.request().settings.estimator.strategy.rays_per_sample());
        Self { mean: (0..r.len()).map(luminance).collect(), variance, cost }
    }

    fn noise(&self) -> Noise<'_> {
        Noise { mean: &self.mean, variance: &self.variance, cost: self.cost }
    }
}

fn settings(strategy: Strategy, seed: u32, side: u32) -> Settings {
    let size = REPLICATES.map(|count| side * count);
    Settings { estimator: Estimator { strategy, ..Estimator::default() }, ..independent(SPP, seed, size) }
}

/// The ratios of all replicates.
fn ratios(scene: &Arc<Scene>, [a, b]: [(Strategy, u32); 2]) -> Vec<Option<Ratio>> {
    let [a, b] = [a, b].map(|(strategy, seed)| Side::of(&render(scene, &settings(strategy, seed, SIDE))));
    in_squares(&Pixels::noise(&a.noise(), &b.noise(), (SIDE * REPLICATES[0]) as usize), SIDE)
}

fn in_squares(pixels: &Pixels, side: u32) -> Vec<Option<Ratio>> {
    let width = (side * REPLICATES[0]) as usize;
    let squares = (0..REPLICATES[1]).flat_map(|y| (0..REPLICATES[0]).map(move |x| [x * side, y * side]));
    squares
        .map(|min| {
            let region = Region::Rect { width, rect: PixelRect { min, max: min.map(|v| v + side) } };
            Ratio::of(pixels, &region)
        })
        .collect()
}

fn place(name: &str) -> (Scene, DVec3) {
    let all = places(&veach());
    let (_, scene, target) = all.into_iter().find(|(label, ..)| label == name).expect("the place exists");
    (scene, target)
}

#[test]
fn the_band_holds_the_exact_ratio_in_95_of_100_replicates() {
    for (name, [a, b]) in [
        ("plate3 at light 2", [Strategy::Mis, Strategy::MisAll]),
        ("plate2 at light 3", [Strategy::Bsdf, Strategy::Mis]),
        // One BSDF sample in tens of thousands carries a good part of the variance, and most replicates have none.
        ("plate3 at light 3", [Strategy::MisAll, Strategy::Bsdf]),
        ("plate3 at light 3", [Strategy::Light, Strategy::Mis]),
        ("plate4 at light 3", [Strategy::Light, Strategy::MisAll]),
    ] {
        let (scene, target) = place(name);
        let point = World::new(&scene).point(EYE, target);
        let exact = |strategy: Strategy| {
            let variance = point.sample(&settings(strategy, 1, SIDE), LUMINANCE).total.variance();
            variance * f64::from(strategy.rays_per_sample())
        };
        let truth = exact(a) / exact(b);
        let found = ratios(&keyhole(&scene, EYE, target), [(a, 7), (b, 8)]);
        let covered = found.iter().flatten().filter(|ratio| {
            let [low, high] = ratio.interval(0.95);
            (low..=high).contains(&truth)
        });
        let (covered, all) = (covered.count(), found.len());
        // With 400 replicates of an exact 95 % band, 372 to 388 are within two standard errors.
        println!("{name}: {covered} of {all} hold {truth:.4}; the first is {:?}", found[0]);
        assert!((372..=388).contains(&covered), "{name}, {a:?} over {b:?}: {covered} of {all} hold {truth}");
        let wrong = found.iter().flatten().filter(|r| r.is_distinguishable() && (r.value() > 1.0) != (truth > 1.0));
        assert!(wrong.count() <= 20, "{name}: the wrong one is called less noisy");
    }
}

/// Side of the squares for errors: that of a pixel has a heavier tail than its variance over samples.
const SIDE_OF_ERRORS: u32 = 40;

/// Errors of both against the exact picture, and their exact ratio.
#[test]
fn the_band_of_errors_holds_the_exact_ratio_in_95_of_100_replicates() {
    for (name, [a, b]) in [
        ("plate3 at light 2", [Strategy::Mis, Strategy::MisAll]),
        ("plate3 at light 3", [Strategy::Light, Strategy::Mis]),
    ] {
        let (scene, target) = place(name);
        let point = World::new(&scene).point(EYE, target);
        let exact = |strategy: Strategy| {
            DVec3::AXES.map(|axis| {
                let total = point.sample(&settings(strategy, 1, SIDE_OF_ERRORS), axis).total;
                [total.mean(), total.variance()]
            })
        };
        let error = |of: [[f64; 2]; 3]| of.map(|[mean, variance]| variance / (mean * mean + RELMSE_EPSILON));
        let [of_a, of_b] = [a, b].map(exact);
        let truth = error(of_a).iter().sum::<f64>() / error(of_b).iter().sum::<f64>();
        let area = (SIDE_OF_ERRORS.pow(2) * REPLICATES[0] * REPLICATES[1]) as usize;
        let planes = of_a.map(|[mean, _]| vec![mean; area]);
        let planes = planes.each_ref().map(Vec::as_slice);
        let errors = |strategy: Strategy, seed: u32| {
            let frame = render(&keyhole(&scene, EYE, target), &settings(strategy, seed, SIDE_OF_ERRORS));
            let picture = [Channel::R, Channel::G, Channel::B].map(|channel| frame.channel(channel));
            let picture = picture.each_ref().map(Vec::as_slice);
            let reference = Reference::Halves([&planes, &planes]);
            let all = pixel_errors(&picture, &reference);
            let mean = all.iter().sum::<f64>() / area as f64;
            let rel_mse = Errors::of(&picture, &reference, &Region::All).rel_mse().expect("there are pixels");
            assert!((mean / rel_mse - 1.0).abs() < 1e-9, "the mean of {mean} is the relMSE of {rel_mse}");
            all
        };
        let found = in_squares(&Pixels::errors(&errors(a, 7), &errors(b, 8)), SIDE_OF_ERRORS);
        let covered = found.iter().flatten().filter(|ratio| {
            let [low, high] = ratio.interval(0.95);
            (low..=high).contains(&truth)
        });
        let (covered, all) = (covered.count(), found.len());
        println!("errors, {name}: {covered} of {all} hold {truth:.4}; the first is {:?}", found[0]);
        assert!((372..=388).contains(&covered), "{name}, {a:?} over {b:?}: {covered} of {all} hold {truth}");
    }
}

#[test]
fn a_picture_is_not_distinguished_from_itself_with_another_seed() {
    for (name, strategy) in [
        ("plate2 at light 4", Strategy::Light),
        ("plate3 at light 2", Strategy::MisAll),
        // One sample in hundreds hits: its tails are the heaviest of all.
        ("plate4 at light 1", Strategy::Bsdf),
    ] {
        let (scene, target) = place(name);
        let found = ratios(&keyhole(&scene, EYE, target), [(strategy, 3), (strategy, 4)]);
        let called = found.iter().flatten().filter(|ratio| ratio.is_distinguishable()).count();
        println!("{name}: {called} of {}", found.len());
        assert!(called <= found.len() / 20, "{name}, {strategy:?}: {called} of {} are called different", found.len());
    }
}

#[test]
fn numbers_and_sentences_by_hand() {
    // Means of 1 in both, variances that alternate: sums 30 and 10 over 8 pixels in a row.
    let mean = [1.0; 8];
    let (a, b) = ([3.0, 4.5, 3.0, 4.5, 3.0, 4.5, 3.0, 4.5], [1.0, 1.5, 1.0, 1.5, 1.0, 1.5, 1.0, 1.5]);
    let noise = |variance, cost| Noise { mean: &mean, variance, cost };
    let of = |a: Noise<'_>, b: Noise<'_>| Ratio::of(&Pixels::noise(&a, &b, 8), &Region::All);
    let ratio = of(noise(&a, 1.0), noise(&b, 2.0)).expect("both have noise");
    assert!((ratio.value() - 1.5).abs() < 1e-12, "30 over 20");
    let same = ratio.interval(0.95);
    assert_eq!(same, [0.0, f64::INFINITY], "without any chance there is nothing to judge by");
    assert!(of(noise(&a, 1.0), noise(&[0.0; 8], 1.0)).is_none(), "no noise is no ratio");
    assert!(of(noise(&[f32::NAN; 8], 1.0), noise(&b, 1.0)).is_none(), "one sample has no variance");
}

#[test]
fn sentences_say_who_and_how_much() {
    let (scene, target) = place("plate2 at light 4");
    let [ratio] = ratios(&keyhole(&scene, EYE, target), [(Strategy::Light, 7), (Strategy::MisAll, 8)])[..1] else {
        panic!("there are many");
    };
    let ratio = ratio.expect("both have noise");
    let sentence = ratio.sentence();
    assert_eq!(sentence, "not distinguishable yet: a few bright samples decide", "its tails are too heavy");
    let (scene, target) = place("plate2 at light 3");
    let [ratio] = ratios(&keyhole(&scene, EYE, target), [(Strategy::Bsdf, 7), (Strategy::Mis, 8)])[..1] else {
        panic!("there are many");
    };
    let sentence = ratio.expect("both have noise").sentence();
    assert!(sentence.starts_with("A is 6.") && sentence.contains(" \u{d7} less noisy here ("), "{sentence}");
    let [null] = ratios(&keyhole(&scene, EYE, target), [(Strategy::Bsdf, 3), (Strategy::Bsdf, 4)])[..1] else {
        panic!("there are many");
    };
    let sentence = null.expect("both have noise").sentence();
    assert!(sentence.starts_with("not distinguishable yet (A over B: "), "{sentence}");
}
