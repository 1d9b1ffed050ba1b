//! One sample of the pixel: the formula with its numbers, and what it makes of the mean.

use eframe::egui::{self, DragValue, RichText, ScrollArea, Sense, Stroke, TextStyle, Ui, vec2};
use mislab_renderer::inspect::{Ray, Replayed, Technique};
use mislab_renderer::{Estimator, Heuristic, OneSampleWeights, Strategy};

use super::number::short;
use super::place::{Place, angle, luminance};
use super::samples::{MOST, Samples, both};
use super::shown::Shown;
use crate::look::theme::{GRID, Inks};
use crate::panel::formula::Technique as Symbols;
use crate::panel::hint::Hint as _;
use crate::panel::math::{Math, frac, row, size_in_text, text};
use crate::panel::widgets::{caption, title};

/// Which sample is looked at.
#[derive(Default)]
pub struct Sample {
    index: usize,
}

/// Draws it; `exact` is the luminance of the pixel.
pub fn sample_ui(ui: &mut Ui, state: &mut Sample, shown: &Shown<'_>, exact: f64) {
    let Some(samples) = shown.samples.filter(|samples| !samples.list.is_empty()) else {
        caption(ui, "Replaying \u{2026}");
        return;
    };
    state.index = state.index.min(samples.list.len() - 1);
    steps_ui(ui, state, samples);
    let sample = &samples.list[state.index];
    ScrollArea::vertical().id_salt("sample").auto_shrink(false).show(ui, |ui| {
        mean_ui(ui, samples, state.index, exact);
        if sample.emits {
            ui.label(format!("The camera ray hits a light: it adds {}.", short(luminance(sample.emitted))));
        }
        for ray in &sample.rays {
            ray_ui(ui, &samples.place, sample, ray);
        }
        if sample.rays.is_empty() {
            ui.label("The camera ray of this sample hits nothing that reflects.");
        } else {
            caption(
                ui,
                "Weights belong to a direction, not to a sample: in each, those of both techniques sum to one.",
            );
        }
    });
}

fn steps_ui(ui: &mut Ui, state: &mut Sample, samples: &Samples) {
    let last = samples.list.len() - 1;
    ui.horizontal(|ui| {
        let back = ui.add_enabled(state.index > 0, egui::Button::new("<")).accessible_name("Previous sample");
        if back.hint("The sample before.").clicked() {
            state.index -= 1;
        }
        // Samples are counted from 1, as people do.
        let mut number = state.index + 1;
        let field = DragValue::new(&mut number).range(1..=last + 1).prefix("sample ").speed(0.1);
        ui.add(field).accessible_name("Sample").hint("Its number in the pixel: click to type, drag to change.");
        state.index = number - 1;
        let next = ui.add_enabled(state.index < last, egui::Button::new(">")).accessible_name("Next sample");
        if next.hint("The sample after.").clicked() {
            state.index += 1;
        }
        let of = format!("of {}", last + 1);
        ui.label(of).hint(format!("Of the picture's samples, at most {MOST} are replayed here, to the bit."));
        let brightest = || (0..=last).max_by(|a, b| samples.list[*a].luminance.total_cmp(&samples.list[*b].luminance));
        if ui.button("Brightest").hint("The one that adds the most: a firefly, if there is one.").clicked() {
            state.index = brightest().unwrap_or(0);
        }
    });
}

/// The mean of the samples up to this one as a bar, the exact mean as a line across it.
fn mean_ui(ui: &mut Ui, samples: &Samples, index: usize, exact: f64) {
    let value = |sample: &Replayed| f64::from(sample.luminance);
    let sum = |count: usize| samples.list[..count].iter().map(value).sum::<f64>();
    let (before, mean) = (sum(index) / index.max(1) as f64, sum(index + 1) / (index + 1) as f64);
    let size = vec2(ui.available_width(), 3.0 * GRID);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let words = format!(
        "Mean of {}: {} (before it {}; exact {})",
        index + 1,
        short(mean),
        if index == 0 { "\u{2013}".to_owned() } else { short(before) },
        short(exact)
    );
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &words));
    // The exact mean stays where it is unless the mean goes far beyond it.
    let end = (2.0 * exact).max(1.05 * mean).max(1.05 * before).max(1e-12);
    let x = |v: f64| rect.left() + (v / end) as f32 * rect.width();
    let painter = ui.painter();
    painter.rect_filled(rect, 2.0, ui.visuals().widgets.inactive.weak_bg_fill);
    painter.rect_filled(rect.with_max_x(x(mean)), 2.0, ui.visuals().weak_text_color());
    painter.vline(x(exact), rect.y_range().expand(3.0), Stroke::new(2.5, ui.visuals().text_color()));
    ui.label(RichText::new(words).text_style(TextStyle::Small));
}

/// A ray of a sample of the pixel: why it was drawn, where it goes, and its contribution with all numbers.
pub fn ray_ui(ui: &mut Ui, place: &Place, sample: &Replayed, ray: &Ray) {
    let estimator = &place.settings.estimator;
    let inks = Inks::of(ui.visuals());
    let symbols = Symbols::both(inks);
    let (own, name, ink) = match ray.technique {
        Technique::Light => (0, "Light sample", inks.light),
        Technique::Bsdf => (1, "BSDF sample", inks.bsdf),
    };
    ui.horizontal(|ui| {
        let label = title(ui, name);
        let line = label.rect.with_min_y(label.rect.bottom()).with_max_y(label.rect.bottom() + 2.0);
        ui.painter().rect_filled(line, 0.0, ink);
        caption(ui, why(estimator, sample, ray.technique)).hint("Why this technique drew the direction.");
    });
    if !ray.valid {
        ui.label("The light that was chosen turns its back: there is no direction, and the sample adds 0.");
        return;
    }
    ui.label(RichText::new(direction_words(place, sample, ray)).text_style(TextStyle::Small));
    let weighted = both(ray, estimator);
    let number = |v: f64| text(format!(" = {}    ", short(v)));
    let f = luminance(ray.f);
    let unit = if ray.dirac { "" } else { " /sr" };
    row([
        text("f"),
        number(f),
        symbols[0].p(),
        text(format!(" = {}{unit}    ", short(f64::from(ray.p_light)))),
        symbols[1].p(),
        text(format!(" = {}{unit}", short(f64::from(ray.p_bsdf)))),
    ])
    .show(ui, size_in_text(ui))
    .hint(
        "f: luminance of bsdf \u{d7} L_e \u{d7} visible \u{d7} cos. Both densities, whichever technique drew. \
         p_L is one density over all lights: 1/n times that of the light in this direction.",
    );
    if !ray.lit {
        ui.label("f is 0: the sample adds 0.");
        return;
    }
    for line in formulas(estimator, ray, &symbols, own) {
        line.show(ui, size_in_text(ui));
    }
    let other = 1 - own;
    let value = luminance(weighted[other].value);
    let words = if weighted[other].weight > 0.0 {
        row([
            text(if other == 0 { "a light sample here:  " } else { "a BSDF sample here:  " }),
            symbols[other].w(),
            text(format!(" = {},  adding {}", short(f64::from(weighted[other].weight)), short(value))),
        ])
    } else {
        row([text(if other == 0 { "a light sample is never drawn here" } else { "a BSDF sample is never drawn here" })])
    };
    words.show(ui, size_in_text(ui)).hint("What the other technique would have given for the same direction.");
}

/// `w f / (c p)` with its numbers and, where the balance heuristic makes one of it, `f / (p_L + p_B)`.
fn formulas(estimator: &Estimator, ray: &Ray, symbols: &[Symbols; 2], own: usize) -> Vec<Math> {
    let p = [ray.p_light, ray.p_bsdf].map(f64::from);
    let (f, value) = (luminance(ray.f), luminance(ray.value));
    let light_prob = f64::from(estimator.light_prob);
    let c = [light_prob, 1.0 - light_prob];
    let one = estimator.strategy == Strategy::Mis;
    let weighted = matches!(estimator.strategy, Strategy::MisAll | Strategy::Mis);
    let t = &symbols[own];
    let product = |names: bool| {
        let p = if names { t.p() } else { text(short(p[own])) };
        let c_name = if own == 0 { "c ".to_owned() } else { "(1 \u{2212} c) ".to_owned() };
        let c = if names { c_name } else { format!("{:.2} \u{b7} ", c[own]) };
        if one { row([text(c), p]) } else { p }
    };
    let mut plain = Vec::new();
    if weighted {
        plain.extend([t.w(), text(" ")]);
    }
    plain.extend([frac(text("f"), product(true)), text(" = ")]);
    if weighted {
        plain.push(text(format!("{} \u{b7} ", short(f64::from(ray.weight)))));
    }
    plain.extend([frac(text(short(f)), product(false)), text(format!(" = {}", short(value)))]);
    let mut lines = vec![row(plain)];
    if weighted && estimator.heuristic == Heuristic::Balance {
        let tutorial = one && estimator.weights == OneSampleWeights::Tutorial;
        let veach = one && !tutorial;
        let names = if veach {
            row([text("c "), symbols[0].p(), text(" + (1 \u{2212} c) "), symbols[1].p()])
        } else {
            row([symbols[0].p(), text(" + "), symbols[1].p()])
        };
        let numbers = if veach { [c[0] * p[0], c[1] * p[1]] } else { p }.map(short);
        // What the tutorial's weights leave out of the sum.
        let before = |with: &str| if tutorial { with.to_owned() } else { String::new() };
        let name = if own == 0 { "c (" } else { "(1 \u{2212} c) (" };
        lines.push(row([
            text("= "),
            frac(text("f"), row([text(before(name)), names, text(before(")"))])),
            text(" = "),
            frac(
                text(short(f)),
                text(format!("{}{} + {}{}", before(&format!("{:.2} (", c[own])), numbers[0], numbers[1], before(")"))),
            ),
        ]));
    }
    lines
}

/// Why that technique drew.
fn why(estimator: &Estimator, sample: &Replayed, technique: Technique) -> String {
    match estimator.strategy {
        Strategy::Light | Strategy::Bsdf => "the strategy draws no other".to_owned(),
        Strategy::MisAll => "the strategy draws both".to_owned(),
        Strategy::Mis => {
            let (c, sign) = match technique {
                Technique::Light => (estimator.light_prob, "<"),
                Technique::Bsdf => (estimator.light_prob, "\u{2265}"),
            };
            sample.drawn.technique.map_or_else(String::new, |u| format!("its number {u:.3} {sign} c = {c:.2}"))
        }
    }
}

/// Where the direction goes.
fn direction_words(place: &Place, sample: &Replayed, ray: &Ray) -> String {
    let Some(point) = place.look(sample.drawn.pixel.map(f64::from)).point() else { return String::new() };
    let off = angle(ray.wi, point.mirrored()).to_degrees();
    let tilt = angle(ray.wi, point.normal()).to_degrees();
    let seen = point.direction(ray.wi);
    let hit =
        seen.hit.and_then(|hit| place.scene.shapes.get(hit.shape)?.light.as_ref().map(|light| light.name.clone()));
    let ends = match hit {
        Some(name) if ray.lit || ray.f != glam::Vec3::ZERO => format!("hits {name}"),
        Some(name) if tilt >= 90.0 => format!("{name} lies below the surface"),
        Some(name) if seen.visible => format!("hits {name}, of which nothing is reflected"),
        Some(name) => format!("something is before {name}"),
        None => "hits no light".to_owned(),
    };
    format!("{tilt:.1}\u{b0} from the normal, {off:.1}\u{b0} from the mirror direction: {ends}")
}
