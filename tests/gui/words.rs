//! What the window says of its parts: hints, keys, names.

use eframe::egui::accesskit::Role;
use eframe::egui::{self, Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use mislab::state::keys::bindings;
use mislab_renderer::Layer;

use crate::lab::Lab;

#[test]
fn words_of_the_file_stand_by_those_of_the_window() {
    let mut lab = Lab::new();
    let at = lab.rect("4 MIS, one").center();
    lab.rest_on(at);
    assert!(lab.has("\"string MISstrategy\" [\"mis\"]") && lab.has("one-sample model"));
    lab.click("Menu");
    assert!(lab.has("Theme") && lab.has("Interface"), "what is light and dark is said");
}

#[test]
fn every_layer_and_slider_has_a_hint_off_the_formula() {
    let mut lab = Lab::with_size([1280.0, 900.0]);
    lab.key(Modifiers::NONE, Key::Num4);
    let formula = lab.harness.query_all_by_label_contains("Formula: ").next().expect("a formula").rect();
    let hinted = |lab: &mut Lab, at: egui::Pos2, what: &str, words: &str| {
        lab.rest_on(at);
        assert!(lab.has(words), "no hint for {what}");
        let hint = lab.harness.query_all_by_label_contains(words).next().expect("asked above").rect();
        assert!(!hint.intersects(formula), "{what}: {hint:?} lies over the formula");
        lab.harness.remove_cursor();
        lab.harness.run_steps(30);
        assert!(!lab.has(words), "the hint of {what} goes with the mouse");
    };
    for layer in Layer::ALL {
        let label = format!("Layer: {}", mislab::look::layer::LayerLook::of(layer).name);
        let at = lab.rect(&label).center();
        hinted(&mut lab, at, &label, "In the EXR file: ");
    }
    for (slider, words) in [
        ("c", "sample_L_pdf"),
        ("plate2", "width of the GGX lobe"),
        ("Exposure", "Exposure in stops"),
        ("Offset", "Added after exposure"),
    ] {
        let at = lab.harness.get_by_role_and_label(Role::Slider, slider).rect().center();
        hinted(&mut lab, at, slider, words);
    }
    for (field, words) in [("4 / 4 spp", "xsamples times ysamples"), ("seed 1", "all random numbers start")] {
        let at = lab.rect(field).center();
        hinted(&mut lab, at, field, words);
    }
}

#[test]
fn hints_of_the_bar_keep_clear_of_the_formula_in_a_narrow_window() {
    let mut lab = Lab::with_size([1120.0, 720.0]);
    lab.key(Modifiers::NONE, Key::Num4);
    let formula = lab.harness.query_all_by_label_contains("Formula: ").next().expect("a formula").rect();
    let at = lab.harness.get_by_role_and_label(Role::Slider, "c").rect().center();
    lab.rest_on(at);
    let hint = lab.harness.query_all_by_label_contains("probability of drawing").next().expect("a hint").rect();
    assert!(!hint.intersects(formula), "{hint:?} over {formula:?}");
    assert!(hint.top() > at.y, "under what it explains");
}

#[test]
fn the_projector_view_has_no_hints() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.key(Modifiers::COMMAND, Key::B);
    lab.fit();
    lab.key(Modifiers::NONE, Key::Num4);
    for label in ["4 MIS, one", "Layer menu"] {
        let at = lab.rect(label).center();
        lab.rest_on(at);
        assert!(!lab.has("In a scene file") && !lab.has("In the EXR file"), "{label}");
    }
}

#[test]
fn a_hint_goes_with_the_first_key() {
    let mut lab = Lab::new();
    let at = lab.rect("Layer: Variance").center();
    lab.rest_on(at);
    assert!(lab.has("In the EXR file: variance.Y"));
    lab.key(Modifiers::NONE, Key::Num1);
    lab.harness.run_steps(30);
    assert!(!lab.has("In the EXR file: variance.Y"), "eyes are on the picture");
}

#[test]
fn escape_puts_the_table_away() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::T);
    assert!(lab.has("Fill in the table"));
    lab.key(Modifiers::NONE, Key::Escape);
    assert!(!lab.has("Fill in the table"));
}

#[test]
fn the_key_sheet() {
    let mut lab = Lab::new();
    lab.key(Modifiers::SHIFT, Key::Questionmark);
    assert!(lab.has("Projector view: hide the panels"));
    lab.click("Close");
    assert!(!lab.has("Projector view: hide the panels"));
}

#[test]
fn every_key_is_on_the_sheet() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.key(Modifiers::NONE, Key::Questionmark);
    for action in bindings() {
        assert!(lab.has(&action.name), "{} ({})", action.name, action.keys);
    }
}
