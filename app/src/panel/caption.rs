//! The caption under the picture: what made it. And the value under the cursor, on the picture.

use eframe::egui::{self, Align2, Color32, Rect, RichText, Role, Sense, TextStyle, Ui, vec2};
use mislab_renderer::{Channel, Frame, Strategy};

use crate::look::layer::LayerLook;
use crate::look::names::{heuristic_name, strategy_name};
use crate::look::theme::{GRID, Inks, TypeScale};
use crate::panel::widgets::{cell, seconds, si};
use crate::state::view::ViewState;

/// Says of the frame on screen, not of the settings, how it came about: true at every moment.
pub fn caption_ui(ui: &mut Ui, frame: Option<&Frame>, updating: bool, scale: TypeScale) {
    let Some(frame) = frame else {
        ui.label("Rendering the first picture \u{2026}");
        return;
    };
    let inks = Inks::of(ui.visuals());
    let settings = &frame.request().settings;
    let stats = frame.stats();
    let strategy = settings.estimator.strategy;
    ui.spacing_mut().item_spacing.x = 4.0 * GRID;

    let mut how = String::new();
    if matches!(strategy, Strategy::MisAll | Strategy::Mis) {
        how = heuristic_name(settings.estimator.heuristic).to_lowercase();
    }
    if strategy == Strategy::Mis {
        how = format!("{how}, c {:.2}", settings.estimator.light_prob);
    }
    let spp = format!("{} spp", frame.spp());
    let paths = format!("{} paths", si(stats.paths as f64));
    let time = seconds(stats.render_seconds);

    let name =
        RichText::new(strategy_name(strategy)).family(crate::look::theme::medium()).color(inks.strategy(strategy));
    let response = ui.label(name);
    response.widget_info(|| {
        let parts = [strategy_name(strategy), &how, &spp, &paths, &time];
        let parts: Vec<&str> = parts.into_iter().filter(|part| !part.is_empty()).collect();
        egui::WidgetInfo::labeled(Role::Label, true, format!("Caption: {}", parts.join(", ")))
    });
    if !how.is_empty() {
        ui.label(how);
    }
    if let Some(bias) = settings.estimator.bias() {
        ui.label(RichText::new("biased").color(inks.wrong)).on_hover_text(bias);
    }
    let font = TextStyle::Body.resolve(ui.style());
    let digits = settings.sampling.spp.map_or(frame.spp(), |target| target.get()).to_string().len();
    let templates = [format!("{} spp", "8".repeat(digits)), "88.8 M paths".into(), "88.8 s".into()];
    for (text, template) in [spp, paths, time].iter().zip(templates) {
        // Rather nothing than half a number.
        if ui.available_width() < 5.0 * font.size {
            return;
        }
        cell(ui, text, &template, font.clone(), None, Align2::LEFT_CENTER);
    }
    if updating {
        ui.label(RichText::new("previous settings \u{2026}").italics());
    } else if scale == TypeScale::Desk && ui.available_width() > 220.0 {
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| ui.weak("drop a .pbrt or .exr here"));
    }
}

/// Place and values of the pixel under the cursor, on a plate in the lower right corner of the viewport.
pub fn pixel_overlay(ui: &Ui, viewport: Rect, frame: &Frame, view: &ViewState, [x, y]: [u32; 2]) {
    let text = pixel_text(frame, view, [x, y]);
    let font = TextStyle::Body.resolve(ui.style());
    let galley = ui.painter().layout_no_wrap(text.clone(), font.clone(), ui.visuals().text_color());
    // As wide as usual values are, so that the plate stands still under a moving cursor.
    let usual =
        if LayerLook::of(view.layer).is_colour() { "R 0.0000   G 0.0000   B 0.0000" } else { "x 0000   y 0000" };
    let usual = ui.painter().layout_no_wrap(usual.into(), font, Color32::WHITE).size();
    let size = galley.size().max(usual) + vec2(4.0 * GRID, 3.0 * GRID);
    let margin = vec2(2.0 * GRID, 2.0 * GRID);
    // The legend has the lower left corner; in a narrow viewport the two would meet.
    let corner = if viewport.width() > 600.0 { Align2::RIGHT_BOTTOM } else { Align2::RIGHT_TOP };
    let plate = corner.align_size_within_rect(size, viewport.shrink2(margin));
    let painter = ui.painter_at(viewport);
    painter.rect_filled(plate, 4.0, ui.visuals().panel_fill.gamma_multiply(0.92));
    painter.galley(plate.min + vec2(2.0 * GRID, 1.5 * GRID), galley, ui.visuals().text_color());
    let response = ui.interact(plate, ui.scope_id().with("pixel"), Sense::empty());
    response.widget_info(|| egui::WidgetInfo::labeled(Role::Label, true, format!("Pixel: {text}")));
}

/// Position and values of a pixel in the layer on screen.
pub fn pixel_text(frame: &Frame, view: &ViewState, [x, y]: [u32; 2]) -> String {
    let values = view.layer.channels().iter().map(|c| frame.pixel(x, y, *c).unwrap_or(f32::NAN));
    let values: Vec<String> = values.map(value_text).collect();
    let names = LayerLook::of(view.layer).values;
    let values: Vec<String> = names.iter().zip(&values).map(|(name, value)| format!("{name} {value}")).collect();
    format!("x {x}   y {y}\n{}", values.join("   "))
}

/// All channels of a pixel, for the clipboard.
pub fn pixel_table(frame: &Frame, [x, y]: [u32; 2]) -> String {
    let values =
        Channel::ALL.iter().map(|c| format!("{}\t{}", c.exr_name(), frame.pixel(x, y, *c).unwrap_or(f32::NAN)));
    let values: Vec<String> = values.collect();
    format!("x\t{x}\ny\t{y}\n{}\n", values.join("\n"))
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
