//! The caption of a picture from a file: its name and size, in neutral ink. What made it is not known.

use eframe::egui::{Align2, Color32, FontId, Label, RichText, TextStyle, Ui};
use mislab_renderer::Layer;

use crate::look::layer::LayerLook;
use crate::look::theme::{GRID, medium};
use crate::panel::hint::Hint as _;
use crate::panel::widgets::cell;
use crate::picture::foreign::Foreign;
use crate::state::paths::shortened;

/// Why controls about how a picture is made are off.
pub const FROM_FILE: &str = "This picture is from a file: strategy, weights and sampler have no part in it.";

/// Characters of a name: at most where there is room, and at least.
const LONGEST: usize = 24;
const LEAST: usize = 6;

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

    /// In one line, or in the first of several.
    pub fn line_ui(&self, ui: &mut Ui, layer: Layer) {
        ui.spacing_mut().item_spacing.x = 2.5 * GRID;
        let size = TextStyle::Body.resolve(ui.style()).size;
        let ink = ui.visuals().strong_text_color();
        let font = FontId::new(size, medium());
        let text = self.fitting_name(ui, &font);
        let name = cell(ui, &text, &text, font, Some(ink), Align2::LEFT_CENTER);
        name.hint(format!(
            "{}: no control changes a picture from a file. Zoom, exposure and cursor are those of all pictures.",
            self.name
        ));
        let layer = (layer != Layer::Picture).then(|| format!("   {}", LayerLook::of(layer).name));
        let about =
            RichText::new(self.about.clone() + &layer.unwrap_or_default()).color(ui.visuals().weak_text_color());
        ui.add(Label::new(about).truncate())
            .hint("Size in pixels. Pictures of other sizes are aligned by their edges; pixels are read as they are.");
    }

    /// The name, its middle left out as far as the line has no room for it.
    fn fitting_name(&self, ui: &Ui, font: &FontId) -> String {
        let width = |text: &str| ui.painter().layout_no_wrap(text.to_owned(), font.clone(), Color32::WHITE).size().x;
        let shorter = (LEAST..LONGEST).rev().map(|most| shortened(&self.name, most));
        std::iter::once(shortened(&self.name, LONGEST))
            .chain(shorter)
            .find(|text| width(text) <= ui.available_width())
            .unwrap_or_else(|| shortened(&self.name, LEAST))
    }

    /// What [`Self::line_ui`] says, for screen readers.
    pub fn spoken_line(&self) -> String {
        format!("{}, {}", shortened(&self.name, LONGEST), self.about)
    }
}
