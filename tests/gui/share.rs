//! Drawing takes its share of the processor and leaves the rest to the picture.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use eframe::egui::{Context, Event, Modifiers, PointerButton, RawInput, pos2};
use mislab::AppOptions;
use mislab::state::edit::{Edit, SppTarget};
use mislab::state::passes::{self, Meter, Passes, Quiet};
use mislab_renderer::{Frame, Spent};

use crate::lab::Lab;

/// A driver that takes a thousand seconds for each pass.
fn dear() -> Spent {
    static PASSES: AtomicU32 = AtomicU32::new(0);
    let beside_rendering = 1000.0 * f64::from(PASSES.fetch_add(1, Ordering::Relaxed));
    Spent { all: beside_rendering, beside_rendering }
}

/// Samples of the frame on screen, and how long until the next pass for one is due.
fn look(lab: &mut Lab) -> (u32, Duration) {
    lab.harness.step();
    let spp = lab.app().live().current_frame().as_deref().map_or(0, Frame::spp);
    (spp, passes::due(&lab.harness.ctx).saturating_duration_since(Instant::now()))
}

#[test]
fn dear_passes_make_frames_rare_and_input_makes_them_come() {
    let mut lab = Lab::with_options([1280.0, 1000.0], AppOptions { meter: Meter(dear), ..AppOptions::default() });
    lab.apply(Edit::SetSpp(SppTarget::Endless));
    assert!(look(&mut lab).1.is_zero(), "just after a change");
    std::thread::sleep(Duration::from_millis(1100));
    let (_, wait) = look(&mut lab);
    assert!(wait > Duration::from_millis(1500), "{wait:?} until the next pass");
    // What was made before it may still come.
    let (before, _) = look(&mut lab);
    let begun = Instant::now();
    let mut seen = Vec::new();
    while begun.elapsed() < wait / 2 {
        seen.push(look(&mut lab).0);
        std::thread::sleep(Duration::from_millis(20));
    }
    assert!(seen.iter().all(|spp| *spp == before), "{before}, then {seen:?}");

    let at = pos2(300.0, 300.0);
    lab.harness.event(Event::PointerMoved(at));
    assert!(!look(&mut lab).1.is_zero(), "a mouse that is only moved needs no newer picture");
    for pressed in [true, false] {
        let modifiers = Modifiers::default();
        lab.harness.event(Event::PointerButton { pos: at, button: PointerButton::Primary, pressed, modifiers });
    }
    assert!(look(&mut lab).1.is_zero(), "a button was pressed");
    lab.until("a newer frame", |lab| lab.app().live().current_frame().is_some_and(|frame| frame.spp() > before));

    // A change nobody's hand has made, once it is quiet again.
    std::thread::sleep(Duration::from_millis(1100));
    assert!(!look(&mut lab).1.is_zero());
    lab.apply(Edit::SetSeed(77));
    assert!(look(&mut lab).1.is_zero());
}

#[test]
fn news_waits_until_a_pass_is_due_and_while_there_is_to_be_quiet() {
    let ctx = Context::default();
    ctx.add_plugin(Passes::new(Meter(dear)));
    let asked = Arc::new(Mutex::new(Vec::new()));
    let list = asked.clone();
    ctx.set_repaint_observer(move |info| list.lock().expect("not poisoned").push(info.delay));
    let pass = || {
        ctx.run_ui(RawInput::default(), |_| {}).textures_delta.clear();
    };
    let news = || {
        asked.lock().expect("not poisoned").clear();
        passes::for_news(&ctx);
        asked.lock().expect("not poisoned").last().copied()
    };
    pass();
    assert!(news().is_some_and(|wait| wait < Duration::from_millis(10)), "nothing is owed");
    pass();
    pass();
    assert!(news().is_some_and(|wait| wait > Duration::from_secs(1)), "the passes have to be paid for");
    passes::freshen(&ctx);
    pass();
    assert!(news().is_some_and(|wait| wait < Duration::from_millis(10)), "just after a change");
    pass();
    let quiet = Quiet::begin(&ctx);
    assert_eq!(news(), None);
    drop(quiet);
    assert!(news().is_some());
}
