//! How the picture is looked at: layer, exposure, tone map. None of it reaches the renderer.

use eframe::egui::{self, ComboBox, Ui};
use mislab_renderer::{Layer, Strategy, Technique};

use crate::look::layer::{Colouring, LayerLook};
use crate::look::theme::{GRID, Inks, strategy_fill};
use crate::panel::widgets::{ParamSlider, Scale, segmented, title, wide_button};
use crate::state::command::Command;
use crate::state::document::Document;
use crate::state::edit::Edit;
use crate::state::view::{ToneMap, ViewState};

/// The panel.
pub fn display_ui(ui: &mut Ui, document: &Document, out: &mut Vec<Command>) {
    let shown = document.active().layer;
    title(ui, "Layer");
    ui.scope(|ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        for layer in Layer::ALL {
            if layer_row(ui, layer, shown == layer) {
                out.push(Edit::SetLayer(layer).into());
            }
        }
    });
    let (view, default) = (&document.view, &document.opened.view);
    match LayerLook::of(shown).colouring {
        Colouring::Radiance => colour_ui(ui, view, default, out),
        Colouring::Magnitude => variance_ui(ui, view, default, out),
        // Its range is 0 to 1, whatever the picture.
        Colouring::Share { .. } => {}
    }
}

/// The layers in one menu, for the bar of the projector view.
pub fn layer_menu(ui: &mut Ui, shown: Layer, width: f32, out: &mut Vec<Command>) {
    let response = ComboBox::from_id_salt("layer menu")
        .width(width)
        .selected_text(LayerLook::of(shown).name)
        .show_ui(ui, |ui| {
            for layer in Layer::ALL {
                if ui.selectable_label(layer == shown, LayerLook::of(layer).name).clicked() {
                    out.push(Edit::SetLayer(layer).into());
                    ui.close();
                }
            }
        })
        .response;
    response.accessible_name("Layer menu");
}

fn layer_row(ui: &mut Ui, layer: Layer, on: bool) -> bool {
    let height = ui.spacing().interact_size.y;
    let (rect, response) = ui.allocate_exact_size(egui::vec2(ui.available_width(), height), egui::Sense::click());
    let fill = if on {
        ui.visuals().selection.bg_fill
    } else if response.hovered() || response.has_focus() {
        ui.visuals().widgets.hovered.weak_bg_fill
    } else {
        egui::Color32::TRANSPARENT
    };
    ui.painter().rect_filled(rect, 4.0, fill);
    let LayerLook { name, technique, .. } = LayerLook::of(layer);
    // The technique a layer is about, in its colour.
    let dot = technique.map(|technique| match technique {
        Technique::Light => strategy_fill(Strategy::Light).0,
        Technique::Bsdf => Inks::of(ui.visuals()).bsdf,
    });
    let at = egui::pos2(rect.left() + 3.0 * GRID, rect.center().y);
    match dot {
        Some(color) => ui.painter().circle_filled(at, 4.0, color),
        None => ui.painter().circle_stroke(at, 3.5, egui::Stroke::new(1.5, ui.visuals().weak_text_color())),
    };
    let font = egui::TextStyle::Body.resolve(ui.style());
    let at = egui::pos2(rect.left() + 6.0 * GRID, rect.center().y);
    ui.painter().text(at, egui::Align2::LEFT_CENTER, name, font, ui.visuals().text_color());
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::RadioButton, true, on, format!("Layer: {name}")));
    response.clicked()
}

fn colour_ui(ui: &mut Ui, view: &ViewState, default: &ViewState, out: &mut Vec<Command>) {
    title(ui, "Display");
    let exposure = ParamSlider {
        name: "Exposure",
        label_width: 72.0,
        value: f64::from(view.exposure_ev),
        default: f64::from(default.exposure_ev),
        range: -10.0..=10.0,
        scale: Scale::Linear(1),
        template: "-10.0",
        unit: " EV",
        accent: None,
        zero_text: "",
    }
    .show(ui);
    if let Some(ev) = exposure.changed {
        out.push(Edit::SetExposure(ev as f32).into());
    }
    let offset = ParamSlider {
        name: "Offset",
        label_width: 72.0,
        value: f64::from(view.offset),
        default: f64::from(default.offset),
        range: -1.0..=1.0,
        scale: Scale::Linear(2),
        // As wide as the exposure's, so that both rails end at one place.
        template: "-10.0 EV",
        unit: "",
        accent: None,
        zero_text: "",
    }
    .show(ui);
    if let Some(offset) = offset.changed {
        out.push(Edit::SetOffset(offset as f32).into());
    }
    let tone_maps: Vec<(ToneMap, &str, &str)> =
        ToneMap::ALL.into_iter().map(|t| (t, t.name(), t.description())).collect();
    if let Some(tone_map) = segmented(ui, "Tone map", view.tone_map, &tone_maps, true) {
        out.push(Edit::SetToneMap(tone_map).into());
    }
    buttons(ui, "Sets the exposure so that 99 of 100 pixels stay below white. (N)", out);
}

fn variance_ui(ui: &mut Ui, view: &ViewState, default: &ViewState, out: &mut Vec<Command>) {
    title(ui, "Range of the colour bar");
    let [low, high] = view.variance_range;
    let slider = |name, value: f32, default: f32| ParamSlider {
        name,
        label_width: 72.0,
        value: f64::from(value),
        default: f64::from(default),
        range: -12.0..=12.0,
        scale: Scale::Linear(0),
        template: "-12",
        unit: "",
        accent: None,
        zero_text: "",
    };
    let edit_low = slider("from 10^", low, default.variance_range[0]).show(ui);
    if let Some(value) = edit_low.changed {
        let value = value as f32;
        out.push(Edit::SetVarianceRange([value, high.max(value + 1.0)]).into());
    }
    let edit_high = slider("to 10^", high, default.variance_range[1]).show(ui);
    if let Some(value) = edit_high.changed {
        let value = value as f32;
        out.push(Edit::SetVarianceRange([low.min(value - 1.0), value]).into());
    }
    buttons(ui, "Sets the range to whole decades that hold 98 of 100 pixels. (N)", out);
}

fn buttons(ui: &mut Ui, hint: &str, out: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = GRID;
        let width = (ui.available_width() - GRID) / 2.0;
        if wide_button(ui, "Normalise", width).on_hover_text(hint).clicked() {
            out.push(Command::Normalise);
        }
        if wide_button(ui, "Reset view", width).on_hover_text("Exposure, offset, tone map and ranges. (R)").clicked() {
            out.push(Edit::ResetView.into());
        }
    });
}
