//! Controls: what each sets, and how it is written, dragged and undone.

use eframe::egui::accesskit::Role;
use eframe::egui::{self, Key, Modifiers};
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use mislab::state::command::Command;
use mislab::state::document::Document;
use mislab::state::edit::{Edit, SppTarget};
use mislab::state::view::ToneMap;
use mislab_renderer::State;
use mislab_renderer::{Heuristic, Layer, OneSampleWeights, SamplerKind, Strategy};
use std::collections::HashMap;
use std::time::Duration;

use crate::lab::{Lab, small_scene};

#[test]
fn keys_and_buttons_choose_the_strategy() {
    let mut lab = Lab::new();
    let names = ["Light", "BSDF", "MIS, both", "MIS, one"];
    for (index, strategy) in Strategy::ALL.into_iter().enumerate() {
        lab.key(Modifiers::NONE, [Key::Num1, Key::Num2, Key::Num3, Key::Num4][index]);
        assert_eq!(lab.document().active().estimator.strategy, strategy);
        lab.settle();
        assert!(lab.has(&format!("Caption: {}", names[index])), "the caption names the strategy on screen");
    }
    for (index, strategy) in Strategy::ALL.into_iter().enumerate() {
        lab.click(&format!("{} {}", index + 1, names[index]));
        assert_eq!(lab.document().active().estimator.strategy, strategy);
    }
}

#[test]
fn the_formula_follows_the_settings() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::Num1);
    assert!(lab.has("(f) / (p_L)") && !lab.has("p_B"), "light sampling knows one density");
    lab.key(Modifiers::NONE, Key::Num4);
    lab.slide("c", 0.25);
    assert!(lab.has("0.25 p_L") && lab.has("0.75 p_B"), "the formula has the live c in it");
    lab.apply(Edit::SetWeights(OneSampleWeights::Tutorial));
    assert!(lab.has("w_L  =  (p_L) / (p_L + p_B)"), "the tutorial's weight leaves c out");
}

#[test]
fn c_matters_to_one_strategy_only() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::Num4);
    lab.slide("c", 0.2);
    assert_eq!(lab.document().active().estimator.light_prob, 0.2);
    lab.double_click(Role::Slider, "c");
    assert_eq!(lab.document().active().estimator.light_prob, 0.5, "a double click resets");
    lab.type_number("c value", 0.75);
    assert_eq!(lab.document().active().estimator.light_prob, 0.75);
    lab.key(Modifiers::NONE, Key::Num3);
    let slider = lab.harness.get_by_role_and_label(Role::Slider, "c");
    assert!(slider.accesskit_node().is_disabled(), "c is of no use to mis_all");
}

#[test]
fn weights_and_sampler() {
    let mut lab = Lab::new();
    for (label, heuristic) in [
        ("Heuristic: Power", Heuristic::Power),
        ("Heuristic: Cutoff", Heuristic::Cutoff),
        ("Heuristic: Maximum", Heuristic::Maximum),
        ("Heuristic: Balance", Heuristic::Balance),
    ] {
        lab.click(label);
        assert_eq!(lab.document().active().estimator.heuristic, heuristic);
    }
    lab.key(Modifiers::NONE, Key::Num4);
    lab.click("One-sample weights: Tutorial");
    assert_eq!(lab.document().active().estimator.weights, OneSampleWeights::Tutorial);
    lab.click("Sampler: Sobol");
    assert_eq!(lab.document().sampling().sampler.kind, SamplerKind::Sobol);
    lab.click("Sampler: Random");
    assert_eq!(lab.document().sampling().sampler.kind, SamplerKind::Independent);
    lab.click("Sampler: Stratified");
    assert_eq!(lab.document().sampling().sampler.kind, SamplerKind::Stratified);
    lab.click("jitter");
    assert!(!lab.document().sampling().sampler.jitter);
}

#[test]
fn the_target_and_the_seed() {
    let mut lab = Lab::new();
    lab.click("Samples per pixel");
    lab.click("36  =  6 \u{d7} 6");
    assert_eq!(lab.document().sampling().spp.map(|n| n.get()), Some(36));
    assert_eq!(lab.document().sampling().sampler.strata, [6, 6], "all strata are used");
    lab.settle();
    assert!(lab.has("36 / 36 spp"));
    lab.click("Samples per pixel");
    lab.click("endless");
    assert_eq!(lab.document().sampling().spp, None);
    lab.until("more than the old target", |lab| lab.app().live().current_frame().is_some_and(|f| f.spp() > 40));

    lab.apply(Edit::SetSpp(SppTarget::passes(2)));
    lab.settle();
    let before = lab.app().live().generation();
    lab.type_number("Seed", 7.0);
    assert_eq!(lab.document().sampling().seed, 7);
    assert!(lab.app().live().generation() > before, "another seed is another picture");
    lab.click("next");
    assert_eq!(lab.document().sampling().seed, 8);
}

#[test]
fn the_pace() {
    let mut lab = Lab::new();
    lab.apply(Edit::SetSpp(SppTarget::Endless));
    lab.key(Modifiers::NONE, Key::Space);
    assert!(lab.app().pacing().paused);
    // Not before the pass is over that was running.
    lab.until("the workers to hold", |lab| {
        let (status, frame) = (lab.app().live().status(), lab.app().live().current_frame());
        status.zip(frame).is_some_and(|(status, frame)| status.state == State::Paused && status.spp == frame.spp())
    });
    let held = lab.app().live().current_frame().map(|f| f.spp());
    std::thread::sleep(Duration::from_millis(50));
    lab.harness.step();
    assert_eq!(lab.app().live().current_frame().map(|f| f.spp()), held, "paused is paused");
    lab.click("One pass");
    lab.until("one more pass", |lab| lab.app().live().current_frame().map(|f| f.spp()) == held.map(|n| n + 1));
    lab.click("Restart");
    lab.until("the first pass of the new start", |lab| lab.app().live().current_frame().is_some_and(|f| f.spp() == 1));
    lab.click("Go on");
    assert!(!lab.app().pacing().paused);
    lab.click("Pace: Slowly");
    lab.type_number("Passes per second", 5.0);
    assert_eq!(lab.app().pacing().rate, Some(5.0));
    lab.click("Pace: Full speed");
    assert_eq!(lab.app().pacing().rate, None);
}

#[test]
fn plates_and_lights() {
    let mut lab = Lab::new();
    let alpha = |lab: &Lab, name: &str| lab.document().scene.material(name).and_then(|m| m.bsdf.alpha());
    lab.slide("plate2", 0.2);
    assert_eq!(alpha(&lab, "plate2"), Some(0.2));
    lab.double_click(Role::Slider, "plate2");
    assert_eq!(alpha(&lab, "plate2"), Some(0.02), "back to the file");
    lab.slide("plate2", 0.0);
    assert_eq!(alpha(&lab, "plate2"), Some(0.0), "the left end is a mirror");
    lab.type_number("plate1 value", 0.3);
    assert_eq!(alpha(&lab, "plate1"), Some(0.3), "a mirror can be made rough");

    let light = lab.document().scene.light_shapes().next().expect("the scene has lights");
    let state = |lab: &Lab| {
        let shape = &lab.document().scene.shapes[light];
        let emission = shape.light.as_ref().expect("a light").clone();
        (Document::radius(&lab.document().scene, light).expect("a sphere"), emission)
    };
    let name = state(&lab).1.name;
    let (r0, l0) = state(&lab);
    lab.slide(&name, f64::from(2.0 * r0));
    let (r1, l1) = state(&lab);
    assert!(r1 > 1.9 * r0, "{r0} -> {r1}");
    let power = |r: f32, l: &mislab_renderer::Light| r * r * l.radiance.x;
    assert!((power(r1, &l1) / power(r0, &l0) - 1.0).abs() < 1e-5, "the power stays");
    lab.double_click(Role::Slider, &name);
    assert_eq!(state(&lab), (r0, l0), "the same bits as in the file");
    lab.click(&format!("{name} on"));
    assert!(!state(&lab).1.on);
    lab.click("Reset to the file");
    assert_eq!(lab.document().scene, lab.document().opened.scene);
}

#[test]
fn layers_and_their_legends() {
    let mut lab = Lab::new();
    for layer in Layer::ALL {
        let name = mislab::look::layer::LayerLook::of(layer).name;
        lab.click(&format!("Layer: {name}"));
        assert_eq!(lab.document().active().layer, layer);
        assert!(lab.has(&format!("Legend: {name}")), "a legend for {name}");
    }
    lab.key(Modifiers::NONE, Key::V);
    assert_eq!(lab.document().active().layer, Layer::Picture, "after the last the first");
    let generation = lab.app().live().generation();
    lab.key(Modifiers::SHIFT, Key::V);
    assert_eq!(lab.document().active().layer, Layer::Variance);
    assert_eq!(lab.app().live().generation(), generation, "the view never reaches the renderer");
    lab.slide("from 10^", -8.0);
    assert_eq!(lab.document().view.variance_range[0], -8.0);
}

#[test]
fn exposure_offset_and_tone_map() {
    let mut lab = Lab::new();
    lab.slide("Exposure", 2.0);
    assert_eq!(lab.document().view.exposure_ev, 2.0);
    lab.key(Modifiers::NONE, Key::E);
    assert_eq!(lab.document().view.exposure_ev, 2.5);
    lab.key(Modifiers::SHIFT, Key::E);
    lab.key(Modifiers::SHIFT, Key::E);
    assert_eq!(lab.document().view.exposure_ev, 1.5);
    lab.key(Modifiers::NONE, Key::O);
    assert!(lab.document().view.offset > 0.0);
    lab.click("Tone map: Filmic");
    assert_eq!(lab.document().view.tone_map, ToneMap::Filmic);
    lab.key(Modifiers::NONE, Key::R);
    assert_eq!(lab.document().view.exposure_ev, 0.0);
    assert_eq!(lab.document().view.offset, 0.0);
    lab.click("Normalise");
    assert_ne!(lab.document().view.exposure_ev, 0.0, "set in plain sight");
    lab.key(Modifiers::COMMAND, Key::Z);
    assert_eq!(lab.document().view.exposure_ev, 0.0, "and undone like anything else");
}

#[test]
fn undo_and_redo_go_over_everything() {
    let mut lab = Lab::new();
    let start = lab.document().clone();
    lab.key(Modifiers::NONE, Key::Num1);
    lab.slide("plate3", 0.4);
    lab.slide("Exposure", 1.0);
    lab.type_number("Seed", 5.0);
    let end = lab.document().clone();
    for _ in 0..4 {
        lab.key(Modifiers::COMMAND, Key::Z);
    }
    assert_eq!(*lab.document(), start);
    lab.key(Modifiers::COMMAND, Key::Z);
    assert_eq!(*lab.document(), start, "there is nothing before the start");
    for _ in 0..3 {
        lab.key(Modifiers::COMMAND, Key::Y);
    }
    lab.key(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(*lab.document(), end);
}

#[test]
fn a_drag_is_one_step_of_undo() {
    let mut lab = Lab::new();
    let rect = lab.harness.get_by_role_and_label(Role::Slider, "plate4").rect();
    let button = |pos, pressed| egui::Event::PointerButton {
        pos,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    let start = rect.left_center() + egui::vec2(12.0, 0.0);
    lab.harness.event(egui::Event::PointerMoved(start));
    lab.harness.event(button(start, true));
    lab.harness.step();
    for i in 1..8 {
        lab.harness.event(egui::Event::PointerMoved(start + egui::vec2(8.0 * i as f32, 0.0)));
        lab.harness.step();
    }
    let end = start + egui::vec2(56.0, 0.0);
    lab.harness.event(button(end, false));
    lab.harness.step();
    let alpha = |lab: &Lab| lab.document().scene.material("plate4").and_then(|m| m.bsdf.alpha());
    assert_ne!(alpha(&lab), Some(0.1));
    lab.key(Modifiers::COMMAND, Key::Z);
    assert_eq!(alpha(&lab), Some(0.1));
}

#[test]
fn an_old_picture_is_never_passed_off_as_the_new_one() {
    let mut lab = Lab::new();
    let mut strategies = HashMap::new();
    for key in [Key::Num1, Key::Num2, Key::Num3] {
        lab.harness.key_press(key);
        for _ in 0..4 {
            strategies.insert(lab.app().live().generation(), lab.document().active().estimator.strategy);
            lab.harness.step();
            strategies.insert(lab.app().live().generation(), lab.document().active().estimator.strategy);
            let shown = strategies[&lab.app().live().shown().expect("there is a picture")];
            let name =
                ["Light", "BSDF", "MIS, both", "MIS, one"][Strategy::ALL.iter().position(|s| *s == shown).unwrap()];
            assert!(lab.has(&format!("Caption: {name}")), "the caption is about the picture on screen");
            assert_eq!(lab.app().live().is_behind(), lab.has("previous settings"), "an old picture says so");
        }
    }
}

#[test]
fn a_black_picture_says_why() {
    let mut lab = Lab::new();
    assert!(!lab.has("No light reaches"));
    let dark = lab.file("dark.pbrt");
    std::fs::write(&dark, small_scene().replace("AreaLightSource", "LightSource")).expect("write");
    lab.apply(Command::OpenPath(dark.clone()));
    lab.until("the dark scene", |lab| lab.document().opened.path.as_deref() == Some(dark.as_path()));
    lab.settle();
    assert!(lab.has("No light reaches this picture directly: the scene has no area light"));
    // It goes when its cause goes.
    lab.apply(Command::OpenShipped(mislab::state::command::Shipped::Veach));
    lab.apply(Edit::SetSpp(SppTarget::passes(1)));
    lab.settle();
    assert!(!lab.has("No light reaches"));
}

#[test]
fn the_palette_finds_commands() {
    let mut lab = Lab::new();
    lab.key(Modifiers::COMMAND | Modifiers::SHIFT, Key::P);
    lab.harness.step();
    lab.harness.get_by_label("Command").type_text("sobol");
    lab.harness.step();
    lab.harness.key_press(Key::Enter);
    lab.harness.run_steps(2);
    assert_eq!(lab.document().sampling().sampler.kind, SamplerKind::Sobol);
    assert!(lab.harness.query_by_label("Command").is_none(), "done is gone");
}

#[test]
fn bias_is_said_in_words() {
    let mut lab = Lab::new();
    lab.apply(Edit::SetStrategy(Strategy::Mis));
    lab.apply(Edit::SetWeights(OneSampleWeights::Tutorial));
    lab.settle();
    assert!(!lab.has("biased"));
    lab.apply(Edit::SetLightProb(1.0));
    lab.settle();
    assert!(lab.has("biased"), "in the caption");
}

#[test]
fn undo_says_what_it_undid() {
    let mut lab = Lab::new();
    lab.slide("plate2", 0.2);
    lab.key(Modifiers::COMMAND, Key::Z);
    assert!(lab.has("Undone: roughness of plate2"));
    lab.key(Modifiers::COMMAND, Key::Y);
    assert!(lab.has("Done again: roughness of plate2"));
    lab.click("Menu");
    assert!(lab.has("Undo: roughness of plate2"));
}

#[test]
fn a_decimal_comma_is_one_and_nonsense_is_said() {
    let mut lab = Lab::new();
    lab.write_into("Exposure value", "1,5", Key::Enter);
    assert_eq!(lab.document().view.exposure_ev, 1.5);
    lab.write_into("Exposure value", "-0,5 EV", Key::Enter);
    assert_eq!(lab.document().view.exposure_ev, -0.5);
    lab.write_into("Exposure value", "bright", Key::Enter);
    assert_eq!(lab.document().view.exposure_ev, -0.5);
    assert!(lab.has("\u{201c}bright\u{201d} is not a number"));
    let seed = lab.document().sampling().seed;
    lab.write_into("Seed", "7,5", Key::Enter);
    assert_eq!(lab.document().sampling().seed, seed, "a seed is whole");
    assert!(lab.has("\u{201c}7,5\u{201d} is not a number"));
}

#[test]
fn tab_through_a_field_changes_nothing() {
    let mut lab = Lab::new();
    let plate = lab.document().scene.materials.iter().position(|m| m.name == "plate2").expect("the scene has it");
    lab.apply(Edit::SetAlpha(plate, 0.033_333));
    lab.settle();
    let (before, generation) = (lab.document().clone(), lab.app().live().generation());
    lab.harness.get_by_role_and_label(Role::SpinButton, "plate2 value").focus();
    lab.harness.run_steps(2);
    lab.key(Modifiers::NONE, Key::Tab);
    lab.harness.run_steps(2);
    assert_eq!(*lab.document(), before);
    assert_eq!(lab.app().live().generation(), generation, "the picture goes on");
}

#[test]
fn a_value_beyond_the_rail_stays() {
    let mut lab = Lab::new();
    lab.apply(Edit::SetExposure(12.0));
    lab.harness.run_steps(3);
    assert_eq!(lab.document().view.exposure_ev, 12.0, "looking at it does not change it");
}

#[test]
fn a_press_and_a_long_way_in_one_pass_are_a_drag() {
    let mut lab = Lab::new();
    let rect = lab.harness.get_by_role_and_label(Role::Slider, "Exposure").rect();
    let button = |pos, pressed| egui::Event::PointerButton {
        pos,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    lab.harness.event(egui::Event::PointerMoved(rect.center()));
    lab.harness.step();
    let far = rect.right_center() + egui::vec2(200.0, 300.0);
    // All at once, as after a busy moment.
    let events = [button(rect.center(), true), egui::Event::PointerMoved(far)];
    lab.harness.input_mut().events.extend(events);
    lab.harness.run_steps(2);
    assert!(lab.document().view.exposure_ev > 9.0, "{}", lab.document().view.exposure_ev);
    lab.harness.event(button(far, false));
    lab.harness.run_steps(2);
}

#[test]
fn the_cursor_says_what_a_drag_does() {
    let mut lab = Lab::new();
    let cursor = |lab: &mut Lab, at: egui::Pos2| {
        lab.harness.hover_at(at);
        lab.harness.run_steps(2);
        lab.harness.output().platform_output.cursor_icon
    };
    let rail = lab.harness.get_by_role_and_label(Role::Slider, "Exposure").rect().center();
    assert_eq!(cursor(&mut lab, rail), egui::CursorIcon::ResizeHorizontal);
    let picture = lab.harness.get_by_role_and_label(Role::Image, "Picture").rect();
    let at = picture.center_bottom() - egui::vec2(0.0, 60.0);
    assert_eq!(cursor(&mut lab, at), egui::CursorIcon::Crosshair, "nothing to move, all of it is there");
    lab.apply(Command::ActualSize);
    assert_eq!(cursor(&mut lab, picture.center()), egui::CursorIcon::Grab);
}

#[test]
fn brackets_move_c() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::CloseBracket);
    assert_eq!(lab.document().active().estimator.light_prob, 0.5, "strategy 3 has no c");
    lab.key(Modifiers::NONE, Key::Num4);
    for _ in 0..3 {
        lab.key(Modifiers::NONE, Key::CloseBracket);
    }
    assert_eq!(lab.document().active().estimator.light_prob, 0.65);
    for _ in 0..30 {
        lab.key(Modifiers::NONE, Key::OpenBracket);
    }
    assert_eq!(lab.document().active().estimator.light_prob, 0.0);
}

#[test]
fn a_technique_that_is_not_drawn_says_so() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::Num1);
    lab.apply(Edit::SetLayer(Layer::Bsdf));
    lab.settle();
    assert!(lab.has("This strategy draws no BSDF samples."));
    lab.key(Modifiers::NONE, Key::Num2);
    lab.settle();
    assert!(!lab.has("This strategy draws no BSDF samples."));
}
