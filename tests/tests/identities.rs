//! What must hold exactly, or between two renderings.

use std::num::NonZeroU32;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::Vec3;
use mislab_kernel::film::Tile;
use mislab_kernel::lanes::Lanewise;
use mislab_kernel::stop::Stop;
use mislab_kernel::tile::render_tile;
use mislab_kernel::world::BuiltScene;
use mislab_renderer::{
    Bsdf, Channel, Estimator, Frame, Heuristic, ImageSettings, Layer, Pace, Picture, Renderer, Request, SamplerKind,
    SamplerSettings, Sampling, Scene, Settings, State, Strategy,
};
use mislab_tests::experiment::{render, render_on, veach};
use mislab_tests::statistics::Family;

/// A picture small enough to be rendered many times, with edges that fill no block or tile.
const SIZE: [u32; 2] = [109, 75];

fn settings(strategy: Strategy) -> Settings {
    Settings {
        estimator: Estimator { strategy, ..Estimator::default() },
        sampling: Sampling { spp: NonZeroU32::new(16), seed: 5, ..Sampling::default() },
        image: ImageSettings { resolution: SIZE, ..ImageSettings::default() },
    }
}

fn plastic() -> Scene {
    mislab_renderer::pbrt::embedded_plastic_scene().scene
}

/// All scenes and strategies that bits are compared over.
fn cases() -> Vec<(Arc<Scene>, Settings)> {
    let (veach, plastic) = (Arc::new(veach()), Arc::new(plastic()));
    let mut cases = Vec::new();
    for strategy in Strategy::ALL {
        for kind in SamplerKind::ALL {
            let base = settings(strategy);
            let sampler = SamplerSettings { kind, ..base.sampling.sampler };
            let two_lobes = matches!(kind, SamplerKind::Sobol | SamplerKind::Stratified);
            let scene = if two_lobes { &plastic } else { &veach };
            cases.push((scene.clone(), Settings { sampling: Sampling { sampler, ..base.sampling }, ..base }));
        }
    }
    cases
}

fn bits(frame: &Frame) -> Vec<u32> {
    Channel::ALL.iter().flat_map(|&channel| frame.channel(channel)).map(f32::to_bits).collect()
}

fn layer_bits(frame: &Frame, layer: Layer) -> Vec<u32> {
    layer.channels().iter().flat_map(|&channel| frame.channel(channel)).map(f32::to_bits).collect()
}

#[test]
fn one_sample_model_is_a_single_technique_at_the_ends_of_c() {
    for scene in [Arc::new(veach()), Arc::new(plastic())] {
        for (light_prob, single) in [(1.0, Strategy::Light), (0.0, Strategy::Bsdf)] {
            for (kind, heuristic) in SamplerKind::ALL.into_iter().flat_map(|kind| Heuristic::ALL.map(|h| (kind, h))) {
                let of = |strategy| {
                    let base = settings(strategy);
                    let sampler = SamplerSettings { kind, ..base.sampling.sampler };
                    Settings { sampling: Sampling { sampler, ..base.sampling }, ..base }
                };
                let expected = render(&scene, &of(single));
                let base = of(Strategy::Mis);
                let mixed = Settings { estimator: Estimator { light_prob, heuristic, ..base.estimator }, ..base };
                let frame = render(&scene, &mixed);
                for layer in Layer::ALL {
                    assert_eq!(
                        layer_bits(&frame, layer),
                        layer_bits(&expected, layer),
                        "{kind:?}, c = {light_prob}, {}: {layer:?} differs from `{}`",
                        heuristic.name(),
                        single.name()
                    );
                }
            }
        }
    }
}

#[test]
fn layers_sum_to_the_picture() {
    for (scene, settings) in cases() {
        let frame = render(&scene, &settings);
        // With black materials only the lights themselves are seen.
        let mut dark = (*scene).clone();
        for material in &mut dark.materials {
            material.bsdf = Bsdf::Matte { kd: Vec3::ZERO };
        }
        let emission = render(&Arc::new(dark), &settings);
        let mut lit = 0;
        for (picture, light, bsdf) in [
            (Channel::R, Channel::LightR, Channel::BsdfR),
            (Channel::G, Channel::LightG, Channel::BsdfG),
            (Channel::B, Channel::LightB, Channel::BsdfB),
        ] {
            let visible = emission.channel(picture);
            let [picture, light, bsdf] = [picture, light, bsdf].map(|c| frame.channel(c));
            for i in 0..picture.len() {
                let sum = f64::from(light[i]) + f64::from(bsdf[i]) + f64::from(visible[i]);
                let difference = (sum - f64::from(picture[i])).abs();
                assert!(
                    difference <= 3e-7 * sum,
                    "{}, pixel {i}: {sum} and {}",
                    settings.estimator.strategy.name(),
                    picture[i]
                );
                lit += usize::from(visible[i] > 0.0);
            }
        }
        assert!(lit > 0, "the lights are in the picture");
    }
}

#[test]
fn doubled_radiance_doubles_the_picture_exactly() {
    for (scene, settings) in cases() {
        let mut bright = (*scene).clone();
        for light in bright.shapes.iter_mut().filter_map(|shape| shape.light.as_mut()) {
            light.radiance *= 2.0;
        }
        let frame = render(&scene, &settings);
        let double = render(&Arc::new(bright), &settings);
        for &channel in &Channel::ALL {
            let factor = match channel {
                Channel::VarianceY => 4.0,
                Channel::WeightLightY | Channel::WeightBsdfY | Channel::ShareLightY => 1.0,
                _ => 2.0,
            };
            for (i, (a, b)) in frame.channel(channel).into_iter().zip(double.channel(channel)).enumerate() {
                let same = (factor * a).to_bits() == b.to_bits() || a.is_nan() && b.is_nan();
                assert!(same, "{}, {}, pixel {i}: {a} and {b}", settings.estimator.strategy.name(), channel.exr_name());
            }
        }
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    for (scene, settings) in cases() {
        let expected = bits(&render_on(1, &scene, &settings));
        for threads in [2, 3, 7, 16] {
            assert_eq!(
                bits(&render_on(threads, &scene, &settings)),
                expected,
                "{} with {} at {threads} threads",
                settings.estimator.strategy.name(),
                settings.sampling.sampler.kind.name()
            );
        }
    }
}

/// Pairs of samples are worked on together where a pass has both.
#[test]
fn cutting_samples_into_passes_does_not_change_a_bit() {
    for (scene, settings) in cases() {
        let built = BuiltScene::new(&scene, &settings).expect("a valid scene");
        let bounds = settings.pixel_bounds();
        for how in Lanewise::all() {
            let render = |passes: &[u32]| {
                let mut tile = Tile::new(bounds, settings.estimator.strategy, None);
                for &count in passes {
                    let invalid = render_tile(how, &built, &settings, &mut tile, count, Stop::NEVER);
                    assert_eq!(invalid, Ok(0), "valid samples");
                }
                tile
            };
            let single = render(&[1; 9]);
            for passes in [[9].as_slice(), &[1, 8], &[2, 2, 5], &[3, 3, 3]] {
                let what = format!("{}, {}", settings.estimator.strategy.name(), settings.sampling.sampler.kind.name());
                assert!(render(passes) == single, "{what}, passes of {passes:?} samples, {}", how.name());
            }
        }
    }
}

/// Waits until the picture is in a state; a hung renderer has to fail, not to hang.
fn wait(picture: &Picture, what: &str, done: impl Fn(&mislab_renderer::Status) -> bool) {
    let start = Instant::now();
    loop {
        let status = picture.status();
        assert!(status.error.is_none(), "{what}: {status:?}");
        if done(&status) {
            return;
        }
        assert!(start.elapsed() < Duration::from_secs(120), "{what} was never reached: {status:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn finished(picture: &Picture) -> Arc<Frame> {
    wait(picture, "the spp target", |status| status.state == State::Finished);
    picture.latest().expect("a finished picture has a frame")
}

#[test]
fn history_does_not_change_a_bit() {
    let scene = Arc::new(veach());
    let request = Request { scene: scene.clone(), settings: settings(Strategy::MisAll) };
    let other = Request { scene: Arc::new(plastic()), settings: settings(Strategy::Mis) };
    let expected = bits(&render_on(1, &scene, &request.settings));
    let renderer = Renderer::new(3, || {});
    let picture = renderer.add_picture();

    picture.submit(request.clone());
    assert_eq!(bits(&finished(&picture)), expected, "in a window");

    picture.restart();
    assert_eq!(bits(&finished(&picture)), expected, "after a restart");

    // Cancelled in all kinds of places, by another scene, another strategy, and by itself.
    for _ in 0..20 {
        picture.submit(other.clone());
        std::thread::yield_now();
        picture.submit(request.clone());
        picture.restart();
    }
    assert_eq!(bits(&finished(&picture)), expected, "after being cancelled");

    picture.set_pace(Pace::Paused);
    picture.restart();
    for pass in 1..=5 {
        wait(&picture, "a pause", |status| status.state == State::Paused && status.spp == pass);
        if pass < 5 {
            picture.step();
        }
    }
    picture.set_pace(Pace::Full);
    assert_eq!(bits(&finished(&picture)), expected, "after pause, steps and going on");

    // A smaller target first, then more of the same.
    let fewer = Settings {
        sampling: Sampling { spp: NonZeroU32::new(3), ..request.settings.sampling },
        ..request.settings.clone()
    };
    picture.submit(Request { settings: fewer.clone(), ..request.clone() });
    assert_eq!(bits(&finished(&picture)), bits(&render_on(1, &scene, &fewer)), "with a smaller target");
    picture.submit(request.clone());
    wait(&picture, "the larger target", |status| status.state == State::Finished && status.spp == 16);
    assert_eq!(bits(&finished(&picture)), expected, "continued from a smaller target");
}

#[test]
fn pictures_side_by_side_do_not_change_a_bit() {
    let cases: Vec<_> = cases().into_iter().step_by(1 + SamplerKind::ALL.len()).collect();
    assert_eq!(cases.len(), 4, "one case of each strategy, with a sampler of its own");
    let renderer = Renderer::new(3, || {});
    let pictures: Vec<_> = cases.iter().map(|_| renderer.add_picture()).collect();
    for (picture, (scene, settings)) in pictures.iter().zip(&cases) {
        picture.submit(Request { scene: scene.clone(), settings: settings.clone() });
    }
    for (picture, (scene, settings)) in pictures.iter().zip(&cases) {
        assert_eq!(
            bits(&finished(picture)),
            bits(&render_on(1, scene, settings)),
            "{}",
            settings.estimator.strategy.name()
        );
    }
}

#[test]
fn crop_window_is_a_part_of_the_full_image() {
    for (scene, settings) in cases() {
        let full = render(&scene, &settings);
        let crop = render(
            &scene,
            &Settings { image: ImageSettings { crop: [0.13, 0.71, 0.27, 0.88], ..settings.image }, ..settings.clone() },
        );
        let bounds = crop.bounds();
        assert!(bounds.area() > 1000 && bounds.area() < full.bounds().area(), "the crop window crops");
        for &channel in &Channel::ALL {
            let part = crop.channel(channel);
            for (i, value) in part.into_iter().enumerate() {
                let (x, y) = (bounds.min[0] + i as u32 % bounds.width(), bounds.min[1] + i as u32 / bounds.width());
                let expected = full.pixel(x, y, channel).expect("the pixel is in the full image");
                assert_eq!(value.to_bits(), expected.to_bits(), "{} at {x}, {y}", channel.exr_name());
            }
        }
    }
}

/// Mean of a picture's green channel over `seeds`, its standard error, and the variance of a pixel
/// over seeds. Pixels and seeds are independent, whatever the sampler does inside a pixel.
fn over_seeds(scene: &Arc<Scene>, settings: &Settings, seeds: u32) -> (f64, f64, f64) {
    let frames: Vec<_> = (0..seeds)
        .map(|s| {
            render(scene, &Settings { sampling: Sampling { seed: 100 + s, ..settings.sampling }, ..settings.clone() })
                .channel(Channel::G)
        })
        .collect();
    let (n, pixels) = (f64::from(seeds), frames[0].len() as f64);
    let (mut total, mut variance) = (0.0, 0.0);
    for i in 0..frames[0].len() {
        let mean = frames.iter().map(|f| f64::from(f[i])).sum::<f64>() / n;
        variance += frames.iter().map(|f| (f64::from(f[i]) - mean).powi(2)).sum::<f64>() / (n - 1.0);
        total += mean;
    }
    let variance = variance / pixels;
    (total / pixels, (variance / (n * pixels)).sqrt(), variance)
}

#[test]
fn samplers_agree_and_stratification_pays() {
    let scene = Arc::new(veach());
    let mut family = Family::new("samplers against each other");
    for strategy in [Strategy::Light, Strategy::MisAll, Strategy::Mis] {
        // Part of the wall: smooth, and every light in sight.
        let base = Settings {
            estimator: Estimator { strategy, ..Estimator::default() },
            image: ImageSettings { crop: [0.45, 0.53, 0.1, 0.18], ..ImageSettings::default() },
            ..Settings::default()
        };
        let by = |kind: SamplerKind, spp: u32| {
            let sampler = SamplerSettings { kind, ..base.sampling.sampler };
            over_seeds(
                &scene,
                &Settings {
                    sampling: Sampling { sampler, spp: NonZeroU32::new(spp), ..base.sampling },
                    ..base.clone()
                },
                24,
            )
        };
        let independent = by(SamplerKind::Independent, 64);
        let stratified = by(SamplerKind::PaddedStratified, 64);
        // Any prefix of the strata too: people stop early.
        for (label, other) in [
            ("padded strata", stratified),
            ("padded strata, 23", by(SamplerKind::PaddedStratified, 23)),
            ("padded strata, 100 of 64", by(SamplerKind::PaddedStratified, 100)),
            ("padded sobol", by(SamplerKind::PaddedSobol, 64)),
            ("sobol", by(SamplerKind::Sobol, 64)),
            ("sobol, 23", by(SamplerKind::Sobol, 23)),
            ("lattice", by(SamplerKind::Lattice, 64)),
            ("lattice, 23", by(SamplerKind::Lattice, 23)),
            ("stratified", by(SamplerKind::Stratified, 64)),
            ("stratified, 23", by(SamplerKind::Stratified, 23)),
            ("stratified, 100 of 64", by(SamplerKind::Stratified, 100)),
        ] {
            let label = format!("{}, {label}", strategy.name());
            family.test(label, other.0, independent.0, independent.1.hypot(other.1));
        }
        // One number for all choices leaves less noise than one for each.
        for nested in [SamplerKind::Lattice, SamplerKind::Stratified, SamplerKind::Sobol] {
            let ratio = by(nested, 64).2 / stratified.2;
            println!("{}: {} / padded variance {ratio:.3}", strategy.name(), nested.name());
            assert!(ratio < 0.8, "{}: {} leaves {ratio:.3} of the variance", strategy.name(), nested.name());
        }
        let ratio = stratified.2 / independent.2;
        println!("{}: padded / independent variance {ratio:.3}", strategy.name());
        assert!(ratio < 0.8, "{}: stratification leaves {ratio:.3} of the variance", strategy.name());
    }
    family.judge(33);
}
