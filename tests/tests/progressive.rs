//! The background renderer as a window uses it: latest wins, nothing stale, nothing lost.

use std::num::NonZeroU32;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use glam::Vec3;
use mislab_renderer::{
    Channel, Frame, Geometry, ImageSettings, Pace, Picture, Renderer, Request, Sampling, Settings, State, Strategy,
    Subscription, pbrt, render,
};
use mislab_tests::experiment::wait;

fn request(size: u32, spp: Option<u32>) -> Request {
    let file = pbrt::embedded_scene();
    let settings = Settings {
        sampling: Sampling { spp: spp.and_then(NonZeroU32::new), ..file.settings.sampling },
        image: ImageSettings { resolution: [size, size], ..file.settings.image },
        ..file.settings
    };
    Request { scene: Arc::new(file.scene), settings }
}

fn finished(picture: &Picture) -> Arc<Frame> {
    wait("the target", || picture.status().state == State::Finished);
    picture.latest().expect("a finished picture has a frame")
}

fn bits(frame: &Frame) -> Vec<u32> {
    Channel::ALL.into_iter().flat_map(|c| frame.channel(c)).map(f32::to_bits).collect()
}

#[test]
fn the_latest_request_wins_and_old_frames_are_told_by_their_generation() {
    let renderer = Renderer::new(2, || {});
    let picture = renderer.add_picture();
    assert_eq!(picture.status().state, State::Idle);
    let mut last = 0;
    for i in 0..50 {
        let mut r = request(64, Some(4));
        r.settings.sampling.seed = i;
        let generation = picture.submit(r);
        assert!(generation > last, "generations grow");
        last = generation;
    }
    let frame = finished(&picture);
    assert_eq!(frame.generation(), last);
    assert_eq!(frame.request().settings.sampling.seed, 49);
    assert_eq!(frame.spp(), 4);
}

#[test]
fn frames_hold_whole_passes_and_never_change() {
    let renderer = Renderer::new(2, || {});
    let picture = renderer.add_picture();
    let _frames = picture.subscribe(Subscription { max_hz: Some(30.0), ..Subscription::default() });
    picture.submit(request(96, None));
    wait("a first frame", || picture.latest().is_some());
    let early = picture.latest().unwrap();
    let before = bits(&early);
    wait("a later frame", || picture.latest().is_some_and(|f| f.spp() > early.spp() + 20));
    assert_eq!(before, bits(&early), "a frame in hand changed while rendering went on");

    let spp = early.spp();
    let mut again = request(96, Some(spp));
    again.settings.sampling.spp = NonZeroU32::new(spp);
    let alone = render(&again, 1, &mut |_| true).unwrap();
    assert_eq!(before, bits(&alone), "{spp} spp on the way differ from {spp} spp asked for");
}

#[test]
fn pausing_holds_and_steps_are_single_passes() {
    let renderer = Renderer::new(2, || {});
    let picture = renderer.add_picture();
    picture.set_pace(Pace::Paused);
    picture.submit(request(32, Some(8)));
    // A new request is seen even while paused: one pass of it.
    wait("the one pass", || picture.status().state == State::Paused);
    assert_eq!(picture.status().spp, 1);
    for spp in 2..=4 {
        picture.step();
        wait("a step", || picture.status().spp == spp && picture.status().state == State::Paused);
        std::thread::sleep(Duration::from_millis(5));
        assert_eq!(picture.status().spp, spp, "one step is one pass");
    }
    picture.set_pace(Pace::Full);
    let frame = finished(&picture);
    assert_eq!(bits(&frame), bits(&render(&request(32, Some(8)), 1, &mut |_| true).unwrap()));
}

#[test]
fn a_pause_shows_the_last_pass() {
    let renderer = Renderer::new(2, || {});
    let picture = renderer.add_picture();
    let frames = picture.subscribe(Subscription::live());
    picture.submit(request(64, None));
    for _ in 0..30 {
        let before = picture.status().spp;
        picture.set_pace(Pace::Full);
        wait("passes", || picture.latest().is_some() && picture.status().spp > before + 2);
        // Frames wait for the last one to be drawn: somebody has it in hand all the time.
        let drawn = frames.take().or_else(|| picture.latest()).unwrap();
        std::thread::sleep(Duration::from_millis(3));
        picture.set_pace(Pace::Paused);
        wait("the pause", || picture.status().state == State::Paused);
        let spp = picture.status().spp;
        wait("the frame of the last pass", || picture.latest().is_some_and(|frame| frame.spp() == spp));
        assert!(drawn.spp() <= spp);
    }
}

#[test]
fn a_render_that_is_stopped_returns_all_its_passes() {
    let mut told = 0;
    let frame = render(&request(64, Some(1_000_000)), 2, &mut |progress| {
        told = progress.spp;
        assert_eq!(progress.paths, 2 * 64 * 64 * u64::from(progress.spp), "two rays a sample");
        progress.spp < 10
    });
    let frame = frame.expect("passes were complete");
    assert!(told >= 10 && frame.spp() >= told && frame.spp() < 1_000_000, "{told} spp told, {} returned", frame.spp());
    let spp = frame.spp();
    assert_eq!(bits(&frame), bits(&render(&request(64, Some(spp)), 1, &mut |_| true).unwrap()));
}

#[test]
fn a_slow_pace_counts_single_passes() {
    let renderer = Renderer::new(2, || {});
    let picture = renderer.add_picture();
    let frames = picture.subscribe(Subscription { max_hz: Some(f32::INFINITY), ..Subscription::default() });
    picture.set_pace(Pace::PassesPerSecond(200.0));
    picture.submit(request(16, Some(20)));
    let mut seen = Vec::new();
    wait("the target", || {
        seen.extend(frames.take().map(|frame| frame.spp()));
        picture.status().state == State::Finished
    });
    assert!(seen.len() > 1 && seen.windows(2).all(|w| w[0] < w[1]), "{seen:?}");
}

#[test]
fn another_target_goes_on_and_a_lower_one_starts_again() {
    let renderer = Renderer::new(2, || {});
    let picture = renderer.add_picture();
    let first = picture.submit(request(32, Some(4)));
    assert_eq!(finished(&picture).spp(), 4);
    assert_eq!(picture.submit(request(32, Some(9))), first, "same samples, more of them: no restart");
    wait("9 spp", || picture.latest().is_some_and(|f| f.spp() == 9));
    let frame = finished(&picture);
    assert_eq!(frame.request().settings.sampling.spp, NonZeroU32::new(9));
    assert_eq!(bits(&frame), bits(&render(&request(32, Some(9)), 1, &mut |_| true).unwrap()));

    let second = picture.submit(request(32, Some(2)));
    assert!(second > first);
    wait("2 spp", || picture.latest().is_some_and(|f| f.generation() == second && f.spp() == 2));
}

#[test]
fn restarting_gives_the_same_bits() {
    let renderer = Renderer::new(3, || {});
    let picture = renderer.add_picture();
    picture.submit(request(48, Some(6)));
    let once = finished(&picture);
    let generation = picture.restart();
    wait("the restarted frame", || picture.latest().is_some_and(|f| f.generation() == generation && f.spp() == 6));
    assert_eq!(bits(&once), bits(&picture.latest().unwrap()));
}

/// A scene that takes a while to build: a thousand by a hundred steps of a stair.
fn slow_to_build(spp: u32) -> Request {
    const WIDE: u32 = 1000;
    const DEEP: u32 = 100;
    let corner = |i: u32| {
        let (x, z) = (i % (WIDE + 1), i / (WIDE + 1));
        Vec3::new(x as f32, ((x + z) % 3) as f32, z as f32) * 0.01
    };
    let corners = |i: u32| {
        let at = i / WIDE * (WIDE + 1) + i % WIDE;
        [[at, at + 1, at + WIDE + 1], [at + 1, at + WIDE + 2, at + WIDE + 1]]
    };
    let mut r = request(32, Some(spp));
    let mut scene = (*r.scene).clone();
    scene.shapes[0].geometry = Geometry::Mesh {
        positions: Arc::new((0..(WIDE + 1) * (DEEP + 1)).map(corner).collect()),
        triangles: Arc::new((0..WIDE * DEEP).flat_map(corners).collect()),
    };
    r.scene = Arc::new(scene);
    r
}

#[test]
fn restarting_while_a_scene_is_built_restarts_that_scene() {
    let slow = slow_to_build(2);
    let expected = bits(&render(&slow, 1, &mut |_| true).unwrap());
    for (quick, milliseconds) in [(None, 1), (Some(request(32, Some(2))), 1), (None, 15), (Some(request(32, None)), 15)]
    {
        let renderer = Renderer::new(2, || {});
        let picture = renderer.add_picture();
        if let Some(quick) = quick {
            picture.submit(quick);
            wait("a first frame", || picture.latest().is_some());
        }
        picture.submit(slow.clone());
        // Before and after a worker takes it up; on a machine too busy to wake in time, after it is built.
        std::thread::sleep(Duration::from_millis(milliseconds));
        let generation = picture.restart();
        let frame = finished(&picture);
        assert_eq!(frame.generation(), generation);
        assert_eq!(bits(&frame), expected);
    }
}

#[test]
fn pictures_take_turns_and_do_not_mix() {
    let renderer = Renderer::new(2, || {});
    let pictures: Vec<_> = Strategy::ALL
        .into_iter()
        .map(|strategy| {
            let picture = renderer.add_picture();
            let mut r = request(64, Some(16));
            r.settings.estimator.strategy = strategy;
            picture.submit(r.clone());
            (picture, r)
        })
        .collect();
    for (picture, r) in &pictures {
        assert_eq!(bits(&finished(picture)), bits(&render(r, 1, &mut |_| true).unwrap()));
    }
}

#[test]
fn a_scene_that_cannot_be_rendered_says_why_and_the_old_frame_stays() {
    let renderer = Renderer::new(2, || {});
    let picture = renderer.add_picture();
    picture.submit(request(32, Some(2)));
    let good = finished(&picture);

    let mut r = request(32, Some(2));
    let mut scene = (*r.scene).clone();
    for shape in &mut scene.shapes {
        if let Geometry::Sphere { radius, .. } = &mut shape.geometry {
            *radius = f32::NAN;
        }
    }
    r.scene = Arc::new(scene);
    picture.submit(r);
    wait("the failure", || picture.status().state == State::Failed);
    let message = picture.status().error.unwrap();
    assert!(message.contains("radius NaN") && message.contains("expected"), "{message}");
    assert!(Arc::ptr_eq(&good, &picture.latest().unwrap()));

    picture.submit(request(32, Some(3)));
    wait("recovery", || picture.latest().is_some_and(|f| f.spp() == 3));
    assert_eq!(picture.status().error, None);
}

#[test]
fn news_wakes_the_window() {
    let wakes = Arc::new(AtomicU64::new(0));
    let count = wakes.clone();
    let renderer = Renderer::new(1, move || {
        count.fetch_add(1, Ordering::Relaxed);
    });
    let picture = renderer.add_picture();
    picture.submit(request(32, Some(2)));
    finished(&picture);
    wait("a wake-up", || wakes.load(Ordering::Relaxed) > 0);
    let settled = {
        std::thread::sleep(Duration::from_millis(20));
        wakes.load(Ordering::Relaxed)
    };
    std::thread::sleep(Duration::from_millis(50));
    assert_eq!(settled, wakes.load(Ordering::Relaxed), "a finished picture is silent");
}

#[test]
fn handles_may_be_dropped_at_any_moment() {
    for i in 0..20 {
        let renderer = Renderer::new(2, || {});
        let picture = renderer.add_picture();
        picture.submit(request(128, None));
        std::thread::sleep(Duration::from_micros(300 * i));
        if i % 2 == 0 {
            drop(picture);
            drop(renderer);
        } else {
            drop(renderer);
            drop(picture);
        }
    }
}

#[test]
fn a_running_renderer_renders_beside_its_live_pictures() {
    let renderer = Renderer::new(2, || {});
    let live = renderer.add_picture();
    live.submit(request(64, None));
    wait("the live picture", || live.status().spp > 0);
    let before = live.status().spp;
    for strategy in [Strategy::Mis, Strategy::MisAll] {
        let mut wanted = request(48, Some(16));
        wanted.settings.estimator.strategy = strategy;
        let mut told = 0;
        let frame = renderer.render(&wanted, &mut |progress| {
            assert!((told..=16).contains(&progress.spp), "{progress:?} after {told}");
            told = progress.spp;
            true
        });
        let frame = frame.expect("renders");
        assert_eq!((frame.spp(), frame.stats().threads), (16, 2));
        assert!(bits(&frame) == bits(&render(&wanted, 1, &mut |_| true).unwrap()), "{}", strategy.name());
    }
    // Several at a time, from threads of their own.
    std::thread::scope(|scope| {
        let renders = [3, 5].map(|spp| {
            let renderer = &renderer;
            scope.spawn(move || renderer.render(&request(48, Some(spp)), &mut |_| true).expect("renders"))
        });
        for render in renders {
            let frame = render.join().expect("no panic");
            let alone = self::render(frame.request(), 1, &mut |_| true).unwrap();
            assert!(bits(&frame) == bits(&alone), "{} spp", frame.spp());
        }
    });
    let stopped = renderer.render(&request(48, Some(1_000_000)), &mut |progress| progress.spp < 5).expect("passes");
    assert!((5..1_000_000).contains(&stopped.spp()), "{}", stopped.spp());
    let mut broken = request(48, Some(2));
    broken.settings.image.resolution = [0, 5];
    assert!(renderer.render(&broken, &mut |_| true).is_err(), "no pixels");
    wait("more of the live picture", || live.status().spp > before);
    assert_eq!(live.status().state, State::Rendering);
}

#[test]
fn an_endless_render_needs_a_window() {
    let error = render(&request(8, None), 1, &mut |_| true).unwrap_err();
    assert!(error.to_string().contains("expected a number"), "{error}");
}
