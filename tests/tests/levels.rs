//! The same picture on every vector level that this machine has, and on one lane.

use std::num::NonZeroU32;
use std::sync::Arc;
use std::time::SystemTime;

use mislab_kernel::lanes::Lanewise;
use mislab_renderer::snapshot::{Contents, SaveOptions};
use mislab_renderer::{
    Channel, Estimator, Frame, ImageSettings, Renderer, Request, SamplerKind, SamplerSettings, Sampling, Settings,
    State, Strategy, engine,
};
use mislab_tests::experiment::{render_on, veach};

fn cases() -> Vec<Request> {
    let scenes = [Arc::new(veach()), Arc::new(mislab_renderer::pbrt::embedded_plastic_scene().scene)];
    let mut cases = Vec::new();
    for (i, strategy) in Strategy::ALL.into_iter().enumerate() {
        for (j, kind) in SamplerKind::ALL.into_iter().enumerate() {
            let base = Settings::default();
            let sampler = SamplerSettings { kind, ..base.sampling.sampler };
            let settings = Settings {
                estimator: Estimator { strategy, ..base.estimator },
                sampling: Sampling { sampler, spp: NonZeroU32::new(16), ..base.sampling },
                image: ImageSettings { resolution: [109, 75], ..base.image },
            };
            cases.push(Request { scene: scenes[(i + j) % 2].clone(), settings });
        }
    }
    cases
}

fn render(request: &Request, how: Lanewise) -> Arc<Frame> {
    engine::render_with(request, 0, how, &mut |_| true).expect("the request can be rendered")
}

fn green(frame: &Frame) -> Vec<f64> {
    frame.channel(Channel::G).into_iter().map(f64::from).collect()
}

#[test]
fn every_level_agrees() {
    let ways = Lanewise::all();
    println!("levels: {}", ways.iter().map(|way| way.name()).collect::<Vec<_>>().join(", "));
    assert!(ways.len() >= 2, "a vector level and one lane");
    // Fused operations round differently, and now and then a ray at an edge goes the other way: all
    // but a few pixels agree closely, and those few do not move the mean.
    for &way in &ways[1..] {
        let (mut off, mut pixels, mut same) = (0, 0, 0);
        let (mut sum, mut difference) = (0.0, 0.0);
        for request in cases() {
            let (best, other) = (green(&render(&request, ways[0])), green(&render(&request, way)));
            for (a, b) in best.iter().zip(&other) {
                pixels += 1;
                same += usize::from(a == b);
                off += usize::from((a - b).abs() > 1e-3 * a.max(*b));
            }
            let (a, b) = (best.iter().sum::<f64>(), other.iter().sum::<f64>());
            sum += a;
            difference += b - a;
            assert!((a - b).abs() < 1e-3 * a, "{}, {:?}: {a} and {b}", way.name(), request.settings);
        }
        let mean = difference / sum;
        println!("{}: {same} of {pixels} pixels the same, {off} off by 0.1 %, mean {mean:+.1e}", way.name());
        assert!(off * 200 < pixels, "{}: {off} of {pixels} pixels differ by more than 0.1 %", way.name());
        assert!(mean.abs() < 2e-5, "{}: the mean differs by {mean:e}", way.name());
    }
}

#[test]
fn levels_that_fuse_alike_give_the_same_bits() {
    let fused: Vec<_> = Lanewise::all().into_iter().filter(|way| way.name() != "SSE4.2").collect();
    if fused.len() < 2 {
        println!("this machine has no vector level that fuses: nothing to compare");
        return;
    }
    for request in cases() {
        let first = render(&request, fused[0]);
        for &way in &fused[1..] {
            let other = render(&request, way);
            for &channel in &Channel::ALL {
                for (i, (a, b)) in first.channel(channel).into_iter().zip(other.channel(channel)).enumerate() {
                    let name = request.settings.estimator.strategy.name();
                    let what = format!("{}, {name}, {}, pixel {i}", way.name(), channel.exr_name());
                    assert_eq!(a.to_bits(), b.to_bits(), "{what}: {a} and {b}");
                }
            }
        }
    }
}

/// The file of a frame, as if it had taken no time: how long a picture took is the only thing that may
/// differ from run to run.
fn file(frame: &Frame) -> Vec<u8> {
    let mut contents = Contents::from_frame(frame);
    contents.stats.render_seconds = 0.0;
    contents.stats.cpu_seconds = 0.0;
    contents.stats.threads = 1;
    let options = SaveOptions { date: Some(SystemTime::UNIX_EPOCH), ..SaveOptions::default() };
    contents.encode(&options).expect("the frame can be saved").0
}

#[test]
fn files_are_the_same_bytes_in_a_window_and_without_at_any_number_of_threads() {
    for request in cases().into_iter().step_by(2) {
        let expected = file(&render_on(1, &request.scene, &request.settings));
        for threads in [2, 3, 7, 16] {
            let headless = file(&render_on(threads, &request.scene, &request.settings));
            assert!(headless == expected, "{:?} on {threads} threads", request.settings);
            // As the window does it, four pictures at once, of which one is looked at.
            let renderer = Renderer::new(threads, || {});
            let pictures: Vec<_> = (0..4).map(|_| renderer.add_picture()).collect();
            for (i, picture) in pictures.iter().enumerate() {
                let settings = Settings {
                    sampling: Sampling { seed: request.settings.sampling.seed + i as u32, ..request.settings.sampling },
                    ..request.settings.clone()
                };
                picture.submit(Request { settings, ..request.clone() });
            }
            while pictures[0].status().state != State::Finished {
                assert!(pictures[0].status().error.is_none(), "{:?}", pictures[0].status());
                std::thread::sleep(std::time::Duration::from_millis(1));
            }
            let frame = pictures[0].latest().expect("a finished picture has a frame");
            assert!(file(&frame) == expected, "{:?} in a window with {threads} threads", request.settings);
        }
    }
}
