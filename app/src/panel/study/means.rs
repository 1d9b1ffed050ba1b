//! Means of each picture against a reference: bias or noise.

use eframe::egui::Ui;

use super::Subject;
use crate::state::command::Command;

/// What is kept of it while it is open and after.
#[derive(Default)]
pub struct Means {}

/// Draws it over all that is left of `ui`.
pub fn means_ui(ui: &mut Ui, _study: &mut Means, _subject: &Subject<'_>, _out: &mut Vec<Command>) {
    ui.label("Means");
}
