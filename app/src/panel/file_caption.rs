//! The caption of a picture from a file: its name and size, in neutral ink. What made it is not known.

use eframe::egui::{Align2, FontId, Label, RichText, TextStyle, Ui};
use mislab_renderer::Layer;

use crate::look::layer::LayerLook;
use crate::look::theme::{GRID, medium};
use crate::panel::hint::Hint as _;
use crate::panel::widgets::cell;
use crate::picture::foreign::Foreign;
use crate::state::paths::shortened;

/// Why controls about how a picture is made are off.
pub const FROM_FILE: &str = "This picture is from a file: strategy, weights and sampler have no part in it.";

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
        Self { name: shortened(file.name(), 24), about: format!("{w} x {h}, from file{aligned}") }
    }

    /// In one line, or in the first of several.
    pub fn line_ui(&self, ui: &mut Ui, layer: Layer) {
        ui.spacing_mut().item_spacing.x = 2.5 * GRID;
        let size = TextStyle::Body.resolve(ui.style()).size;
        let ink = ui.visuals().strong_text_color();
        let name = cell(ui, &self.name, &self.name, FontId::new(size, medium()), Some(ink), Align2::LEFT_CENTER);
        name.hint("A picture from a file: no control changes it. Zoom, exposure and cursor are those of all pictures.");
        let layer = (layer != Layer::Picture).then(|| format!("   {}", LayerLook::of(layer).name));
        let about =
            RichText::new(self.about.clone() + &layer.unwrap_or_default()).color(ui.visuals().weak_text_color());
        ui.add(Label::new(about).truncate())
            .hint("Size in pixels. Pictures of other sizes are aligned by their edges; pixels are read as they are.");
    }

    /// What [`Self::line_ui`] says, for screen readers.
    pub fn spoken_line(&self) -> String {
        format!("{}, {}", self.name, self.about)
    }
}
