//! The caption of a picture from a file: its name and size, in neutral ink. What made it is not known.

use eframe::egui::{Align2, FontId, Label, RichText, Ui};
use mislab_renderer::Layer;

use crate::look::layer::LayerLook;
use crate::look::theme::{GRID, medium};
use crate::panel::caption::line_font;
use crate::panel::hint::Hint as _;
use crate::panel::widgets::{cell, text_width};
use crate::picture::foreign::Foreign;
use crate::state::paths::shortened;

/// Why controls about how a picture is made are off.
pub const FROM_FILE: &str = "This picture is from a file: strategy, weights and sampler have no part in it.";

/// Characters of a name: at most, and at least.
const LONGEST: usize = 24;
const SHORTEST: usize = 12;

/// The file in words.
pub struct FileCaption {
    name: String,
    about: String,
}

impl FileCaption {
    /// `image`: the size of the pictures it is compared with.
    pub fn new(file: &Foreign, image: [u32; 2]) -> Self {
        let [w, h] = file.size();
        // Pictures are aligned by their edges.
        let aligned = if file.size() == image { "" } else { ", aligned" };
        Self { name: file.name().to_owned(), about: format!("{w} x {h}, from file{aligned}") }
    }

    /// In one line, or in the first of several: the name, and what else is known and the `layer`, where all of that has room.
    pub fn line_ui(&self, ui: &mut Ui, layer: Option<Layer>) {
        ui.spacing_mut().item_spacing.x = 2.0 * GRID;
        let font = line_font(ui);
        let medium = FontId::new(font.size, medium());
        let layer = layer.map(|layer| format!("   {}", LayerLook::of(layer).name));
        let about = self.about.clone() + &layer.unwrap_or_default();
        let room = ui.available_width();
        let beside = room - text_width(ui, &about, &font) - ui.spacing().item_spacing.x;
        let short = self.fitting_name(ui, &medium, beside);
        let alone = short.is_none();
        let name =
            short.or_else(|| self.fitting_name(ui, &medium, room)).unwrap_or_else(|| shortened(&self.name, SHORTEST));
        let ink = ui.visuals().strong_text_color();
        cell(ui, &name, &name, medium, Some(ink), Align2::LEFT_CENTER).hint(format!(
            "{}, {}: no control changes a picture from a file. Zoom, exposure and cursor are those of all pictures.",
            self.name, self.about
        ));
        if !alone {
            let about = RichText::new(about).font(font).color(ui.visuals().weak_text_color());
            ui.add(Label::new(about).truncate()).hint(
                "Size in pixels. Pictures of other sizes are aligned by their edges; pixels are read as they are.",
            );
        }
    }

    /// As much of the name as fits into `room`, its middle left out; `None` if that says too little.
    fn fitting_name(&self, ui: &Ui, font: &FontId, room: f32) -> Option<String> {
        let mut names = (SHORTEST..=LONGEST).rev().map(|most| shortened(&self.name, most));
        names.find(|name| text_width(ui, name, font) <= room)
    }

    /// What [`Self::line_ui`] says, for screen readers.
    pub fn spoken_line(&self) -> String {
        format!("{}, {}", shortened(&self.name, LONGEST), self.about)
    }
}
