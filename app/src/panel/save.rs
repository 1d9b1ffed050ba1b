//! Snapshots: where they go and what they are called.

use eframe::egui::{Align, Layout, Response, RichText, TextEdit, TextStyle, Ui, vec2};

use crate::look::theme::{GRID, Inks};
use crate::panel::hint::Hint as _;
use crate::panel::widgets::{caption, labelled, title, wide_button};
use crate::state::command::Command;
use crate::state::destination::Destination;
use crate::state::document::Document;
use crate::state::file_name;

/// The panel. `spp` is what the picture has by the time it is saved, as far as one knows.
pub fn save_ui(
    ui: &mut Ui,
    destination: &mut Destination,
    png: &mut bool,
    document: &Document,
    spp: u32,
    out: &mut Vec<Command>,
) {
    title(ui, "Snapshot");
    let label = 72.0;
    labelled(ui, "Name", label, |ui| {
        let default = Destination::default_name(document, spp);
        let edit = defaulted(ui, &mut destination.name, default, ui.available_width(), "Snapshot name");
        edit.hint("Scene, strategy and samples per pixel, unless you type something else.");
    });
    // Its room is there with and without: what is below never moves.
    let room = vec2(ui.available_width(), 2.0 * ui.text_style_height(&TextStyle::Small));
    ui.allocate_ui_with_layout(room, Layout::top_down(Align::Min), |ui| {
        ui.set_min_size(room);
        match file_name::check(&destination.name(document, Some(spp))) {
            Err(why) => ui.label(RichText::new(why).small().color(Inks::of(ui.visuals()).wrong)),
            Ok(()) => caption(ui, "A number is added where a file is already there."),
        }
    });
    labelled(ui, "Folder", label, |ui| {
        ui.spacing_mut().item_spacing.x = GRID;
        let button = 40.0;
        let default = Destination::default_folder(document).display().to_string();
        let width = ui.available_width() - button - GRID;
        let edit = defaulted(ui, &mut destination.folder, default, width, "Snapshot folder");
        edit.hint(format!(
            "{}\nThe scene's own folder, unless you choose another.",
            destination.folder(document).display()
        ));
        if wide_button(ui, "\u{2026}", button).accessible_name("Choose folder").clicked() {
            out.push(Command::ChooseFolder);
        }
    });
    ui.horizontal(|ui| {
        ui.checkbox(png, "PNG of the view");
        if wide_button(ui, "Save EXR", ui.available_width()).accessible_name("Save snapshot").clicked() {
            out.push(Command::Save);
        }
    });
}

/// A field that shows a default until something else is typed, and again when all of it is taken away.
fn defaulted(ui: &mut Ui, typed: &mut Option<String>, default: String, width: f32, name: &str) -> Response {
    let mut text = typed.clone().unwrap_or_else(|| default.clone());
    let edit = ui.add(TextEdit::singleline(&mut text).desired_width(width)).accessible_name(name);
    if edit.changed() {
        *typed = Some(text).filter(|text| *text != default);
    } else if !edit.has_focus() && typed.as_ref().is_some_and(|text| text.trim().is_empty()) {
        *typed = None;
    }
    edit
}
