//! The reader's warnings over the picture's lower edge: they push nothing aside, and can be put away and called back.

use eframe::egui::{self, Align2, Area, CornerRadius, Id, Order, Rect, ScrollArea, Stroke, vec2};
use mislab_renderer::Diagnostic;

use crate::look::theme::GRID;
use crate::panel::messages::warnings_ui;
use crate::panel::widgets::sheet_type;

/// Shows them inside `picture`. Returns true when they are put away.
pub fn sheet_ui(ctx: &egui::Context, picture: Rect, warnings: &[Diagnostic]) -> bool {
    let width = (picture.width() - 6.0 * GRID).min(760.0);
    let at = picture.left_bottom() + vec2(3.0 * GRID, -3.0 * GRID);
    let area = Area::new(Id::unique("warnings")).order(Order::Middle).pivot(Align2::LEFT_BOTTOM).fixed_pos(at);
    let inner = area.show(ctx, |ui| {
        sheet_type(ui);
        ui.set_width(width);
        let frame = egui::Frame::new().fill(ui.visuals().window_fill).stroke(ui.visuals().window_stroke);
        let frame = frame.corner_radius(CornerRadius::same(6)).inner_margin(2.0 * GRID);
        frame.stroke(Stroke::new(1.0, ui.visuals().weak_text_color())).show(ui, |ui| {
            ScrollArea::vertical().max_height(0.4 * picture.height()).show(ui, |ui| warnings_ui(ui, warnings));
            ui.button("Close").accessible_name("Close warnings").clicked()
        })
    });
    inner.inner.inner
}
