//! Opening a file by its path, where the desktop has no dialog or one would rather type.

use std::path::PathBuf;

use eframe::egui::{self, Id, Key, Modal, TextEdit, Ui};

use crate::look::theme::GRID;
use crate::panel::hint::Hint as _;
use crate::panel::widgets::{caption, sheet_type, title};
use crate::state::command::{Command, Shipped};
use crate::state::paths::{short_name, typed};

/// The text of the path field while the sheet is open.
#[derive(Default)]
pub struct OpenSheet {
    /// What has been typed.
    pub text: String,
    /// Said above the field.
    pub remark: &'static str,
    /// What the file is for.
    pub purpose: Purpose,
}

/// What becomes of the file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Purpose {
    /// It is opened.
    #[default]
    Open,
    /// It is shown beside the active picture.
    Compare,
    /// Errors are measured against it.
    Reference,
}

impl Purpose {
    /// What to do with the file at `path`.
    fn command(self, path: PathBuf) -> Command {
        match self {
            Self::Open => Command::OpenPath(path),
            Self::Compare => Command::ComparePath(path),
            Self::Reference => Command::ReferencePath(path),
        }
    }
}

/// The sheet. Returns false when it is done with.
pub fn open_ui(ctx: &egui::Context, sheet: &mut OpenSheet, recent: &[PathBuf], out: &mut Vec<Command>) -> bool {
    let mut open = true;
    let modal = Modal::new(Id::unique("open sheet")).show(ctx, |ui| {
        sheet_type(ui);
        ui.set_width(560.0_f32.min(ctx.content_rect().width() - 40.0));
        let (heading, hint, verb) = match sheet.purpose {
            Purpose::Open => ("Open a scene or a snapshot", "path of a .pbrt or .exr", "Open"),
            Purpose::Compare => ("Compare with a picture", "path of an .exr", "Compare"),
            Purpose::Reference => ("Measure errors against a picture", "path of a converged .exr", "Take it"),
        };
        ui.heading(heading);
        if !sheet.remark.is_empty() {
            caption(ui, sheet.remark);
        }
        ui.add_space(GRID);
        ui.horizontal(|ui| {
            let edit = TextEdit::singleline(&mut sheet.text).hint_text(hint);
            let edit = ui.add(edit.desired_width(ui.available_width() - 96.0)).accessible_name("Path");
            if !edit.has_focus() && !edit.lost_focus() && sheet.text.is_empty() {
                edit.request_focus();
            }
            let entered = edit.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
            let clicked = ui.add_sized([88.0, ui.spacing().interact_size.y], egui::Button::new(verb)).clicked();
            if (entered || clicked) && !sheet.text.trim().is_empty() {
                out.push(sheet.purpose.command(typed(&sheet.text)));
                open = false;
            }
        });
        open &= match sheet.purpose {
            Purpose::Open => !choices_ui(ui, recent, out),
            Purpose::Compare | Purpose::Reference => !pictures_ui(ui, recent, sheet.purpose, out),
        };
    });
    open && !modal.should_close()
}

/// Recent pictures as a list of buttons. Returns true after a choice.
fn pictures_ui(ui: &mut Ui, recent: &[PathBuf], purpose: Purpose, out: &mut Vec<Command>) -> bool {
    let mut chosen = false;
    for path in recent.iter().filter(|path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"))) {
        if ui.button(short_name(path)).hint(path.display().to_string()).clicked() {
            out.push(purpose.command(path.clone()));
            chosen = true;
        }
    }
    chosen
}

/// Recent files and the scenes of the program, as a list of buttons. Returns true after a choice.
pub fn choices_ui(ui: &mut Ui, recent: &[PathBuf], out: &mut Vec<Command>) -> bool {
    let mut chosen = false;
    title(ui, "In the program");
    for shipped in Shipped::ALL {
        if ui.button(shipped.name()).clicked() {
            out.push(Command::OpenShipped(shipped));
            chosen = true;
        }
    }
    if !recent.is_empty() {
        title(ui, "Recent");
        for path in recent {
            if ui.button(short_name(path)).hint(path.display().to_string()).clicked() {
                out.push(Command::OpenPath(path.clone()));
                chosen = true;
            }
        }
    }
    chosen
}
