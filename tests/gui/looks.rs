//! What is said where, in words that are true of the picture at hand.

use eframe::egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use mislab::state::command::Command;
use mislab::state::edit::{Edit, SppTarget};
use mislab_renderer::{Layer, Strategy};

use crate::lab::Lab;

/// A grey picture in a file of that name.
fn grey(lab: &Lab, name: &str) -> std::path::PathBuf {
    use exr::prelude::*;
    let path = lab.file(name);
    let pixels = SpecificChannels::build().with_channel("Y").with_pixel_fn(|at| (at.x() as f32,));
    Image::from_channels((8, 8), pixels).write().to_file(&path).expect("can be written");
    path
}

/// Beside the live picture, and the one that controls are about.
fn show(lab: &mut Lab, path: std::path::PathBuf) {
    lab.apply(Command::ComparePath(path));
    lab.until("the second picture", |lab| lab.document().slots().len() == 2);
    lab.key(Modifiers::NONE, Key::X);
    lab.harness.run_steps(2);
}

/// Everything written that contains this.
fn texts(lab: &Lab, part: &str) -> Vec<String> {
    let nodes = lab.harness.query_all_by_label_contains(part);
    nodes.filter_map(|node| node.accesskit_node().label().or_else(|| node.accesskit_node().value())).collect()
}

#[test]
fn a_file_has_no_samples_to_count_and_no_pattern_to_choose() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    let path = grey(&lab, "grey.exr");
    let enabled = |lab: &Lab, label: &str| !lab.harness.get_by_label(label).accesskit_node().is_disabled();
    assert!(enabled(&lab, "Sampler: Random") && enabled(&lab, "jitter"));
    assert!(!lab.has("Picture from a file"));
    show(&mut lab, path);
    assert!(lab.has("Picture from a file"), "in the status bar");
    assert!(!texts(&lab, " spp").iter().any(|text| text.contains(" / ") && text.ends_with(" spp")));
    assert!(!enabled(&lab, "Sampler: Random") && !enabled(&lab, "jitter"));
}

#[test]
fn a_long_file_name_loses_its_middle_and_not_its_end() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    let path = grey(&lab, "a_picture_with_a_very_long_name_indeed.exr");
    show(&mut lab, path);
    lab.key(Modifiers::COMMAND, Key::B);
    lab.key(Modifiers::NONE, Key::W);
    lab.harness.run_steps(3);
    let drawn = texts(&lab, ".exr");
    assert!(drawn.iter().any(|text| text.starts_with("a_pic") && text.ends_with(".exr")), "{drawn:?}");
    let right = lab.harness.query_all_by_label_contains(".exr").map(|node| node.rect()).collect::<Vec<_>>();
    assert!(right.iter().all(|rect| rect.left() >= 0.0 && rect.right() <= 1280.0), "{right:?}");
}

#[test]
fn a_mirror_that_cannot_be_sampled_is_no_lack_of_samples() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.apply(Edit::SetStrategy(Strategy::Light));
    lab.apply(Edit::SetSpp(SppTarget::passes(16)));
    lab.key(Modifiers::NONE, Key::M);
    lab.until("the mirror", |lab| lab.has("biased: cannot be sampled"));
    assert!(!lab.has("plate1 under light4: too few samples with light"));
    lab.apply(Edit::SetStrategy(Strategy::MisAll));
    lab.until("no mirror", |lab| !lab.has("cannot be sampled"));
}

#[test]
fn a_reference_can_be_typed_where_there_is_no_dialog() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.key(Modifiers::NONE, Key::M);
    lab.harness.run_steps(2);
    lab.click("Reference from elsewhere");
    lab.until("the sheet", |lab| lab.has("Measure errors against a picture"));
    lab.key(Modifiers::NONE, Key::Escape);
    lab.harness.run_steps(2);
    assert!(!lab.has("Measure errors against a picture"), "one Escape closes it");
    assert!(lab.has("Means: bias or noise"), "and no more than it");
    lab.apply(Command::ReferencePath(lab.file("nowhere.exr")));
    lab.until("the reason", |lab| lab.has("nowhere.exr"));
}

#[test]
fn the_projector_column_says_what_a_picture_cost() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.settle();
    lab.key(Modifiers::COMMAND, Key::B);
    lab.harness.run_steps(3);
    let spp = lab.app().live().frame().expect("a frame").spp();
    let rays = format!("{} rays", 2 * spp);
    let found = lab.harness.query_all_by_label(rays.as_str()).map(|node| node.rect()).next();
    let rect = found.expect("the rays of MIS, both");
    assert!(rect.right() <= 560.0 && rect.bottom() <= 720.0 && rect.height() >= 24.0, "{rect:?}");
}

#[test]
fn in_the_projector_column_nothing_lies_over_anything() {
    for size in [[1280.0, 720.0], [1920.0, 1080.0], [1024.0, 768.0]] {
        let mut lab = Lab::with_size(size);
        lab.apply(Edit::SetStrategy(Strategy::Light));
        lab.apply(Edit::SetLayer(Layer::Variance));
        lab.settle();
        lab.key(Modifiers::COMMAND, Key::B);
        lab.fit();
        let rect = |label: &str| lab.harness.query_all_by_label_contains(label).map(|node| node.rect()).next();
        let places =
            ["Formula: ", "Layer menu", "Legend: ", "Caption: Light", " rays"].map(|label| (label, rect(label)));
        for pair in places.windows(2) {
            let [(above, Some(a)), (below, Some(b))] = pair else { panic!("{places:?}") };
            assert!(a.bottom() <= b.top() + 0.5, "{above} {a:?} reaches into {below} {b:?} at {size:?}");
        }
    }
}
