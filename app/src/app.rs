//! The window: its state, what every command does to it, and how it is kept.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use eframe::egui::{self, Context, ViewportCommand};
use eframe::egui_wgpu::{RenderState, WgpuConfiguration, WgpuSetup};
use mislab_renderer::Pace;

use crate::files::{FileEvent, Files, SaveJob, read, shipped};
use crate::look::theme::{self, TypeScale};
use crate::panel::messages::{Notice, OpenError, remark};
use crate::panel::open::OpenSheet;
use crate::panel::palette::Palette;
use crate::panel::table::TablePanel;
use crate::picture::engine::Engine;
use crate::picture::picking::Target;
use crate::picture::swatch::Swatches;
use crate::picture::viewport::{Viewport, render_to_rgba8};
use crate::state::command::Command;
use crate::state::document::{Document, History, Opened};
use crate::state::prefs::Prefs;
use crate::state::view::Geometry;

/// Why there is no window.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NoWindow {
    /// One sentence for the terminal.
    pub reason: String,
}

/// How fast the live picture goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pacing {
    /// Held.
    pub paused: bool,
    /// Passes per second; `None` is full speed.
    pub rate: Option<f32>,
    /// The last rate there was, to come back to.
    pub last_rate: f32,
}

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
pub(crate) type GpuTrouble = Arc<Mutex<Option<String>>>;

/// The app.
pub struct MisLabApp {
    pub(crate) document: Document,
    pub(crate) history: History,
    pub(crate) engine: Engine,
    pub(crate) pacing: Pacing,
    pub(crate) viewport: Viewport,
    pub(crate) geometry: Option<Geometry>,
    pub(crate) pixel: Option<[u32; 2]>,
    pub(crate) hovered_in_panel: Option<Target>,
    pub(crate) hovered_in_picture: Option<Target>,
    pub(crate) dragged_light: Option<usize>,
    pub(crate) swatches: Swatches,
    pub(crate) files: Files,
    pub(crate) prefs: Prefs,
    pub(crate) table: TablePanel,
    pub(crate) palette: Option<Palette>,
    pub(crate) open_sheet: Option<OpenSheet>,
    pub(crate) help: bool,
    pub(crate) open_error: Option<OpenError>,
    pub(crate) save_error: Option<String>,
    pub(crate) gpu_error: Option<String>,
    pub(crate) notices: Vec<Notice>,
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
                shipped(crate::state::command::Shipped::Veach)
            }
        });
        let from_command_line = opened.is_some();
        let opened = opened.unwrap_or_else(|| shipped(crate::state::command::Shipped::Veach));
        if from_command_line || prefs.save.stem.is_empty() {
            prefs.save.stem.clone_from(&opened.snapshot_stem);
        }

        theme::install_fonts(ctx);
        ctx.options_mut(|o| o.zoom_with_keyboard = false);
        ctx.set_theme(prefs.theme);
        ctx.set_zoom_factor(prefs.zoom);
        let gpu_trouble = GpuTrouble::default();
        if let Some(state) = &cc.wgpu_render_state {
            watch_gpu(state, &gpu_trouble, ctx);
        }
        let app = Self {
            document: Document::new(opened),
            history: History::default(),
            engine: Engine::new(ctx, options.threads),
            pacing: Pacing { paused: false, rate: None, last_rate: 2.0 },
            viewport: Viewport::new(cc.wgpu_render_state.as_ref()),
            geometry: None,
            pixel: None,
            hovered_in_panel: None,
            hovered_in_picture: None,
            dragged_light: None,
            swatches: Swatches::default(),
            files: Files::new(ctx),
            prefs,
            table: TablePanel::default(),
            palette: None,
            open_sheet: None,
            help: false,
            open_error,
            save_error: None,
            gpu_error: None,
            notices: Vec::new(),
            gpu_trouble,
            title: String::new(),
        };
        app.install_look(ctx);
        app
    }

    /// What is edited: for tests and the command line.
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// The live picture: for tests.
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// How fast it goes: for tests.
    pub fn pacing(&self) -> Pacing {
        self.pacing
    }

    /// What is kept between runs: for tests.
    pub fn prefs(&self) -> &Prefs {
        &self.prefs
    }

    fn install_look(&self, ctx: &Context) {
        theme::install(ctx, self.scale(), self.prefs.reduce_motion);
    }

    /// The size of type: larger in the projector view.
    pub(crate) fn scale(&self) -> TypeScale {
        if self.prefs.panels { TypeScale::Desk } else { TypeScale::Hall }
    }

    /// Carries out one command.
    pub fn apply(&mut self, ctx: &Context, command: Command) {
        let before = self.document.clone();
        self.act(ctx, &command);
        command.edit(&mut self.document);
        if let Some(key) = command.edit_key()
            && self.document != before
        {
            self.history.record(before, key);
        }
    }

    fn act(&mut self, ctx: &Context, command: &Command) {
        match command {
            Command::Fit => self.document.view.fit(),
            Command::ActualSize => {
                if let Some(geometry) = &self.geometry {
                    self.document.view.actual_size(geometry);
                }
            }
            Command::Normalise => {
                if let Some(frame) = self.engine.frame() {
                    let before = self.document.clone();
                    self.document.view.normalise(&frame);
                    if self.document != before {
                        self.history.record(before, crate::state::document::EditKey("normalise", 0));
                        self.history.end_gesture();
                    }
                }
            }
            Command::TogglePause => self.pacing.paused = !self.pacing.paused,
            Command::Step => {
                self.pacing.paused = true;
                self.engine.set_pace(Pace::Paused);
                self.engine.step();
            }
            Command::SetRate(rate) => {
                self.pacing.rate = *rate;
                self.pacing.last_rate = rate.unwrap_or(self.pacing.last_rate);
                self.pacing.paused = false;
            }
            Command::Restart => self.engine.restart(),
            Command::Undo => self.history.undo(&mut self.document),
            Command::Redo => self.history.redo(&mut self.document),
            Command::Open => {
                let folder = self.document.opened.path.as_ref().and_then(|p| p.parent()).map(Into::into);
                self.files.pick(folder);
            }
            Command::OpenTyped => self.open_sheet = Some(OpenSheet::default()),
            Command::OpenPath(path) => self.files.open(path.clone()),
            Command::OpenShipped(which) => self.take_over(shipped(*which)),
            Command::Save => self.save(ctx),
            Command::ChooseFolder => self.files.pick_folder(self.prefs.save.folder.clone()),
            Command::CopyPicture => {
                if let Some(frame) = self.engine.frame() {
                    let (w, h, rgba) = render_to_rgba8(&frame, &self.document.view, ctx.theme() == egui::Theme::Dark);
                    ctx.copy_image(egui::ColorImage::from_rgba_unmultiplied([w as usize, h as usize], &rgba));
                    self.say("The picture is on the clipboard.");
                }
            }
            Command::CopyValues => {
                if let (Some(frame), Some(pixel)) = (self.engine.frame(), self.pixel) {
                    ctx.copy_text(crate::panel::caption::pixel_table(&frame, pixel));
                    self.say("The values of the pixel are on the clipboard.");
                }
            }
            Command::TogglePanels => {
                self.prefs.panels = !self.prefs.panels;
                self.install_look(ctx);
            }
            Command::ToggleMotion => {
                self.prefs.reduce_motion = !self.prefs.reduce_motion;
                self.install_look(ctx);
            }
            Command::ToggleInspector => self.prefs.inspector = !self.prefs.inspector,
            Command::ToggleFullScreen => {
                let full = ctx.input(|i| i.viewport().fullscreen.unwrap_or(false));
                ctx.send_viewport_cmd(ViewportCommand::Fullscreen(!full));
            }
            Command::SetTheme(theme) => {
                self.prefs.theme = *theme;
                ctx.set_theme(*theme);
            }
            Command::ZoomInterface(factor) => {
                let zoom = factor.map_or(1.0, |f| self.prefs.zoom * f);
                // Steps of a twentieth: what comes back from five steps up and five down is 1.
                let zoom = (zoom * 20.0).round() / 20.0;
                self.prefs.zoom = zoom.clamp(*Prefs::ZOOM.start(), *Prefs::ZOOM.end());
                let room = self.zoom_room(ctx);
                if self.prefs.zoom > room {
                    self.prefs.zoom = room;
                    self.say("No room for larger panels. Ctrl+B hides them: the projector view.");
                }
            }
            Command::ToggleHelp => self.help = !self.help,
            Command::TogglePalette => {
                self.palette = if self.palette.is_none() { Some(Palette::default()) } else { None };
            }
            Command::ToggleTable => self.table.open = !self.table.open,
            _ => {}
        }
    }

    /// The largest interface scale at which both columns still fit beside the picture.
    fn zoom_room(&self, ctx: &Context) -> f32 {
        let points_at_one = ctx.content_rect().width() * ctx.zoom_factor();
        if self.prefs.panels { (points_at_one / crate::layout::FULL_WIDTH).max(1.0) } else { *Prefs::ZOOM.end() }
    }

    fn say(&mut self, text: &str) {
        remark(&mut self.notices, Notice::done(text));
    }

    fn take_over(&mut self, opened: Opened) {
        let before = self.document.clone();
        self.prefs.save.stem.clone_from(&opened.snapshot_stem);
        if let Some(path) = &opened.path {
            self.prefs.remember(path.clone());
        }
        self.document = Document::new(opened);
        self.history.record(before, crate::state::document::EditKey("open", 0));
        self.history.end_gesture();
        self.swatches.clear();
        self.open_error = None;
        self.open_sheet = None;
    }

    fn save(&mut self, ctx: &Context) {
        let Some(frame) = self.engine.current_frame() else {
            remark(
                &mut self.notices,
                Notice::failed("Not saved: the first picture with these settings is not complete yet"),
            );
            return;
        };
        let stem = match self.prefs.save.stem.trim() {
            "" => self.document.opened.snapshot_stem.clone(),
            stem => stem.to_owned(),
        };
        self.files.save(SaveJob {
            frame,
            view: self.document.view.clone(),
            dark: ctx.theme() == egui::Theme::Dark,
            folder: self.prefs.save.folder.clone(),
            stem,
            png: self.prefs.save.png,
        });
    }

    fn handle(&mut self, event: FileEvent) {
        match event {
            FileEvent::Picked(path) => self.files.open(path),
            FileEvent::PickedFolder(folder) => self.prefs.save.folder = folder,
            FileEvent::NoDialog => {
                let remark = "This desktop offers no file dialog: type a path, or drop a file on the window.";
                self.open_sheet = Some(OpenSheet { remark, ..OpenSheet::default() });
            }
            FileEvent::Opened(opened) => self.take_over(*opened),
            FileEvent::OpenFailed { path, message } => self.open_error = Some(OpenError { path, message }),
            FileEvent::Saved { path, notice } => {
                let name = path.file_name().map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into());
                let notice = notice.map_or(String::new(), |n| format!(" ({n})"));
                self.say(&format!("Saved {name}{notice}"));
                self.save_error = None;
            }
            FileEvent::TableSaved(what) => self.say(&what),
            FileEvent::TableNotSaved(message) => {
                remark(&mut self.notices, Notice::failed(format!("Not saved: {message}")));
            }
            FileEvent::SaveFailed(message) => {
                if !(self.prefs.panels && self.prefs.inspector) {
                    remark(&mut self.notices, Notice::failed(format!("Not saved: {message}")));
                }
                self.save_error = Some(message);
            }
        }
    }

    /// Everything that happens without drawing: also while the window is hidden.
    fn update(&mut self, ctx: &Context) {
        for event in self.files.events() {
            self.handle(event);
        }
        let dropped: Vec<PathBuf> = ctx.input(|i| i.raw.dropped_files.iter().map(|f| f.path().to_owned()).collect());
        if let Some(path) = dropped.into_iter().next() {
            self.files.open(path);
        }
        // A scale kept from a larger screen must not push the panels out of a smaller one.
        let zoom = self.prefs.zoom.min(self.zoom_room(ctx));
        if (ctx.zoom_factor() - zoom).abs() > 1e-3 {
            ctx.set_zoom_factor(zoom);
        }
        self.table.poll();
        let trouble = self.gpu_trouble.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(message) = trouble {
            // The picture goes on without the graphics device; the toolkit may recover its own part or not.
            self.viewport = Viewport::new(None);
            self.gpu_error = Some(message);
        }
    }

    /// Hands the renderer what the commands of this pass have made of the document.
    pub(crate) fn submit(&mut self, ctx: &Context) {
        let pace = match self.pacing {
            _ if self.table.is_running() => Pace::Paused,
            Pacing { paused: true, .. } => Pace::Paused,
            Pacing { rate: Some(rate), .. } => Pace::PassesPerSecond(rate),
            Pacing { rate: None, .. } => Pace::Full,
        };
        self.engine.set_pace(pace);
        self.engine.submit(self.document.request());
        if let Some(wait) = self.engine.marked_in().filter(|wait| !wait.is_zero()) {
            ctx.request_repaint_after(wait);
        }
        if !ctx.input(|i| i.pointer.any_down()) {
            self.history.end_gesture();
        }
        let title = format!("{} \u{2013} MIS Lab", self.document.opened.title);
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
        self.engine.hold();
        let mut commands = crate::state::keys::pressed(ui.ctx());
        crate::layout::window_ui(self, ui, &mut commands);
        let ctx = ui.ctx().clone();
        for command in commands {
            self.apply(&ctx, command);
        }
        self.submit(&ctx);
        self.engine.release();
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        eframe::set_value(storage, Self::STORAGE_KEY, &self.prefs);
    }

    fn on_exit(&mut self) {
        self.table.stop();
        self.engine.stop();
    }
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

/// The toolkit asks for textures of 8192 pixels, whatever the device can do: less is refused where
/// the device has less, and a window larger than that is a panic.
fn allow_large_windows(options: &mut WgpuConfiguration) {
    if let WgpuSetup::CreateNew(setup) = &mut options.wgpu_setup {
        let usual = setup.device_descriptor.clone();
        setup.device_descriptor = Arc::new(move |adapter| {
            let mut descriptor = usual(adapter);
            descriptor.required_limits.max_texture_dimension_2d = adapter.limits().max_texture_dimension_2d;
            descriptor
        });
    }
}

/// Opens the window and stays until it is closed.
///
/// # Errors
/// If there is no display or no way to draw on it.
pub fn run_app(scene: Option<PathBuf>) -> Result<(), NoWindow> {
    let viewport = egui::ViewportBuilder::default()
        .with_title("MIS Lab")
        .with_app_id("mislab")
        .with_inner_size([1440.0, 900.0])
        .with_min_inner_size([960.0, 600.0])
        .with_drag_and_drop(true);
    let mut native = eframe::NativeOptions { viewport, ..Default::default() };
    allow_large_windows(&mut native.wgpu_options);
    let options = AppOptions { scene, ..AppOptions::default() };
    let created = Arc::new(AtomicBool::new(false));
    let there = created.clone();
    let create: eframe::AppCreator<'_> = Box::new(move |cc| {
        there.store(true, Ordering::Relaxed);
        Ok(Box::new(MisLabApp::new(cc, options)))
    });
    // A missing keyboard library panics inside the window library, instead of being an error.
    let result = catch_unwind(AssertUnwindSafe(|| eframe::run_native("mislab", native, create)));
    let reason = match result {
        Ok(Ok(())) => return Ok(()),
        // What the library adds names its own source files.
        Ok(Err(eframe::Error::WinitEventLoop(_))) => "no display to open a window on".to_owned(),
        Ok(Err(eframe::Error::Winit(error))) => format!("the window could not be opened ({error})"),
        Ok(Err(eframe::Error::Wgpu(error))) => format!("no graphics to draw with ({error})"),
        Ok(Err(error)) => format!("the window could not be opened ({error})"),
        // A fault of ours, not a missing display.
        Err(panic) if created.load(Ordering::Relaxed) => resume_unwind(panic),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().cloned();
            let text = text.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()));
            format!("a library of the window system is missing ({})", text.unwrap_or_default())
        }
    };
    Err(NoWindow { reason })
}
