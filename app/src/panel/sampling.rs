//! How the picture is sampled: weights, pattern, number, seed, pace.

use eframe::egui::{self, ComboBox, DragValue, Ui};
use mislab_renderer::{Estimator, Heuristic, OneSampleWeights, SamplerKind, SamplerSettings, Sampling, Strategy};

use crate::look::names::{heuristic_name, sampler_name, weights_name};
use crate::look::theme::GRID;
use crate::panel::widgets::{labelled, segmented, title, wide_button};
use crate::state::command::Command;
use crate::state::edit::{Edit, SppTarget};
use crate::state::pacing::Pacing;

/// Width of the labels in this panel.
const LABEL: f32 = 68.0;

/// How two techniques are weighted.
pub fn weights_ui(ui: &mut Ui, estimator: &Estimator, out: &mut Vec<Command>) {
    title(ui, "Weights");
    let weighted = matches!(estimator.strategy, Strategy::MisAll | Strategy::Mis);
    let heuristics: Vec<(Heuristic, &str, &str)> =
        Heuristic::ALL.into_iter().map(|h| (h, heuristic_name(h), heuristic_hint(h))).collect();
    if let Some(h) = segmented(ui, "Heuristic", estimator.heuristic, &heuristics, weighted) {
        out.push(Edit::SetHeuristic(h).into());
    }
    let weights: Vec<(OneSampleWeights, &str, &str)> =
        OneSampleWeights::ALL.into_iter().map(|w| (w, weights_name(w), weights_hint(w))).collect();
    let one_sample = estimator.strategy == Strategy::Mis;
    if let Some(w) = segmented(ui, "One-sample weights", estimator.weights, &weights, one_sample) {
        out.push(Edit::SetWeights(w).into());
    }
}

/// Pattern, number and seed of the samples.
pub fn samples_ui(ui: &mut Ui, sampling: &Sampling, defaults: &Sampling, out: &mut Vec<Command>) {
    title(ui, "Samples");
    let samplers: Vec<(SamplerKind, &str, &str)> =
        SamplerKind::ALL.into_iter().map(|s| (s, sampler_name(s), sampler_hint(s))).collect();
    if let Some(kind) = segmented(ui, "Sampler", sampling.sampler.kind, &samplers, true) {
        out.push(Edit::SetSampler(kind).into());
    }
    let reset = labelled(ui, "per pixel", LABEL, |ui| {
        spp_combo(ui, sampling, out);
        let stratified = sampling.sampler.kind == SamplerKind::Stratified;
        let mut jitter = sampling.sampler.jitter;
        let response = ui
            .add_enabled(stratified, egui::Checkbox::new(&mut jitter, "jitter"))
            .on_hover_text("A random position in each stratum; off: its centre (biased).");
        if response.changed() {
            out.push(Edit::SetJitter(jitter).into());
        }
    });
    if reset {
        out.push(Edit::SetSpp(defaults.spp.map_or(SppTarget::Endless, SppTarget::Passes)).into());
    }
    let reset = labelled(ui, "seed", LABEL, |ui| {
        let mut seed = sampling.seed;
        let width = 2.0 * LABEL;
        let height = ui.spacing().interact_size.y;
        let field = DragValue::new(&mut seed).speed(0.1).update_while_editing(false);
        let response = ui.add_sized([width, height], field).accessible_name("Seed");
        if response.changed() {
            out.push(Edit::SetSeed(seed).into());
        }
        if wide_button(ui, "next", ui.available_width()).on_hover_text("The same picture with other noise.").clicked() {
            out.push(Edit::SetSeed(seed.wrapping_add(1)).into());
        }
    });
    if reset {
        out.push(Edit::SetSeed(defaults.seed).into());
    }
}

/// Pause, single passes, speed.
pub fn pace_ui(ui: &mut Ui, pacing: &Pacing, out: &mut Vec<Command>) {
    title(ui, "Pace");
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = GRID;
        let width = (ui.available_width() - 2.0 * GRID) / 3.0;
        let (pause, hint) = if pacing.paused { ("Go on", "Space") } else { ("Pause", "Space") };
        if wide_button(ui, pause, width).on_hover_text(hint).clicked() {
            out.push(Command::TogglePause);
        }
        if wide_button(ui, "One pass", width).on_hover_text("One more sample for every pixel, then hold. (S)").clicked()
        {
            out.push(Command::Step);
        }
        if wide_button(ui, "Restart", width).on_hover_text("Again from the first sample. (Backspace)").clicked() {
            out.push(Command::Restart);
        }
    });
    ui.horizontal(|ui| {
        let field = 96.0;
        let height = ui.spacing().interact_size.y;
        ui.allocate_ui(egui::vec2(ui.available_width() - field - 2.0 * GRID, height), |ui| {
            let choices =
                [(true, "Full speed", "As fast as the machine goes."), (false, "Slowly", "Slow enough to watch.")];
            if let Some(full) = segmented(ui, "Pace", pacing.rate.is_none(), &choices, true) {
                out.push(Command::SetRate(if full { None } else { Some(pacing.last_rate) }));
            }
        });
        let mut rate = pacing.last_rate;
        let number = DragValue::new(&mut rate).range(0.1..=1000.0).speed(0.05).max_decimals(1).suffix(" / s");
        if pacing.rate.is_none() {
            ui.disable();
        }
        let response = ui.add_sized([ui.available_width(), height], number).accessible_name("Passes per second");
        if response.changed() {
            out.push(Command::SetRate(Some(rate)));
        }
    });
}

fn spp_combo(ui: &mut Ui, sampling: &Sampling, out: &mut Vec<Command>) {
    let current = sampling.spp.map_or(SppTarget::Endless, SppTarget::Passes);
    let stratified = sampling.sampler.kind == SamplerKind::Stratified;
    let width = ui.available_width() - 88.0;
    let response = ComboBox::from_id_salt("spp")
        .width(width)
        .selected_text(spp_text(current, stratified.then_some(sampling.sampler.strata)))
        .show_ui(ui, |ui| {
            ui.set_min_width(width);
            for choice in SppTarget::choices() {
                let strata = match choice {
                    SppTarget::Passes(n) if stratified => Some(SamplerSettings::strata_for(n.get())),
                    _ => None,
                };
                if ui.selectable_label(choice == current, spp_text(choice, strata)).clicked() {
                    out.push(Edit::SetSpp(choice).into());
                    ui.close();
                }
            }
        })
        .response;
    response.accessible_name("Samples per pixel");
}

fn spp_text(target: SppTarget, strata: Option<[u32; 2]>) -> String {
    match (target, strata) {
        (SppTarget::Endless, _) => "endless".into(),
        (SppTarget::Passes(n), Some([x, y])) if x * y == n.get() && n.get() > 1 => format!("{n}  =  {x} \u{d7} {y}"),
        (SppTarget::Passes(n), _) => n.to_string(),
    }
}

fn heuristic_hint(heuristic: Heuristic) -> &'static str {
    match heuristic {
        Heuristic::Balance => "Weights in proportion to the densities.",
        Heuristic::Power => "Weights in proportion to the squared densities.",
        Heuristic::Cutoff => "Densities below a tenth of the larger are dropped, the rest is balanced.",
        Heuristic::Maximum => "The technique with the larger density takes all.",
    }
}

fn weights_hint(weights: OneSampleWeights) -> &'static str {
    match weights {
        OneSampleWeights::Veach => "The densities are compared as c p_L and (1 - c) p_B: the least noise.",
        OneSampleWeights::Tutorial => {
            "c is left out of the weight: the same at c = 1/2, noisier elsewhere, biased at 0 and 1."
        }
    }
}

fn sampler_hint(kind: SamplerKind) -> &'static str {
    match kind {
        SamplerKind::Stratified => "One sample in each cell of a grid, in a random order per pixel.",
        SamplerKind::Independent => "Every sample independent of the others.",
        SamplerKind::Sobol => "Owen-scrambled Sobol points.",
    }
}
