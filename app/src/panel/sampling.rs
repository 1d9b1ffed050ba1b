//! How the picture is sampled: weights, pattern, number, seed, pace.

use std::cell::Cell;

use eframe::egui::{self, ComboBox, DragValue, RichText, Sense, StrokeKind, Ui, Vec2, vec2};
use mislab_renderer::inspect::points;
use mislab_renderer::{Estimator, Heuristic, OneSampleWeights, SamplerKind, SamplerSettings, Sampling, Strategy};

use crate::look::names::{heuristic_name, sampler_name, weights_name};
use crate::look::theme::GRID;
use crate::panel::explain;
use crate::panel::hint::{self, Hint as _};
use crate::panel::number::{self, Kind};
use crate::panel::widgets::{labelled, segmented, title, wide_button};
use crate::state::command::Command;
use crate::state::document::{Counted, Document};
use crate::state::edit::{Edit, SppTarget};
use crate::state::pacing::Pacing;

/// Width of the labels in this panel.
const LABEL: f32 = 68.0;

/// How two techniques are weighted.
pub fn weights_ui(ui: &mut Ui, estimator: &Estimator, out: &mut Vec<Command>) {
    title(ui, "Weights");
    let weighted = matches!(estimator.strategy, Strategy::MisAll | Strategy::Mis);
    let heuristics = Heuristic::ALL.map(|h| (h, heuristic_name(h)));
    let picked = segmented(ui, "Heuristic", estimator.heuristic, &heuristics, weighted, &explain::heuristic);
    out.extend(picked.map(|h| Edit::SetHeuristic(h).into()));
    let weights = OneSampleWeights::ALL.map(|w| (w, weights_name(w)));
    let one_sample = estimator.strategy == Strategy::Mis;
    let picked = segmented(ui, "One-sample weights", estimator.weights, &weights, one_sample, &weights_hint);
    out.extend(picked.map(|w| Edit::SetWeights(w).into()));
}

/// Pattern, number and seed of the samples.
pub fn samples_ui(ui: &mut Ui, document: &Document, out: &mut Vec<Command>) {
    let (sampling, defaults) = (&document.sampling(), &document.opened.settings.sampling);
    // A file has its samples; number and seed are those of the pictures beside it, too.
    let made = !document.active().is_file();
    title(ui, "Samples");
    let samplers = SamplerKind::ALL.map(|s| (s, sampler_name(s)));
    // Two rows: those with a number for each choice, those with one for all.
    for row in samplers.chunk_by(|(a, _), (b, _)| a.is_nested() == b.is_nested()) {
        let picked =
            segmented(ui, "Sampler", sampling.sampler.kind, row, made, &|ui, kind| sampler_hint(ui, kind, document));
        out.extend(picked.map(|kind| Edit::SetSampler(kind).into()));
    }
    let reset = labelled(ui, "per pixel", LABEL, |ui| {
        spp_combo(ui, sampling, out);
        let stratified = sampling.sampler.kind.has_strata();
        let mut jitter = sampling.sampler.jitter;
        let response = ui
            .add_enabled(made && stratified, egui::Checkbox::new(&mut jitter, "jitter"))
            .hint("A random position in each stratum; off: its centre (biased). In a scene file: \"bool jitter\"");
        if response.changed() {
            out.push(Edit::SetJitter(jitter).into());
        }
    });
    if reset {
        out.push(Edit::SetSpp(defaults.spp.map_or(SppTarget::Endless, SppTarget::Passes)).into());
    }
    counted_ui(ui, document, out);
    let reset = labelled(ui, "seed", LABEL, |ui| {
        let mut seed = sampling.seed;
        let width = 2.0 * LABEL;
        let height = ui.spacing().interact_size.y;
        let refused = Cell::new(None);
        let parse = number::parser(seed.to_string(), f64::from(seed), "", Kind::Whole, &refused);
        let field = DragValue::new(&mut seed).speed(0.1).custom_parser(parse).update_while_editing(false);
        let response = ui.add_sized([width, height], field).accessible_name("Seed");
        if let Some(text) = refused.take() {
            number::refuse(ui.ctx(), &text);
        }
        let response =
            response.hint("Where all random numbers start: the same seed gives the same noise, to the last bit.");
        if response.changed() {
            out.push(Edit::SetSeed(seed).into());
        }
        if wide_button(ui, "next", ui.available_width()).hint("The same picture with other noise.").clicked() {
            out.push(Edit::SetSeed(seed.wrapping_add(1)).into());
        }
    });
    if reset {
        out.push(Edit::SetSeed(defaults.seed).into());
    }
}

/// Whether the number of samples counts samples or rays; several pictures say what is equal in them instead.
fn counted_ui(ui: &mut Ui, document: &Document, out: &mut Vec<Command>) {
    let alone = document.slots().len() == 1;
    let reset = labelled(ui, "counts", LABEL, |ui| {
        let choices = [(Counted::Samples, "samples"), (Counted::Rays, "rays")];
        let picked = segmented(ui, "Per pixel", document.counted, &choices, alone, &counted_hint);
        out.extend(picked.map(|counted| Edit::SetCounted(counted).into()));
    });
    if reset && alone {
        out.push(Edit::SetCounted(Counted::Samples).into());
    }
}

fn counted_hint(ui: &mut Ui, counted: Counted) {
    ui.label(match counted {
        Counted::Samples => "The picture stops after so many samples, as in the tutorial, whatever they cost.",
        Counted::Rays => {
            "The picture stops after so many second rays: \u{201c}MIS, both\u{201d} traces two a sample and has half the samples."
        }
    });
}

/// Pause, single passes, speed.
pub fn pace_ui(ui: &mut Ui, pacing: &Pacing, out: &mut Vec<Command>) {
    title(ui, "Pace");
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = GRID;
        let width = (ui.available_width() - 2.0 * GRID) / 3.0;
        let pause = if pacing.paused { "Go on" } else { "Pause" };
        if wide_button(ui, pause, width).hint("Hold the picture as it is, or go on. (Space)").clicked() {
            out.push(Command::TogglePause);
        }
        if wide_button(ui, "One pass", width).hint("One more sample for every pixel, then hold. (S)").clicked() {
            out.push(Command::Step);
        }
        if wide_button(ui, "Restart", width).hint("Again from the first sample. (Backspace)").clicked() {
            out.push(Command::Restart);
        }
    });
    ui.horizontal(|ui| {
        let field = 96.0;
        let height = ui.spacing().interact_size.y;
        ui.allocate_ui(egui::vec2(ui.available_width() - field - 2.0 * GRID, height), |ui| {
            let choices = [(true, "Full speed"), (false, "Slowly")];
            let hint = |ui: &mut Ui, full| {
                ui.label(if full { "As fast as the machine goes." } else { "Slow enough to watch." });
            };
            let picked = segmented(ui, "Pace", pacing.rate.is_none(), &choices, true, &hint);
            out.extend(picked.map(|full| Command::SetRate(if full { None } else { Some(pacing.last_rate) })));
        });
        let mut rate = pacing.last_rate;
        let refused = Cell::new(None);
        let parse = number::parser(number::three_digits(rate.into()), f64::from(rate), "/ s", Kind::Real, &refused);
        let field = DragValue::new(&mut rate)
            .range(0.1..=1000.0)
            .speed(0.05)
            .suffix(" / s")
            .custom_formatter(|v, _| number::three_digits(v))
            .custom_parser(parse)
            .update_while_editing(false);
        if pacing.rate.is_none() {
            ui.disable();
        }
        let response = ui.add_sized([ui.available_width(), height], field).accessible_name("Passes per second");
        if let Some(text) = refused.take() {
            number::refuse(ui.ctx(), &text);
        }
        let response = response.hint("Passes over the picture per second, one sample per pixel each.");
        if response.changed() {
            out.push(Command::SetRate(Some(rate)));
        }
    });
}

fn spp_combo(ui: &mut Ui, sampling: &Sampling, out: &mut Vec<Command>) {
    let current = sampling.spp.map_or(SppTarget::Endless, SppTarget::Passes);
    let stratified = sampling.sampler.kind.has_strata();
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
    let response = response.accessible_name("Samples per pixel");
    response.hint("Where the picture stops. In a scene file: \"integer xsamples\" times \"integer ysamples\"; the tutorial has 8 \u{d7} 8 and 6 \u{d7} 6.");
}

fn spp_text(target: SppTarget, strata: Option<[u32; 2]>) -> String {
    match (target, strata) {
        (SppTarget::Endless, _) => "endless".into(),
        (SppTarget::Passes(n), Some([x, y])) if x * y == n.get() && n.get() > 1 => format!("{n}  =  {x} \u{d7} {y}"),
        (SppTarget::Passes(n), _) => n.to_string(),
    }
}

fn weights_hint(ui: &mut Ui, weights: OneSampleWeights) {
    let what = match weights {
        OneSampleWeights::Veach => "The densities are compared as c p_L and (1 \u{2212} c) p_B: the least noise.",
        OneSampleWeights::Tutorial => {
            "c is left out of the weight: the same at c = 1/2, noisier elsewhere, biased at 0 and 1."
        }
    };
    hint::lines(ui, what, &[&format!("In a scene file: \"string weights\" [\"{}\"]", weights.name())]);
}

/// What a sampler is, with the points of a pixel.
fn sampler_hint(ui: &mut Ui, kind: SamplerKind, document: &Document) {
    let sampling = &document.sampling();
    let parts = document.active().estimator.parts(document.scene.light_shapes().count());
    let (what, file) = match kind {
        SamplerKind::Stratified => (
            "One sample in each cell of a grid, and one in each row and column of a grid as fine as there are samples. One \
            number chooses technique, light or lobe and, with what is left of it, the direction.",
            "stratified",
        ),
        SamplerKind::Lattice => (
            "A lattice that grows: any number of samples is spread evenly. One number chooses technique, light or lobe \
            and, with what is left of it, the direction.",
            "lattice",
        ),
        SamplerKind::Sobol => (
            "Owen-scrambled Sobol points. One number chooses technique, light or lobe and, with what is left of it, the \
            direction.",
            "sobol",
        ),
        SamplerKind::Independent => ("Every sample independent of the others.", "random"),
        SamplerKind::PaddedStratified => (
            "As pbrt-v3's \"stratified\": one sample in each cell of a grid, but technique and light have numbers of their \
            own, so that each light's samples are a random part of the cells. Noisier.",
            "padded_stratified",
        ),
        SamplerKind::PaddedSobol => {
            ("Owen-scrambled Sobol points, but technique and light have numbers of their own. Noisier.", "padded_sobol")
        }
    };
    let count = sampling.spp.map_or(SHOWN, |spp| spp.get().clamp(1, SHOWN));
    let strata =
        if sampling.sampler.kind.has_strata() { sampling.sampler.strata } else { SamplerSettings::strata_for(count) };
    let sampling = Sampling { sampler: SamplerSettings { kind, strata, ..sampling.sampler }, ..*sampling };
    points_ui(ui, &points(&sampling, parts, [0, 0], count));
    let remark = format!("In a scene file: Sampler \"{file}\"; on the command line: {}", kind.name());
    hint::lines(ui, what, &[&remark]);
}

/// Most points of a pixel that are shown.
const SHOWN: u32 = 64;

/// The points of a pixel in the unit square, u to the right and v up.
fn points_ui(ui: &mut Ui, points: &[[f32; 2]]) {
    let (rect, _) = ui.allocate_exact_size(Vec2::splat(144.0), Sense::hover());
    let (frame, dot) = (ui.visuals().widgets.noninteractive.bg_stroke, ui.visuals().strong_text_color());
    ui.painter().rect_stroke(rect, 0.0, frame, StrokeKind::Inside);
    for [u, v] in points {
        ui.painter().circle_filled(rect.lerp_inside(vec2(*u, 1.0 - *v)), 1.5, dot);
    }
    let caption =
        format!("{} points (u, v) of the pixel (0, 0); u chooses the light as well where it is shared", points.len());
    ui.label(RichText::new(caption).small());
}
