//! The app over a small picture, and what a user does with it.

use eframe::egui::accesskit::Role;
use eframe::egui::{self, Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use mislab::picture::live::LivePicture;
use mislab::state::command::Command;
use mislab::state::document::{Document, Slot};
use mislab::state::prefs::Prefs;
use mislab::{AppOptions, MisLabApp};
use mislab_renderer::Strategy;
use mislab_renderer::pbrt::DEFAULT_SCENE;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// The app over a small picture, in a folder of its own.
pub struct Lab {
    pub harness: Harness<'static, MisLabApp>,
    pub folder: tempfile::TempDir,
    /// Of the window, in points at the system's factor.
    pub size: [f32; 2],
}

impl Lab {
    pub fn new() -> Self {
        Self::with_size([1280.0, 1000.0])
    }

    pub fn with_size(size: [f32; 2]) -> Self {
        Self::with_prefs(size, Prefs::default())
    }

    pub fn with_prefs(size: [f32; 2], prefs: Prefs) -> Self {
        Self::with_options(size, AppOptions { prefs, ..AppOptions::default() })
    }

    pub fn with_options(size: [f32; 2], options: AppOptions) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let scene = folder.path().join("small.pbrt");
        std::fs::write(&scene, small_scene()).expect("the scene can be written");
        let options = AppOptions { scene: Some(scene), threads: 1, ..options };
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

    pub fn app(&self) -> &MisLabApp {
        self.harness.state()
    }

    /// What the window system does when the interface is scaled: the same window has another number of points.
    pub fn fit(&mut self) {
        for _ in 0..3 {
            let size = egui::Vec2::from(self.size) / self.harness.ctx.zoom_factor();
            self.harness.set_size(size);
            self.harness.step();
        }
    }

    #[track_caller]
    pub fn rect(&self, label: &str) -> egui::Rect {
        self.harness.get_by_label(label).rect()
    }

    /// Rests the mouse there until hints come.
    pub fn rest_on(&mut self, at: egui::Pos2) {
        self.harness.hover_at(at - egui::vec2(1.0, 0.0));
        self.harness.step();
        self.harness.hover_at(at);
        self.harness.run_steps(45);
    }

    /// Types a text in place of what a field holds, as the keyboard does, and stays in the field.
    #[track_caller]
    pub fn type_over(&mut self, field: &str, text: &str) {
        self.harness.get_by_label(field).focus();
        self.harness.run_steps(2);
        self.key(Modifiers::COMMAND, Key::A);
        self.harness.event(egui::Event::Text(text.into()));
        self.harness.run_steps(3);
    }

    /// Types into a number's field, as the keyboard does.
    #[track_caller]
    pub fn write_into(&mut self, label: &str, text: &str, then: Key) {
        self.harness.get_by_role_and_label(Role::SpinButton, label).focus();
        self.harness.run_steps(2);
        self.harness.event(egui::Event::Text(text.into()));
        self.harness.step();
        self.harness.key_press(then);
        self.harness.run_steps(3);
    }

    pub fn document(&self) -> &Document {
        self.app().document()
    }

    /// Steps until `done`, or fails.
    #[track_caller]
    pub fn until(&mut self, what: &str, done: impl Fn(&Self) -> bool) {
        // A bound on failures alone: a table of checked kernels on a busy machine takes more than a minute.
        let deadline = Instant::now() + Duration::from_secs(240);
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
    pub fn settle(&mut self) {
        self.until("the finished picture", |lab| {
            let document = lab.document();
            let target = document.settings(document.active()).sampling.spp.map_or(1, |n| n.get());
            let live = lab.app().live();
            live.current_frame().is_some_and(|f| f.spp() >= target) && !live.is_coming()
        });
        self.harness.step();
    }

    pub fn key(&mut self, modifiers: Modifiers, key: Key) {
        self.harness.key_press_modifiers(modifiers, key);
        self.harness.step();
        self.harness.step();
    }

    #[track_caller]
    pub fn click(&mut self, label: &str) {
        self.harness.get_by_label(label).click_accesskit();
        self.harness.step();
        self.harness.step();
    }

    #[track_caller]
    pub fn slide(&mut self, label: &str, value: f64) {
        self.harness.get_by_role_and_label(Role::Slider, label).set_value_accesskit(value);
        self.harness.step();
        self.harness.step();
    }

    #[track_caller]
    pub fn type_number(&mut self, label: &str, value: f64) {
        self.harness.get_by_role_and_label(Role::SpinButton, label).set_value_accesskit(value);
        self.harness.step();
        self.harness.step();
    }

    #[track_caller]
    pub fn double_click(&mut self, role: Role, label: &str) {
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

    pub fn has(&self, label: &str) -> bool {
        self.harness.query_all_by_label_contains(label).next().is_some()
    }

    pub fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn apply(&mut self, command: impl Into<Command>) {
        let ctx = self.harness.ctx.clone();
        self.harness.state_mut().apply(&ctx, command.into());
        self.harness.step();
    }
}

impl Lab {
    /// Until the pictures of all slots are on screen and complete.
    #[track_caller]
    pub fn settle_all(&mut self) {
        self.until("all pictures", |lab| {
            let document = lab.document();
            let done = |(slot, live): (&Slot, &LivePicture)| {
                let target = document.settings(slot).sampling.spp.map_or(1, |n| n.get());
                live.current_frame().is_some_and(|f| f.spp() >= target) && !live.is_coming()
            };
            document.slots().len() == lab.app().pictures().len()
                && document.slots().iter().zip(lab.app().pictures()).all(done)
        });
        self.harness.step();
    }

    /// The same, of those that are rendered.
    #[track_caller]
    pub fn settle_live(&mut self) {
        self.until("all live pictures", |lab| {
            let document = lab.document();
            let done = |(slot, live): (&Slot, &LivePicture)| {
                let target = document.settings(slot).sampling.spp.map_or(1, |n| n.get());
                let here = |spp| spp >= target && !live.is_coming();
                slot.kept.is_some() || live.current_frame().is_some_and(|f| here(f.spp()))
            };
            document.slots().iter().zip(lab.app().pictures()).all(done)
        });
        self.harness.step();
    }

    pub fn click_at(&mut self, at: egui::Pos2) {
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

    pub fn strategies(&self) -> Vec<Strategy> {
        self.document().slots().iter().map(|slot| slot.estimator.strategy).collect()
    }

    /// Where the pictures are, in their order.
    pub fn picture_rects(&self) -> Vec<egui::Rect> {
        let mut all: Vec<_> = self.harness.query_all_by_label("Picture").map(|node| node.rect()).collect();
        all.sort_by(|a, b| (a.top(), a.left()).partial_cmp(&(b.top(), b.left())).expect("finite"));
        all
    }
}

/// Veach's scene, small enough for tests.
pub fn small_scene() -> String {
    let small = DEFAULT_SCENE.replace("[800]", "[60]").replace("[8]", "[2]");
    assert_ne!(small, DEFAULT_SCENE, "the scene file says its size otherwise");
    small
}
