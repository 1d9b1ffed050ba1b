//! Error curves: their points are those of pictures rendered one by one, independent samples have the slope -1 and the level
//! that their variance says, and a biased estimator stops falling.

use std::num::NonZeroU32;
use std::sync::Arc;

use mislab_renderer::convergence::{Convergence, Options, converge};
use mislab_renderer::metrics::{self, Errors, Region};
use mislab_renderer::snapshot::{Image, Window};
use mislab_renderer::table::quality::mean_and_error;
use mislab_renderer::{
    Channel, Estimator, Frame, ImageSettings, OneSampleWeights, Request, SamplerKind, SamplerSettings, Sampling,
    Settings, Strategy, pbrt, render,
};

const SIDE: u32 = 40;

fn request(kind: SamplerKind) -> Request {
    let file = pbrt::embedded_scene();
    let settings = Settings {
        sampling: Sampling {
            sampler: SamplerSettings { kind, ..file.settings.sampling.sampler },
            seed: 11,
            ..file.settings.sampling
        },
        image: ImageSettings { resolution: [SIDE; 2], ..file.settings.image },
        ..file.settings
    };
    Request { scene: Arc::new(file.scene), settings }
}

fn measured(request: &Request, options: &Options) -> Convergence {
    converge(request, options, &mut |_| true).expect("it can be measured").expect("nobody stops it")
}

fn rgb(frame: &Frame) -> [Vec<f32>; 3] {
    [Channel::R, Channel::G, Channel::B].map(|channel| frame.channel(channel))
}

fn image(frame: &Frame) -> Image {
    let window = Window { min: [0; 2], size: [SIDE; 2] };
    let channels = ["B", "G", "R"].into_iter().zip(rgb(frame).into_iter().rev());
    Image {
        window,
        display: window,
        channels: channels.map(|(name, plane)| (name.to_owned(), plane)).collect(),
        attributes: vec![("samplesPerPixel".to_owned(), frame.spp().to_string())],
    }
}

/// A picture of so many samples, with the strata that belong to them.
fn picture(request: &Request, strategy: Strategy, spp: u32, seed: u32) -> Arc<Frame> {
    let mut request = request.clone();
    request.settings.estimator.strategy = strategy;
    let sampling = &mut request.settings.sampling;
    (sampling.seed, sampling.spp, sampling.sampler.strata) =
        (seed, NonZeroU32::new(spp), SamplerSettings::strata_for(spp));
    render(&request, 0, &mut |_| true).expect("the request can be rendered")
}

#[test]
fn points_are_those_of_pictures_rendered_one_by_one() {
    let request = request(SamplerKind::Stratified);
    let reference = picture(&request, Strategy::MisAll, 256, 99);
    let (strategies, at) = (vec![Strategy::Mis, Strategy::MisAll], vec![3, 4, 12]);
    let options = Options {
        strategies: strategies.clone(),
        at: at.clone(),
        replicates: 3,
        reference: Some(image(&reference)),
        ..Options::default()
    };
    let found = measured(&request, &options);
    assert_eq!((found.reference.spp, found.reference.rel_mse), (Some(256), None));
    let exact = rgb(&reference);
    let exact = exact.each_ref().map(Vec::as_slice);
    for (curve, strategy) in found.curves.iter().zip(strategies) {
        assert_eq!(curve.strategy, strategy.name());
        for (i, point) in curve.points.iter().enumerate() {
            let errors = [0, 1, 2].map(|replicate| {
                let planes = rgb(&picture(&request, strategy, at[i], 11 + 3 * i as u32 + replicate));
                let planes = planes.each_ref().map(Vec::as_slice);
                Errors::of(&planes, &metrics::Reference::Exact(&exact), &Region::All).rel_mse().expect("pixels")
            });
            let (mean, error) = mean_and_error(&errors);
            let rays = u64::from(at[i] * strategy.rays_per_sample());
            assert_eq!((point.spp, point.rays), (at[i], rays));
            assert_eq!((point.rel_mse, point.standard_error), (Some(mean), Some(error)), "{strategy:?}, {}", at[i]);
        }
    }
}

/// The error of independent samples is their variance over their number. BSDF sampling is another matter: what makes its
/// error has not been drawn at all where samples are few. 10 intervals of 99.99 %: Student's t with 15 degrees of freedom.
#[test]
fn independent_samples_have_the_slope_minus_one() {
    let options = Options { at: vec![2, 8, 32, 128], replicates: 16, by_square: true, ..Options::default() };
    let found = measured(&request(SamplerKind::Independent), &options);
    let [_, bsdf, both, one] = &found.curves[..] else { panic!("four curves") };
    for curve in [both, one] {
        let squares = curve.squares.as_deref().expect("by square");
        let all = squares.iter().map(|s| (s.slope, s.slope_interval, s.heavy_tailed));
        for (slope, interval, heavy_tailed) in all.chain([(curve.slope, curve.slope_interval, curve.heavy_tailed)]) {
            let (slope, [low, high]) = (slope.expect("a slope"), interval.expect("an interval"));
            // From the 95 % that are stated to 99.99 %.
            let half = (high - low) / 2.0 * (5.24 / 2.131);
            assert!((slope + 1.0).abs() < half, "{}: slope {slope} ({low} to {high})", curve.strategy);
            assert!(!heavy_tailed || curve.strategy == "mis", "one render carries most of the error of one of each");
        }
        let pixels: usize = squares.iter().map(|square| square.pixels).sum();
        assert!(pixels > 100 && pixels < (SIDE * SIDE) as usize, "{pixels} pixels in squares");
    }
    assert!(bsdf.squares.as_deref().is_some_and(|squares| squares.iter().any(|s| s.heavy_tailed)), "{bsdf:?}");
    assert!(both.slope_interval.is_some_and(|[low, high]| high - low < 0.1), "{both:?}");
    assert!(found.reference.rel_mse.is_some_and(|own| own > 0.0 && own < both.points[3].rel_mse.expect("pixels")));
}

/// The tutorial's weights at c = 1 lose what they leave to the BSDF samples: the curve ends on a floor.
#[test]
fn a_biased_estimator_stops_falling() {
    let mut request = request(SamplerKind::Independent);
    request.settings.estimator =
        Estimator { light_prob: 1.0, weights: OneSampleWeights::Tutorial, ..request.settings.estimator };
    let options = Options {
        strategies: vec![Strategy::Mis, Strategy::MisAll],
        at: vec![64, 256, 1024],
        replicates: 4,
        ..Options::default()
    };
    let found = measured(&request, &options);
    let [biased, unbiased] = &found.curves[..] else { panic!("two curves") };
    assert!(biased.bias.is_some_and(|text| text.contains("c = 1")) && unbiased.bias.is_none());
    assert!(biased.slope.is_some_and(|slope| slope > -0.5), "{biased:?}");
    assert!(unbiased.slope.is_some_and(|slope| slope < -0.9), "{unbiased:?}");
}

#[test]
fn a_crop_is_measured_on_its_own_pixels() {
    let mut request = request(SamplerKind::Sobol);
    request.settings.image.crop = [0.25, 0.75, 0.3, 0.9];
    let options = Options { at: vec![1, 4], replicates: 2, by_square: true, ..Options::default() };
    let found = measured(&request, &options);
    let squares = found.curves[0].squares.as_deref().expect("by square");
    let pixels: usize = squares.iter().map(|square| square.pixels).sum();
    assert!(pixels > 50 && pixels <= request.settings.pixel_bounds().area(), "{pixels}");
    assert!(found.curves.iter().all(|curve| curve.points.iter().all(|point| point.rel_mse.is_some())));
}

#[test]
fn what_cannot_be_measured_is_refused_in_words() {
    let request = request(SamplerKind::Sobol);
    let image = image(&picture(&request, Strategy::Mis, 1, 1));
    let mut other = image.clone();
    other.window.min = [1, 0];
    let mut hole = image.clone();
    hole.channels[1].1[5] = f32::NAN;
    let mut colourless = image;
    colourless.channels.truncate(2);
    let base = Options::default();
    for (options, parts) in [
        (Options { at: vec![4, 2], ..base.clone() }, ["[4, 2]", "ascending"]),
        (Options { replicates: 1, ..base.clone() }, ["1 replicates", "2 to 1000"]),
        (Options { strategies: Vec::new(), ..base.clone() }, ["no strategy", "at least one"]),
        (Options { reference: Some(other), ..base.clone() }, ["(1 0)", "expected the same"]),
        (Options { reference: Some(hole), ..base.clone() }, ["channel G is NaN at pixel 5, 0", "expected numbers"]),
        (Options { reference: Some(colourless), ..base }, ["no channel", "R"]),
    ] {
        let error = converge(&request, &options, &mut |_| true).expect_err("it is refused").to_string();
        assert!(parts.iter().all(|part| error.contains(part)), "{error}: expected {parts:?}");
    }
}

#[test]
fn it_stops_when_asked_to() {
    let mut calls = 0;
    let stopped = converge(&request(SamplerKind::Sobol), &Options::default(), &mut |step| {
        calls += 1;
        assert!(step.fraction <= 1.0);
        calls < 3
    });
    assert!(stopped.expect("no error").is_none() && calls == 3);
}
