//! A picture in the window, with all that is drawn on it: legend, outlines, the pixel under the mouse.

use eframe::egui::{self, Align2, Rect, Ui};
use eframe::egui_wgpu::RenderState;

use crate::picture::film_texture::FilmPipeline;
use crate::picture::interaction::{Interaction, Place};
use crate::picture::legend::legend_overlay;
use crate::picture::live::LivePicture;
use crate::picture::picking::Target;
use crate::picture::pixel::Pixel;
use crate::picture::viewport::{Shown, Viewport};
use crate::state::command::Command;
use crate::state::document::Document;
use crate::state::placement::Geometry;

/// What a pane is to show.
pub struct Subject<'a> {
    /// Which slot of the document.
    pub slot: usize,
    /// Its frames.
    pub live: &'a LivePicture,
    /// What the mouse is on in a panel.
    pub pointed_at: Option<Target>,
}

/// One picture on screen.
pub struct Pane {
    viewport: Viewport,
    geometry: Option<Geometry>,
    pixel: Option<[u32; 2]>,
    interaction: Interaction,
}

impl Pane {
    fn new(pipeline: Option<FilmPipeline>) -> Self {
        Self { viewport: Viewport::new(pipeline), geometry: None, pixel: None, interaction: Interaction::default() }
    }

    /// Where the picture lay in the last pass; `None` without a frame.
    pub fn geometry(&self) -> Option<Geometry> {
        self.geometry
    }

    /// The pixel that was under the mouse, in coordinates of the full image.
    pub fn pixel(&self) -> Option<[u32; 2]> {
        self.pixel
    }

    /// What the mouse was on.
    pub fn hovered(&self) -> Option<Target> {
        self.interaction.hovered()
    }

    /// Draws it over all that is left of `ui`, and lets the mouse zoom, pan and drag lights. Returns where.
    pub fn ui(&mut self, ui: &mut Ui, document: &mut Document, on: &Subject<'_>, out: &mut Vec<Command>) -> Rect {
        let layer = document.slots()[on.slot].layer;
        let frame = on.live.frame();
        let planes = frame.as_ref().map(|frame| self.viewport.planes_of(frame, layer));
        let stale = on.live.marked_in().is_some_and(|wait| wait.is_zero());
        let shown = self.viewport.ui(ui, &mut document.view, Shown { layer, planes: planes.as_ref(), stale });
        self.geometry = shown.geometry;
        self.pixel = shown.hovered_pixel;
        let rect = shown.response.rect;
        let Some(frame) = frame else {
            let text = "Rendering the first picture \u{2026}";
            let font = egui::TextStyle::Heading.resolve(ui.style());
            ui.painter().text(rect.center(), Align2::CENTER_CENTER, text, font, ui.visuals().weak_text_color());
            return rect;
        };
        if let Some(geometry) = self.geometry {
            let place = Place { document, geometry, pixel: self.pixel };
            self.interaction.ui(ui, &place, on.pointed_at, out);
        }
        legend_overlay(ui, rect, layer, &document.view);
        if let Some(at) = self.pixel {
            Pixel { frame: &frame, at }.overlay(ui, rect, layer);
        }
        rect
    }
}

/// The pictures of the window, one for each slot of the document, and what they are all drawn with.
pub struct Panes {
    pipeline: Option<FilmPipeline>,
    panes: Vec<Pane>,
}

impl Panes {
    /// Drawn on that device, or on the CPU if there is none or it refuses the shader. None yet: see
    /// [`Self::set_count`].
    pub fn new(render_state: Option<&RenderState>) -> Self {
        Self { pipeline: render_state.and_then(FilmPipeline::new), panes: Vec::new() }
    }

    /// As many as the document has slots: the last ones go, or new ones come.
    pub fn set_count(&mut self, count: usize) {
        self.panes.resize_with(count, || Pane::new(self.pipeline.clone()));
    }

    /// The panes, in the order of the slots.
    pub fn all(&self) -> &[Pane] {
        &self.panes
    }

    /// The same, to draw them.
    pub fn all_mut(&mut self) -> &mut [Pane] {
        &mut self.panes
    }

    /// What the mouse was on in any of them.
    pub fn hovered(&self) -> Option<Target> {
        self.panes.iter().find_map(Pane::hovered)
    }

    /// Without the graphics device from here on.
    pub fn draw_on_cpu(&mut self) {
        self.pipeline = None;
        for pane in &mut self.panes {
            pane.viewport = Viewport::new(None);
        }
    }
}
