//! The formula of the running strategy, with its colours and its live numbers: the bridge between
//! picture and blackboard.

use eframe::egui::{self, Color32, Sense, Ui, vec2};
use mislab_renderer::{Estimator, Heuristic, OneSampleWeights, Strategy};

use crate::look::names::strategy_description;
use crate::look::theme::{GRID, Inks, TypeScale};
use crate::panel::file_caption::FROM_FILE;
use crate::panel::hint::keep_clear;
use crate::panel::math::{Math, frac, row, sub, text};

/// Lines that the longest formula takes.
const LINES: f32 = 3.0;

/// Shows it in the width of the column, in as much height as the tallest one needs, with room for a sentence below it:
/// nothing jumps when strategy or c change. `None`: a file, for which there is none.
pub fn formula_ui(ui: &mut Ui, estimator: Option<&Estimator>, scale: TypeScale) {
    let inks = Inks::of(ui.visuals());
    let (size, line) = match scale {
        TypeScale::Desk => (18.0, 44.0),
        TypeScale::Hall => (29.0, 67.0),
    };
    let small = egui::TextStyle::Small.resolve(ui.style());
    let room = 2.0 * ui.text_style_height(&egui::TextStyle::Small);
    let height = LINES * line + room;
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::hover());
    keep_clear(ui.ctx(), rect);
    let Some(estimator) = estimator else {
        let words = ui.painter().layout(FROM_FILE.into(), small, ui.visuals().text_color(), rect.width());
        ui.painter().galley(rect.min + vec2(0.0, GRID), words, ui.visuals().text_color());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, FROM_FILE));
        return;
    };
    let formulas = formulas(estimator, inks);
    let color = ui.visuals().text_color();
    let painter = ui.painter_at(rect);
    let mut top = rect.top();
    for formula in &formulas {
        let laid = formula.fitted(&painter, size, rect.width(), color);
        let y = top + 0.5 * (line - laid.size().y);
        laid.paint(&painter, egui::pos2(rect.left(), y));
        top += line;
    }
    let (sentence, ink) = sentence_about(ui, estimator);
    let words = painter.layout(sentence.into(), small, ink, rect.width());
    painter.galley(egui::pos2(rect.left(), top), words, ink);
    let spoken = formulas.iter().map(Math::plain).collect::<Vec<_>>().join("; ");
    response
        .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, format!("Formula: {spoken}. {sentence}")));
}

/// Shows it in one line, over or beside a picture that needs the height.
pub fn formula_line_ui(ui: &mut Ui, estimator: &Estimator, size: f32) {
    let inks = Inks::of(ui.visuals());
    let mut parts = Vec::new();
    for formula in formulas(estimator, inks) {
        if !parts.is_empty() {
            parts.push(text("     "));
        }
        parts.push(formula);
    }
    let whole = row(parts);
    let response = whole.show(ui, size);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, format!("Formula: {}", whole.plain())));
}

/// What is wrong with the estimator, or what it does.
fn sentence_about(ui: &Ui, estimator: &Estimator) -> (&'static str, Color32) {
    match estimator.bias() {
        Some(bias) => (bias, Inks::of(ui.visuals()).wrong),
        None => (strategy_description(estimator.strategy), ui.visuals().weak_text_color()),
    }
}

/// The formula of a strategy, line by line.
pub fn formulas(estimator: &Estimator, inks: Inks) -> Vec<Math> {
    let [light, bsdf] = Technique::both(inks);
    let c = f64::from(estimator.light_prob);
    match estimator.strategy {
        Strategy::Light => vec![row([estimate(), frac(text("f"), light.p()), note("one light sample")])],
        Strategy::Bsdf => vec![row([estimate(), frac(text("f"), bsdf.p()), note("one BSDF sample")])],
        Strategy::MisAll => vec![
            row([
                estimate(),
                light.w(),
                Math::Gap(0.1),
                frac(text("f"), light.p()),
                text("  +  "),
                bsdf.w(),
                Math::Gap(0.1),
                frac(text("f"), bsdf.p()),
            ]),
            row([light.w(), text("  =  "), weight(estimator.heuristic, &light, &bsdf, None)]),
        ],
        Strategy::Mis => {
            let veach = estimator.weights == OneSampleWeights::Veach;
            vec![
                row([
                    estimate(),
                    light.w(),
                    Math::Gap(0.1),
                    frac(text("f"), row([number(c), light.p()])),
                    note(&format!("with probability {c:.2}")),
                ]),
                row([
                    estimate(),
                    bsdf.w(),
                    Math::Gap(0.1),
                    frac(text("f"), row([number(1.0 - c), bsdf.p()])),
                    note("otherwise"),
                ]),
                row([light.w(), text("  =  "), weight(estimator.heuristic, &light, &bsdf, veach.then_some(c))]),
            ]
        }
    }
}

/// One technique's symbols.
pub struct Technique {
    index: &'static str,
    ink: Color32,
}

impl Technique {
    /// The light technique's and the BSDF technique's.
    pub fn both(inks: Inks) -> [Self; 2] {
        [Self { index: "L", ink: inks.light }, Self { index: "B", ink: inks.bsdf }]
    }

    /// Its density.
    pub fn p(&self) -> Math {
        self.letter("p")
    }

    /// The weight of its samples.
    pub fn w(&self) -> Math {
        self.letter("w")
    }

    /// Some letter with its index.
    pub fn letter(&self, base: &str) -> Math {
        sub(base, self.index, self.ink)
    }
}

fn estimate() -> Math {
    text("L  \u{2248}  ")
}

fn note(s: &str) -> Math {
    row([Math::Gap(0.8), Math::Small(text(s).into())])
}

fn number(value: f64) -> Math {
    text(format!("{value:.2} "))
}

/// The weight of a light sample. `c` takes part in it in Veach's one-sample model.
pub fn weight(heuristic: Heuristic, light: &Technique, bsdf: &Technique, c: Option<f64>) -> Math {
    let term = |p: Math, c: Option<f64>| match c {
        Some(c) => row([number(c), p]),
        None => p,
    };
    let q_light = || term(light.p(), c);
    let q_bsdf = || term(bsdf.p(), c.map(|c| 1.0 - c));
    let square = |q: Math| match c {
        Some(_) => row([text("("), q, text(")\u{b2}")]),
        None => row([q, text("\u{b2}")]),
    };
    match heuristic {
        Heuristic::Balance => frac(q_light(), row([q_light(), text(" + "), q_bsdf()])),
        Heuristic::Power => frac(square(q_light()), row([square(q_light()), text(" + "), square(q_bsdf())])),
        Heuristic::Cutoff => row([frac(q_light(), row([q_light(), text(" + "), q_bsdf()])), note("0 below a tenth")]),
        Heuristic::Maximum => row([text("1  if  "), q_light(), text(" \u{2265} "), q_bsdf(), text(" ,  else 0")]),
    }
}
