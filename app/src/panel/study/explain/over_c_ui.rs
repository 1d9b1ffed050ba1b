//! The curves over c on screen: exact ones, measured points, and the marker that is the slider.

use eframe::egui::{
    self, Align2, Color32, CursorIcon, Rect, Role, Sense, Shape, Stroke, StrokeKind, TextStyle, Ui, Vec2, pos2, vec2,
};
use mislab_renderer::{OneSampleWeights, Strategy};

use super::axis::{Spread, plane_ui};
use super::number::short;
use super::numbers::{Measured, how};
use super::over_c::OverC;
use super::place::Place;
use super::shown::Shown;
use crate::look::names::{strategy_name, weights_name};
use crate::look::theme::{GRID, Inks};
use crate::panel::hint::Hint as _;
use crate::panel::study::Subject;
use crate::panel::study::plot::Axes;
use crate::panel::widgets::caption;
use crate::state::command::Command;
use crate::state::edit::Edit;

/// Draws them; faintly while they are still those of another pixel or scene.
pub fn over_c_ui(ui: &mut Ui, over_c: &OverC, shown: &Shown<'_>, subject: &Subject<'_>, out: &mut Vec<Command>) {
    if !over_c.tables.place.is_same(shown.place) {
        ui.multiply_opacity(0.5);
    }
    let best = over_c.best[index(shown.estimator.weights)];
    let Some(best) = best else {
        ui.label("No light arrives here: there is no best c.");
        return;
    };
    let points = measured(over_c, shown, subject);
    let small = ui.text_style_height(&TextStyle::Small);
    let foot = 2.0 * (ui.spacing().interact_size.y + GRID) + 4.0 * small + 4.0 * GRID;
    let size = vec2(ui.available_width(), (ui.available_height() - foot).max(200.0));
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(Role::Image, true, "Variance over c"));
    let label =
        ui.painter().layout_no_wrap("0.0001".into(), TextStyle::Small.resolve(ui.style()), Color32::WHITE).size().x;
    let inner = Rect::from_min_max(
        rect.min + vec2(label + 2.0 * GRID, small + GRID),
        rect.max - vec2(3.0 * GRID, 2.0 * small + 2.0 * GRID),
    );
    let axes = Axes { rect: inner, x: [0.0, 1.0], y: heights(over_c, &points) };
    plane_ui(ui, &axes, Spread::Log, inner.bottom(), "");
    names_ui(ui, rect, inner);
    curves_ui(ui, over_c, shown, &axes);
    points_ui(ui, &points, &axes);
    best_ui(ui, best, &axes);
    marker_ui(ui, shown, &axes, out);
    words_ui(ui, over_c, shown, best, out);
}

fn index(weights: OneSampleWeights) -> usize {
    OneSampleWeights::ALL.iter().position(|each| *each == weights).unwrap_or(0)
}

/// A measured variance over the squared exact mean.
struct Point {
    c: f64,
    variance: f64,
    /// Two standard errors, where they are known.
    bar: Option<f64>,
}

/// Of the pictures of the one-sample model with the same heuristic.
fn measured(over_c: &OverC, shown: &Shown<'_>, subject: &Subject<'_>) -> Vec<Point> {
    let truth = over_c.tables.truth;
    let of = |(slot, live): (usize, &crate::picture::live::LivePicture)| {
        let frame = live.current_frame()?;
        let estimator = frame.request().settings.estimator;
        let place = Place::of(&frame, shown.place.pixel)?;
        if estimator.strategy != Strategy::Mis
            || estimator.heuristic != shown.estimator.heuristic
            || !place.is_same(&over_c.tables.place)
        {
            return None;
        }
        let variance = Measured::of(&frame, shown.place.pixel)?.deviation?.powi(2) / (truth * truth);
        let own = shown.samples.filter(|_| slot == subject.document.active_index());
        let bar = own.and_then(|samples| samples.variance()).map(|[_, error]| 2.0 * error / (truth * truth));
        (variance > 0.0).then(|| Point { c: f64::from(estimator.light_prob), variance, bar })
    };
    subject.pictures.iter().enumerate().filter_map(of).collect()
}

/// Whole decades around everything, or a part of one where all is alike.
fn heights(over_c: &OverC, points: &[Point]) -> [f64; 2] {
    let curves = over_c.curves.iter().flatten().chain(&over_c.others).flatten().copied();
    let all = curves.chain(points.iter().map(|point| point.variance)).filter(|v| *v > 0.0);
    let [low, high] =
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v.log10()), high.max(v.log10())]);
    if low.is_finite() { [(low - 0.1).floor(), (high + 0.1).ceil()] } else { [-1.0, 0.0] }
}

fn names_ui(ui: &Ui, rect: Rect, inner: Rect) {
    let font = TextStyle::Small.resolve(ui.style());
    let weak = ui.visuals().weak_text_color();
    let y = "variance of one ray / mean\u{b2}";
    ui.painter().text(pos2(inner.left(), rect.top()), Align2::LEFT_TOP, y, font.clone(), weak);
    let x = "c: probability of the light technique";
    ui.painter().text(pos2(inner.center().x, rect.bottom()), Align2::CENTER_BOTTOM, x, font, weak);
}

fn curves_ui(ui: &Ui, over_c: &OverC, shown: &Shown<'_>, axes: &Axes) {
    let painter = ui.painter_at(axes.rect);
    let inks = Inks::of(ui.visuals());
    let font = TextStyle::Small.resolve(ui.style());
    let [light, bsdf, both] = over_c.others;
    if let Some(both) = both.filter(|v| *v > 0.0) {
        let ink = inks.strategy(Strategy::MisAll);
        axes.guide(&painter, [0.5, both.log10()], 0.0, Stroke::new(1.5, ink));
        // Where c is small, the curves mostly lie above it.
        let at = axes.at([0.02, both.log10()]) + vec2(0.0, 0.5 * GRID);
        let name = format!("{}, at equal rays", strategy_name(Strategy::MisAll));
        painter.text(at, Align2::LEFT_TOP, name, font.clone(), ink);
    }
    let ink = inks.strategy(Strategy::Mis);
    for (curve, weights) in over_c.curves.iter().zip(OneSampleWeights::ALL) {
        let known = over_c.c.iter().zip(curve).filter_map(|(c, v)| Some([*c, v.filter(|v| *v > 0.0)?.log10()]));
        let points: Vec<_> = known.map(|at| axes.at(at)).collect();
        let own = weights == shown.estimator.weights;
        let stroke = if own { Stroke::new(2.5, ink) } else { Stroke::new(1.5, ink.gamma_multiply(0.7)) };
        match weights {
            OneSampleWeights::Veach => painter.extend([Shape::line(points, stroke)]),
            OneSampleWeights::Tutorial => painter.extend(Shape::dashed_line(&points, stroke, 2.0 * GRID, GRID)),
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
fn marker_ui(ui: &mut Ui, shown: &Shown<'_>, axes: &Axes, out: &mut Vec<Command>) {
    let c = shown.estimator.light_prob;
    let x = axes.at([f64::from(c), axes.y[0]]).x;
    let drawn = shown.estimator.strategy == Strategy::Mis;
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

fn words_ui(ui: &mut Ui, over_c: &OverC, shown: &Shown<'_>, [best, least]: [f64; 2], out: &mut Vec<Command>) {
    let c = shown.estimator.light_prob;
    let curve = &over_c.curves[index(shown.estimator.weights)];
    let here = between(&over_c.c, curve, f64::from(c));
    ui.horizontal(|ui| {
        let words = match here {
            Some(here) => format!("c {c:.2}: {} \u{d7} the least variance", short(here / least)),
            None => format!("c {c:.2}: biased"),
        };
        ui.label(words).hint("Variance at this c over that at the best c, for this pixel alone.");
        let button =
            ui.button(format!("Use c {best:.3}")).hint("Sets c to the best of this pixel, with the weights in use.");
        if button.clicked() {
            out.push(Edit::SetLightProb(best as f32).into());
        }
        let active = shown.estimator.strategy;
        if active != Strategy::Mis && ui.button("Use MIS, one").hint("c takes part in that strategy only.").clicked() {
            out.push(Edit::SetStrategy(Strategy::Mis).into());
        }
    });
    let tables = &over_c.tables;
    let [solid, dashed] = [OneSampleWeights::Veach, OneSampleWeights::Tutorial].map(weights_name);
    caption(
        ui,
        format!(
            "Solid: weights {solid}; dashed: {dashed}. Dots: measured, with two standard errors by the fourth moment of the \
             samples so far, which misses fireflies still to come. {}{}",
            how(tables),
            if over_c.is_fine() || !tables.is_final() { "" } else { " Few places so far \u{2026}" },
        ),
    );
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
