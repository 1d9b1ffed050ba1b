//! Files: opening, watching, saving, what is kept between runs.

use eframe::egui::{self, Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use mislab::state::command::Command;
use mislab::state::edit::{Edit, SppTarget};
use mislab::state::prefs::WindowPrefs;
use mislab::{AppOptions, MisLabApp};
use mislab_renderer::{Layer, Strategy};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::lab::{Lab, small_scene};

#[test]
fn snapshots_restore_everything() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::Num4);
    lab.slide("c", 0.3);
    lab.slide("plate2", 0.15);
    lab.apply(Edit::SetLayer(Layer::ShareLight));
    lab.apply(Edit::SetExposure(1.5));
    lab.click("PNG of the view");
    lab.settle();
    let saved = lab.document().clone();
    let pixels = lab.app().live().current_frame().expect("settled").channel(mislab_renderer::Channel::R);
    lab.key(Modifiers::COMMAND, Key::S);
    lab.until("the file", |lab| lab.has("Saved small_mis_4spp.exr and its PNG in"));
    assert!(lab.file("small_mis_4spp.exr").exists() && lab.file("small_mis_4spp.png").exists());
    lab.click("Save snapshot");
    lab.until("the second file", |lab| lab.file("small_mis_4spp_2.exr").exists());

    lab.apply(Command::OpenShipped(mislab::state::command::Shipped::VeachPlastic));
    lab.apply(Edit::SetSpp(SppTarget::passes(1)));
    lab.apply(Command::OpenPath(lab.file("small_mis_4spp.exr")));
    lab.until("the snapshot", |lab| lab.document().opened.path == Some(lab.file("small_mis_4spp.exr")));
    assert_eq!(lab.document().slots(), saved.slots());
    assert_eq!((lab.document().sampling(), lab.document().image), (saved.sampling(), saved.image));
    assert_eq!(lab.document().scene, saved.scene);
    assert_eq!(lab.document().active().layer, Layer::ShareLight);
    assert_eq!(lab.document().view.exposure_ev, 1.5);
    lab.settle();
    let again = lab.app().live().current_frame().expect("settled").channel(mislab_renderer::Channel::R);
    assert!(pixels.iter().zip(&again).all(|(a, b)| a.to_bits() == b.to_bits()), "the same bits again");
}

#[test]
fn a_bad_file_leaves_the_picture() {
    let mut lab = Lab::new();
    let bad = lab.file("bad.pbrt");
    std::fs::write(&bad, "Film \"image\" \"integer xresolution\" [60\nWorldBegin\n").expect("write");
    let before = lab.document().clone();
    lab.apply(Command::OpenPath(bad));
    lab.until("the error", |lab| lab.has("bad.pbrt was not opened"));
    assert!(lab.has("bad.pbrt:"), "the message has the place");
    assert_eq!(*lab.document(), before);
    assert!(lab.app().live().current_frame().is_some(), "the picture stays");

    let good = lab.file("good.pbrt");
    let text = small_scene().replace("WorldBegin", "WorldBegin\nTwiddle 1\n");
    std::fs::write(&good, text).expect("write");
    lab.apply(Command::OpenPath(good.clone()));
    lab.until("the good file", |lab| lab.document().opened.path.as_deref() == Some(good.as_path()));
    lab.harness.step();
    assert!(!lab.has("was not opened"), "the error goes with its cause");
    assert!(lab.has("1 warning about the scene file") && lab.has("good.pbrt:"), "the warning has its place");
    assert_eq!(lab.app().prefs().recent.first(), Some(&good));
    lab.key(Modifiers::COMMAND, Key::Z);
    assert_eq!(*lab.document(), before, "opening is undone like anything else");
}

/// An EXR that another program could have written: one of ours, without a word of ours.
fn foreign(folder: &Path) -> PathBuf {
    let file = mislab_renderer::pbrt::embedded_scene();
    let mut settings = file.settings;
    settings.image.resolution = [40, 30];
    settings.sampling.spp = std::num::NonZeroU32::new(2);
    let request = mislab_renderer::Request { scene: file.scene.into(), settings };
    let frame = mislab_renderer::render(&request, 1, &mut |_| true).expect("renders");
    let contents = mislab_renderer::snapshot::Contents::from_frame(&frame);
    let (mut bytes, _) = contents.encode(&Default::default()).expect("encodes");
    for name in ["mislabSettings", "mislabFormat"] {
        let at = bytes.windows(name.len()).position(|w| w == name.as_bytes()).expect("an attribute of ours");
        bytes[at..at + 6].copy_from_slice(b"others");
    }
    let path = folder.join("foreign.exr");
    std::fs::write(&path, bytes).expect("write");
    path
}

#[test]
fn a_picture_of_another_program_is_looked_at_and_the_lesson_stays() {
    let mut lab = Lab::new();
    let path = foreign(lab.folder.path());
    let before = lab.document().clone();
    lab.apply(Command::OpenPath(path.clone()));
    lab.until("the picture", |lab| lab.has("Made by another program"));
    lab.harness.step();
    assert_eq!(*lab.document(), before);
    for text in
        ["data: 40 x 30 at (0 0)", "display: 40 x 30 at (0 0)", "RGB in colour", "light.R  FLOAT", "strategy: mis_all"]
    {
        assert!(lab.has(text), "{text}");
    }
    assert!(!lab.has("was not opened"));
    lab.click("variance.Y  FLOAT");
    lab.slide("File exposure", 2.0);
    lab.harness.run_steps(3);
    assert_eq!(*lab.document(), before, "it is looked at by itself");
    assert_eq!(lab.app().prefs().recent.first(), Some(&path));
    lab.key(Modifiers::NONE, Key::Escape);
    assert!(!lab.has("Made by another program"));
    assert!(lab.app().live().current_frame().is_some(), "the live picture is where it was");
}

/// Named on the command line as well.
#[test]
fn a_picture_of_another_program_may_be_there_from_the_start() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let options = AppOptions { scene: Some(foreign(folder.path())), threads: 1, ..AppOptions::default() };
    let size = [1280.0, 1000.0];
    let harness =
        Harness::builder().with_size(size).with_max_steps(64).build_eframe(move |cc| MisLabApp::new(cc, options));
    let mut lab = Lab { harness, folder, size };
    lab.until("the picture", |lab| lab.has("Made by another program"));
    lab.harness.step();
    assert!(!lab.has("was not opened"));
}

#[test]
fn a_long_name_leaves_room_for_the_reason() {
    let mut lab = Lab::new();
    let bad = lab.file(&format!("{}.pbrt", "n".repeat(240)));
    std::fs::write(&bad, "Film \"image\" \"integer xresolution\" [60\nWorldBegin\n").expect("write");
    lab.apply(Command::OpenPath(bad));
    lab.until("the error", |lab| lab.has("was not opened"));
    lab.harness.run_steps(2);
    let message = lab.harness.get_by_label_contains("expected a number");
    let text = message.accesskit_node().value().or(message.accesskit_node().label()).unwrap_or_default();
    assert!(text.chars().count() < 200, "{text}");
}

#[test]
fn a_path_can_be_typed() {
    let mut lab = Lab::new();
    let other = lab.file("other.pbrt");
    std::fs::write(&other, small_scene()).expect("write");
    lab.key(Modifiers::COMMAND | Modifiers::SHIFT, Key::O);
    lab.harness.step();
    lab.harness.get_by_label("Path").focus();
    lab.harness.step();
    lab.harness.get_by_label("Path").type_text(&other.display().to_string());
    lab.harness.step();
    lab.harness.key_press(Key::Enter);
    lab.until("the file", |lab| lab.document().opened.path.as_deref() == Some(other.as_path()));
    assert_eq!(
        lab.document().active().estimator.strategy,
        Strategy::MisAll,
        "digits of the path are not keys of strategies"
    );
}

#[test]
fn a_dropped_file_is_opened() {
    let mut lab = Lab::new();
    let other = lab.file("dropped.pbrt");
    std::fs::write(&other, small_scene()).expect("write");
    lab.harness.input_mut().dropped_files.push(std::sync::Arc::new(Dropped(other.clone())));
    lab.harness.step();
    lab.until("the file", |lab| lab.document().opened.path.as_deref() == Some(other.as_path()));
}

/// What the window system hands over when a file is dropped.
#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|e| e.to_string())
    }
}

#[test]
fn of_two_dropped_files_the_second_is_not_ignored_in_silence() {
    let mut lab = Lab::new();
    let (one, two) = (lab.file("one.pbrt"), lab.file("two.pbrt"));
    for path in [&one, &two] {
        std::fs::write(path, small_scene()).expect("write");
        lab.harness.input_mut().dropped_files.push(std::sync::Arc::new(Dropped(path.clone())));
    }
    lab.harness.step();
    lab.until("the first file", |lab| lab.document().opened.path.as_deref() == Some(one.as_path()));
    assert!(lab.has("One file at a time: one.pbrt is opened, not two.pbrt."));
}

#[test]
fn saves_close_together_are_all_there() {
    let mut lab = Lab::new();
    lab.click("PNG of the view");
    lab.harness.run_steps(2);
    for _ in 0..3 {
        lab.apply(Command::Save);
    }
    assert!(lab.has("Saving small_mis_all_4spp"), "what is being done is on screen");
    lab.until("all of them", |lab| !lab.has("Saving "));
    for n in ["", "_2", "_3"] {
        for extension in ["exr", "png"] {
            assert!(lab.file(&format!("small_mis_all_4spp{n}.{extension}")).exists(), "{n}.{extension}");
        }
    }
    assert!(lab.has("Saved small_mis_all_4spp_3.exr and its PNG in"));
}

#[test]
fn closing_finishes_what_is_being_saved() {
    let mut lab = Lab::new();
    lab.apply(Command::Save);
    lab.apply(Command::Save);
    let close = |lab: &mut Lab| {
        let root = lab.harness.input_mut().viewports.entry(egui::ViewportId::ROOT).or_default();
        root.events.push(egui::ViewportEvent::Close);
        lab.harness.step();
        lab.harness.output().viewport_output[&egui::ViewportId::ROOT].commands.clone()
    };
    // On a fast disk it may be done already.
    if lab.has("Saving ") {
        assert!(close(&mut lab).contains(&egui::ViewportCommand::CancelClose), "it waits");
    }
    // Closed without asking, as by the end of a session.
    let Lab { harness, folder, .. } = lab;
    drop(harness);
    for name in ["small_mis_all_4spp.exr", "small_mis_all_4spp_2.exr"] {
        assert!(folder.path().join(name).exists(), "{name}");
    }
}

#[test]
fn what_cannot_be_saved_is_said_with_a_way_out_and_goes_with_its_cause() {
    let mut lab = Lab::new();
    let folder = lab.file("not/yet").display().to_string();
    lab.type_over("Snapshot folder", &folder);
    lab.apply(Command::Save);
    lab.until("the error", |lab| lab.has("was not saved"));
    assert!(lab.has("there is no folder") && !lab.has(".mislab-"));
    lab.click("Create the folder and save");
    lab.until("the file", |lab| lab.file("not/yet/small_mis_all_4spp.exr").exists());
    lab.until("the end of the error", |lab| !lab.has("was not saved"));
    assert_eq!(lab.app().prefs().recent.first(), Some(&lab.file("not/yet/small_mis_all_4spp.exr")), "under Recent");

    lab.type_over("Snapshot name", "../elsewhere");
    assert!(lab.has("a name has no / in it"), "while it is typed");
    lab.apply(Command::Save);
    lab.harness.run_steps(2);
    assert!(lab.has("was not saved"));
    assert!(!lab.file("not/elsewhere.exr").exists(), "nothing leaves the folder");
    lab.type_over("Snapshot name", "elsewhere");
    assert!(!lab.has("a name has no / in it") && !lab.has("was not saved"), "the error goes with its cause");
    lab.apply(Command::Save);
    lab.until("the file", |lab| lab.file("not/yet/elsewhere.exr").exists());

    // Both belong to the scene.
    let other = lab.file("other.pbrt");
    std::fs::write(&other, small_scene()).expect("write");
    lab.apply(Command::OpenPath(other.clone()));
    lab.until("the file", |lab| lab.document().opened.path.as_deref() == Some(other.as_path()));
    lab.apply(Edit::SetStrategy(Strategy::Light));
    lab.settle();
    lab.apply(Command::Save);
    lab.until("the file", |lab| lab.file("other_light_4spp.exr").exists());
    lab.until("the confirmation", |lab| lab.has("Saved other_light_4spp.exr in "));
    assert!(lab.has("Show in folder"));
    lab.click("Copy path");
    let path = lab.file("other_light_4spp.exr").display().to_string();
    assert!(lab.has("The path is on the clipboard"), "{path}");
}

#[test]
fn a_scene_that_is_edited_is_read_again() {
    let mut lab = Lab::new();
    let scene = lab.file("small.pbrt");
    let strategy = |lab: &Lab| lab.document().active().estimator.strategy;
    lab.apply(Edit::SetExposure(1.0));
    lab.apply(Edit::SetLayer(Layer::ShareLight));
    lab.key(Modifiers::COMMAND, Key::Num0);
    let view = lab.document().view.clone();
    assert_eq!(strategy(&lab), Strategy::MisAll);

    // Written in place.
    let text = std::fs::read_to_string(&scene).expect("the scene");
    let header = text.lines().position(|line| line.contains("[\"mis_all\"]")).expect("the header") + 1;
    let light = text.replace("[\"mis_all\"]", "[\"light\"]");
    assert_ne!(light, text);
    std::fs::write(&scene, &light).expect("write");
    lab.until("the new strategy", |lab| strategy(lab) == Strategy::Light);
    lab.harness.run_steps(2);
    assert!(lab.has(&format!("small.pbrt was read again. Changed: line {header}.")), "which lines");
    assert_eq!(
        (&lab.document().view, lab.document().active().layer),
        (&view, Layer::ShareLight),
        "looked at as before"
    );

    // An error: the picture stays, is marked, and the message has place and text.
    std::fs::write(&scene, light.replace("[\"light\"]", "[\"light\" 3 \"x\"")).expect("write");
    lab.until("the error", |lab| lab.has("small.pbrt has an error"));
    assert!(lab.has(&format!("small.pbrt:{header}:")) && lab.has(&format!("{header} | ")), "place and text");
    assert_eq!(strategy(&lab), Strategy::Light);
    assert!(lab.has("the file as it was before the error"), "the picture is marked");
    lab.key(Modifiers::NONE, Key::F5);
    assert!(lab.has("small.pbrt has an error"), "by hand it is no better");

    // Another file put in its place, as editors do.
    let other = lab.file("small.pbrt~");
    std::fs::write(&other, text.replace("[\"mis_all\"]", "[\"bsdf\"]")).expect("write");
    std::fs::rename(&other, &scene).expect("rename");
    lab.until("the next strategy", |lab| strategy(lab) == Strategy::Bsdf);
    lab.harness.run_steps(2);
    assert!(!lab.has("small.pbrt has an error"), "the error goes with its cause");
    lab.key(Modifiers::COMMAND, Key::Z);
    assert_eq!(strategy(&lab), Strategy::Light, "and it can be undone");
    lab.key(Modifiers::NONE, Key::F5);
    lab.until("the file again", |lab| strategy(lab) == Strategy::Bsdf);
}

#[test]
fn what_a_scene_includes_is_watched_too() {
    let mut lab = Lab::new();
    let (main, part) = (lab.file("main.pbrt"), lab.file("part.pbrt"));
    let text = small_scene();
    let (header, world) = text.split_at(text.find("WorldBegin").expect("a world") + "WorldBegin".len());
    std::fs::write(&main, format!("{header}\nInclude \"part.pbrt\"\n")).expect("write");
    lab.apply(Command::OpenPath(main.clone()));
    lab.until("the scene", |lab| lab.document().opened.path.as_deref() == Some(main.as_path()));
    let warnings = &lab.document().opened.warnings;
    assert!(warnings.iter().any(|warning| warning.message.contains("part.pbrt")), "the part is missing: {warnings:?}");
    assert!(lab.document().scene.shapes.is_empty());
    std::fs::write(&part, world).expect("write");
    lab.until("the part", |lab| lab.document().scene.material("plate2").is_some());
    assert!(lab.document().opened.warnings.is_empty());
    std::fs::write(&part, world.replace("0.02", "0.03")).expect("write");
    lab.until("the edit", |lab| lab.document().scene.material("plate2").and_then(|m| m.bsdf.alpha()) == Some(0.03));
    lab.harness.run_steps(2);
    assert!(lab.has("of part.pbrt"), "which file");
}

#[test]
fn what_was_kept_is_checked_and_written_long_before_the_end() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("preferences.json");
    std::fs::write(&path, r#"{"window": {"size": [1e30, -4]}, "zoom": 1e9, "inspector": false}"#).expect("write");
    let (prefs, remark) = mislab::files::kept::load(&path);
    let options = AppOptions { threads: 1, prefs, remark, prefs_file: Some(path.clone()), ..AppOptions::default() };
    let mut harness = Harness::builder().with_size([1280.0, 800.0]).build_eframe(move |cc| MisLabApp::new(cc, options));
    harness.step();
    assert!(harness.query_by_label_contains("could not be used: ").is_some(), "said once");
    assert!(!harness.state().prefs().inspector, "the rest is kept");
    assert_eq!(harness.state().prefs().window, WindowPrefs::default(), "columns neither grow nor shrink by being kept");
    let written = |harness: &mut Harness<'static, MisLabApp>, word: &str| {
        let deadline = Instant::now() + Duration::from_secs(20);
        while !std::fs::read_to_string(&path).is_ok_and(|text| text.contains(word)) {
            assert!(Instant::now() < deadline, "{word} is written without the program being closed");
            harness.step();
            std::thread::sleep(Duration::from_millis(20));
        }
        assert_eq!(mislab::files::kept::load(&path).1, None, "and there is nothing to be said the next time");
    };
    written(&mut harness, "\"zoom\": 1.0");
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, Command::ToggleInspector);
    written(&mut harness, "\"inspector\": true");
}

/// What is hatched in one picture is worked out for its size.
#[test]
fn a_file_with_another_size_is_shown() {
    // Without the thread that works out layers the window does it itself, and nothing would be seen of a panic.
    static FAILED: AtomicBool = AtomicBool::new(false);
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        FAILED.fetch_or(std::thread::current().name() == Some("layers"), Ordering::Relaxed);
        hook(info);
    }));
    let mut lab = Lab::new();
    lab.apply(Edit::SetSpp(SppTarget::Endless));
    for (name, side) in [("large.pbrt", 90), ("small.pbrt", 30), ("large.pbrt", 90)] {
        let file = lab.file(name);
        std::fs::write(&file, small_scene().replace("[60]", &format!("[{side}]"))).expect("write");
        lab.apply(Command::OpenPath(file));
        let spp = |lab: &Lab| {
            let frame = lab.app().live().current_frame()?;
            (frame.bounds().area() == side * side).then(|| frame.spp())
        };
        lab.until("the other size", |lab| spp(lab).is_some());
        lab.apply(Edit::SetSpp(SppTarget::Endless));
        let before = spp(&lab);
        lab.until("more samples", |lab| spp(lab) > before);
    }
    assert!(!FAILED.load(Ordering::Relaxed), "layers are worked out");
}
