//! The projector view: the picture as large as it gets, beside one column or between two bars.

use eframe::egui::{Align, CentralPanel, Layout, Panel, Rect, TextStyle, Ui, Vec2, vec2};
use mislab_renderer::Layer;

use super::{
    FROM_FILE, LEGEND, active_legend_ui, bar_frame, caption_strip, column_frame, file_caption_ui, layer_menu, pictures,
    single_caption,
};
use crate::lab::Lab;
use crate::look::layer::LayerLook;
use crate::look::theme::{GRID, TypeScale};
use crate::panel::caption::waiting_ui;
use crate::panel::widgets::text_width;
use crate::panel::{compare, display, formula, menu, status, strategy};
use crate::picture::content::Content;
use crate::picture::legend::{Key, hatched_ui, legend_size};
use crate::state::arrangement::Arrangement;
use crate::state::command::Command;
use crate::state::study::Study;

/// The projector view, in whichever of the two ways makes the picture larger. Returns where the pictures are.
pub(super) fn hall_ui(ui: &mut Ui, lab: &mut Lab, out: &mut Vec<Command>) -> Rect {
    let strip = strip_height(ui, lab);
    if lab.studies.open.is_some_and(Study::is_beside_pictures) {
        // The study takes the column's place: without the picture nobody could point at a pixel.
        caption_strip(ui, lab, strip, out);
        return CentralPanel::no_frame().show(ui, |ui| pictures(ui, lab, false, out)).inner;
    }
    let size = ui.available_size();
    let [columns, rows] = lab.document.arrangement().grid().map(|n| n as f32);
    let aspect = columns / rows * lab.document.view.placement.aspect(lab.document.image.resolution);
    // A study in place of the pictures gets all that the strategies leave.
    let column = if lab.studies.open.is_some() { Some(HALL_COLUMN) } else { hall_column(size, aspect, strip) };
    match column {
        Some(width) => {
            let panel = Panel::left("hall column").resizable(false).exact_size(width).show_separator_line(false);
            panel.frame(column_frame()).show(ui, |ui| hall_column_ui(ui, lab, out));
            CentralPanel::no_frame().show(ui, |ui| pictures(ui, lab, false, out)).inner
        }
        None => {
            let bar = Panel::top("hall bar").exact_size(HALL_BAR).frame(bar_frame()).show_separator_line(false);
            bar.show(ui, |ui| hall_bar_ui(ui, lab, out));
            caption_strip(ui, lab, strip, out);
            CentralPanel::no_frame().show(ui, |ui| pictures(ui, lab, false, out)).inner
        }
    }
}

/// Height in points of what stands over a wide picture in a hall.
const HALL_BAR: f32 = 186.0;
/// The least height of what stands under it: three lines.
pub(super) const HALL_CAPTION: f32 = 92.0;
/// What a menu takes beside the text in it.
const MENU_FRAME: f32 = 60.0;
/// Height of the caption in the column: three lines.
const HALL_LINES: f32 = 100.0;
/// The narrowest column that holds the strategies.
const HALL_COLUMN: f32 = 440.0;

/// Width of the column beside a picture of that shape in the projector view; `None` if the picture becomes larger with
/// bars above and below.
fn hall_column(size: Vec2, aspect: f32, strip: f32) -> Option<f32> {
    let column = (size.x - size.y * aspect).max(HALL_COLUMN);
    let beside = ((size.x - column) / aspect).min(size.y);
    let between = (size.x / aspect).min(size.y - HALL_BAR - strip);
    (beside >= between).then_some(column)
}

/// Height of the strip with caption and legend: room for that of any layer, so that nothing moves when another one is looked at.
fn strip_height(ui: &Ui, lab: &Lab) -> f32 {
    let height = |layer: Layer| {
        let key = Key { quantity: layer.into(), view: &lab.document.view, here: None };
        legend_size(ui, key, LEGEND).y
    };
    Layer::ALL.into_iter().map(height).fold(HALL_CAPTION, f32::max)
}

/// What the projector view has beside the picture.
fn hall_column_ui(ui: &mut Ui, lab: &Lab, out: &mut Vec<Command>) {
    let slot = *lab.document.active();
    let content = lab.live().content();
    let made = !slot.is_file();
    ui.add_enabled_ui(made, |ui| strategy::square_ui(ui, &slot.estimator, out));
    let default = lab.document.opened.settings.estimator.light_prob;
    ui.horizontal(|ui| {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            menu::menu_ui(ui, &lab.prefs, &lab.document, &lab.history, lab.studies.open.is_some(), out);
            let width = ui.available_width();
            ui.add_enabled_ui(made, |ui| strategy::light_prob_ui(ui, &slot.estimator, default, width, out));
        });
    });
    formula::formula_ui(ui, made.then_some(&slot.estimator), TypeScale::Hall);
    ui.with_layout(Layout::bottom_up(Align::Min), |ui| {
        ui.add_space(GRID);
        // Each of several pictures has its own caption, and the switch of what is equal needs the room.
        if lab.document.slots().len() == 1 {
            ui.allocate_ui(vec2(ui.available_width(), HALL_LINES), |ui| {
                ui.with_layout(Layout::top_down(Align::Min), |ui| match &content {
                    Some(Content::Frame(frame)) => single_caption(lab, frame).column_ui(ui),
                    Some(Content::File(file)) => file_caption_ui(ui, lab, file),
                    None => waiting_ui(ui),
                });
            });
        }
        if let Some(progress) = lab.sheets.table.progress() {
            ui.allocate_ui(vec2(ui.available_width(), ui.spacing().interact_size.y), |ui| {
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| status::table_ui(ui, &progress, out));
            });
        }
        ui.with_layout(Layout::top_down(Align::Min), |ui| {
            // A study, and two pictures as one, have colours of their own.
            let as_one = lab.document.arrangement() == Arrangement::Difference;
            let legend = !as_one && lab.studies.open.is_none();
            let named = legend && !LayerLook::of(slot.layer).is_colour();
            menus_ui(ui, lab, named, out);
            if lab.document.slots().len() > 1 {
                ui.horizontal(|ui| {
                    ui.label("Equal");
                    compare::equal_ui(ui, &lab.document, out);
                });
            }
            if named {
                active_legend_ui(ui, lab);
            } else if legend {
                hatched_ui(ui);
            }
        });
    });
}

/// The menus of layers and layouts: side by side where both names have room or that of the layer is `named` below, in a legend, which
/// needs the height.
fn menus_ui(ui: &mut Ui, lab: &Lab, named: bool, out: &mut Vec<Command>) {
    let layer = lab.document.active().layer;
    let font = TextStyle::Button.resolve(ui.style());
    let wide = |text: &str| text_width(ui, text, &font) + MENU_FRAME;
    let [first, second] = [LayerLook::of(layer).name, lab.document.arrangement().name()].map(wide);
    let (width, room) = (ui.available_width(), ui.available_width() - ui.spacing().item_spacing.x);
    if named || first + second <= room {
        ui.horizontal(|ui| {
            let first = first.min(room - second);
            // A menu cuts its name at the end of what it is in.
            ui.scope(|ui| {
                ui.set_max_width(first);
                display::layer_menu(ui, layer, first, out);
            });
            compare::layout_menu(ui, &lab.document, lab.studies.open, ui.available_width(), out);
        });
    } else {
        display::layer_menu(ui, layer, width, out);
        compare::layout_menu(ui, &lab.document, lab.studies.open, width, out);
    }
}

/// What the projector view has above a wide picture.
fn hall_bar_ui(ui: &mut Ui, lab: &Lab, out: &mut Vec<Command>) {
    let estimator = &lab.document.active().estimator;
    let made = !lab.document.active().is_file();
    ui.add_space(GRID);
    ui.allocate_ui(vec2(ui.available_width(), 62.0), |ui| {
        ui.horizontal_centered(|ui| {
            ui.add_enabled_ui(made, |ui| strategy::row_ui(ui, estimator, out));
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                menu::menu_ui(ui, &lab.prefs, &lab.document, &lab.history, lab.studies.open.is_some(), out);
            });
        });
    });
    ui.horizontal(|ui| {
        let default = lab.document.opened.settings.estimator.light_prob;
        let width = 0.36 * ui.available_width();
        ui.add_enabled_ui(made, |ui| strategy::light_prob_ui(ui, estimator, default, width, out));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            compare::layout_menu(ui, &lab.document, lab.studies.open, 250.0, out);
            layer_menu(ui, lab, 300.0, out);
        });
    });
    if made {
        formula::formula_line_ui(ui, estimator, 26.0);
    } else {
        ui.label(FROM_FILE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn in_a_hall_a_square_picture_has_the_whole_height() {
        assert_eq!(hall_column(vec2(1280.0, 720.0), 1.0, HALL_CAPTION), Some(560.0));
        assert_eq!(hall_column(vec2(1280.0, 720.0), 2.4, HALL_CAPTION), None, "a wide one has the whole width");
        assert_eq!(
            hall_column(vec2(960.0, 720.0), 1.0, HALL_CAPTION),
            Some(HALL_COLUMN),
            "larger than between two bars"
        );
    }
}
