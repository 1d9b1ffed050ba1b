//! What went wrong and what the reader did not understand, in words, until the cause is gone.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use eframe::egui::{self, Align2, Area, CornerRadius, Id, Order, Rect, RichText, ScrollArea, Stroke, Ui, vec2};
use mislab_renderer::Diagnostic;

use crate::look::theme::{GRID, Inks};
use crate::panel::widgets::caption;

/// A file that could not be opened. The picture that was there stays.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OpenError {
    /// The file.
    pub path: PathBuf,
    /// Why not, with line and column for a scene.
    pub message: String,
}

/// Everything that is to be said.
#[derive(Debug, Default)]
pub struct Messages {
    /// The last file could not be opened.
    pub open_error: Option<OpenError>,
    /// Why the last save failed.
    pub save_error: Option<String>,
    /// Why the graphics device is not used any more.
    pub gpu_error: Option<String>,
    notices: Vec<Notice>,
}

impl Messages {
    /// Remarks in passing that something has worked.
    pub fn say(&mut self, text: impl Into<String>) {
        self.remark(Notice { text: text.into(), wrong: false, until: Instant::now() + Duration::from_secs(4) });
    }

    /// Remarks in passing that something could not be done.
    pub fn complain(&mut self, text: impl Into<String>) {
        self.remark(Notice { text: text.into(), wrong: true, until: Instant::now() + Duration::from_secs(12) });
    }

    /// Adds a remark; one that is there already stays longer instead of coming twice.
    fn remark(&mut self, notice: Notice) {
        self.notices.retain(|old| old.text != notice.text);
        self.notices.push(notice);
    }
}

/// Over the picture at `rect`: what could not be opened, drawn or (`failed`) rendered.
pub fn errors_ui(ui: &Ui, rect: Rect, messages: &mut Messages, failed: Option<&str>) {
    if messages.open_error.is_none() && failed.is_none() && messages.gpu_error.is_none() {
        return;
    }
    let width = (rect.width() - 6.0 * GRID).min(760.0);
    let at = rect.center_top() + vec2(-0.5 * width, 3.0 * GRID);
    Area::new(Id::unique("errors")).order(Order::Middle).fixed_pos(at).show(ui.ctx(), |ui| {
        ui.set_width(width);
        if let Some(message) = failed {
            let remark = "Undo (Ctrl+Z) brings the last picture back.";
            error_strip(ui, "This cannot be rendered", message, remark);
        }
        if let Some(error) = &messages.open_error {
            let name = error.path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
            let remark = "The picture on screen stays.";
            if error_strip(ui, &format!("{name} was not opened"), &error.message, remark) {
                messages.open_error = None;
            }
        }
        if let Some(message) = &messages.gpu_error {
            let remark = "The picture is drawn by the processor from here on. Restarting the program tries again.";
            if error_strip(ui, "Drawing without the graphics device", message, remark) {
                messages.gpu_error = None;
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
            let text = RichText::new(warning.to_string()).small();
            ui.add(egui::Label::new(text).selectable(true).wrap());
        }
    });
    ui.add_space(GRID);
}

/// The remarks of the last seconds, above the lower right corner of `rect`.
pub fn notices_ui(ctx: &egui::Context, messages: &mut Messages, rect: Rect) {
    let notices = &mut messages.notices;
    let now = Instant::now();
    notices.retain(|notice| notice.until > now);
    let Some(next) = notices.iter().map(|notice| notice.until).min() else { return };
    ctx.request_repaint_after(next - now);
    let area = Area::new(Id::unique("notices")).order(Order::Foreground).interactable(false);
    area.pivot(Align2::RIGHT_BOTTOM).fixed_pos(rect.right_bottom() - vec2(3.0 * GRID, 3.0 * GRID)).show(ctx, |ui| {
        for notice in notices.iter() {
            let stroke =
                if notice.wrong { Stroke::new(1.5, Inks::of(ui.visuals()).wrong) } else { ui.visuals().window_stroke };
            egui::Frame::popup(ui.style()).stroke(stroke).show(ui, |ui| {
                ui.set_max_width(420.0);
                ui.label(&notice.text);
            });
        }
    });
}

/// A passing remark.
#[derive(Clone, Debug)]
struct Notice {
    text: String,
    wrong: bool,
    until: Instant,
}

/// A strip over the picture with an error in it. Returns true when it is put away.
fn error_strip(ui: &mut Ui, headline: &str, message: &str, remark: &str) -> bool {
    let wrong = Inks::of(ui.visuals()).wrong;
    let mut closed = false;
    egui::Frame::new()
        .fill(ui.visuals().window_fill)
        .stroke(Stroke::new(1.5, wrong))
        .corner_radius(CornerRadius::same(6))
        .inner_margin(3.0 * GRID)
        .show(ui, |ui| {
            ui.horizontal(|ui| {
                ui.label(RichText::new(headline).family(crate::look::theme::medium()).color(wrong));
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    closed = ui.button("Close").accessible_name("Close message").clicked();
                });
            });
            ScrollArea::vertical().id_salt(headline).max_height(120.0).show(ui, |ui| {
                ui.add(egui::Label::new(message).selectable(true).wrap());
            });
            if !remark.is_empty() {
                caption(ui, remark);
            }
        });
    closed
}
