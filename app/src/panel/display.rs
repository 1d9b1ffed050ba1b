//! How the picture is looked at: layer, exposure, tone map. None of it reaches the renderer.

use eframe::egui::{self, ComboBox, Ui};
use mislab_renderer::{Layer, Strategy, Technique};

use crate::look::layer::{Colouring, LayerLook};
use crate::look::theme::{GRID, Inks, strategy_fill};
use crate::panel::explain;
use crate::panel::exposure::exposure_ui;
use crate::panel::hint::{self, Hint as _};
use crate::panel::math::text;
use crate::panel::widgets::{ParamSlider, Scale, focus_ring, segmented, title, wide_button};
use crate::picture::histogram::Histogram;
use crate::picture::legend::{Key, colour_note, hatched_ui, legend_ui};
use crate::picture::tone::clipped_from;
use crate::state::command::Command;
use crate::state::document::Document;
use crate::state::edit::Edit;
use crate::state::view::{ToneMap, VarianceUnit, ViewState};

/// What the panel shows of the picture on screen.
pub struct Measured<'a> {
    /// How bright its pixels are.
    pub histogram: &'a Histogram,
    /// The number under the mouse.
    pub here: Option<f32>,
}

/// The panel.
pub fn display_ui(ui: &mut Ui, document: &Document, measured: &Measured<'_>, out: &mut Vec<Command>) {
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
    let key = Key { quantity: shown.into(), view, here: measured.here };
    match LayerLook::of(shown).colouring {
        Colouring::Radiance => colour_ui(ui, key, default, measured.histogram, out),
        Colouring::Magnitude => variance_ui(ui, key, default, out),
        // Their range does not depend on the picture.
        Colouring::Share { .. } | Colouring::Signed => {
            ui.add_space(2.0 * GRID);
            legend_ui(ui, key);
        }
    }
}

/// The layers in one menu, for the bar of the projector view.
pub fn layer_menu(ui: &mut Ui, shown: Layer, width: f32, out: &mut Vec<Command>) {
    let response = ComboBox::from_id_salt("layer menu")
        .width(width)
        .truncate()
        .selected_text(LayerLook::of(shown).name)
        .show_ui(ui, |ui| {
            let column = ui.max_rect().expand2(egui::vec2(3.0 * GRID, 0.0));
            hint::beside(ui, column, |ui| {
                for layer in Layer::ALL {
                    let row = ui.selectable_label(layer == shown, LayerLook::of(layer).name);
                    if row.hint_ui(|ui| explain::layer(ui, layer)).clicked() {
                        out.push(Edit::SetLayer(layer).into());
                        ui.close();
                    }
                }
            });
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
    focus_ring(ui, &response, rect);
    response.hint_ui(|ui| explain::layer(ui, layer)).clicked()
}

fn colour_ui(ui: &mut Ui, key: Key<'_>, default: &ViewState, histogram: &Histogram, out: &mut Vec<Command>) {
    let view = key.view;
    title(ui, "Display");
    histogram_ui(ui, key, histogram);
    hatched_ui(ui);
    let remark = "The radiances stay what they are. (E, Shift+E)";
    let exposure = exposure_ui(ui, ("Exposure", 72.0), view, default.exposure_ev, remark);
    out.extend(exposure.map(|ev| Edit::SetExposure(ev).into()));
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
        explain: &|ui| {
            text("x = 2^EV L + offset").show(ui, 18.0);
            hint::lines(ui, "Added after exposure: lifts what is too dark to see. (O, Shift+O)", &[]);
        },
    }
    .show(ui);
    if let Some(offset) = offset.changed {
        out.push(Edit::SetOffset(offset as f32).into());
    }
    let tone_maps = ToneMap::ALL.map(|t| (t, t.name()));
    let hint = |ui: &mut Ui, tone_map: ToneMap| {
        ui.label(tone_map.description());
    };
    let picked = segmented(ui, "Tone map", view.tone_map, &tone_maps, true, &hint);
    out.extend(picked.map(|tone_map| Edit::SetToneMap(tone_map).into()));
    clipped_ui(ui, view, out);
    buttons(ui, "Sets the exposure so that 99 of 100 pixels stay below white. (N)", out);
}

/// How bright the pixels are, from ten stops below white to four above, and how many are clipped.
fn histogram_ui(ui: &mut Ui, key: Key<'_>, histogram: &Histogram) {
    let view = key.view;
    let small = egui::TextStyle::Small.resolve(ui.style());
    let line = ui.text_style_height(&egui::TextStyle::Small);
    let size = egui::vec2(ui.available_width(), 36.0 + line);
    let (rect, response) = ui.allocate_exact_size(size, egui::Sense::hover());
    let (graph, words) = rect.split_top_bottom_at_y(rect.top() + 36.0);
    let painter = ui.painter();
    painter.rect_filled(graph, 2.0, ui.visuals().extreme_bg_color);
    let (ink, weak) = (ui.visuals().text_color(), ui.visuals().weak_text_color());
    let bars = histogram.bars(view, 56);
    let width = graph.width() / bars.len() as f32;
    for (i, height) in bars.iter().enumerate().filter(|(_, height)| **height > 0.0) {
        let left = graph.left() + i as f32 * width;
        let top = graph.bottom() - height * (graph.height() - 2.0);
        let bar = egui::Rect::from_min_max(egui::pos2(left, top), egui::pos2(left + width - 1.0, graph.bottom()));
        painter.rect_filled(bar, 0.0, weak);
    }
    let at = |stops: f32| graph.left() + graph.width() * (stops - Histogram::LOW) / (Histogram::HIGH - Histogram::LOW);
    let white = clipped_from(view.tone_map).log2();
    painter.vline(at(white), graph.y_range(), egui::Stroke::new(1.5, ink));
    let clipped = match histogram.clipped(view) {
        0.0 => "nothing clipped".to_owned(),
        share if share < 0.001 => "< 0.1 % clipped".to_owned(),
        share => format!("{:.1} % clipped", 100.0 * share),
    };
    painter.text(words.left_center(), egui::Align2::LEFT_CENTER, "dark", small.clone(), weak);
    let right = painter.text(words.right_center(), egui::Align2::RIGHT_CENTER, &clipped, small.clone(), weak);
    let middle = egui::pos2(at(white).min(right.left() - GRID), words.center().y);
    painter.text(middle, egui::Align2::RIGHT_CENTER, "white", small, weak);
    let name = LayerLook::of(key.quantity).name;
    response.widget_info(|| {
        let words = format!("Legend: {name}, {}, {clipped}", colour_note(view));
        egui::WidgetInfo::labeled(egui::Role::Image, true, words)
    });
    response.hint(
        "How many pixels are how bright, stop by stop; the line is where the screen is white. Black pixels are left out.",
    );
}

fn variance_ui(ui: &mut Ui, key: Key<'_>, default: &ViewState, out: &mut Vec<Command>) {
    title(ui, "Variance");
    let view = key.view;
    let units = VarianceUnit::ALL.map(|unit| (unit, unit.name()));
    let describe = |ui: &mut Ui, unit: VarianceUnit| {
        ui.label(unit.description());
    };
    let picked = segmented(ui, "Unit of the variance", view.variance_unit, &units, true, &describe);
    out.extend(picked.map(|unit| Edit::SetVarianceUnit(unit).into()));
    ui.add_space(GRID);
    legend_ui(ui, key);
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
        explain: &|ui| {
            hint::lines(ui, "End of the colour bar, as a power of ten; beyond it the colour stays. (N sets both)", &[]);
        },
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
        if wide_button(ui, "Normalise", width).hint(hint).clicked() {
            out.push(Command::Normalise);
        }
        if wide_button(ui, "Reset view", width).hint("Exposure, offset, tone map and ranges. (R)").clicked() {
            out.push(Edit::ResetView.into());
        }
    });
}

/// A switch for the marks on clipped pixels.
fn clipped_ui(ui: &mut Ui, view: &ViewState, out: &mut Vec<Command>) {
    let mut on = view.mark_clipped;
    let response = ui.checkbox(&mut on, "mark clipped pixels");
    let response =
        response.hint("Stripes where a number is beyond what the screen can show, and all look white alike.");
    if response.changed() {
        out.push(Edit::SetMarkClipped(on).into());
    }
}
