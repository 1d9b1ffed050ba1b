//! The window as a program: how it starts, what every command does, and what happens in each pass.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use eframe::egui::{self, Context, ViewportCommand};
use eframe::egui_wgpu::RenderState;
use mislab_renderer::Pace;

use crate::files::FileEvent;
use crate::files::opening::{read, shipped};
use crate::files::saving::SaveJob;
use crate::lab::Lab;
use crate::layout::window_ui;
use crate::look::theme::{self, TypeScale};
use crate::look::zoom::{self, ZoomStep};
use crate::panel::hint;
use crate::panel::messages::OpenError;
use crate::panel::number;
use crate::panel::open::OpenSheet;
use crate::panel::palette::Palette;
use crate::picture::live::LivePicture;
use crate::picture::normalise::normalise;
use crate::picture::picking::things;
use crate::picture::pixel::Pixel;
use crate::picture::planes::Planes;
use crate::picture::still::render_to_rgba8;
use crate::state::command::{Command, Shipped};
use crate::state::document::{Document, Opened};
use crate::state::history::EditKey;
use crate::state::keys;
use crate::state::pacing::Pacing;
use crate::state::placement::Placement;
use crate::state::prefs::Prefs;
use crate::state::presses::Presses;
use crate::state::view::StoredView;

/// How the app is started.
#[derive(Clone, Debug, Default)]
pub struct AppOptions {
    /// The scene or snapshot to open; `None` is Veach's scene.
    pub scene: Option<PathBuf>,
    /// Worker threads; 0 is one per core.
    pub threads: usize,
    /// Settings of the window, instead of those kept from the last run.
    pub prefs: Option<Prefs>,
}

/// What the graphics driver reported, from whatever thread.
type GpuTrouble = Arc<Mutex<Option<String>>>;

/// The app.
pub struct MisLabApp {
    lab: Lab,
    gpu_trouble: GpuTrouble,
    title: String,
}

impl MisLabApp {
    /// Key of [`Prefs`] in the window library's storage.
    const STORAGE_KEY: &'static str = "mislab";

    /// Starts the workers on the first picture.
    pub fn new(cc: &eframe::CreationContext<'_>, options: AppOptions) -> Self {
        let ctx = &cc.egui_ctx;
        let stored = || cc.storage.and_then(|s| eframe::get_value::<Prefs>(s, Self::STORAGE_KEY));
        let mut prefs = options.prefs.or_else(stored).unwrap_or_default().sane();

        let mut open_error = None;
        let opened = options.scene.map(|path| match read(&path) {
            Ok(opened) => {
                prefs.remember(path);
                opened
            }
            Err(error) => {
                open_error = Some(OpenError { path, message: error.to_string() });
                shipped(Shipped::Veach)
            }
        });
        let from_command_line = opened.is_some();
        let opened = opened.unwrap_or_else(|| shipped(Shipped::Veach));
        if from_command_line || prefs.save.stem.is_empty() {
            prefs.save.stem.clone_from(&opened.snapshot_stem);
        }

        theme::install_fonts(ctx);
        ctx.options_mut(|o| o.zoom_with_keyboard = false);
        ctx.set_theme(prefs.theme);
        ctx.add_plugin(Presses::default());
        let mut lab = Lab::new(ctx, Document::new(opened), prefs, options.threads);
        lab.messages.open_error = open_error;
        let gpu_trouble = GpuTrouble::default();
        if let Some(state) = &cc.wgpu_render_state {
            watch_gpu(state, &gpu_trouble, ctx);
            lab.draw_on(state);
        }
        let app = Self { lab, gpu_trouble, title: String::new() };
        app.install_look(ctx);
        app
    }

    /// What is edited: for tests.
    pub fn document(&self) -> &Document {
        &self.lab.document
    }

    /// The live picture that controls are about: for tests.
    pub fn live(&self) -> &LivePicture {
        self.lab.live()
    }

    /// How fast it goes: for tests.
    pub fn pacing(&self) -> Pacing {
        self.lab.pacing
    }

    /// What is kept between runs: for tests.
    pub fn prefs(&self) -> &Prefs {
        &self.lab.prefs
    }

    fn install_look(&self, ctx: &Context) {
        theme::install(ctx, self.lab.scale(), self.lab.prefs.reduce_motion);
    }

    /// Carries out one command.
    pub fn apply(&mut self, ctx: &Context, command: Command) {
        let Lab { document, history, pacing, prefs, engine, files, sheets, messages, .. } = &mut self.lab;
        match command {
            Command::Edit(edit) => {
                self.change(edit.key(), |document| edit.apply(document));
            }
            Command::Normalise => self.normalise(),
            Command::Fit => document.view.placement.fit(),
            Command::FitThings => {
                if let Some(bounds) = things(&document.scene, document.image.resolution) {
                    document.view.placement = Placement::Part(bounds);
                }
            }
            Command::ActualSize => {
                if let Some(geometry) = self.lab.pane().geometry() {
                    self.lab.document.view.placement.actual_size(&geometry);
                }
            }
            Command::TogglePause => pacing.paused = !pacing.paused,
            Command::Step => {
                pacing.paused = true;
                engine.set_pace(Pace::Paused);
                engine.pictures().iter().for_each(LivePicture::step);
            }
            Command::SetRate(rate) => pacing.set_rate(rate),
            Command::Restart => engine.pictures_mut().iter_mut().for_each(LivePicture::restart),
            Command::Undo => {
                if let Some(key) = history.undo(document) {
                    messages.say(format!("Undone: {}", key.words(document)));
                }
            }
            Command::Redo => {
                if let Some(key) = history.redo(document) {
                    messages.say(format!("Done again: {}", key.words(document)));
                }
            }
            Command::Open => {
                let folder = document.opened.path.as_ref().and_then(|p| p.parent()).map(Into::into);
                files.pick(folder);
            }
            Command::OpenTyped => sheets.open = Some(OpenSheet::default()),
            Command::OpenPath(path) => files.open(path),
            Command::OpenShipped(which) => self.take_over(shipped(which)),
            Command::Save => self.save(ctx),
            Command::ChooseFolder => files.pick_folder(prefs.save.folder.clone()),
            Command::CopyPicture => self.copy_picture(ctx),
            Command::CopyValues => self.copy_values(ctx),
            Command::TogglePanels => {
                prefs.panels = !prefs.panels;
                self.install_look(ctx);
            }
            Command::ToggleInspector => prefs.inspector = !prefs.inspector,
            Command::ToggleMotion => {
                prefs.reduce_motion = !prefs.reduce_motion;
                self.install_look(ctx);
            }
            Command::ToggleFullScreen => {
                let full = ctx.input(|i| i.viewport().fullscreen.unwrap_or(false));
                ctx.send_viewport_cmd(ViewportCommand::Fullscreen(!full));
            }
            Command::SetTheme(theme) => {
                prefs.theme = theme;
                ctx.set_theme(theme);
            }
            Command::ZoomInterface(step) => self.zoom_interface(ctx, step),
            Command::ToggleHelp => sheets.help = !sheets.help,
            Command::TogglePalette => {
                sheets.palette = if sheets.palette.is_none() { Some(Palette::default()) } else { None };
            }
            Command::ToggleTable => sheets.table.open = !sheets.table.open,
            Command::StopTable => sheets.table.cancel(),
        }
        self.lab.match_slots();
    }

    /// Changes the document; remembers how it was if that made a difference, and says whether it did.
    fn change(&mut self, key: EditKey, change: impl FnOnce(&mut Document)) -> bool {
        let before = self.lab.document.clone();
        change(&mut self.lab.document);
        let changed = self.lab.document != before;
        if changed {
            self.lab.history.record(before, key);
        }
        changed
    }

    /// Sets exposure or range from the picture that controls are about.
    fn normalise(&mut self) {
        let Some(frame) = self.lab.live().frame() else { return };
        let planes = Planes::from_frame(&frame, self.lab.document.active().layer);
        if self.change(EditKey("normalise", 0), |document| normalise(&mut document.view, &planes)) {
            self.lab.history.end_gesture();
        }
    }

    fn copy_picture(&mut self, ctx: &Context) {
        let Some(frame) = self.lab.live().frame() else { return };
        let document = &self.lab.document;
        let dark = ctx.theme() == egui::Theme::Dark;
        let (w, h, rgba) = render_to_rgba8(&frame, document.active().layer, &document.view, dark);
        ctx.copy_image(egui::ColorImage::from_rgba_unmultiplied([w as usize, h as usize], &rgba));
        self.lab.messages.say("The picture is on the clipboard.");
    }

    fn copy_values(&mut self, ctx: &Context) {
        let (Some(frame), Some(at)) = (self.lab.live().frame(), self.lab.pane().pixel()) else { return };
        ctx.copy_text(Pixel { frame: &frame, at }.table());
        self.lab.messages.say("The values of the pixel are on the clipboard.");
    }

    fn zoom_interface(&mut self, ctx: &Context, step: ZoomStep) {
        let (native, scale) = (native_size(ctx), self.lab.scale());
        let Lab { prefs, messages, .. } = &mut self.lab;
        let wanted = step.from(prefs.zoom);
        let grown = zoom::factor(native, scale, wanted) > zoom::factor(native, scale, prefs.zoom) + 1e-3;
        if step == ZoomStep::Larger && !grown {
            messages.say(match scale {
                TypeScale::Desk => "No room for anything larger. Ctrl+B hides the panels: the projector view.",
                TypeScale::Hall => "No room for anything larger.",
            });
            return;
        }
        prefs.zoom = wanted;
        messages.say(format!("Interface {:.0} %", 100.0 * wanted));
    }

    fn take_over(&mut self, opened: Opened) {
        let Lab { document, history, prefs, swatches, sheets, messages, .. } = &mut self.lab;
        prefs.save.stem.clone_from(&opened.snapshot_stem);
        if let Some(path) = &opened.path {
            prefs.remember(path.clone());
        }
        let before = std::mem::replace(document, Document::new(opened));
        history.record(before, EditKey("opening of a file", 0));
        history.end_gesture();
        swatches.clear();
        messages.open_error = None;
        sheets.open = None;
    }

    fn save(&mut self, ctx: &Context) {
        let frame = self.lab.live().current_frame();
        let Lab { document, prefs, files, messages, .. } = &mut self.lab;
        let Some(frame) = frame else {
            messages.complain("Not saved: the first picture with these settings is not complete yet");
            return;
        };
        let stem = match prefs.save.stem.trim() {
            "" => document.opened.snapshot_stem.clone(),
            stem => stem.to_owned(),
        };
        files.save(SaveJob {
            frame,
            view: StoredView { layer: document.active().layer, view: document.view.clone() },
            dark: ctx.theme() == egui::Theme::Dark,
            folder: prefs.save.folder.clone(),
            stem,
            png: prefs.save.png,
        });
    }

    fn handle(&mut self, event: FileEvent) {
        let Lab { prefs, files, sheets, messages, .. } = &mut self.lab;
        match event {
            FileEvent::Picked(path) => files.open(path),
            FileEvent::PickedFolder(folder) => prefs.save.folder = folder,
            FileEvent::NoDialog => {
                let remark = "This desktop offers no file dialog: type a path, or drop a file on the window.";
                sheets.open = Some(OpenSheet { remark, ..OpenSheet::default() });
            }
            FileEvent::Opened(opened) => self.take_over(*opened),
            FileEvent::OpenFailed { path, message } => messages.open_error = Some(OpenError { path, message }),
            FileEvent::Saved { path, notice } => {
                let name = path.file_name().map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into());
                let notice = notice.map_or(String::new(), |n| format!(" ({n})"));
                messages.say(format!("Saved {name}{notice}"));
                messages.save_error = None;
            }
            FileEvent::TableSaved(what) => messages.say(what),
            FileEvent::TableNotSaved(message) => messages.complain(format!("Not saved: {message}")),
            FileEvent::SaveFailed(message) => {
                if !(prefs.panels && prefs.inspector) {
                    messages.complain(format!("Not saved: {message}"));
                }
                messages.save_error = Some(message);
            }
        }
    }

    /// Everything that happens without drawing: also while the window is hidden.
    fn update(&mut self, ctx: &Context) {
        for event in self.lab.files.events() {
            self.handle(event);
        }
        self.lab.match_slots();
        let dropped: Vec<PathBuf> = ctx.input(|i| i.raw.dropped_files.iter().map(|f| f.path().to_owned()).collect());
        if let Some(path) = dropped.into_iter().next() {
            self.lab.files.open(path);
        }
        // A scale kept from a larger screen must not push the panels out of a smaller one.
        let zoom = zoom::factor(native_size(ctx), self.lab.scale(), self.lab.prefs.zoom);
        if (ctx.zoom_factor() - zoom).abs() > 1e-3 {
            ctx.set_zoom_factor(zoom);
        }
        self.lab.sheets.table.poll();
        if let Some(text) = number::take_refused(ctx) {
            self.lab
                .messages
                .complain(format!("\u{201c}{text}\u{201d} is not a number for this field; it stays as it was."));
        }
        let trouble = self.gpu_trouble.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(message) = trouble {
            // The picture goes on without the graphics device; the toolkit may recover its own part or not.
            self.lab.panes.draw_on_cpu();
            self.lab.messages.gpu_error = Some(message);
        }
    }

    /// Hands the renderer what the commands of this pass have made of the document.
    fn submit(&mut self, ctx: &Context) {
        let Lab { document, engine, pacing, sheets, history, .. } = &mut self.lab;
        engine.set_pace(if sheets.table.is_running() { Pace::Paused } else { pacing.pace() });
        for (live, slot) in engine.pictures_mut().iter_mut().zip(document.slots()) {
            live.submit(document.request(slot));
            if let Some(wait) = live.marked_in().filter(|wait| !wait.is_zero()) {
                ctx.request_repaint_after(wait);
            }
        }
        if !ctx.input(|i| i.pointer.any_down()) {
            history.end_gesture();
        }
        let title = format!("{} \u{2013} MIS Lab", document.opened.title);
        if self.title != title {
            ctx.send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }
}

impl eframe::App for MisLabApp {
    fn logic(&mut self, ctx: &Context, _frame: &mut eframe::Frame) {
        self.update(ctx);
    }

    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        self.lab.engine.pictures_mut().iter_mut().for_each(LivePicture::hold);
        hint::begin_pass(ui.ctx(), self.lab.scale() == TypeScale::Desk);
        let mut commands = keys::pressed(ui.ctx());
        window_ui(ui, &mut self.lab, &mut commands);
        let ctx = ui.ctx().clone();
        for command in commands {
            self.apply(&ctx, command);
        }
        self.submit(&ctx);
        self.lab.engine.pictures_mut().iter_mut().for_each(LivePicture::release);
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        eframe::set_value(storage, Self::STORAGE_KEY, &self.lab.prefs);
    }

    fn on_exit(&mut self) {
        self.lab.sheets.table.stop();
        self.lab.engine.stop();
    }
}

/// The window in points at the system's own factor.
fn native_size(ctx: &Context) -> egui::Vec2 {
    ctx.content_rect().size() * ctx.zoom_factor()
}

/// Without these the default handler ends the process.
fn watch_gpu(state: &RenderState, trouble: &GpuTrouble, ctx: &Context) {
    let report = |trouble: &GpuTrouble, ctx: &Context, message: String| {
        *trouble.lock().unwrap_or_else(PoisonError::into_inner) = Some(message);
        ctx.request_repaint();
    };
    let (slot, context) = (trouble.clone(), ctx.clone());
    state.device.set_device_lost_callback(move |reason, message| {
        // Said as well when the window closes and takes its device along.
        if reason != eframe::wgpu::DeviceLostReason::Destroyed {
            report(&slot, &context, format!("the graphics device was lost: {message}"));
        }
    });
    let (slot, context) = (trouble.clone(), ctx.clone());
    state.device.on_uncaptured_error(Arc::new(move |error: eframe::wgpu::Error| {
        report(&slot, &context, format!("the graphics driver reported: {error}"));
    }));
}
