//! A sheet with all that it needs where there is no window round it: legends, and a line that says what is shown.

use std::sync::Arc;

use eframe::egui::text::LayoutJob;
use eframe::egui::{Galley, TextStyle, Ui, pos2, vec2};
use mislab_renderer::Layer;

use crate::look::theme::TypeScale;
use crate::picture::legend::{hatched_on_paper, legend_on_paper};
use crate::picture::png_file;
use crate::picture::raster::Offscreen;
use crate::picture::sheet::Sheet;
use crate::picture::vector;
use crate::state::view::ViewState;

/// Round what stands under the sheet, in points.
const MARGIN: f32 = 12.0;
/// Pixels to a point.
const SCALE: f32 = 2.0;

/// A figure to be made, on any thread.
pub struct Paper {
    /// What was on screen.
    pub sheet: Arc<Sheet>,
    /// Layers whose colours are explained under it.
    pub legends: Vec<Layer>,
    /// How they come about.
    pub view: ViewState,
    /// What stands under it.
    pub lines: Vec<String>,
    /// Dark theme?
    pub dark: bool,
    /// The size of type.
    pub type_scale: TypeScale,
}

impl Paper {
    /// Width and height in pixels, and rows of RGBA8 from the top left; two pixels to a point.
    pub fn rgba(&self) -> ([u32; 2], Vec<u8>) {
        let drawn = self.drawn();
        (drawn.size, drawn.pixels())
    }

    /// The bytes of a PNG.
    ///
    /// # Errors
    /// As the encoder.
    pub fn png(&self) -> Result<Vec<u8>, png::EncodingError> {
        let ([width, height], rgba) = self.rgba();
        png_file::encode(width, height, &rgba)
    }

    /// The text of an SVG.
    ///
    /// # Errors
    /// As the encoder of PNG, for what has to be an image in it.
    pub fn svg(&self) -> Result<String, png::EncodingError> {
        vector::svg(&self.drawn())
    }

    fn drawn(&self) -> Offscreen {
        let sheet = self.sheet.size();
        // Laid out once for its height, and once in its place.
        let mut strip = 0.0;
        let place = [sheet.x, sheet.y.max(1.0)];
        drop(self.pass(place, |ui| strip = self.strip_ui(ui)));
        self.pass([sheet.x, sheet.y + strip], |ui| {
            self.sheet.ui(ui);
            self.strip_ui(ui);
        })
    }

    fn pass(&self, size: [f32; 2], add: impl FnMut(&mut Ui)) -> Offscreen {
        let size = size.map(|side| (side * SCALE).ceil().max(1.0) as u32);
        Offscreen::new(size, SCALE, self.dark, self.type_scale, add)
    }

    /// Draws what stands under the sheet and returns its height.
    fn strip_ui(&self, ui: &Ui) -> f32 {
        let top = self.sheet.size().y;
        let width = self.sheet.size().x - 2.0 * MARGIN;
        let mut at = pos2(MARGIN, top + MARGIN);
        for layer in &self.legends {
            at.y += legend_on_paper(ui, at, *layer, &self.view, width).y + MARGIN;
        }
        let hatched = self.sheet.has_hatched_colours();
        if hatched {
            at.y += hatched_on_paper(ui, at) + MARGIN;
        }
        for line in &self.lines {
            let ink = ui.visuals().strong_text_color();
            let galley = one_line(ui, line, width);
            let height = galley.size().y;
            ui.painter().galley(at, galley, ink);
            at += vec2(0.0, height);
        }
        if self.legends.is_empty() && self.lines.is_empty() && !hatched { 0.0 } else { at.y + MARGIN - top }
    }
}

/// Cut where there is no room.
fn one_line(ui: &Ui, text: &str, width: f32) -> Arc<Galley> {
    let font = TextStyle::Small.resolve(ui.style());
    let mut job = LayoutJob::simple_singleline(text.to_owned(), font, ui.visuals().strong_text_color());
    job.wrap.max_width = width;
    job.wrap.max_rows = 1;
    job.wrap.break_anywhere = true;
    ui.fonts_mut(|fonts| fonts.layout_job(job))
}
