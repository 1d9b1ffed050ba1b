//! Which strategy is best for each size of light and roughness.

use eframe::egui::Ui;

use super::Subject;
use crate::state::command::Command;

/// What is kept of it while it is open and after.
#[derive(Default)]
pub struct Plane {}

/// Draws it over all that is left of `ui`.
pub fn plane_ui(ui: &mut Ui, _study: &mut Plane, _subject: &Subject<'_>, _out: &mut Vec<Command>) {
    ui.label("Plane");
}
