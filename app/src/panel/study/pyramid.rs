//! Each technique: its picture, its weights, both multiplied; the sum is the picture.

use eframe::egui::Ui;

use super::Subject;
use crate::state::command::Command;

/// What is kept of it while it is open and after.
#[derive(Default)]
pub struct Pyramid {}

/// Draws it over all that is left of `ui`.
pub fn pyramid_ui(ui: &mut Ui, _study: &mut Pyramid, _subject: &Subject<'_>, _out: &mut Vec<Command>) {
    ui.label("Pyramid");
}
