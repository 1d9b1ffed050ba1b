//! Small pictures of all strategies under all heuristics, or over c.

use eframe::egui::Ui;

use super::Subject;
use crate::state::command::Command;

/// What is kept of it while it is open and after.
#[derive(Default)]
pub struct Grid {}

/// Draws it over all that is left of `ui`.
pub fn grid_ui(ui: &mut Ui, _study: &mut Grid, _subject: &Subject<'_>, _out: &mut Vec<Command>) {
    ui.label("Grid");
}
