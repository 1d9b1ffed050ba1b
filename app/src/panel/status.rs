//! The status bar: how far, how fast, and everything that must never be hidden.

use std::num::NonZeroU32;

use eframe::egui::{self, ProgressBar, RichText, Ui};
use mislab_renderer::{Frame, State, Status, simd_level_name};

use crate::look::layer::LayerLook;
use crate::look::theme::Inks;
use crate::panel::widgets::{number, si, three_digits};
use crate::state::command::Command;
use crate::state::document::Document;

/// What is being done about a picture.
pub struct Work<'a> {
    /// Its newest frame, if that was made with the current settings.
    pub frame: Option<&'a Frame>,
    /// What the renderer says.
    pub status: &'a Status,
    /// Worker threads.
    pub threads: usize,
}

/// The bar.
pub fn status_ui(ui: &mut Ui, work: &Work<'_>, document: &Document, out: &mut Vec<Command>) {
    let Work { frame, status, threads } = *work;
    let (sampling, view) = (&document.sampling, &document.view);
    let spp = frame.map_or(0, Frame::spp);
    let stats = frame.map(Frame::stats);
    let target = sampling.spp.map_or("\u{221e}".into(), |n| n.to_string());
    // As wide as the target, or as an hour of endless passes.
    let widest = "8".repeat(if sampling.spp.is_some() { target.len() } else { 6 });
    number(ui, &format!("{spp} / {target} spp"), &format!("{widest} / {target} spp"), None);
    progress(ui, spp, sampling.spp, status);
    let paths = stats.map_or(0.0, |s| s.paths as f64);
    number(ui, &format!("{} paths", si(paths)), "888.8 M paths", None);
    let rate = stats.map_or(0.0, |s| s.mpaths_per_second());
    number(ui, &format!("{} Mpaths/s", three_digits(rate)), "8888 Mpaths/s", None);
    let time = stats.map_or(0.0, |s| s.render_seconds);
    number(ui, &crate::panel::widgets::seconds(time), "88:88 min", None);
    let invalid = stats.map_or(0, |s| s.invalid_samples);
    let wrong = Inks::of(ui.visuals()).wrong;
    if invalid > 0 {
        let text = RichText::new(format!("{} invalid samples", si(invalid as f64))).color(wrong);
        ui.label(text).on_hover_text("Samples that were not a finite number. They were left out of the picture.");
    }
    if status.worker_panics > 0 {
        let text = RichText::new(format!("{} passes redone", status.worker_panics)).color(wrong);
        ui.label(text).on_hover_text(status.error.clone().unwrap_or_default());
    }
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        if ui.button("Save EXR").on_hover_text("Ctrl+S").clicked() {
            out.push(Command::Save);
        }
        // In a narrow window the less important goes first.
        if ui.available_width() > 330.0 {
            let text = format!("{} \u{d7} {threads}", simd_level_name());
            ui.label(text).on_hover_text("Vector unit and worker threads");
            ui.separator();
        }
        if ui.available_width() < 190.0 {
            return;
        }
        if LayerLook::of(document.active().layer).is_colour() {
            ui.label(view.tone_map.name());
            number(ui, &format!("EV {:+.1}", view.exposure_ev), "EV +88.8", None);
            if view.offset != 0.0 {
                ui.label(format!("offset {:+.2}", view.offset));
            }
        } else {
            ui.label("false colour");
        }
        ui.label(format!("seed {}", sampling.seed));
    });
}

fn progress(ui: &mut Ui, spp: u32, target: Option<NonZeroU32>, status: &Status) {
    let width = 120.0;
    let text = match status.state {
        State::Paused => "paused",
        State::Building => "building",
        State::Failed => "failed",
        State::Idle | State::Rendering | State::Finished => "",
    };
    let fraction = match target {
        Some(target) => spp as f32 / target.get() as f32,
        // Nothing to be a fraction of: the bar shows the way to the next power of two.
        None if spp > 0 => spp as f32 / (spp + 1).next_power_of_two() as f32,
        None => 0.0,
    };
    // Faint enough for the words on it.
    let fill = ui.visuals().text_color().gamma_multiply(0.35);
    let height = 0.7 * ui.spacing().interact_size.y;
    let bar = ProgressBar::new(fraction.clamp(0.0, 1.0)).desired_width(width).desired_height(height).fill(fill);
    let bar = bar.corner_radius(2.0).text(RichText::new(text).small().color(ui.visuals().text_color()));
    ui.add(bar).accessible_name("Progress");
}
