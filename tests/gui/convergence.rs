//! Studies of convergence and of means, and the errors in captions.

use eframe::egui::accesskit::Role;
use eframe::egui::{self, Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use mislab::state::edit::{Edit, SppTarget};
use mislab_renderer::{OneSampleWeights, Strategy};

use crate::lab::Lab;

/// Until a text that contains this is on screen.
#[track_caller]
fn wait_for(lab: &mut Lab, text: &str) {
    lab.until(text, |lab| lab.has(text));
}

#[test]
fn curves_appear_with_their_slopes_and_are_saved() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    assert!(lab.harness.query_all_by_label_contains("error").next().is_none(), "no reference, no error");
    lab.key(Modifiers::NONE, Key::G);
    wait_for(&mut lab, "Light: slope \u{2212}");
    wait_for(&mut lab, "MIS, one: slope \u{2212}");
    wait_for(&mut lab, "error 0.");
    lab.click("Error: RMSE");
    assert!(lab.harness.query_all_by_label_contains("RMSE = ").next().is_some(), "the formula is shown");
    wait_for(&mut lab, "MIS, both: slope \u{2212}0.");
    lab.click("Save the curves as CSV");
    lab.until("the file", |lab| lab.file("convergence.csv").exists());
    let text = std::fs::read_to_string(lab.file("convergence.csv")).expect("text");
    let head = text.lines().next().expect("a head line");
    assert!(head.starts_with("strategy,heuristic,weights,light_prob,part,spp"), "{head}");
    assert!(text.lines().filter(|line| line.contains(",whole picture,")).count() >= 4 * 2, "{text}");
}

#[test]
fn a_prediction_is_drawn_and_compared() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.key(Modifiers::NONE, Key::G);
    lab.click("Draw your prediction");
    wait_for(&mut lab, "MIS, both: slope \u{2212}");
    let plot = lab.harness.get_by_role_and_label(Role::Image, "Plot of errors").rect();
    let [from, to] = [plot.lerp_inside(egui::vec2(0.2, 0.2)), plot.lerp_inside(egui::vec2(0.9, 0.6))];
    lab.harness.event(egui::Event::PointerMoved(from));
    lab.harness.step();
    let button = |pos, pressed| egui::Event::PointerButton {
        pos,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    lab.harness.event(button(from, true));
    for step in 1..=10 {
        lab.harness.event(egui::Event::PointerMoved(from + (to - from) * (step as f32 / 10.0)));
        lab.harness.step();
    }
    lab.harness.event(button(to, false));
    lab.harness.step();
    wait_for(&mut lab, "on average, with slope \u{2212}");
}

#[test]
fn a_reference_stays_when_the_strategy_changes_and_goes_with_the_scene() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.key(Modifiers::NONE, Key::M);
    wait_for(&mut lab, "whole picture: ");
    lab.apply(Edit::SetStrategy(Strategy::Light));
    lab.harness.run_steps(3);
    assert!(lab.has("whole picture: "), "it is of the scene, not of the strategy");
    lab.apply(Edit::SetSeed(7));
    lab.harness.run_steps(2);
    assert!(!lab.has("whole picture: "), "pictures with that seed may share its samples");
}

#[test]
fn means_tell_bias_from_noise() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.apply(Edit::SetStrategy(Strategy::Mis));
    lab.apply(Edit::SetWeights(OneSampleWeights::Tutorial));
    lab.apply(Edit::SetSpp(SppTarget::passes(64)));
    lab.slide("c", 0.0);
    lab.key(Modifiers::NONE, Key::M);
    wait_for(&mut lab, "whole picture: biased, p ");
    lab.slide("c", 0.1);
    wait_for(&mut lab, "whole picture: unbiased so far");
    lab.click("Save the means as CSV");
    lab.until("the file", |lab| lab.file("means.csv").exists());
}
