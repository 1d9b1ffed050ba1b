//! The curves over c on screen: exact ones, measured points, and the marker that is the slider.

use std::sync::Arc;

use eframe::egui::{
    self, Align2, Color32, CursorIcon, Rect, Role, Sense, Shape, Stroke, StrokeKind, TextStyle, Ui, Vec2, pos2, vec2,
};
use mislab_renderer::study::Part;
use mislab_renderer::{Estimator, Frame, OneSampleWeights, Strategy};

use super::axis::{Spread, plane_ui};
use super::number::short;
use super::numbers::{Measured, how};
use super::over_c::{Curves, OverC};
use super::part_over_c::{Parts, Worst};
use super::place::Place;
use super::shown::Shown;
use crate::look::names::{strategy_name, weights_name};
use crate::look::theme::{GRID, Inks};
use crate::panel::hint::Hint as _;
use crate::panel::study::Subject;
use crate::panel::study::parts::part_name;
use crate::panel::study::plot::Axes;
use crate::panel::study::tiles::{caption_lines, caption_that_fits};
use crate::panel::widgets::segmented;
use crate::picture::live::LivePicture;
use crate::state::command::Command;
use crate::state::edit::Edit;

/// Of what the curves are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Over {
    /// The pixel.
    #[default]
    Pixel,
    /// The plate under the light that it shows.
    Square,
    /// All pixels.
    Picture,
}

/// What is chosen.
#[derive(Default)]
pub struct OverChoice {
    over: Over,
    measured: Measurements,
}

/// What is drawn.
struct Plot<'a> {
    curves: &'a Curves,
    /// Of light samples alone, of BSDF samples alone, and of both at equal rays, where they are known.
    others: [Option<f64>; 3],
    /// By weights, of the square that has the largest variance.
    worst: Option<&'a [Worst; 2]>,
    points: Vec<Point>,
    estimator: Estimator,
    /// Name of the vertical axis.
    y: &'static str,
}

impl Plot<'_> {
    /// Of the weights in use.
    fn worst(&self) -> Option<&[Option<(f64, usize)>]> {
        let index = OneSampleWeights::ALL.iter().position(|each| *each == self.estimator.weights)?;
        Some(&self.worst?[index])
    }
}

/// Chooses of what the curves are.
pub fn choice_ui(ui: &mut Ui, choice: &mut OverChoice) -> Over {
    let choices = [(Over::Pixel, "Pixel"), (Over::Square, "Its square"), (Over::Picture, "Whole picture")];
    let hint = |ui: &mut Ui, over: Over| {
        ui.label(match over {
            Over::Pixel => "Of this pixel alone.",
            Over::Square => "Averaged over the plate under the light that the pixel is in.",
            Over::Picture => "Averaged over the picture, and the worst of its squares.",
        });
    };
    if let Some(over) = segmented(ui, "Curve", choice.over, &choices, true, &hint) {
        choice.over = over;
    }
    choice.over
}

/// Draws those of a pixel; faintly while they are still those of another pixel or scene.
pub fn over_c_ui(ui: &mut Ui, over_c: &OverC, shown: &Shown<'_>, subject: &Subject<'_>, out: &mut Vec<Command>) {
    if !over_c.tables.place.is_same(shown.place) {
        ui.multiply_opacity(0.5);
    }
    let (estimator, y) = (shown.estimator, "variance of one ray / mean\u{b2}");
    let points = measured(over_c, shown, subject);
    let plot = Plot { curves: &over_c.curves, others: over_c.others, worst: None, points, estimator, y };
    let caption = format!(
        "Dots: measured, with two standard errors by the fourth moment of the samples so far, which misses fireflies still to come. \
         {}{}",
        how(&over_c.tables),
        if over_c.is_fine() || !over_c.tables.is_final() { "" } else { " Few places so far \u{2026}" },
    );
    plot_ui(ui, &plot, "this pixel", &caption, out);
}

/// Draws those of a square, or of the picture; faintly while they are still those of another picture.
pub fn part_over_c_ui(
    ui: &mut Ui,
    choice: &mut OverChoice,
    parts: &Parts,
    shown: &Shown<'_>,
    subject: &Subject<'_>,
) -> Vec<Command> {
    let mut out = Vec::new();
    let part = match choice.over {
        Over::Pixel | Over::Picture => Part::Whole,
        Over::Square => match parts.square_at(shown.place.pixel) {
            Some(index) => Part::Square(index),
            None => {
                ui.label("This pixel is in no square: it shows no plate under a light.");
                return out;
            }
        },
    };
    let name = part_name(Some(&parts.cells), part);
    let Some(average) = parts.average(part) else {
        ui.label(format!("Light comes from none of the pixels of {name} that were looked at."));
        return out;
    };
    let points = choice.measured.of(parts, part, shown, subject);
    let worst = (part == Part::Whole && !parts.cells.squares.is_empty()).then(|| parts.worst());
    let y = "relMSE of one ray: mean of variance / (mean\u{b2} + 0.01)";
    let plot = Plot { curves: &average.curves, others: [None; 3], worst, points, estimator: shown.estimator, y };
    let mut caption = String::new();
    if let Some(worst) = plot.worst() {
        let at = |c: f64| plot.curves.c.iter().position(|place| *place >= c).and_then(|i| worst[i]);
        if let Some((_, square)) = at(f64::from(shown.estimator.light_prob)) {
            let least = worst.iter().zip(&plot.curves.c).filter_map(|(v, c)| Some(((*v)?.0, c)));
            let safest = least.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(f64::NAN, |(_, c)| *c);
            let square = part_name(Some(&parts.cells), Part::Square(square));
            caption = format!("Dotted: the worst square at each c, here {square}; that is least at c {safest:.2}. ");
        }
    }
    let count = average.pixels.len();
    caption.push_str(&format!(
        "Dots: measured in the same pixels, with two standard errors. By quadrature over some hundred directions at the centres of \
         {count} pixels{}",
        if parts.is_fine() { "." } else { "; coarse so far \u{2026}" },
    ));
    plot_ui(ui, &plot, &name, &caption, &mut out);
    out
}

fn plot_ui(ui: &mut Ui, plot: &Plot<'_>, name: &str, about: &str, out: &mut Vec<Command>) {
    let (_, best) = plot.curves.of(plot.estimator.weights);
    let Some(best) = best else {
        ui.label("No light arrives here: there is no best c.");
        return;
    };
    let small = ui.text_style_height(&TextStyle::Small);
    let foot = 2.0 * (ui.spacing().interact_size.y + GRID) + caption_lines(ui, [1.0, 5.0]) + 4.0 * GRID;
    let size = vec2(ui.available_width(), (ui.available_height() - foot).max(200.0));
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(Role::Image, true, format!("Variance over c: {name}")));
    let label =
        ui.painter().layout_no_wrap("0.0001".into(), TextStyle::Small.resolve(ui.style()), Color32::WHITE).size().x;
    let inner = Rect::from_min_max(
        rect.min + vec2(label + 2.0 * GRID, small + GRID),
        rect.max - vec2(3.0 * GRID, 2.0 * small + 2.0 * GRID),
    );
    let axes = Axes { rect: inner, x: [0.0, 1.0], y: heights(plot) };
    plane_ui(ui, &axes, Spread::Log, inner.bottom(), "");
    names_ui(ui, rect, inner, plot.y);
    curves_ui(ui, plot, &axes);
    points_ui(ui, &plot.points, &axes);
    best_ui(ui, best, &axes);
    marker_ui(ui, &plot.estimator, &axes, out);
    words_ui(ui, plot, best, name, out);
    let [solid, dashed] = [OneSampleWeights::Veach, OneSampleWeights::Tutorial].map(weights_name);
    let few = format!("Solid: weights {solid}; dashed: {dashed}.");
    caption_that_fits(ui, &format!("{few} {about}"), &few);
}

/// A measured relative variance.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Point {
    c: f64,
    variance: f64,
    /// Two standard errors, where they are known.
    bar: Option<f64>,
}

/// What the pictures of the one-sample model with the same heuristic have measured in a pixel.
fn measured(over_c: &OverC, shown: &Shown<'_>, subject: &Subject<'_>) -> Vec<Point> {
    let truth = over_c.tables.truth;
    let of = |(slot, live): (usize, &LivePicture)| {
        let frame = live.current_frame().filter(|frame| is_comparable(frame, &shown.estimator))?;
        let place = Place::of(&frame, shown.place.pixel)?;
        if !place.is_same(&over_c.tables.place) {
            return None;
        }
        let variance = Measured::of(&frame, shown.place.pixel)?.deviation?.powi(2) / (truth * truth);
        let own = shown.samples.filter(|_| slot == subject.document.active_index());
        let bar = own.and_then(|samples| samples.variance()).map(|[_, error]| 2.0 * error / (truth * truth));
        let c = f64::from(frame.request().settings.estimator.light_prob);
        (variance > 0.0).then_some(Point { c, variance, bar })
    };
    subject.pictures.iter().enumerate().filter_map(of).collect()
}

/// Whether a frame is of the one-sample model with the same heuristic.
fn is_comparable(frame: &Frame, estimator: &Estimator) -> bool {
    let own = frame.request().settings.estimator;
    own.strategy == Strategy::Mis && own.heuristic == estimator.heuristic
}

/// What pictures have measured in the pixels of a part, kept until they have more samples.
#[derive(Default)]
struct Measurements(Vec<(Of, Option<Point>)>);

/// What was measured.
#[derive(Clone, Copy, PartialEq)]
struct Of {
    slot: usize,
    generation: u64,
    spp: u32,
    part: Part,
    pixels: usize,
}

impl Measurements {
    fn of(&mut self, parts: &Parts, part: Part, shown: &Shown<'_>, subject: &Subject<'_>) -> Vec<Point> {
        let Some(average) = parts.average(part) else { return Vec::new() };
        let mut measured = Vec::new();
        for (slot, live) in subject.pictures.iter().enumerate() {
            let comparable = |frame: &Arc<Frame>| is_comparable(frame, &shown.estimator) && parts.is_of(frame);
            let Some(frame) = live.current_frame().filter(comparable) else { continue };
            let pixels = average.pixels.len();
            let of = Of { slot, generation: frame.generation(), spp: frame.spp(), part, pixels };
            let known = self.0.iter().find(|(known, _)| *known == of).map(|(_, point)| *point);
            let point = known.unwrap_or_else(|| {
                let [variance, error] = average.measured(&frame)?;
                let c = f64::from(frame.request().settings.estimator.light_prob);
                (variance > 0.0).then_some(Point { c, variance, bar: Some(2.0 * error) })
            });
            measured.push((of, point));
        }
        self.0 = measured;
        self.0.iter().filter_map(|(_, point)| *point).collect()
    }
}

/// Whole decades around everything, or a part of one where all is alike.
fn heights(plot: &Plot<'_>) -> [f64; 2] {
    let curves = plot.curves.variances.iter().flatten().chain(&plot.others).flatten().copied();
    let worst = plot.worst().into_iter().flatten().flatten().map(|(variance, _)| *variance);
    let all = curves.chain(worst).chain(plot.points.iter().map(|point| point.variance)).filter(|v| *v > 0.0);
    let [low, high] =
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v.log10()), high.max(v.log10())]);
    if low.is_finite() { [(low - 0.1).floor(), (high + 0.1).ceil()] } else { [-1.0, 0.0] }
}

fn names_ui(ui: &Ui, rect: Rect, inner: Rect, y: &str) {
    let font = TextStyle::Small.resolve(ui.style());
    let weak = ui.visuals().weak_text_color();
    ui.painter().text(pos2(inner.left(), rect.top()), Align2::LEFT_TOP, y, font.clone(), weak);
    let x = "c: probability of the light technique";
    ui.painter().text(pos2(inner.center().x, rect.bottom()), Align2::CENTER_BOTTOM, x, font, weak);
}

fn curves_ui(ui: &Ui, plot: &Plot<'_>, axes: &Axes) {
    let painter = ui.painter_at(axes.rect);
    let inks = Inks::of(ui.visuals());
    let font = TextStyle::Small.resolve(ui.style());
    let [light, bsdf, both] = plot.others;
    if let Some(both) = both.filter(|v| *v > 0.0) {
        let ink = inks.strategy(Strategy::MisAll);
        axes.guide(&painter, [0.5, both.log10()], 0.0, Stroke::new(1.5, ink));
        // Where c is small, the curves mostly lie above it; but BSDF samples alone, at c = 0, may lie where the words would.
        let height = |value: f64| axes.at([0.0, value.log10()]).y;
        let taken = bsdf.is_some_and(|v| v > 0.0 && (0.0..3.0 * font.size).contains(&(height(v) - height(both))));
        let (c, align) = if taken { (0.98, Align2::RIGHT_TOP) } else { (0.02, Align2::LEFT_TOP) };
        let at = axes.at([c, both.log10()]) + vec2(0.0, 0.5 * GRID);
        let name = format!("{}, at equal rays", strategy_name(Strategy::MisAll));
        painter.text(at, align, name, font.clone(), ink);
    }
    let ink = inks.strategy(Strategy::Mis);
    let c = &plot.curves.c;
    for weights in OneSampleWeights::ALL {
        let (curve, _) = plot.curves.of(weights);
        let known = c.iter().zip(curve).filter_map(|(c, v)| Some([*c, v.filter(|v| *v > 0.0)?.log10()]));
        let points: Vec<_> = known.map(|at| axes.at(at)).collect();
        let own = weights == plot.estimator.weights;
        let stroke = if own { Stroke::new(2.5, ink) } else { Stroke::new(1.5, ink.gamma_multiply(0.7)) };
        match weights {
            OneSampleWeights::Veach => painter.extend([Shape::line(points, stroke)]),
            OneSampleWeights::Tutorial => painter.extend(Shape::dashed_line(&points, stroke, 2.0 * GRID, GRID)),
        }
    }
    if let Some(worst) = plot.worst() {
        let known = c.iter().zip(worst).filter_map(|(c, v)| Some(axes.at([*c, (*v)?.0.log10()])));
        let ink = ui.visuals().text_color();
        let points: Vec<_> = known.collect();
        painter.extend(Shape::dotted_line(&points, ink, 1.5 * GRID, 1.2));
        if let Some(middle) = points.get(points.len() / 2) {
            let words = painter.layout_no_wrap("worst square".into(), font.clone(), ink);
            // Above all of the curve that they are as wide as.
            let below = points.iter().filter(|at| (at.x - middle.x).abs() <= 0.5 * words.size().x + GRID);
            let top = below.map(|at| at.y).fold(middle.y, f32::min) - GRID;
            painter.galley(pos2(middle.x - 0.5 * words.size().x, top - words.size().y), words, ink);
        }
    }
    for (value, c, strategy, align) in
        [(bsdf, 0.0, Strategy::Bsdf, Align2::LEFT_BOTTOM), (light, 1.0, Strategy::Light, Align2::RIGHT_BOTTOM)]
    {
        let Some(value) = value.filter(|v| *v > 0.0) else { continue };
        let (at, ink) = (axes.at([c, value.log10()]), inks.strategy(strategy));
        ui.painter().circle_filled(at, 4.0, ink);
        let side = if c == 0.0 { 1.0 } else { -1.0 };
        painter.text(at + vec2(side * 1.5 * GRID, -GRID), align, strategy_name(strategy), font.clone(), ink);
    }
}

fn points_ui(ui: &Ui, points: &[Point], axes: &Axes) {
    let painter = ui.painter_at(axes.rect.expand(6.0));
    let ink = ui.visuals().text_color();
    for Point { c, variance, bar } in points {
        let at = axes.at([*c, variance.log10()]);
        if let Some(bar) = bar {
            let low = (variance - bar).max(1e-3 * variance).log10().max(axes.y[0]);
            let [low, high] = [low, (variance + bar).log10().min(axes.y[1])].map(|y| axes.at([*c, y]).y);
            painter.vline(at.x, high..=low, Stroke::new(1.5, ink));
        }
        painter.circle(at, 4.5, Inks::of(ui.visuals()).strategy(Strategy::Mis), Stroke::new(1.5, ink));
    }
}

/// A diamond where the variance is least.
fn best_ui(ui: &Ui, [c, variance]: [f64; 2], axes: &Axes) {
    if variance <= 0.0 {
        return;
    }
    let at = axes.at([c, variance.log10()]);
    let ink = ui.visuals().text_color();
    let corners = [vec2(0.0, -6.0), vec2(6.0, 0.0), vec2(0.0, 6.0), vec2(-6.0, 0.0)].map(|corner| at + corner);
    ui.painter().add(Shape::convex_polygon(corners.to_vec(), ui.visuals().panel_fill, Stroke::new(2.0, ink)));
    let font = TextStyle::Small.resolve(ui.style());
    let (align, side) = if c > 0.7 { (Align2::RIGHT_TOP, -1.0) } else { (Align2::LEFT_TOP, 1.0) };
    ui.painter().text(at + vec2(side * 2.0 * GRID, 0.5 * GRID), align, format!("best c {c:.3}"), font, ink);
}

/// A line at c, which can be dragged: the slider itself.
fn marker_ui(ui: &mut Ui, estimator: &Estimator, axes: &Axes, out: &mut Vec<Command>) {
    let c = estimator.light_prob;
    let x = axes.at([f64::from(c), axes.y[0]]).x;
    let drawn = estimator.strategy == Strategy::Mis;
    let ink = Inks::of(ui.visuals()).strategy(Strategy::Mis).gamma_multiply(if drawn { 1.0 } else { 0.5 });
    ui.painter().vline(x, axes.rect.y_range(), Stroke::new(1.5, ink));
    let grip = Rect::from_center_size(pos2(x, axes.rect.center().y), vec2(12.0, axes.rect.height() + 12.0));
    let response = ui.interact(grip, ui.scope_id().with("c of the curve"), Sense::drag());
    response.widget_info(|| egui::WidgetInfo::labeled(Role::Splitter, true, "c in the curve"));
    let handle = Rect::from_center_size(pos2(x, axes.rect.bottom()), vec2(9.0, 12.0));
    ui.painter().rect(handle, 2.0, ink, Stroke::new(1.0, ui.visuals().text_color()), StrokeKind::Outside);
    let what = "c: probability of the light technique. Drag it: it is the slider in the bar.";
    let response = response.hint(what).on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
    if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.dragged())
        && response.drag_delta() != Vec2::ZERO
    {
        let c = axes.logs(pointer)[0].clamp(0.0, 1.0);
        out.push(Edit::SetLightProb(((c * 100.0).round() / 100.0) as f32).into());
    }
}

fn words_ui(ui: &mut Ui, plot: &Plot<'_>, [best, least]: [f64; 2], name: &str, out: &mut Vec<Command>) {
    let Estimator { light_prob: c, strategy, weights, .. } = plot.estimator;
    let here = between(&plot.curves.c, plot.curves.of(weights).0, f64::from(c));
    ui.horizontal_wrapped(|ui| {
        let words = match here {
            Some(here) => format!("c {c:.2}: {} \u{d7} the least variance", short(here / least)),
            None => format!("c {c:.2}: biased"),
        };
        ui.label(words).hint(format!("Variance at this c over that at the best c, for {name}."));
        let button = ui.button(format!("Use c {best:.3}"));
        if button.hint(format!("Sets c to the best of {name}, with the weights in use.")).clicked() {
            out.push(Edit::SetLightProb(best as f32).into());
        }
        if strategy != Strategy::Mis && ui.button("Use MIS, one").hint("c takes part in that strategy only.").clicked()
        {
            out.push(Edit::SetStrategy(Strategy::Mis).into());
        }
    });
}

/// A curve between its places; `None` where it is not known.
fn between(c: &[f64], curve: &[Option<f64>], at: f64) -> Option<f64> {
    let after = c.iter().position(|c| *c >= at)?;
    let (before, high) = (after.saturating_sub(1), curve[after]?);
    if c[after] == at || before == after {
        return Some(high);
    }
    let low = curve[before]?;
    let share = (at - c[before]) / (c[after] - c[before]);
    Some((low.max(1e-30).ln() * (1.0 - share) + high.max(1e-30).ln() * share).exp())
}
