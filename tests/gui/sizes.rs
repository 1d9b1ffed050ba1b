//! What an attack on the window left over: nothing out of reach or hidden in a small window, no message that is not true.

use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use mislab::state::command::Command;
use mislab::state::edit::Edit;
use mislab_renderer::Strategy;

use crate::lab::{Lab, small_scene};

#[test]
fn every_control_of_the_bar_has_its_place_in_a_narrow_window() {
    for width in [640.0, 800.0, 960.0, 1100.0, 1280.0] {
        let mut lab = Lab::with_size([width, 400.0]);
        lab.apply(Edit::SetStrategy(Strategy::Mis));
        let c = lab.harness.get_by_role_and_label(Role::Slider, "c").rect();
        let bar = ["1 Light", "2 BSDF", "3 MIS, both", "4 MIS, one", "Menu", "Layout", "Layer menu"];
        let mut rects: Vec<_> = bar.into_iter().map(|label| (label, lab.rect(label))).collect();
        rects.push(("c", c));
        for (i, (name, rect)) in rects.iter().enumerate() {
            assert!(rect.left() >= 0.0 && rect.right() <= width, "{width}: {name} at {rect:?}");
            for (other, place) in &rects[..i] {
                assert!(!rect.shrink(0.5).intersects(place.shrink(0.5)), "{width}: {name} over {other}");
            }
        }
        lab.slide("c", 0.25);
        assert_eq!(lab.document().active().estimator.light_prob, 0.25, "{width}");
    }
}

#[test]
fn a_wrong_name_moves_nothing() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    let places = |lab: &Lab| ["Snapshot folder", "Save snapshot"].map(|label| lab.rect(label));
    let before = places(&lab);
    lab.type_over("Snapshot name", "a/b");
    assert!(lab.has("a name has no / in it"));
    assert_eq!(places(&lab), before);
}

#[test]
fn what_went_wrong_stands_in_one_strip_and_goes_one_by_one() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    let scene = lab.file("small.pbrt");
    std::fs::write(&scene, small_scene().replace("WorldBegin", "WorldBegin [")).expect("write");
    lab.until("the error", |lab| lab.has("small.pbrt has an error"));
    assert!(!lab.has("was not opened"), "it is open: the picture is of the version before");
    assert!(lab.has("The picture is of the version before"));
    let alone = lab.harness.get_by_label("Close message").rect();

    lab.type_over("Snapshot folder", "not_there");
    lab.apply(Command::Save);
    lab.until("the second error", |lab| lab.has("was not saved"));
    lab.harness.run_steps(3);
    assert_eq!(lab.harness.get_by_label("Close message").rect(), alone, "the first stays");
    let picture = lab.harness.get_by_role_and_label(Role::Image, "Picture").rect();
    for node in lab.harness.query_all_by_label_contains("Close message") {
        assert!(node.rect().bottom() < picture.top() + 0.4 * picture.height(), "the picture is seen");
    }
    assert!(!lab.has("Create the folder and save"), "not yet its turn");

    std::fs::write(&scene, small_scene()).expect("write");
    lab.until("the scene again", |lab| !lab.has("has an error"));
    lab.harness.run_steps(3);
    assert!(lab.has("Create the folder and save"), "its turn");
    std::fs::create_dir(lab.file("not_there")).expect("a folder");
    lab.harness.run_steps(3);
    assert!(!lab.has("was not saved"), "the error goes with its cause");
}

#[test]
fn escape_puts_away_what_was_not_saved() {
    let mut lab = Lab::new();
    lab.type_over("Snapshot name", "a/b");
    lab.apply(Command::Save);
    lab.harness.run_steps(3);
    assert!(lab.has("a/b was not saved"));
    lab.key(Modifiers::NONE, Key::Escape);
    assert!(lab.has("a/b was not saved"), "first the field");
    lab.key(Modifiers::NONE, Key::Escape);
    assert!(!lab.has("a/b was not saved"));
}

#[test]
fn a_picture_alone_counts_samples_or_rays() {
    let mut lab = Lab::new();
    assert!(lab.has("4 spp") && lab.has("8 rays"), "MIS, both pays for two rays a sample");
    lab.click("Per pixel: rays");
    lab.settle();
    assert!(lab.has("2 spp") && lab.has("4 rays"), "the caption says both");
    lab.apply(Edit::SetStrategy(Strategy::Light));
    lab.settle();
    assert!(lab.has("4 spp") && lab.has("4 rays"));
    lab.apply(Command::Undo);
    lab.apply(Command::Undo);
    lab.settle();
    assert!(lab.has("8 rays"), "and it can be undone");
}
