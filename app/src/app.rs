//! The window as a program: how it starts, what every command does, and what happens in each pass.

mod exporting;
mod filing;
mod gpu;

use std::io::Write as _;
use std::path::PathBuf;
use std::sync::{Arc, PoisonError};
use std::time::Duration;

use eframe::egui::{self, Context, ViewportCommand};
use mislab_renderer::Pace;

use self::gpu::{GpuTrouble, watch_gpu};
use crate::files::kept::{Due, Kept};
use crate::files::opening::shipped;
use crate::files::showing::show_in_folder;
use crate::lab::Lab;
use crate::layout::window_ui;
use crate::look::theme::{self, TypeScale};
use crate::look::zoom::{self, ZoomStep};
use crate::panel::file_caption::FROM_FILE;
use crate::panel::hint;
use crate::panel::number;
use crate::panel::open::OpenSheet;
use crate::panel::palette::Palette;
use crate::picture::content::Content;
use crate::picture::figure::figure;
use crate::picture::foreign::Foreign;
use crate::picture::live::LivePicture;
use crate::picture::meshes::Meshes;
use crate::picture::normalise::normalise;
use crate::picture::pane::Pane;
use crate::picture::picking::things;
use crate::picture::pixel::Pixel;
use crate::picture::sheet::Recorder;
use crate::picture::still::planes_to_rgba8;
use crate::state::arrangement::Arrangement;
use crate::state::command::{Command, Shipped};
use crate::state::document::Document;
use crate::state::history::EditKey;
use crate::state::keys;
use crate::state::pacing::Pacing;
use crate::state::passes::{self, Meter, Passes};
use crate::state::placement::Placement;
use crate::state::prefs::Prefs;
use crate::state::presses::Presses;

/// How the app is started.
#[derive(Clone, Debug, Default)]
pub struct AppOptions {
    /// The scene or snapshot to open; `None` is Veach's scene.
    pub scene: Option<PathBuf>,
    /// Worker threads; 0 is one per core.
    pub threads: usize,
    /// What drawing has cost so far.
    pub meter: Meter,
    /// What was kept from the last run.
    pub prefs: Prefs,
    /// Where that is kept; `None` forgets it.
    pub prefs_file: Option<PathBuf>,
    /// To be said at the start.
    pub remark: Option<String>,
}

/// The app.
pub struct MisLabApp {
    lab: Lab,
    gpu_trouble: GpuTrouble,
    title: String,
    kept: Option<Kept>,
    /// A scene is being read in place of which nothing has been shown yet.
    starting: bool,
    /// The window is to close once everything asked for is saved.
    closing: bool,
}

impl MisLabApp {
    /// How long the window waits for the scene it was started with before it shows up without.
    const PATIENCE: Duration = Duration::from_millis(300);

    /// Starts the workers on the first picture.
    pub fn new(cc: &eframe::CreationContext<'_>, options: AppOptions) -> Self {
        let ctx = &cc.egui_ctx;
        let AppOptions { scene, threads, meter, prefs, prefs_file, remark } = options;
        let kept = prefs_file.map(|path| Kept::new(path, remark.is_none().then(|| prefs.clone())));

        theme::install_fonts(ctx);
        ctx.options_mut(|o| o.zoom_with_keyboard = false);
        ctx.set_theme(prefs.theme);
        ctx.add_plugin(Presses::default());
        ctx.add_plugin(Passes::new(meter));
        ctx.add_plugin(Recorder::default());
        let mut lab = Lab::new(ctx, Document::new(shipped(Shipped::Veach)), prefs, threads);
        if let Some(remark) = remark {
            lab.messages.complain(remark);
        }
        let gpu_trouble = GpuTrouble::default();
        if let Some(state) = &cc.wgpu_render_state {
            watch_gpu(state, &gpu_trouble, ctx);
            lab.draw_on(state);
            // After the recorder, which looks at what this takes.
            if let Some(meshes) = Meshes::new(state) {
                ctx.add_plugin(meshes);
            }
        }
        let starting = scene.is_some();
        let mut app = Self { lab, gpu_trouble, title: String::new(), kept, starting, closing: false };
        app.install_look(ctx);
        if let Some(path) = scene {
            app.lab.files.open(path);
            for event in app.lab.files.events_within(Self::PATIENCE) {
                app.handle(event);
            }
        }
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

    /// The live pictures of all slots: for tests.
    pub fn pictures(&self) -> &[LivePicture] {
        self.lab.engine.pictures()
    }

    /// What is on screen of them: for tests.
    pub fn panes(&self) -> &[Pane] {
        self.lab.panes.all()
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
        let Lab { document, history, pacing, prefs, destination, engine, files, sheets, messages, .. } = &mut self.lab;
        match command {
            Command::Edit(edit) => {
                if document.active().is_file() && edit.is_about_making() {
                    messages.say(FROM_FILE);
                }
                self.change(edit.key(), |document| edit.apply(document));
            }
            Command::Activate(index) => document.activate(index),
            Command::ActivateNext => document.activate((document.active_index() + 1) % document.slots().len()),
            Command::Keep => self.keep(),
            Command::ToggleStudy(study) => {
                let open = &mut self.lab.studies.open;
                *open = if *open == Some(study) { None } else { Some(study) };
            }
            Command::Pin(pixel) => self.lab.studies.explain.pin(pixel),
            Command::OpenReference => files.pick_reference(),
            Command::ReferencePath(path) => self.lab.references.use_file(Some(path)),
            Command::RenderReference => self.lab.references.use_file(None),
            Command::SaveCsv { name, text } => {
                files.save_text(destination.folder(document), name.into(), "csv", text);
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
            Command::Compare => {
                let folder = document.opened.path.as_ref().and_then(|p| p.parent()).map(Into::into);
                files.pick_to_compare(folder);
            }
            Command::ComparePath(path) => files.read_to_compare(path),
            Command::Reload => self.reload(),
            Command::DismissOpenError => messages.open_error = None,
            Command::OpenShipped(which) => self.take_over_shipped(which),
            Command::Save => self.save(ctx, false),
            Command::SaveCreatingFolder => self.save(ctx, true),
            Command::ShowInFolder(path) => {
                if let Err(why) = show_in_folder(&path) {
                    messages.complain(why);
                }
            }
            Command::CopyPath(path) => {
                ctx.copy_text(path.display().to_string());
                messages.say("The path is on the clipboard.");
            }
            Command::ChooseFolder => files.pick_folder(destination.folder(document)),
            Command::CopyPicture => self.copy_picture(ctx),
            Command::CopyValues => self.copy_values(ctx),
            Command::Export(figure) => self.export(ctx, figure),
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
        let Lab { document, panes, .. } = &self.lab;
        let planes = if document.arrangement() == Arrangement::Difference {
            panes.against().planes().cloned()
        } else {
            let (layer, unit) = (document.active().layer, document.view.variance_unit);
            let dark = self.lab.pane().dark();
            self.lab.live().content().and_then(|content| content.planes(layer, unit, dark).ok()).map(Arc::new)
        };
        let Some(planes) = planes else { return };
        if self.change(EditKey("normalise", 0), |document| normalise(&mut document.view, &planes)) {
            self.lab.history.end_gesture();
        }
    }

    /// Keeps the frame of the active picture and goes on beside it.
    fn keep(&mut self) {
        match self.lab.live().current_frame() {
            Some(frame) => {
                let kept = self.lab.shelf.put(frame);
                self.change(EditKey("keeping of a picture", 0), |document| document.keep(kept));
                self.lab.history.end_gesture();
            }
            None if self.lab.document.active().is_file() => {
                self.lab.messages.complain("A picture from a file is kept where it is.");
            }
            None => self
                .lab
                .messages
                .complain("Nothing to keep yet: the first picture with these settings is not complete."),
        }
    }

    /// Shows a picture from a file beside the active one.
    pub(super) fn compare(&mut self, file: Foreign) {
        let kept = self.lab.shelf.put_file(file);
        self.change(EditKey("picture from a file", 0), |document| document.compare(kept));
        self.lab.history.end_gesture();
        self.lab.match_slots();
    }

    fn copy_picture(&mut self, ctx: &Context) {
        let Some(content) = self.lab.live().content() else { return };
        let document = &self.lab.document;
        let dark = ctx.theme() == egui::Theme::Dark;
        let layer = document.active().layer;
        let (w, h, rgba) = match &content {
            Content::Frame(frame) => figure(frame, layer, &document.view, dark),
            Content::File(_) => match content.planes(layer, document.view.variance_unit, &None) {
                Ok(planes) => planes_to_rgba8(&planes, &document.view, dark),
                Err(why) => return self.lab.messages.complain(why),
            },
        };
        ctx.copy_image(egui::ColorImage::from_rgba_unmultiplied([w as usize, h as usize], &rgba));
        self.lab.messages.say("The picture is on the clipboard.");
    }

    fn copy_values(&mut self, ctx: &Context) {
        let (Some(content), Some(at)) = (self.lab.live().content(), self.lab.pane().read()) else { return };
        let (unit, dark) = (self.lab.document.view.variance_unit, self.lab.pane().dark().as_ref());
        ctx.copy_text(Pixel { content: &content, at, unit, dark }.table());
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

    /// Everything that happens without drawing: also while the window is hidden.
    fn update(&mut self, ctx: &Context) {
        for event in self.lab.files.events() {
            self.handle(event);
        }
        self.lab.match_slots();
        self.open_dropped(ctx);
        self.look_after_files(ctx);
        self.close_when_saved(ctx);
        self.keep_prefs(ctx);
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
        if self.starting {
            return;
        }
        // A table is not to be spoiled, and who closes the window waits for the saving alone.
        let hold = sheets.table.is_running() || self.closing;
        let pace = if hold { Pace::Paused } else { pacing.pace() };
        // At a slow pace the processor has time for every pass.
        let mut fresh = matches!(pace, Pace::PassesPerSecond(_));
        for (live, slot) in engine.pictures_mut().iter_mut().zip(document.slots()) {
            fresh |= live.submit(document.request(slot));
            if let Some(wait) = live.marked_in().filter(|wait| !wait.is_zero()) {
                ctx.request_repaint_after(wait);
            }
        }
        engine.keep_abreast((document.slots().len() > 1).then_some(document.equal));
        engine.set_pace(pace);
        if fresh {
            passes::freshen(ctx);
        }
        if !ctx.input(|i| i.pointer.any_down()) {
            history.end_gesture();
        }
        self.lab.measure(ctx);
        let title = format!("{} \u{2013} MIS Lab", self.lab.document.opened.title);
        if self.title != title {
            ctx.send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }
}

impl eframe::App for MisLabApp {
    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        visuals.panel_fill.to_normalized_gamma_f32()
    }

    fn logic(&mut self, ctx: &Context, _frame: &mut eframe::Frame) {
        if ctx.input(|input| input.viewport().minimized == Some(true)) {
            // No pass will show what waits for one.
            self.lab.engine.release(ctx);
        }
        self.update(ctx);
    }

    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        self.lab.engine.hold();
        hint::begin_pass(ui.ctx(), self.lab.scale() == TypeScale::Desk);
        let mut commands = keys::pressed(ui.ctx());
        window_ui(ui, &mut self.lab, &mut commands);
        let ctx = ui.ctx().clone();
        self.make_figures(&ctx);
        if let Some(file) = self.lab.sheets.compared.take() {
            self.compare(file);
        }
        for command in commands {
            self.apply(&ctx, command);
        }
        self.submit(&ctx);
        self.lab.engine.release(&ctx);
    }

    fn on_exit(&mut self) {
        self.lab.sheets.table.stop();
        self.lab.engine.stop();
        let Lab { prefs, files, .. } = &mut self.lab;
        if let Some(kept) = &mut self.kept
            && kept.due(prefs, true) == Due::Now
        {
            files.keep(&kept.path, prefs);
        }
        for failure in files.finish() {
            // There is no window left to say it in.
            let _ = writeln!(std::io::stderr(), "{failure}");
        }
    }
}

/// The window in points at the system's own factor.
fn native_size(ctx: &Context) -> egui::Vec2 {
    ctx.content_rect().size() * ctx.zoom_factor()
}
