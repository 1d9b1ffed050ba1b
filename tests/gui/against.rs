//! Two pictures as one, units of the variance, and what cannot be sampled.

use eframe::egui::{self, Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use mislab::look::versus::Versus;
use mislab::state::arrangement::Arrangement;
use mislab::state::edit::{Edit, SppTarget};
use mislab::state::view::VarianceUnit;
use mislab_renderer::{Layer, Strategy};

use crate::lab::Lab;

#[test]
fn a_against_b_is_one_picture_with_a_sentence() {
    let mut lab = Lab::new();
    lab.apply(Edit::SetSpp(SppTarget::passes(16)));
    lab.key(Modifiers::NONE, Key::Num1);
    lab.key(Modifiers::NONE, Key::D);
    assert_eq!(lab.document().arrangement(), Arrangement::Difference);
    assert_eq!(lab.strategies(), [Strategy::Light, Strategy::Bsdf]);
    lab.settle_all();
    lab.until("the sentence", |lab| lab.has("Over all: "));
    assert!(lab.has("Legend: Variance: A over B, by 8 \u{d7} 8 pixels, 1/8, 1/4, 1/2, 1, 2, 4, 8"));
    assert!(lab.has("Picture 1: Light") && lab.has("Picture 2: BSDF"), "both have their captions");
    lab.click("A against B: A \u{2212} B");
    assert_eq!(lab.document().view.versus, Versus::Difference);
    lab.until("the difference", |lab| lab.has("Legend: Luminance: A \u{2212} B, in radiance"));
    let before = lab.document().view.difference_range;
    lab.key(Modifiers::NONE, Key::N);
    assert!(lab.document().view.difference_range != before, "the range is set from the picture");
    // A part is selected by a drag with Shift, which does not move the picture.
    let label = "Picture: Luminance: A \u{2212} B, in radiance";
    let middle = lab.rect(label).center();
    let placement = lab.document().view.placement;
    let event = |lab: &mut Lab, at: egui::Pos2, pressed: Option<bool>| {
        lab.harness.event_modifiers(egui::Event::PointerMoved(at), Modifiers::SHIFT);
        if let Some(pressed) = pressed {
            let (button, modifiers) = (egui::PointerButton::Primary, Modifiers::SHIFT);
            let press = egui::Event::PointerButton { pos: at, button, pressed, modifiers };
            lab.harness.event_modifiers(press, Modifiers::SHIFT);
        }
        lab.harness.step();
    };
    event(&mut lab, middle, Some(true));
    event(&mut lab, middle + egui::vec2(60.0, 60.0), None);
    event(&mut lab, middle + egui::vec2(120.0, 120.0), None);
    event(&mut lab, middle + egui::vec2(120.0, 120.0), Some(false));
    lab.until("the sentence about the part", |lab| lab.has("In the part: "));
    assert_eq!(lab.document().view.placement, placement);
    lab.key(Modifiers::NONE, Key::Escape);
    assert_eq!(lab.document().arrangement(), Arrangement::One);
}

#[test]
fn the_sentence_is_about_the_square_under_the_mouse() {
    let mut lab = Lab::new();
    lab.apply(Edit::SetSpp(SppTarget::passes(16)));
    lab.key(Modifiers::NONE, Key::D);
    lab.settle_all();
    lab.until("the sentence", |lab| lab.has("Over all: "));
    let picture = lab.rect("Picture: Variance: A over B, by 8 \u{d7} 8 pixels");
    // Somewhere on the way down the middle there is a plate under a light, and the squares are found on a thread.
    let seen = |lab: &Lab| (1..=4).any(|plate| lab.has(&format!("plate{plate} \u{d7} ")));
    for step in 0..1200 {
        let down = 0.3 + 0.6 * (step % 60) as f32 / 60.0;
        let at = egui::pos2(picture.center().x, picture.top() + down * picture.height());
        lab.harness.event(egui::Event::PointerMoved(at));
        lab.harness.step();
        if seen(&lab) {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    assert!(seen(&lab), "no square was named");
    lab.harness.event(egui::Event::PointerGone);
    lab.until("all again", |lab| lab.has("Over all: "));
}

#[test]
fn errors_have_a_reference_and_it_is_said_how_far_it_is() {
    let mut lab = Lab::new();
    lab.apply(Edit::SetSpp(SppTarget::passes(16)));
    lab.key(Modifiers::NONE, Key::D);
    lab.settle_all();
    lab.click("A against B: Error A / B");
    lab.until("how far the reference is", |lab| lab.has("reference: "));
    lab.until("the sentence", |lab| {
        let spp = lab.has(" of 4096 spp") || lab.has("reference: 4096 spp");
        spp && lab.has("Over all: ") && !lab.has("; variance per ray")
    });
    assert!(lab.has("Legend: Squared error: A over B, by 8 \u{d7} 8 pixels, 1/8, 1/4, 1/2, 1, 2, 4, 8"));
    lab.until("errors in the captions", |lab| lab.has(", error 0.") || lab.has(", error 1"));
    lab.click("A against B: Noise A / B");
    lab.until("noise again", |lab| lab.has("; variance per ray"));
}

#[test]
fn the_variance_has_a_unit_and_what_cannot_be_hit_is_said() {
    let mut lab = Lab::new();
    lab.apply(Edit::SetLayer(Layer::Variance));
    lab.until("the default unit", |lab| lab.has("Legend: Variance over mean\u{b2}, per ray"));
    lab.until("what the samples are worth", |lab| lab.has(" if independent; ") && lab.has("8 replicates"));
    lab.click("Unit of the variance: sample");
    assert_eq!(lab.document().view.variance_unit, VarianceUnit::OneSample);
    assert_eq!(lab.document().view.variance_range, VarianceUnit::OneSample.default_range(), "its usual range");
    assert!(lab.has("Legend: Variance of one sample"));
    let plate = lab.document().scene.materials.iter().position(|m| m.name == "plate1").expect("the scene has plates");
    lab.apply(Edit::SetAlpha(plate, 0.0));
    lab.key(Modifiers::NONE, Key::Num1);
    lab.settle();
    assert!(lab.has("biased on plate1: a light sample never meets a mirror's one direction"));
    lab.key(Modifiers::NONE, Key::Num3);
    lab.settle();
    assert!(!lab.has("biased on plate1"), "BSDF samples do");
    assert!(lab.harness.query_by_label_contains("cross-hatched: cannot be hit").is_some(), "the legend stays as it is");
}
