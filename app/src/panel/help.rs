//! The key sheet.

use eframe::egui::{self, FontId, Grid, Id, Modal, RichText, ScrollArea, TextStyle};

use crate::look::theme::medium;
use crate::panel::widgets::{sheet_type, text_width, title};
use crate::state::keys::bindings;

/// The sheet. Returns false when it is done with.
pub fn help_ui(ctx: &egui::Context) -> bool {
    let bindings = bindings();
    let columns = [
        ["Strategy", "Layout", "Edit"].as_slice(),
        ["View", "Study"].as_slice(),
        ["File", "Rendering", "Window"].as_slice(),
    ];
    let modal = Modal::new(Id::unique("keys")).show(ctx, |ui| {
        sheet_type(ui);
        ui.heading("Keys");
        // The sheet scrolls where it must; its button is always in reach.
        let room = ctx.content_rect().size() - egui::vec2(60.0, 190.0);
        ui.set_max_width(room.x);
        let scroll = ScrollArea::both().max_height(room.y).max_width(room.x).auto_shrink(true);
        scroll.show(ui, |ui| {
            ui.horizontal_top(|ui| {
                for (index, groups) in columns.into_iter().enumerate() {
                    if index > 0 {
                        ui.add_space(10.0);
                    }
                    ui.vertical(|ui| {
                        let keys = bindings.iter().filter(|action| groups.contains(&action.group));
                        let font = FontId::new(TextStyle::Body.resolve(ui.style()).size, medium());
                        let wide = keys.map(|action| text_width(ui, action.keys, &font)).fold(0.0, f32::max);
                        for group in groups {
                            title(ui, group);
                            let grid = Grid::new(*group).num_columns(2).min_col_width(wide).min_row_height(0.0);
                            grid.spacing([10.0, 3.0]).show(ui, |ui| {
                                ui.spacing_mut().interact_size.y = 0.0;
                                for action in bindings.iter().filter(|a| a.group == *group) {
                                    ui.label(RichText::new(action.keys).family(medium()));
                                    ui.label(&action.name);
                                    ui.end_row();
                                }
                            });
                        }
                    });
                }
            })
        });
        ui.add_space(8.0);
        ui.label("Double-click a slider or a label: back to its default.");
        ui.label("On the picture: the wheel zooms, dragging moves, a double click fits.");
        ui.add_space(8.0);
        ui.button("Close").clicked()
    });
    !(modal.inner || modal.should_close())
}
