//! Pictures in lock-step: nobody ahead by more than a pass, nobody waits for one that does not go on.

use std::num::NonZeroU32;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use mislab_renderer::{
    Channel, Estimator, Frame, Frames, Geometry, ImageSettings, Lockstep, Pace, Picture, Renderer, Request, Sampling,
    Settings, State, Strategy, Subscription, pbrt, render,
};
use mislab_tests::experiment::wait;

fn request(size: u32, strategy: Strategy, spp: u32) -> Request {
    let file = pbrt::embedded_scene();
    let settings = Settings {
        estimator: Estimator { strategy, ..file.settings.estimator },
        sampling: Sampling { spp: NonZeroU32::new(spp), seed: 3, ..file.settings.sampling },
        image: ImageSettings { resolution: [size, size], ..file.settings.image },
    };
    Request { scene: Arc::new(file.scene), settings }
}

fn is(picture: &Picture, state: State) -> bool {
    picture.status().state == state
}

fn bits(frame: &Frame) -> Vec<u32> {
    Channel::ALL.into_iter().flat_map(|c| frame.channel(c)).map(f32::to_bits).collect()
}

/// Rendered so far, in the unit of the group.
fn progress(frame: &Frame, by: Lockstep) -> f64 {
    match by {
        Lockstep::Spp => f64::from(frame.spp()),
        Lockstep::Rays => frame.stats().paths as f64 / frame.bounds().area() as f64,
        Lockstep::CpuSeconds => frame.stats().cpu_seconds,
    }
}

/// Renders two pictures with one worker, that makes a frame of every pass and looks at both after each. Returns what both had at
/// each look until one of them was finished and the other free. Without lock-step the smaller, of fewer tiles, would be far ahead.
fn race(by: Lockstep, requests: [Request; 2]) -> Vec<[f64; 2]> {
    let looks = Arc::new(Mutex::new(Vec::new()));
    let pair = Arc::new(OnceLock::<[(Picture, Frames); 2]>::new());
    let (list, there) = (looks.clone(), pair.clone());
    let renderer = Renderer::new(1, move || {
        let Some(pair) = there.get() else { return };
        let frames = pair.each_ref().map(|(picture, _)| picture.latest());
        let target = |frame: &Frame| Some(frame.spp()) == frame.request().settings.sampling.spp.map(NonZeroU32::get);
        if !frames.iter().flatten().any(|frame| target(frame)) {
            let both = frames.map(|frame| frame.map_or(0.0, |frame| progress(&frame, by)));
            list.lock().unwrap_or_else(PoisonError::into_inner).push(both);
        }
    });
    let every_pass = Subscription { max_hz: Some(f32::INFINITY), ..Subscription::default() };
    let pair = pair.get_or_init(|| {
        [0, 1].map(|_| {
            let picture = renderer.add_picture();
            let frames = picture.subscribe(every_pass.clone());
            (picture, frames)
        })
    });
    let pictures = pair.each_ref().map(|(picture, _)| picture);
    // Nobody waits for a picture that has no request yet: both make their first pass before either makes a second one.
    for (picture, request) in pictures.into_iter().zip(requests.clone()) {
        picture.set_pace(Pace::PassesPerSecond(1e-3));
        picture.submit(request);
        wait("the first pass", || picture.status().spp == 1);
    }
    let abreast = renderer.keep_abreast(&pictures, by);
    for picture in pictures {
        picture.set_pace(Pace::Full);
    }
    for (picture, request) in pictures.into_iter().zip(&requests) {
        wait("the target", || is(picture, State::Finished));
        let frame = picture.latest().expect("a finished picture has a frame");
        let alone = render(request, 1, &mut |_| true).expect("renders");
        assert!(bits(&frame) == bits(&alone), "lock-step changes a bit");
    }
    // Joins the worker: it may still be looking.
    drop((abreast, renderer));
    let looks = looks.lock().unwrap_or_else(PoisonError::into_inner);
    looks.clone()
}

/// At every look, whoever is ahead got there by his last pass: it began when he was not.
fn within_one_pass(looks: &[[f64; 2]]) {
    assert!(looks.len() > 20, "{} looks", looks.len());
    let mut before = [0.0; 2];
    let mut last = [0.0; 2];
    for now in looks {
        for i in [0, 1] {
            if now[i] > last[i] {
                before[i] = last[i];
            }
        }
        last = *now;
        for (ahead, behind) in [(0, 1), (1, 0)] {
            let before = before[ahead];
            assert!(before <= now[behind], "{now:?}: picture {ahead} began its pass at {before}");
        }
    }
}

#[test]
fn at_equal_samples() {
    let looks = race(Lockstep::Spp, [16, 64].map(|size| request(size, Strategy::Mis, 40)));
    within_one_pass(&looks);
    assert!(looks.iter().all(|[a, b]| (a - b).abs() <= 1.0), "{looks:?}");
}

#[test]
fn at_equal_rays_mis_all_has_half_the_samples() {
    let looks = race(Lockstep::Rays, [request(24, Strategy::MisAll, 40), request(24, Strategy::Mis, 80)]);
    within_one_pass(&looks);
    assert!(looks.iter().all(|[a, b]| (a - b).abs() <= 2.0), "{looks:?}");
}

#[test]
fn at_equal_seconds_of_processor_time() {
    within_one_pass(&race(Lockstep::CpuSeconds, [request(16, Strategy::Mis, 400), request(64, Strategy::Mis, 60)]));
}

#[test]
fn nobody_waits_for_one_that_is_finished_failed_paused_or_idle() {
    let renderer = Renderer::new(2, || {});
    let [short, failing, paused, idle, long] = [0; 5].map(|_| renderer.add_picture());
    let abreast = renderer.keep_abreast(&[&short, &failing, &paused, &idle, &long], Lockstep::Spp);
    let mut broken = request(32, Strategy::Mis, 50);
    let mut scene = (*broken.scene).clone();
    for shape in &mut scene.shapes {
        if let Geometry::Sphere { radius, .. } = &mut shape.geometry {
            *radius = f32::NAN;
        }
    }
    broken.scene = Arc::new(scene);
    paused.set_pace(Pace::Paused);
    failing.submit(broken);
    paused.submit(request(32, Strategy::Mis, 50));
    short.submit(request(32, Strategy::Mis, 3));
    long.submit(request(32, Strategy::Mis, 50));
    wait("the long one", || is(&long, State::Finished));
    assert!(is(&short, State::Finished) && is(&failing, State::Failed) && is(&idle, State::Idle));
    assert_eq!(paused.status().spp, 1);
    // Steps are the user's, whoever is elsewhere; and on it goes.
    paused.step();
    wait("a step", || paused.status().spp == 2);
    paused.set_pace(Pace::Full);
    wait("the paused one", || is(&paused, State::Finished));
    drop(abreast);
}

/// A picture that never makes a second pass, and one that has to wait for it.
fn stuck(renderer: &Renderer) -> (Picture, Picture) {
    let (slow, fast) = (renderer.add_picture(), renderer.add_picture());
    slow.set_pace(Pace::PassesPerSecond(1e-3));
    slow.submit(request(16, Strategy::Mis, 50));
    wait("the first pass", || slow.status().spp == 1);
    (slow, fast)
}

#[test]
fn the_fast_wait_for_the_slow_until_one_of_them_leaves() {
    for leave in 0..3 {
        let renderer = Renderer::new(2, || {});
        let (slow, fast) = stuck(&renderer);
        let abreast = renderer.keep_abreast(&[&slow, &fast], Lockstep::Spp);
        fast.submit(request(16, Strategy::Mis, 50));
        wait("a pass ahead", || fast.status().spp == 2);
        // The workers look for something to do all the while.
        renderer.render(&request(64, Strategy::Mis, 20), &mut |_| true).expect("renders");
        assert_eq!((slow.status().spp, fast.status().spp), (1, 2), "a pass ahead, and no further");
        let _other = match leave {
            0 => {
                drop(slow);
                None
            }
            1 => {
                drop(abreast);
                None
            }
            // A picture is in one group.
            _ => Some(renderer.keep_abreast(&[&fast], Lockstep::Rays)),
        };
        wait("the target", || is(&fast, State::Finished));
    }
}
