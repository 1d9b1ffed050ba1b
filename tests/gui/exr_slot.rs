//! A picture from a file beside the live one: aligned, read and undone like any other.

use std::path::{Path, PathBuf};

use eframe::egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use mislab::look::versus::Versus;
use mislab::picture::content::Content;
use mislab::picture::pane::Pane;
use mislab::state::arrangement::Arrangement;
use mislab::state::command::Command;
use mislab::state::document::Kept;
use mislab::state::edit::Edit;
use mislab::state::placement::Placement;
use mislab_renderer::snapshot::{Contents, SaveOptions};
use mislab_renderer::{Channel, Frame, Layer, Strategy, pbrt};

use crate::lab::Lab;

/// A frame of Veach's scene.
fn frame(size: [u32; 2]) -> std::sync::Arc<Frame> {
    let file = pbrt::embedded_scene();
    let mut settings = file.settings;
    settings.image.resolution = size;
    settings.sampling.spp = std::num::NonZeroU32::new(2);
    let request = mislab_renderer::Request { scene: file.scene.into(), settings };
    mislab_renderer::render(&request, 1, &mut |_| true).expect("renders")
}

/// A file of it: a snapshot, or one that another program could have written.
fn file(folder: &Path, name: &str, frame: &Frame, own: bool) -> PathBuf {
    let (mut bytes, _) = Contents::from_frame(frame).encode(&SaveOptions::default()).expect("encodes");
    for name in ["mislabSettings", "mislabFormat"].into_iter().filter(|_| !own) {
        let at = bytes.windows(name.len()).position(|w| w == name.as_bytes()).expect("an attribute of ours");
        bytes[at..at + 6].copy_from_slice(b"others");
    }
    let path = folder.join(name);
    std::fs::write(&path, bytes).expect("write");
    path
}

#[test]
fn a_picture_of_another_program_is_compared_with_from_its_sheet() {
    let mut lab = Lab::new();
    let path = file(lab.folder.path(), "student.exr", &frame([60, 60]), false);
    let before = lab.document().clone();
    lab.apply(Command::OpenPath(path));
    lab.until("the picture", |lab| lab.has("Made by another program"));
    lab.click("Compare with it");
    lab.until("the second picture", |lab| lab.document().slots().len() == 2);
    lab.harness.run_steps(3);
    assert!(!lab.has("Made by another program"), "the sheet has done its part");
    assert_eq!(lab.document().arrangement(), Arrangement::Beside);
    assert_eq!(lab.document().active_index(), 0, "the live picture stays the one that controls are about");
    assert!(lab.has("Picture 2: student.exr, 60 x 60, from file"));
    assert!(!lab.has("60 x 60, from file, aligned"), "it has the same pixels");
    lab.key(Modifiers::COMMAND, Key::Z);
    assert_eq!(*lab.document(), before, "one step");
    lab.key(Modifiers::COMMAND, Key::Y);
    assert!(lab.has("Picture 2: student.exr"), "and again");
}

#[test]
fn a_file_has_a_difference_and_an_error_but_no_variance() {
    let mut lab = Lab::new();
    let path = file(lab.folder.path(), "student.exr", &frame([60, 60]), false);
    lab.apply(Command::ComparePath(path));
    lab.until("the second picture", |lab| lab.document().slots().len() == 2);
    lab.key(Modifiers::NONE, Key::D);
    lab.until("why there is nothing", |lab| lab.has("A file has no variance to compare"));
    lab.apply(Edit::SetVersus(Versus::Difference));
    lab.until("both means", |lab| lab.has("Over all: mean luminance of A 0."));
    lab.apply(Edit::SetVersus(Versus::Errors));
    lab.until("the errors", |lab| lab.has("Over all: ") && lab.has("; reference: "));
    assert!(!lab.has("nothing to compare"), "two pictures of the same pixels");
}

#[test]
fn snapshots_of_other_sizes_are_aligned_and_their_pixels_read() {
    let mut lab = Lab::new();
    let stored = frame([30, 30]);
    let path = file(lab.folder.path(), "half.exr", &stored, true);
    lab.apply(Command::ComparePath(path));
    lab.until("the second picture", |lab| lab.document().slots().len() == 2);
    lab.settle();
    assert!(lab.has("Picture 2: half.exr, 30 x 30, from file, aligned"));
    let rects = lab.picture_rects();
    let geometries = |lab: &Lab| -> Vec<_> { lab.app().panes().iter().filter_map(Pane::geometry).collect() };
    let at = geometries(&lab)[0].to_screen([41.5, 33.5]);
    lab.harness.hover_at(at);
    lab.harness.run_steps(4);
    let read: Vec<_> = lab.app().panes().iter().filter_map(Pane::read).collect();
    assert_eq!(read, [[41, 33], [20, 16]], "the same place, each in its own pixels");
    let value = stored.pixel(20, 16, Channel::R).expect("inside");
    let shown = lab.app().pictures()[1].content().and_then(|content| content.value([20, 16], Channel::R));
    assert_eq!(shown, Some(value));
    assert!(lab.has("Pixel: x 20   y 16"));
    // From the file's side, too; and zoom is shared.
    let at = geometries(&lab)[1].to_screen([20.5, 16.5]);
    lab.harness.hover_at(at);
    lab.harness.run_steps(4);
    assert_eq!(lab.app().panes()[0].pixel(), Some([41, 33]), "the middle of the larger pixel");
    assert!(rects[1].contains(at));
    lab.apply(Command::ActualSize);
    lab.harness.run_steps(2);
    assert!(matches!(lab.document().view.placement, Placement::Free { .. }));
    let all = geometries(&lab);
    assert_eq!(all[1].scale, 2.0 * all[0].scale, "half the pixels, twice as large");
    let corner = |i: usize, p: [f32; 2]| all[i].to_screen(p) - all[i].viewport.min;
    assert!((corner(0, [60.0, 60.0]) - corner(1, [30.0, 30.0])).length() < 1.5, "edges lie on edges");
}

#[test]
fn what_a_file_lacks_is_said_and_what_made_it_cannot_be_changed() {
    let mut lab = Lab::new();
    let grey = lab.file("grey.exr");
    {
        use exr::prelude::*;
        let pixels = SpecificChannels::build().with_channel("Y").with_pixel_fn(|at| (at.x() as f32,));
        Image::from_channels((8, 8), pixels).write().to_file(&grey).expect("can be written");
    }
    lab.apply(Command::ComparePath(grey));
    lab.until("the second picture", |lab| lab.document().slots().len() == 2);
    lab.key(Modifiers::NONE, Key::X);
    assert!(matches!(lab.document().active().kept, Some(Kept::File(_))));
    assert!(lab.has("This picture is from a file"));
    let strategy = lab.document().active().estimator.strategy;
    lab.key(Modifiers::NONE, Key::Num1);
    assert_eq!(lab.document().active().estimator.strategy, strategy, "keys do nothing");
    assert!(lab.document().active().is_file());
    let enabled = |lab: &Lab, label: &str| !lab.harness.get_by_label(label).accesskit_node().is_disabled();
    assert!(!enabled(&lab, "1 Light") && !enabled(&lab, "Heuristic: Power"));
    lab.apply(Edit::SetLayer(Layer::Variance));
    lab.harness.run_steps(2);
    assert!(lab.has("grey.exr has no layer"), "and nothing is shown in its place");
    lab.key(Modifiers::COMMAND, Key::S);
    assert!(lab.has("Not saved: this picture is from a file"));
    // Alone it is a picture like any other.
    lab.apply(Edit::SetLayer(Layer::Picture));
    lab.key(Modifiers::NONE, Key::Escape);
    lab.harness.run_steps(2);
    assert_eq!(lab.document().slots().len(), 1);
    assert!(matches!(lab.app().live().content(), Some(Content::File(_))));
    // The other pictures go on: a layout with the file in it keeps it.
    lab.key(Modifiers::NONE, Key::Q);
    lab.settle_live();
    assert_eq!(lab.document().slots().iter().filter(|slot| slot.is_file()).count(), 1);
    assert_eq!(lab.document().slots().iter().filter(|s| s.estimator.strategy == Strategy::Light).count(), 1);
}

#[test]
fn what_cannot_be_compared_with_is_said() {
    let mut lab = Lab::new();
    let before = lab.document().clone();
    let broken = lab.file("broken.exr");
    std::fs::write(&broken, b"no picture").expect("write");
    for path in [broken, lab.file("nowhere.exr"), lab.file("small.pbrt")] {
        lab.apply(Command::ComparePath(path.clone()));
        lab.until("the complaint", |lab| lab.has(&format!("Not compared: {}", path.display())));
        assert_eq!(*lab.document(), before);
    }
}
