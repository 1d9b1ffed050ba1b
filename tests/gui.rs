//! The window, driven by label and role as a user or a screen reader would: every control once.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use mislab::look::zoom::ZoomStep;
use mislab::picture::live::LivePicture;
use mislab::picture::pane::Pane;
use mislab::state::arrangement::Arrangement;
use mislab::state::command::Command;
use mislab::state::document::{Document, Slot};
use mislab::state::edit::{Edit, SppTarget};
use mislab::state::keys::bindings;
use mislab::state::placement::Placement;
use mislab::state::prefs::{Prefs, WindowPrefs};
use mislab::state::view::ToneMap;
use mislab::{AppOptions, MisLabApp};
use mislab_renderer::State;
use mislab_renderer::pbrt::DEFAULT_SCENE;
use mislab_renderer::{Heuristic, Layer, OneSampleWeights, SamplerKind, Strategy};

use eframe::egui::accesskit::Role;
use eframe::egui::{self, Key, Modifiers};

/// The app over a small picture, in a folder of its own.
struct Lab {
    harness: Harness<'static, MisLabApp>,
    folder: tempfile::TempDir,
    /// Of the window, in points at the system's factor.
    size: [f32; 2],
}

impl Lab {
    fn new() -> Self {
        Self::with_size([1280.0, 1000.0])
    }

    fn with_size(size: [f32; 2]) -> Self {
        Self::with_prefs(size, Prefs::default())
    }

    fn with_prefs(size: [f32; 2], prefs: Prefs) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let scene = folder.path().join("small.pbrt");
        std::fs::write(&scene, small_scene()).expect("the scene can be written");
        let options = AppOptions { scene: Some(scene), threads: 1, prefs, ..AppOptions::default() };
        let harness = Harness::builder()
            .with_size(size)
            .with_max_steps(64)
            .with_step_dt(1.0 / 60.0)
            .build_eframe(move |cc| MisLabApp::new(cc, options));
        let mut lab = Self { harness, folder, size };
        lab.settle();
        lab.fit();
        lab.settle();
        lab
    }

    fn app(&self) -> &MisLabApp {
        self.harness.state()
    }

    /// What the window system does when the interface is scaled: the same window has another number of points.
    fn fit(&mut self) {
        for _ in 0..3 {
            let size = egui::Vec2::from(self.size) / self.harness.ctx.zoom_factor();
            self.harness.set_size(size);
            self.harness.step();
        }
    }

    #[track_caller]
    fn rect(&self, label: &str) -> egui::Rect {
        self.harness.get_by_label(label).rect()
    }

    /// Rests the mouse there until hints come.
    fn rest_on(&mut self, at: egui::Pos2) {
        self.harness.hover_at(at - egui::vec2(1.0, 0.0));
        self.harness.step();
        self.harness.hover_at(at);
        self.harness.run_steps(45);
    }

    /// Types into a field, as the keyboard does.
    #[track_caller]
    fn write_into(&mut self, label: &str, text: &str, then: Key) {
        self.harness.get_by_role_and_label(Role::SpinButton, label).focus();
        self.harness.run_steps(2);
        self.harness.event(egui::Event::Text(text.into()));
        self.harness.step();
        self.harness.key_press(then);
        self.harness.run_steps(3);
    }

    fn document(&self) -> &Document {
        self.app().document()
    }

    /// Steps until `done`, or fails.
    #[track_caller]
    fn until(&mut self, what: &str, done: impl Fn(&Self) -> bool) {
        let deadline = Instant::now() + Duration::from_secs(60);
        loop {
            self.harness.step();
            if done(self) {
                return;
            }
            assert!(Instant::now() < deadline, "waited in vain for {what}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Until the picture of the current settings is on screen and complete.
    #[track_caller]
    fn settle(&mut self) {
        self.until("the finished picture", |lab| {
            let document = lab.document();
            let target = document.settings(document.active()).sampling.spp.map_or(1, |n| n.get());
            lab.app().live().current_frame().is_some_and(|f| f.spp() >= target)
        });
        self.harness.step();
    }

    fn key(&mut self, modifiers: Modifiers, key: Key) {
        self.harness.key_press_modifiers(modifiers, key);
        self.harness.step();
        self.harness.step();
    }

    #[track_caller]
    fn click(&mut self, label: &str) {
        self.harness.get_by_label(label).click_accesskit();
        self.harness.step();
        self.harness.step();
    }

    #[track_caller]
    fn slide(&mut self, label: &str, value: f64) {
        self.harness.get_by_role_and_label(Role::Slider, label).set_value_accesskit(value);
        self.harness.step();
        self.harness.step();
    }

    #[track_caller]
    fn type_number(&mut self, label: &str, value: f64) {
        self.harness.get_by_role_and_label(Role::SpinButton, label).set_value_accesskit(value);
        self.harness.step();
        self.harness.step();
    }

    #[track_caller]
    fn double_click(&mut self, role: Role, label: &str) {
        let at = self.harness.get_by_role_and_label(role, label).rect().center();
        // Long after the last click, lest it count as the third.
        self.harness.run_steps(60);
        self.harness.event(egui::Event::PointerMoved(at));
        self.harness.step();
        for pressed in [true, false, true, false] {
            self.harness.event(egui::Event::PointerButton {
                pos: at,
                button: egui::PointerButton::Primary,
                pressed,
                modifiers: Modifiers::NONE,
            });
            self.harness.step();
        }
        self.harness.remove_cursor();
        self.harness.step();
    }

    fn has(&self, label: &str) -> bool {
        self.harness.query_all_by_label_contains(label).next().is_some()
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn apply(&mut self, command: impl Into<Command>) {
        let ctx = self.harness.ctx.clone();
        self.harness.state_mut().apply(&ctx, command.into());
        self.harness.step();
    }
}

/// Veach's scene, small enough for tests.
fn small_scene() -> String {
    let small = DEFAULT_SCENE.replace("[800]", "[60]").replace("[8]", "[2]");
    assert_ne!(small, DEFAULT_SCENE, "the scene file says its size otherwise");
    small
}

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
    let type_into = |lab: &mut Lab, field: &str, text: &str| {
        lab.harness.get_by_label(field).focus();
        lab.harness.run_steps(2);
        lab.key(Modifiers::COMMAND, Key::A);
        lab.harness.get_by_label(field).type_text(text);
        lab.harness.run_steps(2);
    };
    let folder = lab.file("not/yet").display().to_string();
    type_into(&mut lab, "Snapshot folder", &folder);
    lab.apply(Command::Save);
    lab.until("the error", |lab| lab.has("was not saved"));
    assert!(lab.has("there is no folder") && !lab.has(".mislab-"));
    lab.click("Create the folder and save");
    lab.until("the file", |lab| lab.file("not/yet/small_mis_all_4spp.exr").exists());
    lab.until("the end of the error", |lab| !lab.has("was not saved"));
    assert_eq!(lab.app().prefs().recent.first(), Some(&lab.file("not/yet/small_mis_all_4spp.exr")), "under Recent");

    type_into(&mut lab, "Snapshot name", "../elsewhere");
    assert!(lab.has("a name has no / in it"), "while it is typed");
    lab.apply(Command::Save);
    lab.harness.run_steps(2);
    assert!(lab.has("was not saved"));
    assert!(!lab.file("not/elsewhere.exr").exists(), "nothing leaves the folder");
    type_into(&mut lab, "Snapshot name", "elsewhere");
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
    lab.until("the error", |lab| lab.has("small.pbrt was not opened"));
    assert!(lab.has(&format!("small.pbrt:{header}:")) && lab.has(&format!("{header} | ")), "place and text");
    assert_eq!(strategy(&lab), Strategy::Light);
    assert!(lab.has("the file as it was before the error"), "the picture is marked");
    lab.key(Modifiers::NONE, Key::F5);
    assert!(lab.has("small.pbrt was not opened"), "by hand it is no better");

    // Another file put in its place, as editors do.
    let other = lab.file("small.pbrt~");
    std::fs::write(&other, text.replace("[\"mis_all\"]", "[\"bsdf\"]")).expect("write");
    std::fs::rename(&other, &scene).expect("rename");
    lab.until("the next strategy", |lab| strategy(lab) == Strategy::Bsdf);
    lab.harness.run_steps(2);
    assert!(!lab.has("was not opened"), "the error goes with its cause");
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

#[test]
fn themes() {
    let mut lab = Lab::new();
    for (name, theme) in [("Light", egui::Theme::Light), ("Dark", egui::Theme::Dark)] {
        lab.click("Menu");
        lab.harness.get_by_role_and_label(Role::Button, name).click_accesskit();
        lab.harness.run_steps(3);
        assert_eq!(lab.harness.ctx.theme(), theme);
        lab.harness.key_press(Key::Escape);
        lab.harness.run_steps(2);
    }
}

#[test]
fn the_projector_view_has_large_type() {
    let mut lab = Lab::with_size([1920.0, 1080.0]);
    assert!(lab.has("Save EXR") && lab.has("Exposure"));
    lab.key(Modifiers::COMMAND, Key::B);
    assert!(!lab.has("Exposure") && !lab.has("Sampler: Sobol"), "the panels are gone");
    assert!(lab.has("4 MIS, one") && lab.has("Caption: MIS, both"), "bar and caption stay");
    let style = lab.harness.ctx.global_style();
    assert!(style.text_styles.values().all(|font| font.size >= 24.0), "legible from the last row");
    lab.key(Modifiers::COMMAND, Key::B);
    assert!(lab.has("Exposure"));
}

#[test]
fn the_picture_is_large_even_in_a_small_window() {
    let lab = Lab::with_size([1280.0, 720.0]);
    let rect = lab.harness.get_by_role_and_label(Role::Image, "Picture").rect();
    assert!(rect.width() >= 600.0 && rect.height() >= 600.0, "{rect:?}");
}

#[test]
fn the_mouse_on_the_picture() {
    let mut lab = Lab::new();
    let picture = lab.harness.get_by_role_and_label(Role::Image, "Picture").rect();
    let side = picture.width().min(picture.height());
    let on_screen = |u: f32, v: f32| picture.center() + egui::vec2((u - 0.5) * side, (v - 0.5) * side);
    lab.harness.hover_at(on_screen(0.5, 0.5));
    lab.harness.run_steps(2);
    assert!(lab.has("Pixel: x 30   y 30"), "the value under the cursor");

    // The large light is on the left; its rim can be dragged.
    let scene = lab.document().scene.clone();
    let large = scene
        .light_shapes()
        .max_by(|a, b| Document::radius(&scene, *a).partial_cmp(&Document::radius(&scene, *b)).expect("numbers"))
        .expect("the scene has lights");
    let finder = mislab::picture::picking::Finder::new(&scene, [60, 60]);
    let [min, max] = finder.bounds(mislab::picture::picking::Target::Light(large)).expect("in front of the camera");
    let rim = on_screen(max[0] / 60.0, 0.5 * (min[1] + max[1]) / 60.0);
    let button = |pos, pressed| egui::Event::PointerButton {
        pos,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    lab.harness.hover_at(rim);
    lab.harness.run_steps(2);
    lab.harness.event(button(rim, true));
    lab.harness.step();
    for i in 1..=6 {
        lab.harness.hover_at(rim - egui::vec2(4.0 * i as f32, 0.0));
        lab.harness.step();
    }
    lab.harness.event(button(rim - egui::vec2(24.0, 0.0), false));
    lab.harness.run_steps(2);
    let radius = |lab: &Lab| Document::radius(&lab.document().scene, large).expect("a sphere");
    let original = Document::radius(&scene, large).expect("a sphere");
    assert!(radius(&lab) < 0.9 * original, "{} from {original}", radius(&lab));
    assert_eq!(lab.document().view.placement, mislab::state::placement::Placement::Fit, "the picture has not moved");
    lab.key(Modifiers::COMMAND, Key::Z);
    assert_eq!(radius(&lab), original);
}

#[test]
fn trouble_with_the_graphics_device_is_said_and_survived() {
    let device = std::sync::Arc::new(std::sync::Mutex::new(None));
    let kept = device.clone();
    let options = AppOptions { threads: 1, ..AppOptions::default() };
    let mut harness = Harness::builder().with_size([1280.0, 800.0]).wgpu().build_eframe(move |cc| {
        let state = cc.wgpu_render_state.as_ref().expect("the harness has a device");
        *kept.lock().expect("not poisoned") = Some(state.device.clone());
        MisLabApp::new(cc, options)
    });
    harness.step();
    // A buffer that cannot be mapped for reading and drawn from: the driver's error has no taker but ours.
    let device = device.lock().expect("not poisoned").take().expect("set above");
    let _ = device.create_buffer(&eframe::wgpu::BufferDescriptor {
        label: None,
        size: 16,
        usage: eframe::wgpu::BufferUsages::MAP_READ | eframe::wgpu::BufferUsages::VERTEX,
        mapped_at_creation: false,
    });
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("Drawing without the graphics device").is_some());
    assert!(harness.query_by_role_and_label(Role::Image, "Picture").is_some(), "the picture goes on");
    harness.get_by_label("Close message").click_accesskit();
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("Drawing without the graphics device").is_none());
}

#[test]
fn at_a_large_interface_scale_the_picture_stays() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    for _ in 0..5 {
        lab.apply(Command::ZoomInterface(ZoomStep::Larger));
        lab.fit();
    }
    let rect = lab.harness.get_by_role_and_label(Role::Image, "Picture").rect();
    assert!(rect.width() > 300.0 && rect.height() > 150.0, "{rect:?}");
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
fn a_scale_kept_from_a_larger_screen_leaves_the_panels() {
    let lab = Lab::with_prefs([1280.0, 720.0], Prefs { zoom: 3.0, ..Prefs::default() });
    assert!(lab.harness.ctx.zoom_factor() <= 1280.0 / 1100.0 + 1e-3, "{}", lab.harness.ctx.zoom_factor());
    assert!(lab.has("Normalise"), "the right column is there");
}

#[test]
fn type_grows_with_the_window() {
    let lab = Lab::with_size([2560.0, 1440.0]);
    assert_eq!(lab.harness.ctx.zoom_factor(), 1.4);
    let rect = lab.harness.get_by_role_and_label(Role::Image, "Picture").rect();
    assert!(1.4 * rect.height() > 1200.0, "the picture still has most of it: {rect:?}");
}

#[test]
fn steps_of_the_interface_meet_again() {
    let mut lab = Lab::with_size([2560.0, 1440.0]);
    let start = lab.harness.ctx.zoom_factor();
    for key in [Key::Plus, Key::Plus, Key::Minus, Key::Minus] {
        lab.key(Modifiers::COMMAND, key);
        lab.fit();
    }
    assert_eq!(lab.harness.ctx.zoom_factor(), start);
    assert!(lab.has("Interface 100 %"), "it says where it is");
    lab.key(Modifiers::COMMAND, Key::Plus);
    lab.fit();
    lab.click("Menu");
    assert!(lab.has("110 %") || lab.has("Interface at 100 %"));
    lab.click("Interface at 100 %");
    lab.fit();
    assert_eq!(lab.harness.ctx.zoom_factor(), start);
}

#[test]
fn one_escape_closes_one_thing() {
    let mut lab = Lab::new();
    let bad = lab.file("bad.pbrt");
    std::fs::write(&bad, "Film \"image\" \"integer xresolution\" [60\nWorldBegin\n").expect("write");
    lab.apply(Command::OpenPath(bad));
    lab.until("the error", |lab| lab.has("bad.pbrt was not opened"));
    lab.key(Modifiers::NONE, Key::T);
    lab.click("Image size of the table");
    assert!(lab.has("100 \u{d7} 100"), "the menu is open");
    lab.key(Modifiers::NONE, Key::Escape);
    assert!(!lab.has("100 \u{d7} 100") && lab.has("Fill in the table"), "first the menu");
    lab.harness.get_by_role_and_label(Role::SpinButton, "Seed").focus();
    lab.harness.run_steps(2);
    lab.key(Modifiers::NONE, Key::Escape);
    assert!(lab.has("Fill in the table"), "then the field");
    lab.key(Modifiers::NONE, Key::Escape);
    assert!(!lab.has("Fill in the table") && lab.has("was not opened"), "then the table");
    lab.key(Modifiers::NONE, Key::Escape);
    assert!(!lab.has("was not opened"), "then the message");
}

#[test]
fn the_tables_run_is_in_the_status_bar() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::T);
    lab.click("Image size of the table");
    lab.click("100 \u{d7} 100");
    lab.click("Fill in the table");
    lab.key(Modifiers::NONE, Key::Escape);
    assert!(!lab.has("Table progress"), "the window is closed");
    assert!(lab.has("Progress of the table"));
    lab.click("Stop the table");
    lab.until("the end of the job", |lab| !lab.has("Progress of the table"));
    assert!(lab.has("4 / 4 spp"), "the bar is about the picture again");
}

#[test]
fn nothing_jumps_when_weights_get_biased_or_warnings_come() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.apply(Edit::SetStrategy(Strategy::Mis));
    lab.apply(Edit::SetWeights(OneSampleWeights::Tutorial));
    lab.settle();
    let places = |lab: &Lab| {
        let spp = lab.harness.query_all_by_label_contains("4 spp").map(|node| node.rect()).next_back();
        let picture = lab.harness.get_by_role_and_label(Role::Image, "Picture").rect();
        assert!(spp.is_some(), "the caption counts");
        (lab.rect("Layer: Picture"), lab.rect("Normalise"), picture, spp)
    };
    let before = places(&lab);
    let scene = lab.document().scene.name.clone();
    let named = lab.rect(&scene);
    lab.slide("c", 1.0);
    lab.settle();
    assert!(lab.has("biased, too dark"), "it is said");
    assert_eq!(places(&lab), before);
    assert_eq!(lab.rect(&scene), named);

    let good = lab.file("good.pbrt");
    std::fs::write(&good, small_scene().replace("WorldBegin", "WorldBegin\nTwiddle 1\n")).expect("write");
    lab.apply(Command::OpenPath(good.clone()));
    lab.until("the file", |lab| lab.document().opened.path.as_deref() == Some(good.as_path()));
    lab.apply(Edit::SetStrategy(Strategy::Mis));
    lab.settle();
    assert!(lab.has("good.pbrt:"), "the warning is there");
    assert_eq!(places(&lab), before);
    lab.key(Modifiers::NONE, Key::Escape);
    assert!(!lab.has("good.pbrt:"), "put away");
    lab.click("Warnings about the scene file");
    assert!(lab.has("good.pbrt:"), "and called back");
}

#[test]
fn the_caption_stands_still_while_it_counts() {
    let mut lab = Lab::new();
    let places = |lab: &mut Lab, spp: u32| {
        lab.apply(Edit::SetSpp(SppTarget::passes(spp)));
        lab.settle();
        let mut rects: Vec<egui::Rect> = [" spp", " paths"]
            .into_iter()
            .flat_map(|what| lab.harness.query_all_by_label_contains(what).map(|node| node.rect()).collect::<Vec<_>>())
            .filter(|rect| rect.bottom() < 990.0 && rect.top() > 900.0)
            .collect();
        rects.sort_by(|a, b| (a.top(), a.left()).partial_cmp(&(b.top(), b.left())).expect("numbers"));
        rects
    };
    let nine = places(&mut lab, 9);
    assert!(nine.len() >= 3, "caption and status bar: {nine:?}");
    let caption =
        |rects: &[egui::Rect]| rects.iter().filter(|r| r.center().y < 968.0).map(|r| r.left()).collect::<Vec<_>>();
    for spp in [10, 400] {
        let other = places(&mut lab, spp);
        assert_eq!(caption(&other), caption(&nine), "at {spp} spp");
    }
}

#[test]
fn the_caption_names_the_scene() {
    let lab = Lab::new();
    let name = lab.document().scene.name.clone();
    assert!(!name.is_empty() && lab.has(&name), "{name}");
}

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
    let at = lab.rect("Layer: Variance of one sample").center();
    lab.rest_on(at);
    assert!(lab.has("In the EXR file: variance.Y"));
    lab.key(Modifiers::NONE, Key::Num1);
    lab.harness.run_steps(30);
    assert!(!lab.has("In the EXR file: variance.Y"), "eyes are on the picture");
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
fn the_projector_view_gives_the_picture_the_whole_height() {
    for size in [[1280.0, 720.0], [1920.0, 1080.0], [2560.0, 1440.0]] {
        let mut lab = Lab::with_size(size);
        lab.key(Modifiers::COMMAND, Key::B);
        lab.fit();
        lab.settle();
        let zoom = lab.harness.ctx.zoom_factor();
        let rect = lab.harness.get_by_role_and_label(Role::Image, "Picture").rect() * zoom;
        assert!(rect.height() > size[1] - 1.0 && rect.width() > size[1] - 1.0, "{size:?}: {rect:?}");
        let body = lab.harness.ctx.global_style().text_styles[&egui::TextStyle::Body].size * zoom;
        assert!((26.0..30.0).contains(&(size[1] / body)), "{size:?}: type of {body}");
        assert!(lab.has("Formula: ") && lab.has("Caption: ") && lab.has("Layer menu"));
        lab.click("Layer menu");
        lab.click("Share of the light technique");
        assert_eq!(lab.document().active().layer, Layer::ShareLight);
        assert!(lab.has("Legend: Share of the light technique"));
    }
}

#[test]
fn nothing_is_larger_than_the_window_of_a_projector() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.key(Modifiers::COMMAND, Key::B);
    lab.fit();
    let window =
        egui::Rect::from_min_size(egui::Pos2::ZERO, egui::Vec2::from(lab.size) / lab.harness.ctx.zoom_factor());
    lab.key(Modifiers::SHIFT, Key::Questionmark);
    lab.harness.run_steps(3);
    assert!(window.contains_rect(lab.rect("Close")), "the keys can be put away");
    lab.click("Close");
    lab.key(Modifiers::NONE, Key::T);
    lab.click("Image size of the table");
    lab.click("100 \u{d7} 100");
    lab.click("Fill in the table");
    lab.until("the table", |lab| lab.has("small light"));
    lab.harness.run_steps(5);
    for head in ["broad BSDF", "sharp BSDF", "Strategy, file", "veachMIS_MIS.exr"] {
        assert!(window.contains_rect(lab.rect(head)), "{head} at {:?}", lab.rect(head));
    }
}

#[test]
fn plates_and_lights_can_fill_the_view() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.key(Modifiers::COMMAND, Key::B);
    lab.fit();
    lab.key(Modifiers::SHIFT, Key::F);
    lab.apply(Edit::SetLayer(Layer::ShareLight));
    lab.settle();
    let Placement::Part([min, max]) = lab.document().view.placement else { panic!("not a part") };
    assert!(max[1] - min[1] < 60.0, "the rest is cut off: {min:?} to {max:?}");
    let picture = lab.harness.get_by_role_and_label(Role::Image, "Picture: Share of the light technique").rect();
    for label in ["4 MIS, one", "Layer menu", "Menu", "c value"] {
        let rect = lab.rect(label);
        assert!(
            rect.left() >= 0.0 && rect.right() <= picture.left(),
            "{label} at {rect:?}, the picture at {picture:?}"
        );
    }
    lab.key(Modifiers::NONE, Key::F);
    assert_eq!(lab.document().view.placement, Placement::Fit);
}

#[test]
fn the_status_bar_never_runs_under_its_button() {
    for width in [480.0, 640.0, 960.0, 1280.0, 2000.0] {
        let lab = Lab::with_size([width, 400.0]);
        let save = lab.rect("Save EXR");
        let nodes = lab.harness.query_all_by_role(Role::Label);
        let row: Vec<egui::Rect> =
            nodes.map(|node| node.rect()).filter(|rect| (rect.center().y - save.center().y).abs() < 4.0).collect();
        assert!(!row.is_empty(), "{width}: there is something in the bar");
        for rect in row {
            assert!(!rect.intersects(save), "{width}: {rect:?} under {save:?}");
        }
    }
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

#[test]
fn the_legend_marks_the_number_under_the_mouse() {
    let mut lab = Lab::new();
    lab.apply(Edit::SetLayer(Layer::Variance));
    lab.settle();
    let at = lab.harness.query_all_by_label_contains("Picture: Variance").next().expect("the picture").rect().center();
    lab.harness.hover_at(at);
    lab.harness.run_steps(3);
    assert!(lab.has("hatched: undefined, marked: "));
    // With the right column and without.
    for _ in 0..2 {
        let legend = lab.harness.query_all_by_label_contains("Legend: ").next().expect("a legend").rect();
        let picture = lab.harness.query_all_by_label_contains("Picture: Variance").next().expect("the picture").rect();
        assert!(!legend.intersects(picture), "off the picture: {legend:?}");
        lab.apply(Command::ToggleInspector);
        lab.harness.run_steps(2);
    }
}

#[test]
fn equal_channels_are_one_number() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::Num1);
    lab.apply(Edit::SetLayer(Layer::Bsdf));
    lab.settle();
    let at = lab.harness.query_all_by_label_contains("Picture: BSDF").next().expect("the picture").rect().center();
    lab.harness.hover_at(at);
    lab.harness.run_steps(2);
    assert!(lab.has("R = G = B  0.0000"));
}

#[test]
fn clipped_pixels_can_be_marked() {
    let mut lab = Lab::new();
    assert!(lab.has("% clipped") || lab.has("nothing clipped"), "the histogram says how many");
    let generation = lab.app().live().generation();
    lab.click("mark clipped pixels");
    assert!(lab.document().view.mark_clipped);
    assert_eq!(lab.app().live().generation(), generation, "only the view");
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
fn the_interface_can_be_enlarged() {
    let mut lab = Lab::new();
    lab.key(Modifiers::COMMAND, Key::Plus);
    assert!(lab.harness.ctx.zoom_factor() > 1.05);
    lab.key(Modifiers::COMMAND, Key::Minus);
    assert_eq!(lab.harness.ctx.zoom_factor(), 1.0);
}

#[test]
fn the_table_is_filled_in_and_can_be_stopped() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::T);
    lab.click("Image size of the table");
    lab.click("100 \u{d7} 100");
    lab.click("Fill in the table");
    lab.until("the job", |lab| lab.has("Cancel"));
    lab.click("Cancel");
    lab.until("the end of the job", |lab| !lab.has("Cancel"));
    assert!(!lab.has("small light"), "a stopped job leaves nothing");
    lab.click("Fill in the table");
    lab.until("the table", |lab| lab.has("small light"));
    assert!(lab.has("\u{d7}  "), "there are crosses");
    lab.click(".csv");
    lab.until("the file", |lab| lab.file("veach_table.csv").exists());
}

impl Lab {
    /// Until the pictures of all slots are on screen and complete.
    #[track_caller]
    fn settle_all(&mut self) {
        self.until("all pictures", |lab| {
            let document = lab.document();
            let done = |(slot, live): (&Slot, &LivePicture)| {
                let target = document.settings(slot).sampling.spp.map_or(1, |n| n.get());
                live.current_frame().is_some_and(|f| f.spp() >= target)
            };
            document.slots().len() == lab.app().pictures().len()
                && document.slots().iter().zip(lab.app().pictures()).all(done)
        });
        self.harness.step();
    }

    fn click_at(&mut self, at: egui::Pos2) {
        // Not the second of two clicks.
        self.harness.run_steps(60);
        for pressed in [true, false] {
            let (button, modifiers) = (egui::PointerButton::Primary, Modifiers::NONE);
            self.harness.event(egui::Event::PointerMoved(at));
            self.harness.event(egui::Event::PointerButton { pos: at, button, pressed, modifiers });
            self.harness.step();
        }
        self.harness.step();
    }

    fn strategies(&self) -> Vec<Strategy> {
        self.document().slots().iter().map(|slot| slot.estimator.strategy).collect()
    }

    /// Where the pictures are, in their order.
    fn picture_rects(&self) -> Vec<egui::Rect> {
        let mut all: Vec<_> = self.harness.query_all_by_label("Picture").map(|node| node.rect()).collect();
        all.sort_by(|a, b| (a.top(), a.left()).partial_cmp(&(b.top(), b.left())).expect("finite"));
        all
    }
}

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
fn every_key_is_on_the_sheet() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.key(Modifiers::NONE, Key::Questionmark);
    for action in bindings() {
        assert!(lab.has(&action.name), "{} ({})", action.name, action.keys);
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
