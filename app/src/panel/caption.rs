//! The caption under the picture: what made it.

use eframe::egui::{self, Align2, RichText, Role, TextStyle, Ui};
use mislab_renderer::{Frame, Strategy};

use crate::look::names::{heuristic_name, strategy_name};
use crate::look::theme::{GRID, Inks, TypeScale};
use crate::panel::widgets::{cell, seconds, si};

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
