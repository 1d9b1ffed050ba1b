//! Frames that nobody has the time to show are not made, and passes are as long as nobody looks.

use std::sync::Arc;
use std::time::{Duration, Instant};

use mislab_renderer::{ImageSettings, Renderer, Request, Sampling, Settings, Subscription, pbrt};
use mislab_tests::experiment::wait;

fn endless() -> Request {
    let file = pbrt::embedded_scene();
    let settings = Settings {
        sampling: Sampling { spp: None, ..file.settings.sampling },
        image: ImageSettings { resolution: [40, 40], ..file.settings.image },
        ..file.settings
    };
    Request { scene: Arc::new(file.scene), settings }
}

#[test]
fn before_the_moment_asked_for_there_are_the_first_few_frames_alone() {
    let renderer = Renderer::new(1, || {});
    let picture = renderer.add_picture();
    let frames = picture.subscribe(Subscription::live());
    let next = Instant::now() + Duration::from_secs(2);
    frames.not_before(next);
    let generation = picture.submit(endless());
    wait("many samples", || picture.status().spp > 100);
    let (mut early, mut late) = (Vec::new(), None);
    wait("a frame after it", || {
        let taken = frames.take();
        // What comes in this very moment may have been made after it.
        let is_early = Instant::now() < next;
        frames.release();
        match taken {
            Some(frame) if is_early => early.push(frame.spp()),
            Some(frame) => late = Some(frame),
            None => {}
        }
        late.as_ref().is_some_and(|frame| frame.spp() > 4)
    });
    assert!(early.iter().all(|&spp| spp <= 4), "{early:?} in the first two seconds");
    assert!(late.is_some_and(|frame| frame.generation() == generation));

    // Brought forward, it comes at once.
    frames.not_before(Instant::now() + Duration::from_secs(3600));
    while frames.take().is_some() {
        frames.release();
    }
    frames.not_before(Instant::now());
    wait("a frame that was put off", || frames.take().is_some());
}

#[test]
fn the_first_frame_of_a_change_and_the_last_are_never_put_off() {
    let renderer = Renderer::new(1, || {});
    let picture = renderer.add_picture();
    let frames = picture.subscribe(Subscription::live());
    frames.not_before(Instant::now() + Duration::from_secs(3600));
    picture.submit(endless());
    wait("the first frame", || frames.take().is_some());
    frames.release();
    let generation = picture.restart();
    wait("the first frame of the next", || frames.take().is_some_and(|frame| frame.generation() == generation));
    frames.release();
    picture.set_pace(mislab_renderer::Pace::Paused);
    wait("the last before a pause", || frames.take().is_some_and(|frame| frame.spp() == picture.status().spp));
}
