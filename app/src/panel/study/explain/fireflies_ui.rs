//! The brightest outliers as a list and, of the one whose pixel is pinned, everything about its sample.

use std::sync::Arc;

use eframe::egui::{
    self, Align2, Color32, Pos2, Rect, RichText, Role, ScrollArea, Sense, Stroke, TextStyle, Ui, pos2, vec2,
};
use mislab_renderer::inspect::{Outlier, Technique};
use mislab_renderer::{Estimator, Frame, Strategy};

use super::fireflies::Found;
use super::number::short;
use super::place::{Place, luminance};
use super::sample::ray_ui;
use crate::look::names::{heuristic_name, strategy_name};
use crate::look::theme::{GRID, Inks};
use crate::panel::formula::Technique as Symbols;
use crate::panel::hint::Hint as _;
use crate::panel::math::{frac, row, size_in_text, text};
use crate::panel::number::two_digits;
use crate::panel::widgets::{caption, focus_ring};
use crate::state::command::Command;

/// What a firefly is.
const WHAT: &str = "A firefly: one sample with more than half of its pixel's sum of squares, from which noise comes. Its share of the light may be smaller.";

/// What is pinned.
pub struct Chosen {
    /// The pixel.
    pub pixel: Option<[u32; 2]>,
    /// Its exact luminance, once that is known.
    pub exact: Option<f64>,
}

/// Draws them; `found` is `None` while nothing is known of this picture.
pub fn fireflies_ui(ui: &mut Ui, frame: &Arc<Frame>, found: Option<&Found>, chosen: &Chosen, out: &mut Vec<Command>) {
    let Some(Found { about, fireflies }) = found else {
        caption(ui, "Looking for the brightest samples \u{2026}");
        return;
    };
    if fireflies.outliers.is_empty() {
        ui.label("No sample outshines all others of its pixel.");
        caption(ui, WHAT);
        return;
    }
    ui.scope(|ui| list_ui(ui, &fireflies.outliers, chosen, out));
    let mut words = format!("{WHAT} The brightest of {} per pixel", about.spp);
    words.push_str(if fireflies.complete { "." } else { "; there may be brighter ones." });
    if fireflies.different > 0 {
        words.push_str(" Some pixels were rendered elsewhere: their samples are not quite those of the picture.");
    }
    caption(ui, words);
    ui.add_space(GRID);
    let Some(outlier) = fireflies.outliers.iter().find(|outlier| Some(outlier.pixel) == chosen.pixel) else {
        ui.label("Click one, here or in the picture: its sample is drawn again.");
        return;
    };
    let Some(place) = Place::of(frame, outlier.pixel) else { return };
    ScrollArea::vertical().id_salt("firefly").auto_shrink(false).show(ui, |ui| {
        means_ui(ui, outlier, chosen.exact);
        let estimator = place.settings.estimator;
        ray_ui(ui, &place, &outlier.sample, &outlier.sample.rays[outlier.ray]);
        if estimator.strategy != Strategy::MisAll {
            mis_all_ui(ui, outlier, &estimator);
        }
    });
}

/// Where the columns begin, as shares of the width.
const COLUMNS: [f32; 6] = [0.01, 0.07, 0.33, 0.53, 0.7, 0.86];

fn list_ui(ui: &mut Ui, outliers: &[Outlier], chosen: &Chosen, out: &mut Vec<Command>) {
    let line = ui.text_style_height(&TextStyle::Small) + GRID;
    let width = ui.available_width();
    ui.spacing_mut().item_spacing.y = 0.0;
    let (head, response) = ui.allocate_exact_size(vec2(width, line), Sense::hover());
    let weak = ui.visuals().weak_text_color();
    let names = ["", "pixel", "sample", "drawn by", "adds", "of pixel"];
    cells(ui, head, names.map(|name| (name.to_owned(), weak)));
    response.hint(
        "adds: luminance w f / (c p) of the sample, in W/(m\u{b2} sr). of pixel: its share of the sum over all samples of the \
         pixel.",
    );
    let (ink, inks) = (ui.visuals().text_color(), Inks::of(ui.visuals()));
    for (index, outlier) in outliers.iter().enumerate() {
        let [x, y] = outlier.pixel;
        let on = chosen.pixel == Some(outlier.pixel);
        let (rect, response) = ui.allocate_exact_size(vec2(width, line), Sense::click());
        let spoken = format!("Firefly {}: pixel x {x}, y {y}", index + 1);
        response.widget_info(|| egui::WidgetInfo::selected(Role::RadioButton, true, on, &spoken));
        let fill = if on {
            ui.visuals().selection.bg_fill
        } else if response.hovered() || response.has_focus() {
            ui.visuals().widgets.hovered.weak_bg_fill
        } else {
            Color32::TRANSPARENT
        };
        ui.painter().rect_filled(rect, 3.0, fill);
        focus_ring(ui, &response, rect);
        let (technique, colour) = match outlier.sample.rays[outlier.ray].technique {
            Technique::Light => ("light", inks.light),
            Technique::Bsdf => ("BSDF", inks.bsdf),
        };
        let share = format!("{:.1} %", 100.0 * outlier.share_of_pixel);
        let texts = [
            ((index + 1).to_string(), weak),
            (format!("{x}, {y}"), ink),
            // Samples are counted from 1, as people do.
            ((outlier.index + 1).to_string(), ink),
            (technique.to_owned(), if on { ink } else { colour }),
            (short(outlier.value), ink),
            (share, ink),
        ];
        cells(ui, rect, texts);
        if response.clicked() {
            out.push(Command::Pin(Some(outlier.pixel)));
        }
    }
}

fn cells(ui: &Ui, rect: Rect, texts: [(String, Color32); 6]) {
    let font = TextStyle::Small.resolve(ui.style());
    for (column, (words, ink)) in COLUMNS.into_iter().zip(texts) {
        let at = pos2(rect.left() + column * rect.width(), rect.center().y);
        ui.painter().text(at, Align2::LEFT_CENTER, words, font.clone(), ink);
    }
}

/// The mean of the pixel with and without that sample, as bars, and the exact one as a line across both.
fn means_ui(ui: &mut Ui, outlier: &Outlier, exact: Option<f64>) {
    let [with, without] = [outlier.mean, outlier.mean_without].map(|mean| luminance(mean.as_vec3()));
    ui.label("Mean of the pixel")
        .hint("Luminance: the sum of all samples over their number n; without this one, the rest over n \u{2212} 1.");
    let line = ui.text_style_height(&TextStyle::Small) + GRID;
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 2.0 * line), Sense::hover());
    let exact_words = exact.map_or_else(|| "\u{2026}".to_owned(), short);
    let words = format!("with it {}, without it {}, exact {exact_words}", short(with), short(without));
    response.widget_info(|| egui::WidgetInfo::labeled(Role::Image, true, format!("Mean of the pixel: {words}")));
    let font = TextStyle::Small.resolve(ui.style());
    let ink = ui.visuals().text_color();
    let left = rect.left() + 0.16 * rect.width();
    // Room for a number behind the longest bar.
    let end = with.max(exact.unwrap_or(0.0)).max(1e-12) / 0.8;
    let x = |v: f64| left + (v / end) as f32 * (rect.right() - left);
    for (i, (name, mean)) in [("with it", with), ("without", without)].into_iter().enumerate() {
        let top = rect.top() + i as f32 * line;
        let middle = top + 0.5 * line;
        let bar = Rect::from_min_max(pos2(left, top + 1.0), pos2(x(mean).max(left + 1.0), top + line - 1.0));
        ui.painter().rect_filled(bar, 2.0, ui.visuals().weak_text_color());
        ui.painter().text(Pos2::new(rect.left(), middle), Align2::LEFT_CENTER, name, font.clone(), ink);
        // Off the line of the exact one.
        let line_at = exact.map(x).filter(|at| (bar.right() - GRID..bar.right() + 15.0 * GRID).contains(at));
        let behind = line_at.unwrap_or(0.0).max(bar.right());
        ui.painter().text(pos2(behind + GRID, middle), Align2::LEFT_CENTER, short(mean), font.clone(), ink);
    }
    if let Some(exact) = exact {
        ui.painter().vline(x(exact), rect.y_range().expand(2.0), Stroke::new(2.5, ink));
    }
    let words = format!(
        "Without it the mean falls from {} to {}; the line: exact, {exact_words}.",
        short(with),
        short(without)
    );
    ui.label(RichText::new(words).text_style(TextStyle::Small));
}

/// What the same direction adds where both techniques are drawn and weighted.
fn mis_all_ui(ui: &mut Ui, outlier: &Outlier, own: &Estimator) {
    let ray = &outlier.sample.rays[outlier.ray];
    let estimator = Estimator { strategy: Strategy::MisAll, ..*own };
    let index = match ray.technique {
        Technique::Light => 0,
        Technique::Bsdf => 1,
    };
    let weighted = super::samples::both(ray, &estimator)[index];
    let symbols = Symbols::both(Inks::of(ui.visuals()));
    let ink = Inks::of(ui.visuals()).strategy(Strategy::MisAll);
    let name = format!(
        "The same direction under {} ({})",
        strategy_name(Strategy::MisAll),
        heuristic_name(own.heuristic).to_lowercase()
    );
    ui.label(RichText::new(name).color(ink));
    let f = short(luminance(ray.f));
    let p = short(f64::from([ray.p_light, ray.p_bsdf][index]));
    row([
        symbols[index].w(),
        text(" "),
        frac(text("f"), symbols[index].p()),
        text(format!(" = {} \u{b7} ", short(f64::from(weighted.weight)))),
        frac(text(f), text(p)),
        text(format!(" = {}", short(outlier.under_mis_all))),
    ])
    .show(ui, size_in_text(ui))
    .hint("Drawn by the same technique, and weighted by both densities: what remains of the firefly.");
    let words = if outlier.under_mis_all > 0.0 {
        format!("{} times less than here.", two_digits(outlier.value / outlier.under_mis_all))
    } else {
        "It adds nothing.".to_owned()
    };
    ui.label(RichText::new(words).text_style(TextStyle::Small));
}
