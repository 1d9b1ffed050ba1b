//! What went wrong and what the reader did not understand, in words, until the cause is gone.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use eframe::egui::{self, Align2, Area, CornerRadius, Id, Order, Rect, RichText, ScrollArea, Stroke, Ui, vec2};
use mislab_renderer::Diagnostic;

use crate::files::opening::Unreadable;
use crate::look::theme::{GRID, Inks};
use crate::panel::widgets::caption;
use crate::state::command::Command;
use crate::state::paths::{short_name, shortened};

/// A file that could not be opened. The picture that was there stays.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OpenError {
    /// The file.
    pub path: PathBuf,
    /// Why not.
    pub why: Unreadable,
}

/// A snapshot that could not be saved.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SaveError {
    /// The name and folder asked for: with others, this is no longer true.
    pub place: (String, PathBuf),
    /// Why not.
    pub message: String,
    /// The folder is missing, which can be helped.
    pub no_folder: bool,
}

/// Everything that is to be said.
#[derive(Debug, Default)]
pub struct Messages {
    /// The last file could not be opened.
    pub open_error: Option<OpenError>,
    /// The last snapshot could not be saved.
    pub save_error: Option<SaveError>,
    /// Why the graphics device is not used any more.
    pub gpu_error: Option<String>,
    notices: Vec<Notice>,
}

impl Messages {
    /// Remarks in passing that something has worked.
    pub fn say(&mut self, text: impl Into<String>) {
        self.remark(Notice::new(text, Duration::from_secs(4)));
    }

    /// Remarks that a file was saved, and stays long enough to do something about it.
    pub fn saved(&mut self, text: impl Into<String>, path: PathBuf) {
        self.forget_saved();
        self.remark(Notice { path: Some(path), ..Notice::new(text, Duration::from_secs(12)) });
    }

    /// Takes back what was said of the file saved before, which is under Recent: the next one is on its way.
    pub fn forget_saved(&mut self) {
        self.notices.retain(|old| old.path.is_none());
    }

    /// Remarks in passing that something could not be done.
    pub fn complain(&mut self, text: impl Into<String>) {
        self.remark(Notice { wrong: true, ..Notice::new(text, Duration::from_secs(12)) });
    }

    /// Adds a remark; one that is there already stays longer instead of coming twice.
    fn remark(&mut self, notice: Notice) {
        self.notices.retain(|old| old.text != notice.text);
        self.notices.push(notice);
    }
}

/// Over the picture at `rect`: what could not be opened, saved, drawn or (`failed`) rendered.
pub fn errors_ui(ui: &Ui, rect: Rect, messages: &mut Messages, failed: Option<&str>, out: &mut Vec<Command>) {
    let Messages { open_error, save_error, gpu_error, notices: _ } = messages;
    if open_error.is_none() && save_error.is_none() && failed.is_none() && gpu_error.is_none() {
        return;
    }
    let width = (rect.width() - 6.0 * GRID).min(760.0);
    let at = rect.center_top() + vec2(-0.5 * width, 3.0 * GRID);
    Area::new(Id::unique("errors")).order(Order::Middle).fixed_pos(at).show(ui.ctx(), |ui| {
        ui.set_width(width);
        if let Some(message) = failed {
            let remark = "Undo (Ctrl+Z) brings the last picture back.";
            Strip { headline: "This cannot be rendered", message, line: None, remark, remedy: None }.ui(ui);
        }
        if let Some(OpenError { path, why: Unreadable { message, line } }) = open_error {
            let headline = format!("{} was not opened", shortened(&short_name(path), 28));
            let remark =
                "The picture on screen stays. This file is looked after: once it is saved without the error, it opens.";
            let strip = Strip { headline: &headline, message, line: line.as_deref(), remark, remedy: None };
            if strip.ui(ui) == Answer::Close {
                out.push(Command::DismissOpenError);
            }
        }
        if let Some(SaveError { place: (name, _), message, no_folder }) = save_error {
            let headline = format!("{} was not saved", shortened(name, 28));
            let remedy = no_folder.then_some("Create the folder and save");
            match (Strip { headline: &headline, message, line: None, remark: "", remedy }).ui(ui) {
                Answer::Close => *save_error = None,
                Answer::Help => out.push(Command::SaveCreatingFolder),
                Answer::Nothing => {}
            }
        }
        if let Some(message) = gpu_error {
            let headline = "Drawing without the graphics device";
            let remark = "The picture is drawn by the processor from here on. Restarting the program tries again.";
            if (Strip { headline, message, line: None, remark, remedy: None }).ui(ui) == Answer::Close {
                *gpu_error = None;
            }
        }
    });
}

/// The reader's warnings about the scene, each with its place.
pub fn warnings_ui(ui: &mut Ui, warnings: &[Diagnostic]) {
    if warnings.is_empty() {
        return;
    }
    let title = match warnings.len() {
        1 => "1 warning about the scene file".to_owned(),
        n => format!("{n} warnings about the scene file"),
    };
    // Above everything else, where it is seen; many keep folded, so that the controls are still there.
    let title = RichText::new(title).family(crate::look::theme::medium());
    egui::CollapsingHeader::new(title).default_open(warnings.len() <= 3).show(ui, |ui| {
        for warning in warnings {
            // In a narrow column the folders would hide what is said.
            let Diagnostic { location, message } = warning;
            let file = short_name(Path::new(&*location.file));
            let text = format!("{file}:{}:{}: {message}", location.line, location.column);
            let text = RichText::new(text).small();
            ui.add(egui::Label::new(text).selectable(true).wrap());
        }
    });
    ui.add_space(GRID);
}

/// The remarks of the last seconds and what is being done, above the lower right corner of `rect`.
pub fn notices_ui(
    ctx: &egui::Context,
    messages: &mut Messages,
    work: Option<&str>,
    rect: Rect,
    out: &mut Vec<Command>,
) {
    let notices = &mut messages.notices;
    let now = Instant::now();
    notices.retain(|notice| notice.until > now);
    if let Some(next) = notices.iter().map(|notice| notice.until).min() {
        ctx.request_repaint_after(next - now);
    } else if work.is_none() {
        return;
    }
    let area = Area::new(Id::unique("notices")).order(Order::Foreground);
    // What has nothing to click lets clicks through to the picture.
    let area = area.interactable(notices.iter().any(|notice| notice.path.is_some()));
    let area = area.pivot(Align2::RIGHT_BOTTOM).fixed_pos(rect.right_bottom() - vec2(3.0 * GRID, 3.0 * GRID));
    let shown = area.show(ctx, |ui| {
        for notice in notices.iter() {
            let stroke =
                if notice.wrong { Stroke::new(1.5, Inks::of(ui.visuals()).wrong) } else { ui.visuals().window_stroke };
            egui::Frame::popup(ui.style()).stroke(stroke).show(ui, |ui| {
                ui.set_max_width(420.0);
                ui.add(egui::Label::new(&notice.text).wrap());
                if let Some(path) = &notice.path {
                    ui.horizontal(|ui| {
                        if ui.button("Show in folder").clicked() {
                            out.push(Command::ShowInFolder(path.clone()));
                        }
                        if ui.button("Copy path").clicked() {
                            out.push(Command::CopyPath(path.clone()));
                        }
                    });
                }
            });
        }
        if let Some(work) = work {
            egui::Frame::popup(ui.style()).show(ui, |ui| {
                ui.label(work);
            });
        }
    });
    if shown.response.contains_pointer() {
        // Not while somebody is about to click.
        for notice in notices.iter_mut().filter(|notice| notice.path.is_some()) {
            notice.until = notice.until.max(now + Duration::from_secs(3));
        }
    }
}

/// A passing remark.
#[derive(Clone, Debug)]
struct Notice {
    text: String,
    wrong: bool,
    /// The file it is about.
    path: Option<PathBuf>,
    until: Instant,
}

impl Notice {
    fn new(text: impl Into<String>, time: Duration) -> Self {
        Self { text: text.into(), wrong: false, path: None, until: Instant::now() + time }
    }
}

/// A strip over the picture with an error in it.
struct Strip<'a> {
    headline: &'a str,
    message: &'a str,
    /// The line of a file that it is about.
    line: Option<&'a str>,
    remark: &'a str,
    /// What a button offers to do about it.
    remedy: Option<&'a str>,
}

/// What the user says to a strip.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Answer {
    Nothing,
    Close,
    Help,
}

impl Strip<'_> {
    fn ui(self, ui: &mut Ui) -> Answer {
        let Self { headline, message, line, remark, remedy } = self;
        let wrong = Inks::of(ui.visuals()).wrong;
        let mut answer = Answer::Nothing;
        egui::Frame::new()
            .fill(ui.visuals().window_fill)
            .stroke(Stroke::new(1.5, wrong))
            .corner_radius(CornerRadius::same(6))
            .inner_margin(3.0 * GRID)
            .show(ui, |ui| {
                ui.horizontal(|ui| {
                    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                        if ui.button("Close").accessible_name("Close message").clicked() {
                            answer = Answer::Close;
                        }
                        ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                            let headline = RichText::new(headline).family(crate::look::theme::medium()).color(wrong);
                            ui.add(egui::Label::new(headline).truncate());
                        });
                    });
                });
                let height = 6.0 * ui.text_style_height(&egui::TextStyle::Body);
                ScrollArea::vertical().id_salt(headline).max_height(height).show(ui, |ui| {
                    ui.add(egui::Label::new(message).selectable(true).wrap());
                    if let Some(line) = line {
                        ui.add(egui::Label::new(RichText::new(line).monospace()).selectable(true).wrap());
                    }
                });
                if let Some(remedy) = remedy
                    && ui.button(remedy).clicked()
                {
                    answer = Answer::Help;
                }
                if !remark.is_empty() {
                    caption(ui, remark);
                }
            });
        answer
    }
}
