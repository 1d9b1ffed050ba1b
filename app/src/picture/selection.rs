//! A part of the picture, dragged out with Shift: what sentences, curves and means are about instead of all of it.

use eframe::egui::{Color32, CursorIcon, PointerButton, Pos2, Rect, Response, Stroke, StrokeKind, Ui};
use mislab_renderer::PixelRect;
use mislab_renderer::study::whole_blocks;

use crate::state::placement::Geometry;

/// A rectangle of the full image, made of the blocks that errors are kept by.
#[derive(Default)]
pub struct Selection {
    part: Option<PixelRect>,
    /// Where it began to be dragged out.
    from: Option<[u32; 2]>,
}

impl Selection {
    /// The rectangle; `None`: all.
    pub fn part(&self) -> Option<PixelRect> {
        self.part
    }

    /// Of a picture of `bounds` there is no part outside.
    pub fn keep_within(&mut self, bounds: PixelRect) {
        self.part = self.part.and_then(|part| whole_blocks(part, bounds));
    }

    /// Lets the mouse select in a picture of `bounds`, which has given that response, and outlines the part: with Shift a drag selects one,
    /// and a click all.
    pub fn ui(&mut self, ui: &Ui, response: &Response, geometry: &Geometry, bounds: PixelRect) {
        let shift = ui.input(|input| input.modifiers.shift);
        let pixel = |at: Pos2| {
            let at = geometry.to_image(at);
            [0, 1].map(|i| (at[i].max(0.0) as u32).clamp(bounds.min[i], bounds.max[i].saturating_sub(1)))
        };
        if shift && response.clicked() {
            self.part = None;
        }
        if shift && response.drag_started_by(PointerButton::Primary) {
            self.from = ui.input(|input| input.pointer.press_origin()).map(pixel);
        }
        if let (Some(from), Some(to)) = (self.from, response.interact_pointer_pos().map(pixel)) {
            let (min, max) = ([0, 1].map(|i| from[i].min(to[i])), [0, 1].map(|i| from[i].max(to[i]) + 1));
            self.part = whole_blocks(PixelRect { min, max }, bounds);
            ui.ctx().set_cursor_icon(CursorIcon::Crosshair);
        }
        if response.drag_stopped() {
            self.from = None;
        }
        if let Some(part) = self.part {
            outline(ui, response.rect, geometry, part);
        }
    }
}

fn outline(ui: &Ui, rect: Rect, geometry: &Geometry, part: PixelRect) {
    let [min, max] = [part.min, part.max].map(|at| geometry.to_screen(at.map(|v| v as f32)));
    let painter = ui.painter_at(rect);
    for (width, ink) in [(4.0, Color32::from_black_alpha(150)), (1.5, Color32::WHITE)] {
        painter.rect_stroke(Rect::from_min_max(min, max), 0.0, Stroke::new(width, ink), StrokeKind::Middle);
    }
}
