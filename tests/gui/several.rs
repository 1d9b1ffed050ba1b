//! Several pictures side by side.

use eframe::egui::{self, Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use mislab::picture::live::LivePicture;
use mislab::picture::pane::Pane;
use mislab::state::arrangement::Arrangement;
use mislab::state::command::Command;
use mislab::state::edit::{Edit, SppTarget};
use mislab::state::placement::Placement;
use mislab_renderer::State;
use mislab_renderer::{Heuristic, Layer, SamplerKind, Strategy};

use crate::lab::{Lab, small_scene};

#[test]
fn four_pictures_are_the_four_strategies_and_escape_leaves_the_active_one() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::Num4);
    lab.slide("c", 0.25);
    lab.key(Modifiers::NONE, Key::Q);
    assert_eq!(lab.strategies(), Strategy::ALL);
    assert_eq!(lab.document().active_index(), 3, "the picture that was there stays the active one");
    assert!(lab.document().slots().iter().all(|slot| slot.estimator.light_prob == 0.25), "only the idea changes");
    lab.settle_all();
    assert_eq!(lab.picture_rects().len(), 4);
    for (index, name) in ["Light", "BSDF", "MIS, both", "MIS, one"].into_iter().enumerate() {
        assert!(lab.has(&format!("Picture {}: {name}", index + 1)), "{name} has its caption");
    }
    lab.key(Modifiers::NONE, Key::Escape);
    assert_eq!((lab.strategies(), lab.app().pictures().len()), (vec![Strategy::Mis], 1), "hidden pictures are gone");
    assert_eq!(lab.picture_rects().len(), 1);
    lab.key(Modifiers::COMMAND, Key::Z);
    assert_eq!((lab.strategies(), lab.document().active_index()), (Strategy::ALL.to_vec(), 3), "undo brings them back");
}

#[test]
fn controls_are_about_the_active_picture() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::Q);
    lab.settle_all();
    // By the mouse, by the caption, by the key.
    let second = lab.picture_rects()[1].center();
    lab.click_at(second);
    assert_eq!(lab.document().active_index(), 1);
    let before: Vec<u64> = lab.app().pictures().iter().map(LivePicture::generation).collect();
    lab.apply(Edit::SetStrategy(Strategy::MisAll));
    lab.click("Heuristic: Power");
    lab.click("Sampler: Sobol");
    lab.apply(Edit::SetLayer(Layer::Variance));
    let slots = lab.document().slots().to_vec();
    assert_eq!(slots[1].estimator.heuristic, Heuristic::Power);
    assert_eq!(slots[1].sampler.kind, SamplerKind::Sobol);
    assert_eq!(slots[1].layer, Layer::Variance);
    for other in [0, 2, 3] {
        assert_eq!(slots[other].estimator.heuristic, Heuristic::Balance);
        assert_eq!(slots[other].sampler.kind, SamplerKind::Stratified);
        assert_eq!(slots[other].layer, Layer::Picture);
        assert_eq!(lab.app().pictures()[other].generation(), before[other], "it is not rendered again");
    }
    lab.harness.get_by_label_contains("Picture 3: MIS, both").click_accesskit();
    lab.harness.step();
    lab.harness.step();
    assert_eq!(lab.document().active_index(), 2);
    lab.key(Modifiers::NONE, Key::X);
    assert_eq!(lab.document().active_index(), 3);
    lab.key(Modifiers::NONE, Key::X);
    assert_eq!(lab.document().active_index(), 0, "the first comes after the last");
    // What is shared is everybody's.
    lab.type_number("Seed", 9.0);
    assert!(lab.document().slots().iter().all(|slot| lab.document().settings(slot).sampling.seed == 9));
    lab.settle_all();
    lab.key(Modifiers::NONE, Key::L);
    assert!(lab.document().slots().iter().all(|slot| slot.layer == Layer::Picture));
}

#[test]
fn a_pixel_read_in_one_picture_is_read_in_all_and_zoom_is_shared() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::Q);
    lab.settle_all();
    let rects = lab.picture_rects();
    let at = rects[0].min + 0.4 * rects[0].size();
    lab.harness.hover_at(at);
    lab.harness.run_steps(4);
    let pixels: Vec<_> = lab.app().panes().iter().map(Pane::pixel).collect();
    assert!(pixels[0].is_some() && pixels.iter().all(|pixel| *pixel == pixels[0]), "{pixels:?}");
    assert_eq!(lab.harness.query_all_by_label_contains("Pixel: x ").count(), 4);
    lab.harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        delta: egui::vec2(0.0, 120.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    });
    lab.harness.run_steps(30);
    let scales: Vec<_> = lab.app().panes().iter().filter_map(|pane| Some(pane.geometry()?.scale)).collect();
    assert!(matches!(lab.document().view.placement, Placement::Free { .. }), "the wheel zooms");
    assert!(scales.len() == 4 && scales.iter().all(|scale| *scale == scales[0]), "{scales:?}");
    lab.harness.remove_cursor();
    lab.harness.run_steps(4);
    assert!(lab.app().panes().iter().all(|pane| pane.pixel().is_none()), "no mouse, no cursor");
}

#[test]
fn several_pictures_have_equal_rays_unless_told_otherwise() {
    let mut lab = Lab::new();
    lab.apply(Edit::SetSpp(SppTarget::passes(16)));
    lab.key(Modifiers::NONE, Key::Q);
    lab.settle_all();
    let spp = |lab: &Lab| -> Vec<u32> {
        lab.app().pictures().iter().map(|live| live.current_frame().map_or(0, |frame| frame.spp())).collect()
    };
    assert_eq!(spp(&lab), [16, 16, 8, 16], "two rays a sample, half the samples");
    assert!(lab.has("Picture 3: MIS, both, 8 spp, 16 rays"));
    assert_eq!(
        lab.document().settings(&lab.document().slots()[2]).sampling.sampler.strata,
        [2, 4],
        "all strata are used"
    );
    lab.click("Equal: samples");
    lab.settle_all();
    assert_eq!(spp(&lab), [16, 16, 16, 16]);
    assert!(lab.has("Picture 3: MIS, both, 16 spp, 32 rays"));
    lab.click("Equal: seconds");
    lab.apply(Command::Restart);
    // The first that is finished ends it for all.
    lab.until("pictures of equal seconds", |lab| {
        let hold = |live: &LivePicture| {
            live.status().is_some_and(|status| matches!(status.state, State::Finished | State::Paused))
        };
        lab.app().pictures().iter().all(hold)
    });
    let seconds: Vec<f64> =
        lab.app().pictures().iter().filter_map(|live| Some(live.current_frame()?.stats().cpu_seconds)).collect();
    let most = seconds.iter().copied().fold(0.0, f64::max);
    assert!(seconds.len() == 4 && seconds.iter().all(|s| *s > 0.4 * most), "{seconds:?}");
    lab.key(Modifiers::NONE, Key::A);
    lab.settle();
    assert_eq!(lab.app().live().current_frame().map(|frame| frame.spp()), Some(16), "alone it has all its samples");
}

#[test]
fn two_pictures_lie_side_by_side_on_both_sides_of_a_divider_or_under_each_other() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::Num3);
    lab.key(Modifiers::NONE, Key::B);
    assert_eq!(lab.strategies(), [Strategy::MisAll, Strategy::Mis], "what one asks about first");
    lab.settle_all();
    let rects = lab.picture_rects();
    assert!(rects[0].right() <= rects[1].left() && rects[0].width() == rects[1].width());

    lab.key(Modifiers::NONE, Key::W);
    lab.settle_all();
    let divider = lab.rect("Divider between the pictures").center();
    for (index, aside) in [(1, 60.0), (0, -60.0)] {
        lab.click_at(divider + egui::vec2(aside, 0.0));
        assert_eq!(lab.document().active_index(), index, "each picture is on its side");
    }
    let to = divider + egui::vec2(100.0, 0.0);
    let modifiers = Modifiers::NONE;
    let press =
        |pos, pressed| egui::Event::PointerButton { pos, button: egui::PointerButton::Primary, pressed, modifiers };
    for event in
        [egui::Event::PointerMoved(divider), press(divider, true), egui::Event::PointerMoved(to), press(to, false)]
    {
        lab.harness.event(event);
        lab.harness.step();
    }
    lab.harness.step();
    assert!((lab.rect("Divider between the pictures").center().x - to.x).abs() < 2.0, "it follows the mouse");
    assert_eq!(lab.document().view.placement, Placement::Fit, "the picture does not");
    let places: Vec<_> = lab.app().panes().iter().filter_map(|pane| Some(pane.geometry()?.picture_rect())).collect();
    assert_eq!(places[0], places[1], "both pictures lie in the same place");

    lab.key(Modifiers::NONE, Key::H);
    lab.settle_all();
    let shown = |lab: &Lab| lab.app().panes().iter().position(|pane| pane.geometry().is_some());
    assert_eq!((lab.picture_rects().len(), shown(&lab)), (1, Some(0)));
    lab.harness.event(egui::Event::ModifiersChanged(Modifiers::SHIFT));
    lab.harness.step();
    assert_eq!((lab.picture_rects().len(), shown(&lab)), (1, Some(1)), "Shift shows the other one");
    lab.harness.event(egui::Event::ModifiersChanged(Modifiers::NONE));
    lab.harness.step();
    assert_eq!(shown(&lab), Some(0));
    assert_eq!(lab.document().active_index(), 0, "looking changes nothing");
}

#[test]
fn pictures_come_back_as_they_were_left() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::Q);
    lab.apply(Command::Activate(3));
    lab.slide("c", 0.1);
    lab.apply(Command::Activate(1));
    let left = lab.document().slots().to_vec();
    lab.settle_all();
    let generation = lab.app().live().generation();
    lab.key(Modifiers::NONE, Key::A);
    assert_eq!(lab.app().live().generation(), generation, "the picture that stays is not rendered again");
    lab.key(Modifiers::NONE, Key::Q);
    assert_eq!((lab.document().slots(), lab.document().active_index()), (left.as_slice(), 1));
    // What was set meanwhile is kept.
    lab.key(Modifiers::NONE, Key::A);
    lab.key(Modifiers::NONE, Key::Num4);
    lab.slide("c", 0.7);
    lab.key(Modifiers::NONE, Key::Q);
    assert_eq!(lab.strategies(), Strategy::ALL);
    assert_eq!((lab.document().active_index(), lab.document().active().estimator.light_prob), (3, 0.7));
}

#[test]
fn a_picture_kept_stays_as_it_is_beside_the_live_one() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::Num4);
    lab.settle();
    let kept = lab.app().live().current_frame().expect("a frame");
    lab.key(Modifiers::NONE, Key::K);
    lab.settle_all();
    assert_eq!(
        (lab.strategies(), lab.document().active_index()),
        (vec![Strategy::Mis; 2], 0),
        "the live one is active"
    );
    // Whatever becomes of the live one.
    lab.slide("c", 0.1);
    lab.type_number("Seed", 5.0);
    lab.settle_all();
    let shown = lab.app().pictures()[1].current_frame().expect("the kept frame");
    assert!(std::sync::Arc::ptr_eq(&shown, &kept));
    assert!(lab.has("Picture 2: MIS, one, 4 spp, 4 rays, balance, c 0.50, kept"), "its caption is of it");
    // It comes to life where a control changes it.
    lab.key(Modifiers::NONE, Key::X);
    lab.key(Modifiers::NONE, Key::Num1);
    lab.settle_all();
    let seed = lab.app().live().current_frame().map(|frame| frame.request().settings.sampling.seed);
    assert_eq!((lab.strategies(), seed), (vec![Strategy::Mis, Strategy::Light], Some(5)));
    lab.key(Modifiers::COMMAND, Key::Z);
    let shown = lab.app().pictures()[1].current_frame().expect("the kept frame");
    assert!(std::sync::Arc::ptr_eq(&shown, &kept), "undo brings it back");
}

#[test]
fn a_scene_that_is_read_again_keeps_the_layout() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::Q);
    lab.apply(Command::Activate(0));
    lab.settle_all();
    // The file's strategy goes to the picture that has it.
    let text = small_scene().replace("[\"mis_all\"]", "[\"mis\"]").replace("[60]", "[40]");
    std::fs::write(lab.file("small.pbrt"), text).expect("write");
    lab.until("the new file", |lab| lab.document().image.resolution == [40, 40]);
    assert_eq!((lab.strategies(), lab.document().active_index()), (Strategy::ALL.to_vec(), 3));
    lab.settle_all();
    assert_eq!(lab.picture_rects().len(), 4);
}

#[test]
fn the_layout_menu_offers_what_the_keys_do() {
    let mut lab = Lab::new();
    for arrangement in Arrangement::ALL.into_iter().rev() {
        lab.click("Layout");
        lab.click(&format!("Layout: {}", arrangement.name()));
        assert_eq!(lab.document().arrangement(), arrangement);
        assert_eq!(lab.document().slots().len(), arrangement.count());
    }
}

#[test]
fn the_projector_view_has_every_layout() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.key(Modifiers::COMMAND, Key::B);
    for (key, pictures) in [(Key::Q, 4), (Key::B, 2), (Key::W, 2), (Key::H, 1), (Key::A, 1)] {
        lab.key(Modifiers::NONE, key);
        lab.settle_all();
        let rects = lab.picture_rects();
        assert_eq!(rects.len(), pictures, "{key:?}");
        let window = egui::Rect::from_min_size(egui::Pos2::ZERO, lab.harness.ctx.content_rect().size());
        assert!(rects.iter().all(|rect| window.contains_rect(*rect) && rect.height() > 250.0), "{key:?}: {rects:?}");
    }
}
