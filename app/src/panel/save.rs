//! Snapshots: where they go, what they are called, what went wrong.

use eframe::egui::{RichText, TextEdit, Ui};

use crate::look::theme::{GRID, Inks};
use crate::panel::hint::Hint as _;
use crate::panel::widgets::{labelled, title, wide_button};
use crate::state::command::Command;
use crate::state::prefs::SavePrefs;

/// The panel. `error` is why the last save failed.
pub fn save_ui(ui: &mut Ui, prefs: &mut SavePrefs, error: Option<&str>, out: &mut Vec<Command>) {
    title(ui, "Snapshot");
    let label = 72.0;
    labelled(ui, "Name", label, |ui| {
        let edit = TextEdit::singleline(&mut prefs.stem).desired_width(ui.available_width());
        ui.add(edit).accessible_name("Snapshot name").hint("A number is added where a file is already there.");
    });
    labelled(ui, "Folder", label, |ui| {
        ui.spacing_mut().item_spacing.x = GRID;
        let button = 40.0;
        let mut folder = prefs.folder.display().to_string();
        let edit = TextEdit::singleline(&mut folder).desired_width(ui.available_width() - button - GRID);
        if ui.add(edit).accessible_name("Snapshot folder").hint(prefs.folder.display().to_string()).changed() {
            prefs.folder = folder.into();
        }
        if wide_button(ui, "\u{2026}", button).accessible_name("Choose folder").clicked() {
            out.push(Command::ChooseFolder);
        }
    });
    ui.horizontal(|ui| {
        ui.checkbox(&mut prefs.png, "PNG of the view");
        if wide_button(ui, "Save EXR", ui.available_width()).accessible_name("Save snapshot").clicked() {
            out.push(Command::Save);
        }
    });
    if let Some(error) = error {
        let wrong = Inks::of(ui.visuals()).wrong;
        ui.label(RichText::new(format!("Not saved: {error}")).small().color(wrong));
    }
}
