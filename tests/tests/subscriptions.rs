//! Which frames a picture makes: those that somebody wants, each once, and no other but the first and the last.

use std::num::NonZeroU32;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use mislab_renderer::{
    Channel, Frame, Frames, ImageSettings, Marks, Picture, Renderer, Request, Sampling, Settings, State, Subscription,
    pbrt, render,
};
use mislab_tests::experiment::wait;

fn request(spp: u32) -> Request {
    let file = pbrt::embedded_scene();
    let settings = Settings {
        sampling: Sampling { spp: NonZeroU32::new(spp), seed: 7, ..file.settings.sampling },
        image: ImageSettings { resolution: [40, 40], ..file.settings.image },
        ..file.settings
    };
    Request { scene: Arc::new(file.scene), settings }
}

/// Waits for the spp target.
fn finish(picture: &Picture, spp: u32) {
    wait(&format!("{spp} spp"), || picture.status().state == State::Finished && picture.status().spp == spp);
}

fn bits(frame: &Frame) -> Vec<u32> {
    Channel::ALL.into_iter().flat_map(|c| frame.channel(c)).map(f32::to_bits).collect()
}

fn every_pass() -> Subscription {
    Subscription { max_hz: Some(f32::INFINITY), ..Subscription::default() }
}

fn all(frames: &Frames) -> Vec<Arc<Frame>> {
    std::iter::from_fn(|| frames.take()).collect()
}

fn spp(frames: &[Arc<Frame>]) -> Vec<u32> {
    frames.iter().map(|frame| frame.spp()).collect()
}

/// Renders to a target with one worker, which calls `look` after every frame and does nothing else meanwhile.
fn watch(target: u32, wanted: Option<Subscription>, look: impl Fn(&Picture, Option<&Frames>) + Send + Sync + 'static) {
    let watched = Arc::new(OnceLock::<(Picture, Option<Frames>)>::new());
    let there = watched.clone();
    let renderer = Renderer::new(1, move || {
        if let Some((picture, frames)) = there.get() {
            look(picture, frames.as_ref());
        }
    });
    let picture = renderer.add_picture();
    let frames = wanted.map(|wanted| picture.subscribe(wanted));
    assert!(watched.set((picture, frames)).is_ok(), "set once");
    let (picture, _) = watched.get().expect("set before");
    picture.submit(request(target));
    finish(picture, target);
    // Joins the worker: it may still be looking.
    drop(renderer);
}

#[test]
fn marks_are_met_exactly_once_each_and_the_frames_are_those_of_a_render_of_that_spp() {
    let renderer = Renderer::new(3, || {});
    let picture = renderer.add_picture();
    let chosen = picture.subscribe(Subscription::at(Marks::At(vec![10, 3, 1, 7, 10, 40, 41])));
    let powers = picture.subscribe(Subscription::at(Marks::PowersOfTwo));
    picture.submit(request(40));
    finish(&picture, 40);
    let (chosen_frames, power_frames) = (all(&chosen), all(&powers));
    assert_eq!(spp(&chosen_frames), [1, 3, 7, 10, 40]);
    assert_eq!(spp(&power_frames), [1, 2, 4, 8, 16, 32]);
    for frame in chosen_frames.iter().chain(&power_frames) {
        let alone = render(&request(frame.spp()), 1, &mut |_| true).expect("renders");
        assert!(bits(frame) == bits(&alone), "{} spp on the way differ from the same alone", frame.spp());
    }

    // More of the same samples: the marks that are left.
    picture.submit(request(70));
    finish(&picture, 70);
    assert_eq!((spp(&all(&chosen)), spp(&all(&powers))), (vec![41], vec![64]));

    // A new generation has all its marks; those of the one before that nobody took are gone.
    picture.restart();
    finish(&picture, 70);
    let generation = picture.restart();
    finish(&picture, 70);
    let frames = all(&powers);
    assert_eq!(spp(&frames), [1, 2, 4, 8, 16, 32, 64]);
    assert!(frames.iter().all(|frame| frame.generation() == generation));
}

#[test]
fn frames_in_hand_delay_no_other() {
    for wanted in [every_pass(), Subscription { one_at_a_time: true, ..every_pass() }] {
        let held = Arc::new(Mutex::new(Vec::new()));
        let hand = held.clone();
        watch(24, Some(wanted.clone()), move |_, frames| {
            let frames = frames.expect("subscribed");
            hand.lock().unwrap_or_else(PoisonError::into_inner).extend(frames.take());
            frames.release();
        });
        let held = held.lock().unwrap_or_else(PoisonError::into_inner);
        assert_eq!(spp(&held), (1..=24).collect::<Vec<_>>(), "{wanted:?}: every pass is a frame, all of them kept");
        for frame in held.iter() {
            // Two techniques of nine floats and the square; where a light is seen, its emission.
            assert!((80 * 1600..=104 * 1600).contains(&frame.bytes()), "{} bytes", frame.bytes());
        }
        let alone = render(&request(12), 1, &mut |_| true).expect("renders");
        assert!(bits(&held[11]) == bits(&alone), "a frame in hand has changed");
    }
}

/// The frames that `latest` shows on the way to 400 spp, looked at all the time.
fn shown(wanted: Option<Subscription>) -> Vec<u32> {
    let seen = Arc::new(Mutex::new(Vec::new()));
    let list = seen.clone();
    watch(400, wanted, move |picture, _| {
        list.lock().unwrap_or_else(PoisonError::into_inner).extend(picture.latest().map(|frame| frame.spp()));
    });
    let mut seen = seen.lock().unwrap_or_else(PoisonError::into_inner).clone();
    seen.dedup();
    seen
}

#[test]
fn without_a_subscription_there_are_the_first_frame_and_the_last() {
    assert_eq!(shown(None), [1, 400], "looking at the latest frame asks for none");
    assert_eq!(shown(Some(Subscription::default())), [1, 400], "nothing wanted");
    let idle = Subscription { one_at_a_time: true, ..every_pass() };
    assert_eq!(shown(Some(idle)), [1, 400], "a subscriber who does not come for the first");
    assert_eq!(shown(Some(Subscription::at(Marks::At(vec![5, 100])))), [1, 5, 100, 400]);
}

#[test]
fn a_dropped_subscription_wants_nothing() {
    let seen = Arc::new(Mutex::new(Vec::new()));
    let (list, frames) = (seen.clone(), Arc::new(Mutex::new(None::<Frames>)));
    let dropped = frames.clone();
    let watched = Arc::new(OnceLock::<Picture>::new());
    let there = watched.clone();
    let renderer = Renderer::new(1, move || {
        let Some(frame) = there.get().and_then(Picture::latest) else { return };
        list.lock().unwrap_or_else(PoisonError::into_inner).push(frame.spp());
        if frame.spp() == 6 {
            dropped.lock().unwrap_or_else(PoisonError::into_inner).take();
        }
    });
    let picture = watched.get_or_init(|| renderer.add_picture());
    *frames.lock().unwrap_or_else(PoisonError::into_inner) = Some(picture.subscribe(every_pass()));
    picture.submit(request(400));
    finish(picture, 400);
    drop(renderer);
    let mut seen = seen.lock().unwrap_or_else(PoisonError::into_inner).clone();
    seen.dedup();
    assert_eq!(seen, [1, 2, 3, 4, 5, 6, 400]);
}

#[test]
fn frames_of_one_generation_share_their_built_scene() {
    let renderer = Renderer::new(2, || {});
    let picture = renderer.add_picture();
    let frames = picture.subscribe(Subscription::at(Marks::PowersOfTwo));
    picture.submit(request(4));
    finish(&picture, 4);
    let first = all(&frames);
    assert!(Arc::ptr_eq(first[0].scene(), first[2].scene()));
    let base = request(2).settings;
    picture.submit(Request {
        settings: Settings { image: ImageSettings { resolution: [48, 40], ..base.image }, ..base },
        ..request(2)
    });
    finish(&picture, 2);
    assert!(!Arc::ptr_eq(first[0].scene(), all(&frames)[0].scene()), "another view is built anew");
}
