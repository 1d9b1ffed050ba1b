//! The formula of the running strategy, with its colours and its live numbers: the bridge between
//! picture and blackboard.

use eframe::egui::{self, Color32, Sense, Ui, vec2};
use mislab_renderer::{Estimator, Heuristic, OneSampleWeights, Strategy};

use crate::look::names::strategy_description;
use crate::look::theme::{GRID, Inks, TypeScale};
use crate::panel::math::{Math, frac, row, sub, text};

/// Shows it in the width of the column, in as much height as the tallest one needs, so that nothing
/// jumps when the strategy changes.
pub fn formula_ui(ui: &mut Ui, estimator: &Estimator, scale: TypeScale) {
    let inks = Inks::of(ui.visuals());
    let (size, line, lines) = match scale {
        TypeScale::Desk => (20.0, 48.0, 3.0),
        TypeScale::Hall => (34.0, 88.0, 3.0),
    };
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), lines * line), Sense::hover());
    let formulas = formulas(estimator, inks);
    let color = ui.visuals().text_color();
    let painter = ui.painter_at(rect);
    let mut top = rect.top();
    for formula in &formulas {
        // A long formula on a narrow column is set smaller rather than cut.
        let laid = formula.layout(&painter, size, color);
        let fit = (rect.width() / laid.size().x).min(1.0);
        let laid = if fit < 1.0 { formula.layout(&painter, size * fit, color) } else { laid };
        let y = top + 0.5 * (line - laid.size().y);
        laid.paint(&painter, egui::pos2(rect.left(), y));
        top += line;
    }
    // What is left of the room says in words what the formula says.
    if (formulas.len() as f32) < lines {
        let body = egui::TextStyle::Small.resolve(ui.style());
        let words = painter.layout(
            strategy_description(estimator.strategy).into(),
            body,
            ui.visuals().weak_text_color(),
            rect.width(),
        );
        painter.galley(egui::pos2(rect.left(), top + GRID), words, color);
    }
    let spoken = formulas.iter().map(Math::plain).collect::<Vec<_>>().join("; ");
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, format!("Formula: {spoken}")));
    if let Some(bias) = estimator.bias() {
        ui.label(egui::RichText::new(bias).color(inks.wrong));
    }
    ui.add_space(GRID);
}

fn formulas(estimator: &Estimator, inks: Inks) -> Vec<Math> {
    let (light, bsdf) = (Technique::new("L", inks.light), Technique::new("B", inks.bsdf));
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
struct Technique {
    index: &'static str,
    ink: Color32,
}

impl Technique {
    fn new(index: &'static str, ink: Color32) -> Self {
        Self { index, ink }
    }

    fn p(&self) -> Math {
        sub("p", self.index, self.ink)
    }

    fn w(&self) -> Math {
        sub("w", self.index, self.ink)
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
fn weight(heuristic: Heuristic, light: &Technique, bsdf: &Technique, c: Option<f64>) -> Math {
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
