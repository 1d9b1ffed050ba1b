//! Error against samples, on logarithmic axes.

use eframe::egui::Ui;

use super::Subject;
use crate::state::command::Command;

/// What is kept of it while it is open and after.
#[derive(Default)]
pub struct Convergence {}

/// Draws it over all that is left of `ui`.
pub fn convergence_ui(ui: &mut Ui, _study: &mut Convergence, _subject: &Subject<'_>, _out: &mut Vec<Command>) {
    ui.label("Convergence");
}
