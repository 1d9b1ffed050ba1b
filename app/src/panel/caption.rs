//! The caption under the picture: what made it, and the value under the cursor.

use eframe::egui::{self, RichText, TextStyle, Ui};
use mislab_renderer::{Channel, Frame, Layer, Strategy};

use super::{heuristic_name, strategy_name};
use crate::theme::{GRID, Inks, TypeScale};
use crate::view_state::{ViewState, is_colour};
use crate::widgets::{seconds, si};

/// Says of the frame on screen, not of the settings, how it came about: true at every moment.
pub fn caption_ui(
    ui: &mut Ui,
    frame: Option<&Frame>,
    view: &ViewState,
    pixel: Option<[u32; 2]>,
    updating: bool,
    scale: TypeScale,
) {
    let Some(frame) = frame else {
        ui.label("Rendering the first picture \u{2026}");
        return;
    };
    let inks = Inks::of(ui.visuals());
    let settings = &frame.request().settings;
    let stats = frame.stats();
    let strategy = settings.strategy;
    ui.spacing_mut().item_spacing.x = 3.0 * GRID;
    ui.label(RichText::new(strategy_name(strategy)).family(crate::theme::medium()).color(inks.strategy(strategy)));
    let mut parts = Vec::new();
    match strategy {
        Strategy::Light | Strategy::Bsdf => {}
        Strategy::MisAll => parts.push(heuristic_name(settings.heuristic).to_lowercase()),
        Strategy::Mis => {
            parts.push(heuristic_name(settings.heuristic).to_lowercase());
            parts.push(format!("c {:.2}", settings.light_prob));
        }
    }
    parts.push(format!("{} spp", frame.spp()));
    parts.push(format!("{} rays", si(stats.paths as f64)));
    parts.push(seconds(stats.render_seconds));
    let text = ui.label(parts.join("  \u{b7}  "));
    text.widget_info(|| {
        let text = format!("Caption: {}, {}", strategy_name(strategy), parts.join(", "));
        egui::WidgetInfo::labeled(egui::Role::Label, true, text)
    });
    if updating {
        ui.label(RichText::new("previous settings \u{2026}").italics());
    }
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        let style = if scale == TypeScale::Hall { TextStyle::Small } else { TextStyle::Body };
        match pixel {
            Some(at) => {
                let response = ui.label(RichText::new(pixel_text(frame, view, at)).text_style(style));
                response.widget_info(|| {
                    let text = format!("Pixel: {}", pixel_text(frame, view, at));
                    egui::WidgetInfo::labeled(egui::Role::Label, true, text)
                });
            }
            None if ui.available_width() > 260.0 && scale == TypeScale::Desk => {
                ui.weak("drop a .pbrt or .exr here");
            }
            None => {}
        }
    });
}

/// Position and values of a pixel in the layer on screen.
pub fn pixel_text(frame: &Frame, view: &ViewState, [x, y]: [u32; 2]) -> String {
    let values = view.layer.channels().iter().map(|c| frame.pixel(x, y, *c).unwrap_or(f32::NAN));
    let values: Vec<String> = values.map(value_text).collect();
    let names: &[&str] = if is_colour(view.layer) { &["R", "G", "B"] } else { &[quantity(view.layer)] };
    let values: Vec<String> = names.iter().zip(&values).map(|(name, value)| format!("{name} {value}")).collect();
    format!("x {x}  y {y}    {}", values.join("   "))
}

/// All channels of a pixel, for the clipboard.
pub fn pixel_table(frame: &Frame, [x, y]: [u32; 2]) -> String {
    let values =
        Channel::ALL.iter().map(|c| format!("{}\t{}", c.exr_name(), frame.pixel(x, y, *c).unwrap_or(f32::NAN)));
    let values: Vec<String> = values.collect();
    format!("x\t{x}\ny\t{y}\n{}\n", values.join("\n"))
}

fn quantity(layer: Layer) -> &'static str {
    match layer {
        Layer::WeightLight | Layer::WeightBsdf => "weight",
        Layer::ShareLight => "share",
        Layer::Variance => "variance",
        Layer::Picture | Layer::Light | Layer::Bsdf => "value",
    }
}

fn value_text(value: f32) -> String {
    if value.is_nan() {
        "undefined".into()
    } else if value != 0.0 && !(1e-3..1e4).contains(&value.abs()) {
        format!("{value:.2e}")
    } else {
        format!("{value:.4}")
    }
}
