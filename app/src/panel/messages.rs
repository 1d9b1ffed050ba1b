//! What went wrong and what the reader did not understand, in words, until the cause is gone.

use std::fs::Permissions;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use eframe::egui::{self, Align2, Area, CornerRadius, Id, Order, Rect, RichText, ScrollArea, Stroke, Ui, vec2};
use mislab_renderer::Diagnostic;

use crate::files::opening::Unreadable;
use crate::files::room::room;
use crate::files::saving::Obstacle;
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
    /// What is in the way.
    pub obstacle: Obstacle,
    /// What the folder was like: `None` if it was not to be seen.
    access: Option<Permissions>,
}

impl SaveError {
    /// That `place` could not be written to just now.
    pub fn new(place: (String, PathBuf), message: String, obstacle: Obstacle) -> Self {
        let access = access(&place.1);
        let error = Self { place, message, obstacle, access };
        // Of a disk that says to have room (a quota is used up, perhaps) nobody can tell when it has.
        let obstacle = if error.has_room() { Obstacle::Other } else { obstacle };
        Self { obstacle, ..error }
    }

    /// The folder has come or goes by other permissions than at that time, or its disk has room by now, so that it may work.
    pub fn may_be_over(&self) -> bool {
        self.access != access(&self.place.1) || self.has_room()
    }

    /// There was no room, and there is.
    fn has_room(&self) -> bool {
        match self.obstacle {
            Obstacle::NoRoom { bytes } => room(&self.place.1).is_some_and(|room| room > bytes),
            Obstacle::NoFolder | Obstacle::Other => false,
        }
    }
}

fn access(folder: &Path) -> Option<Permissions> {
    std::fs::metadata(folder).ok().map(|about| about.permissions())
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

    /// Takes back a remark that is no longer true.
    pub fn retract(&mut self, text: &str) {
        self.notices.retain(|old| old.text != text);
    }

    /// Adds a remark; one that is there already stays longer instead of coming twice.
    fn remark(&mut self, notice: Notice) {
        self.notices.retain(|old| old.text != notice.text);
        self.notices.push(notice);
    }
}

/// What else the messages are about.
#[derive(Clone, Copy, Debug)]
pub struct Trouble<'a> {
    /// Why the picture could not be rendered.
    pub failed: Option<&'a str>,
    /// The file that the picture is of.
    pub running: Option<&'a Path>,
}

/// Over the picture at `rect`: what could not be rendered, opened, saved or drawn. All in one strip: the first in full, the
/// others in a line each until it is their turn.
pub fn errors_ui(ui: &Ui, rect: Rect, messages: &mut Messages, trouble: Trouble<'_>, out: &mut Vec<Command>) {
    let entries = entries(messages, trouble);
    if entries.is_empty() {
        return;
    }
    let width = (rect.width() - 6.0 * GRID).min(760.0);
    let at = rect.center_top() + vec2(-0.5 * width, 3.0 * GRID);
    let shown = Area::new(Id::unique("errors")).order(Order::Middle).fixed_pos(at).show(ui.ctx(), |ui| {
        ui.set_width(width);
        let stroke = Stroke::new(1.5, Inks::of(ui.visuals()).wrong);
        let frame = egui::Frame::new().fill(ui.visuals().window_fill).stroke(stroke);
        let frame = frame.corner_radius(CornerRadius::same(6)).inner_margin(3.0 * GRID);
        frame.show(ui, |ui| {
            let answers: Vec<(Cause, Answer)> =
                entries.iter().enumerate().map(|(i, entry)| (entry.cause, entry.ui(ui, i == 0))).collect();
            answers
        })
    });
    for (cause, answer) in shown.inner.inner {
        match (answer, cause) {
            (Answer::Nothing, _) | (Answer::Close, Cause::Rendering) => {}
            (Answer::Help, _) => out.push(Command::SaveCreatingFolder),
            (Answer::Close, Cause::Opening) => out.push(Command::DismissOpenError),
            (Answer::Close, Cause::Saving) => messages.save_error = None,
            (Answer::Close, Cause::Drawing) => messages.gpu_error = None,
        }
    }
}

/// What is to be said, the most pressing first.
fn entries(messages: &Messages, trouble: Trouble<'_>) -> Vec<Entry> {
    let Messages { open_error, save_error, gpu_error, notices: _ } = messages;
    let failed = trouble.failed.map(|message| Entry {
        headline: "This cannot be rendered".into(),
        message: message.into(),
        remark: "Undo (Ctrl+Z) brings the last picture back.",
        ..Entry::new(Cause::Rendering)
    });
    let opening = open_error.as_ref().map(|OpenError { path, why: Unreadable { message, line } }| {
        let name = shortened(&short_name(path), 28);
        let (headline, remark) = if trouble.running == Some(path.as_path()) {
            let remark =
                "The picture is of the version before. Once the file is saved without the error, it is read again.";
            (format!("{name} has an error"), remark)
        } else {
            let remark =
                "The picture on screen stays. This file is looked after: once it is saved without the error, it opens.";
            (format!("{name} was not opened"), remark)
        };
        Entry { headline, message: message.clone(), line: line.clone(), remark, ..Entry::new(Cause::Opening) }
    });
    let saving = save_error.as_ref().map(|SaveError { place: (name, _), message, obstacle, access: _ }| Entry {
        headline: format!("{} was not saved", shortened(name, 28)),
        message: message.clone(),
        remedy: (*obstacle == Obstacle::NoFolder).then_some("Create the folder and save"),
        ..Entry::new(Cause::Saving)
    });
    let drawing = gpu_error.as_ref().map(|message| Entry {
        headline: "Drawing without the graphics device".into(),
        message: message.clone(),
        remark: "The picture is drawn by the processor from here on. Restarting the program tries again.",
        ..Entry::new(Cause::Drawing)
    });
    [failed, opening, saving, drawing].into_iter().flatten().collect()
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

/// What went wrong.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Cause {
    Rendering,
    Opening,
    Saving,
    Drawing,
}

/// One thing that went wrong, in the strip over the picture.
struct Entry {
    cause: Cause,
    headline: String,
    message: String,
    /// The line of a file that it is about.
    line: Option<String>,
    remark: &'static str,
    /// What a button offers to do about it.
    remedy: Option<&'static str>,
}

/// What the user says to it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Answer {
    Nothing,
    Close,
    Help,
}

impl Entry {
    fn new(cause: Cause) -> Self {
        Self { cause, headline: String::new(), message: String::new(), line: None, remark: "", remedy: None }
    }

    /// With all that is to be said, or only what it is about.
    fn ui(&self, ui: &mut Ui, full: bool) -> Answer {
        let mut answer = self.headline_ui(ui, full);
        if !full {
            return answer;
        }
        let height = 6.0 * ui.text_style_height(&egui::TextStyle::Body);
        ScrollArea::vertical().id_salt(&self.headline).max_height(height).show(ui, |ui| {
            ui.add(egui::Label::new(&self.message).selectable(true).wrap());
            if let Some(line) = &self.line {
                ui.add(egui::Label::new(RichText::new(line).monospace()).selectable(true).wrap());
            }
        });
        if let Some(remedy) = self.remedy
            && ui.button(remedy).clicked()
        {
            answer = Answer::Help;
        }
        if !self.remark.is_empty() {
            caption(ui, self.remark);
        }
        answer
    }

    fn headline_ui(&self, ui: &mut Ui, full: bool) -> Answer {
        let mut answer = Answer::Nothing;
        // Names that tell the buttons apart.
        let name = if full { "Close message".to_owned() } else { format!("Close message: {}", self.headline) };
        ui.horizontal(|ui| {
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                // What cannot be rendered goes with its cause alone.
                if self.cause != Cause::Rendering && ui.button("Close").accessible_name(name).clicked() {
                    answer = Answer::Close;
                }
                ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                    let headline = RichText::new(&self.headline).family(crate::look::theme::medium());
                    ui.add(egui::Label::new(headline.color(Inks::of(ui.visuals()).wrong)).truncate());
                });
            });
        });
        answer
    }
}
