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
}

/// The sheet. Returns false when it is done with.
pub fn open_ui(ctx: &egui::Context, sheet: &mut OpenSheet, recent: &[PathBuf], out: &mut Vec<Command>) -> bool {
    let mut open = true;
    let modal = Modal::new(Id::unique("open sheet")).show(ctx, |ui| {
        sheet_type(ui);
        ui.set_width(560.0_f32.min(ctx.content_rect().width() - 40.0));
        ui.heading("Open a scene or a snapshot");
        if !sheet.remark.is_empty() {
            caption(ui, sheet.remark);
        }
        ui.add_space(GRID);
        ui.horizontal(|ui| {
            let edit = TextEdit::singleline(&mut sheet.text).hint_text("path of a .pbrt or .exr");
            let edit = ui.add(edit.desired_width(ui.available_width() - 80.0)).accessible_name("Path");
            if !edit.has_focus() && !edit.lost_focus() && sheet.text.is_empty() {
                edit.request_focus();
            }
            let entered = edit.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
            let clicked = ui.add_sized([72.0, ui.spacing().interact_size.y], egui::Button::new("Open")).clicked();
            if (entered || clicked) && !sheet.text.trim().is_empty() {
                out.push(Command::OpenPath(typed(&sheet.text)));
                open = false;
            }
        });
        open &= !choices_ui(ui, recent, out);
    });
    open && !modal.should_close()
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
