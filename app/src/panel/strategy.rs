//! The strategy bar: big, always there.

use eframe::egui::{self, Align2, FontId, Sense, Stroke, StrokeKind, TextStyle, Ui, vec2};
use mislab_renderer::{Estimator, Strategy};

use crate::look::names::{strategy_description, strategy_name};
use crate::look::theme::{GRID, Inks, TypeScale, medium, strategy_fill};
use crate::panel::widgets::{ParamSlider, Scale};
use crate::state::command::Command;
use crate::state::edit::Edit;

/// Four buttons in the strategies' colours, then c.
pub fn bar_ui(ui: &mut Ui, estimator: &Estimator, default_c: f32, scale: TypeScale, out: &mut Vec<Command>) {
    for (index, strategy) in Strategy::ALL.into_iter().enumerate() {
        if strategy_button(ui, index + 1, strategy, estimator.strategy == strategy) {
            out.push(Edit::SetStrategy(strategy).into());
        }
    }
    ui.add_space(2.0 * GRID);
    // The menu needs its place at the right end.
    let room = ui.available_width() - 110.0;
    if room < 140.0 {
        return;
    }
    let matters = estimator.strategy == Strategy::Mis;
    let width: f32 = match scale {
        TypeScale::Desk => 300.0,
        TypeScale::Hall => 460.0,
    };
    let inner = ui.allocate_ui_with_layout(
        vec2(width.min(room), ui.spacing().interact_size.y),
        egui::Layout::left_to_right(egui::Align::Center),
        |ui| {
            ui.add_enabled_ui(matters, |ui| {
                let edit = ParamSlider {
                    name: "c",
                    label_width: if scale == TypeScale::Hall { 28.0 } else { 16.0 },
                    value: f64::from(estimator.light_prob),
                    default: f64::from(default_c),
                    range: 0.0..=1.0,
                    scale: Scale::Linear(2),
                    template: "0.00",
                    unit: "",
                    accent: Some(strategy_fill(Strategy::Light).0),
                    zero_text: "",
                }
                .show(ui);
                if let Some(c) = edit.changed {
                    out.push(Edit::SetLightProb(c as f32).into());
                }
            });
        },
    );
    inner.response.on_hover_text(if matters {
        "Probability of drawing the direction from the lights."
    } else {
        "Probability of drawing from the lights: takes part in strategy 4 only."
    });
}

fn strategy_button(ui: &mut Ui, key: usize, strategy: Strategy, on: bool) -> bool {
    let inks = Inks::of(ui.visuals());
    let body = TextStyle::Body.resolve(ui.style()).size;
    let font = FontId::new(body * 1.12, medium());
    let key_font = FontId::proportional(body);
    let name = strategy_name(strategy);
    let painter = ui.painter();
    let text_width = painter.layout_no_wrap(name.into(), font.clone(), egui::Color32::WHITE).size().x;
    let height = ui.available_height().min(2.5 * body);
    let size = vec2(text_width + 3.4 * body, height);
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
    if response.has_focus() {
        painter.rect_stroke(rect, 6.0, Stroke::new(2.0, ui.visuals().text_color()), StrokeKind::Inside);
    }
    let key_at = egui::pos2(rect.left() + 0.8 * body, rect.center().y);
    let key_ink = if on { ink } else { ui.visuals().weak_text_color() };
    painter.text(key_at, Align2::LEFT_CENTER, key, key_font, key_ink);
    let name_at = egui::pos2(rect.left() + 2.2 * body, rect.center().y);
    painter.text(name_at, Align2::LEFT_CENTER, name, font, ink);
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::RadioButton, true, on, format!("{key} {name}")));
    response.on_hover_text(strategy_description(strategy)).clicked()
}
