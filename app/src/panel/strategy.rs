//! The strategies, big, always there, and c.

use eframe::egui::{self, Align2, FontId, Sense, TextStyle, Ui, Vec2, vec2};
use mislab_renderer::{Estimator, Strategy};

use crate::look::names::strategy_name;
use crate::look::theme::{GRID, Inks, medium, strategy_fill};
use crate::panel::explain;
use crate::panel::hint::Hint as _;
use crate::panel::widgets::{ParamSlider, Scale, focus_ring};
use crate::state::command::Command;
use crate::state::edit::Edit;

/// Four buttons in the strategies' colours in a row, each as wide as its name.
pub fn row_ui(ui: &mut Ui, estimator: &Estimator, out: &mut Vec<Command>) {
    for (index, strategy) in Strategy::ALL.into_iter().enumerate() {
        let body = TextStyle::Body.resolve(ui.style()).size;
        let size = vec2(button_width(ui, strategy), ui.available_height().min(2.6 * body));
        if button(ui, size, index + 1, strategy, estimator) {
            out.push(Edit::SetStrategy(strategy).into());
        }
    }
}

/// How wide that row is.
pub fn row_width(ui: &Ui) -> f32 {
    let buttons: f32 = Strategy::ALL.into_iter().map(|strategy| button_width(ui, strategy)).sum();
    buttons + ui.spacing().item_spacing.x * (Strategy::ALL.len() - 1) as f32
}

fn button_width(ui: &Ui, strategy: Strategy) -> f32 {
    let name = ui.painter().layout_no_wrap(strategy_name(strategy).into(), name_font(ui), egui::Color32::WHITE);
    name.size().x + 3.4 * TextStyle::Body.resolve(ui.style()).size
}

/// The same in two rows over the width of a column.
pub fn square_ui(ui: &mut Ui, estimator: &Estimator, out: &mut Vec<Command>) {
    let size = vec2(0.5 * (ui.available_width() - 2.0 * GRID), 2.4 * TextStyle::Body.resolve(ui.style()).size);
    for (row, pair) in Strategy::ALL.chunks(2).enumerate() {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 2.0 * GRID;
            for (column, strategy) in pair.iter().enumerate() {
                if button(ui, size, 2 * row + column + 1, *strategy, estimator) {
                    out.push(Edit::SetStrategy(*strategy).into());
                }
            }
        });
    }
}

/// c, over the width given.
pub fn light_prob_ui(ui: &mut Ui, estimator: &Estimator, default: f32, width: f32, out: &mut Vec<Command>) {
    let matters = estimator.strategy == Strategy::Mis;
    let height = ui.spacing().interact_size.y;
    let layout = egui::Layout::left_to_right(egui::Align::Center);
    ui.allocate_ui_with_layout(vec2(width, height), layout, |ui| {
        ui.add_enabled_ui(matters, |ui| {
            let edit = ParamSlider {
                name: "c",
                label_width: TextStyle::Body.resolve(ui.style()).size,
                value: f64::from(estimator.light_prob),
                default: f64::from(default),
                range: 0.0..=1.0,
                scale: Scale::Linear(2),
                template: "0.00",
                unit: "",
                accent: Some(strategy_fill(Strategy::Light).0),
                zero_text: "",
                explain: &|ui| explain::light_prob(ui, matters),
            }
            .show(ui);
            if let Some(c) = edit.changed {
                out.push(Edit::SetLightProb(c as f32).into());
            }
        });
    });
}

fn name_font(ui: &Ui) -> FontId {
    FontId::new(TextStyle::Body.resolve(ui.style()).size * 1.12, medium())
}

/// Its key, its name, and the word for it in scene files. Returns whether it was clicked.
fn button(ui: &mut Ui, size: Vec2, key: usize, strategy: Strategy, estimator: &Estimator) -> bool {
    // Of what none of them has made, none is chosen.
    let on = estimator.strategy == strategy && ui.is_enabled();
    let inks = Inks::of(ui.visuals());
    let body = TextStyle::Body.resolve(ui.style()).size;
    let name = strategy_name(strategy);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let (fill, on_fill) = strategy_fill(strategy);
    let (fill, ink) = if on {
        (fill, on_fill)
    } else if response.hovered() || response.has_focus() {
        (ui.visuals().widgets.hovered.weak_bg_fill, ui.visuals().text_color())
    } else {
        (ui.visuals().widgets.inactive.weak_bg_fill, ui.visuals().text_color())
    };
    let painter = ui.painter();
    painter.rect_filled(rect, 6.0, fill);
    if !on {
        // The strategy's colour stays in sight while it is off.
        let edge = egui::Rect::from_min_max(egui::pos2(rect.left(), rect.bottom() - GRID), rect.max);
        let corners = egui::CornerRadius { nw: 0, ne: 0, sw: 6, se: 6 };
        painter.rect_filled(edge, corners, inks.strategy(strategy));
    }
    focus_ring(ui, &response, rect);
    let quiet = if on { ink } else { ui.visuals().weak_text_color() };
    let at = |x: f32, y: f32| egui::pos2(rect.left() + x * body, rect.center().y + y * body);
    painter.text(at(0.8, -0.45), Align2::LEFT_CENTER, key, FontId::proportional(body), quiet);
    painter.text(at(2.2, -0.45), Align2::LEFT_CENTER, name, name_font(ui), ink);
    let small = FontId::proportional(TextStyle::Small.resolve(ui.style()).size);
    painter.text(at(2.2, 0.58), Align2::LEFT_CENTER, strategy.name(), small, quiet);
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::RadioButton, true, on, format!("{key} {name}")));
    response.hint_ui(|ui| explain::strategy(ui, estimator, strategy)).clicked()
}
