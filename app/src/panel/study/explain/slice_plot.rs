//! The slice on screen: curves over the angle, under them weights, lights, the lobe and samples, with edges to drag.

use eframe::egui::{
    self, Align2, Color32, CursorIcon, Painter, Rect, Role, Sense, Shape, Stroke, StrokeKind, TextStyle, Ui, Vec2,
    pos2, vec2,
};
use mislab_renderer::inspect::{Replayed, Technique};
use mislab_renderer::{Estimator, Strategy};

use super::axis::{Spread, plane_ui};
use super::circle::{Circle, Sight};
use super::curves::Curve;
use super::place::{LightSeen, luminance};
use super::shown::Shown;
use super::trace::Trace;
use crate::look::theme::{GRID, Inks};
use crate::panel::hint::Hint as _;
use crate::panel::study::plot::Axes;
use crate::state::command::Command;
use crate::state::document::Document;
use crate::state::edit::Edit;

/// Most decades of the logarithmic axis.
const DECADES: f64 = 7.0;
/// Half the width of an edge to drag, in points.
const GRIP: f32 = 5.0;
/// Largest radius of a sample's dot, in points.
const LARGEST: f32 = 7.0;
/// The last samples: so many are drawn.
const LAST: usize = 64;

/// What is drawn.
pub struct Drawing<'a> {
    /// The pixel and what it is about.
    pub shown: &'a Shown<'a>,
    /// The circle.
    pub circle: Circle,
    /// The light that it passes through.
    pub light: &'a LightSeen,
    /// Edges of the lobe, in radians.
    pub lobe: Option<[f64; 2]>,
    /// Ends of the horizontal axis, in radians.
    pub range: [f64; 2],
    /// What is seen along it.
    pub trace: &'a Trace,
    /// The curves that are not hidden.
    pub curves: Vec<Curve>,
    /// Powers of ten.
    pub log: bool,
}

/// Where all is.
struct Plan {
    plot: Rect,
    weights: Rect,
    lights: Rect,
    lobe: Rect,
    samples: Rect,
}

impl Plan {
    fn new(ui: &Ui, rect: Rect) -> Self {
        let small = ui.text_style_height(&TextStyle::Small);
        let font = TextStyle::Small.resolve(ui.style());
        let label = ui.painter().layout_no_wrap("samples".into(), font, Color32::WHITE).size().x;
        let inner = rect.with_min_x(rect.left() + label + 2.0 * GRID).with_max_x(rect.right() - 3.0 * GRID);
        let mut bottom = inner.bottom() - small - GRID;
        let mut strip = |height: f32| {
            let strip = Rect::from_x_y_ranges(inner.x_range(), bottom - height..=bottom);
            bottom -= height + GRID;
            strip
        };
        let samples = strip(2.0 * (2.0 * LARGEST + 1.0));
        let lobe = strip(small);
        let lights = strip(small);
        let weights = strip((3.0 * small).min(0.18 * rect.height()));
        let plot = Rect::from_x_y_ranges(inner.x_range(), inner.top() + 0.5 * small..=bottom - GRID);
        Self { plot, weights, lights, lobe, samples }
    }
}

/// Draws it; returns what there is at the angle under the mouse.
pub fn plot_ui<'a>(ui: &mut Ui, drawing: &Drawing<'a>, size: Vec2, out: &mut Vec<Command>) -> Option<&'a Sight> {
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(Role::Image, true, "Slice through the directions"));
    let plan = Plan::new(ui, rect);
    let degrees = drawing.range.map(f64::to_degrees);
    let spread = if drawing.log { Spread::Log } else { Spread::Relative };
    let axes = Axes { rect: plan.plot, x: degrees, y: heights(drawing) };
    plane_ui(ui, &axes, spread, plan.samples.bottom(), "\u{b0}");
    curves_ui(ui, drawing, &axes);
    weights_ui(ui, drawing, &plan, degrees);
    lights_ui(ui, drawing, &plan, &axes, out);
    lobe_ui(ui, drawing, &plan, &axes, out);
    samples_ui(ui, drawing, &plan, &axes);
    strips_ui(ui, &plan);
    let pointer = response.hover_pos().or(response.interact_pointer_pos())?;
    let columns = plan.plot.with_max_y(plan.samples.bottom());
    if !columns.contains(pointer) {
        return None;
    }
    ui.painter().vline(pointer.x, columns.y_range(), Stroke::new(1.0, ui.visuals().weak_text_color()));
    let angle = axes.logs(pointer)[0].to_radians();
    drawing.trace.sights.iter().min_by(|a, b| (a.angle - angle).abs().total_cmp(&(b.angle - angle).abs()))
}

/// Names of the strips under the plot, and what each is.
fn strips_ui(ui: &Ui, plan: &Plan) {
    let weak = ui.visuals().weak_text_color();
    let font = TextStyle::Small.resolve(ui.style());
    for (strip, name, what) in [
        (
            plan.weights,
            "w_L",
            "Weights of a light sample (amber) and of a BSDF sample (blue) in that direction: from 0 to 1, and one together.",
        ),
        (
            plan.lights,
            "lights",
            "Where the circle crosses lights. Drag the edge of the chosen one: its radius, at the same power.",
        ),
        (
            plan.lobe,
            "lobe \u{3b1}",
            "Up to where the half vector is tilted by atan \u{3b1}: GGX has fallen to a quarter there. Drag an edge: the \
             roughness \u{3b1}.",
        ),
        (
            plan.samples,
            "samples",
            "The last 64 samples at the nearest angle of the circle: light samples are circles, BSDF samples squares, their area \
             what they add. Hollow: nothing.",
        ),
    ] {
        let place = Align2::RIGHT_CENTER.anchor_rect(Rect::from_min_size(
            strip.left_center() - vec2(GRID, 0.0),
            ui.painter().layout_no_wrap(name.into(), font.clone(), weak).size(),
        ));
        ui.painter().text(place.left_center(), Align2::LEFT_CENTER, name, font.clone(), weak);
        ui.interact(place, ui.scope_id().with(name), Sense::hover()).hint(what);
    }
}

/// Colour of a curve.
pub fn ink(ui: &Ui, inks: Inks, curve: Curve, estimator: &Estimator) -> Color32 {
    match curve {
        Curve::F => ui.visuals().text_color(),
        Curve::PLight | Curve::ByLight => inks.light,
        Curve::PBsdf | Curve::ByBsdf => inks.bsdf,
        Curve::Mixture => inks.strategy(estimator.strategy),
    }
}

/// Numbers of a curve where it is not 0.
fn values<'a>(drawing: &'a Drawing<'_>, curve: Curve) -> impl Iterator<Item = (f64, f64)> + 'a {
    let estimator = &drawing.shown.estimator;
    drawing.trace.sights.iter().map(move |sight| (sight.angle.to_degrees(), curve.value(&sight.seen, estimator)))
}

/// Ends of the vertical axis: whole decades around all that is shown, or 0 to just above 1.
fn heights(drawing: &Drawing<'_>) -> [f64; 2] {
    if !drawing.log {
        return [0.0, 1.08];
    }
    let all = || drawing.curves.iter().flat_map(|curve| values(drawing, *curve)).map(|(_, value)| value);
    let positive = || all().filter(|value| *value > 0.0 && value.is_finite());
    let Some(high) = positive().reduce(f64::max) else { return [-1.0, 1.0] };
    let low = positive().fold(high, f64::min);
    let top = high.log10().ceil();
    [low.log10().floor().max(top - DECADES).min(top - 1.0), top]
}

fn curves_ui(ui: &Ui, drawing: &Drawing<'_>, axes: &Axes) {
    let painter = ui.painter_at(axes.rect);
    let inks = Inks::of(ui.visuals());
    for &curve in &drawing.curves {
        let ink = ink(ui, inks, curve, &drawing.shown.estimator);
        let largest = values(drawing, curve).map(|(_, value)| value).fold(0.0, f64::max);
        let height = |value: f64| {
            // What is 0 has no logarithm: it lies below the plot.
            if drawing.log { value.max(1e-30).log10().max(axes.y[0] - 1.0) } else { value / largest.max(1e-30) }
        };
        let points: Vec<_> = values(drawing, curve).map(|(angle, value)| axes.at([angle, height(value)])).collect();
        match curve {
            Curve::F => painter.extend([Shape::line(points, Stroke::new(2.5, ink))]),
            Curve::PLight | Curve::PBsdf => painter.extend([Shape::line(points, Stroke::new(2.0, ink))]),
            Curve::Mixture => painter.extend(Shape::dashed_line(&points, Stroke::new(2.0, ink), 2.0 * GRID, GRID)),
            Curve::ByLight => painter.extend(Shape::dotted_line(&points, ink, 1.5 * GRID, 1.6)),
            Curve::ByBsdf => painter.extend(Shape::dotted_line(&points, ink, 2.5 * GRID, 1.6)),
        }
    }
}

/// The weight of light samples, from 0 to 1.
fn weights_ui(ui: &Ui, drawing: &Drawing<'_>, plan: &Plan, degrees: [f64; 2]) {
    let axes = Axes { rect: plan.weights, x: degrees, y: [-0.05, 1.05] };
    let painter = ui.painter_at(plan.weights);
    painter.rect_filled(plan.weights, 0.0, ui.visuals().extreme_bg_color);
    let line = ui.visuals().widgets.noninteractive.bg_stroke.color;
    for height in [0.0, 0.5, 1.0] {
        painter.hline(plan.weights.x_range(), axes.at([0.0, height]).y, Stroke::new(1.0, line));
    }
    let estimator = &drawing.shown.estimator;
    let weighted = matches!(estimator.strategy, Strategy::MisAll | Strategy::Mis);
    let inks = Inks::of(ui.visuals());
    if !weighted {
        let words = "this strategy has no weights";
        let font = TextStyle::Small.resolve(ui.style());
        painter.text(plan.weights.center(), Align2::CENTER_CENTER, words, font, ui.visuals().weak_text_color());
        return;
    }
    for (t, ink) in [(1, inks.bsdf.gamma_multiply(0.6)), (0, inks.light)] {
        let points = drawing
            .trace
            .sights
            .iter()
            .map(|sight| axes.at([sight.angle.to_degrees(), f64::from(sight.seen.weighted(estimator)[t].weight)]));
        painter.add(Shape::line(points.collect(), Stroke::new(2.0, ink)));
    }
}

/// Lights as intervals of the axis; the edges of the chosen one can be dragged.
fn lights_ui(ui: &mut Ui, drawing: &Drawing<'_>, plan: &Plan, axes: &Axes, out: &mut Vec<Command>) {
    let painter = ui.painter_at(plan.lights.expand2(vec2(GRIP, 0.0)));
    let inks = Inks::of(ui.visuals());
    let font = TextStyle::Small.resolve(ui.style());
    for light in &drawing.shown.surface.lights {
        let Some(ends) = drawing.circle.interval(light) else { continue };
        let chosen = light.shape == drawing.light.shape;
        let ink = if chosen { inks.light } else { inks.light.gamma_multiply(0.45) };
        let bar = bar(axes, plan.lights, ends);
        painter.rect_filled(bar, 2.0, ink);
        // Beside the bar where it has no room inside.
        let galley = painter.layout_no_wrap(light.name.clone(), font.clone(), ui.visuals().text_color());
        let inside = bar.width() > galley.size().x + 2.0 * GRID;
        let (at, ink) = if inside {
            (Align2::CENTER_CENTER.align_size_within_rect(galley.size(), bar).min, ui.visuals().panel_fill)
        } else {
            (pos2(bar.right() + GRIP + GRID, bar.center().y - 0.5 * galley.size().y), ui.visuals().text_color())
        };
        painter.galley_with_override_text_color(at, galley, ink);
    }
    let Some(ends) = drawing.circle.interval(drawing.light) else { return };
    let light = drawing.light;
    let original = Document::radius(&drawing.shown.document.opened.scene, light.shape);
    for (end, side) in ends.into_iter().zip(["Left", "Right"]) {
        let name = format!("{side} edge of {}", light.name);
        if let Some(angle) = edge_ui(ui, axes, plan.lights, end, &name) {
            // Not through the middle: an edge stays on its side.
            let middle = drawing.circle.angle_of(light.centre);
            let angle = if side == "Left" { angle.min(middle) } else { angle.max(middle) };
            let radius = (light.distance * drawing.circle.radius_to(light, angle).sin()) as f32;
            let original = original.unwrap_or(radius);
            out.push(Edit::SetLightRadius(light.shape, radius.clamp(0.1 * original, 10.0 * original)).into());
        }
    }
}

/// Where GGX has fallen to a quarter; both edges can be dragged.
fn lobe_ui(ui: &mut Ui, drawing: &Drawing<'_>, plan: &Plan, axes: &Axes, out: &mut Vec<Command>) {
    let painter = ui.painter_at(plan.lobe.expand2(vec2(GRIP, 0.0)));
    let font = TextStyle::Small.resolve(ui.style());
    let surface = drawing.shown.surface;
    let (Some(ends), Some(material)) = (drawing.lobe, surface.material) else {
        let words = if surface.alpha == Some(0.0) { "a mirror: one direction, no density" } else { "no lobe" };
        painter.text(plan.lobe.center(), Align2::CENTER_CENTER, words, font, ui.visuals().weak_text_color());
        return;
    };
    painter.rect_filled(bar(axes, plan.lobe, ends), 2.0, Inks::of(ui.visuals()).bsdf);
    for (end, side) in ends.into_iter().zip(["Left", "Right"]) {
        let name = format!("{side} edge of the lobe");
        if let Some(angle) = edge_ui(ui, axes, plan.lobe, end, &name) {
            let angle = if side == "Left" { angle.min(0.0) } else { angle.max(0.0) };
            let alpha = drawing.circle.tilt(surface, angle);
            out.push(Edit::SetAlpha(material, alpha.clamp(1e-3, 1.0) as f32).into());
        }
    }
}

/// The part of a strip between two angles.
fn bar(axes: &Axes, strip: Rect, ends: [f64; 2]) -> Rect {
    let [left, right] = ends.map(|end| axes.at([end.to_degrees(), axes.y[0]]).x);
    Rect::from_x_y_ranges(left..=right.max(left + 1.5), strip.shrink2(vec2(0.0, 2.0)).y_range())
}

/// An edge that can be dragged; returns the angle that it was dragged to.
fn edge_ui(ui: &mut Ui, axes: &Axes, strip: Rect, at: f64, name: &str) -> Option<f64> {
    let x = axes.at([at.to_degrees(), axes.y[0]]).x;
    let id = ui.scope_id().with(name);
    // While it is dragged it may leave the plot.
    if !axes.rect.x_range().expand(1.0).contains(x) && !ui.ctx().is_being_dragged(id) {
        return None;
    }
    let rect = Rect::from_center_size(pos2(x, strip.center().y), vec2(2.0 * GRIP, strip.height()));
    let response = ui.interact(rect, id, Sense::drag());
    response.widget_info(|| egui::WidgetInfo::labeled(Role::Splitter, true, name));
    let handle = Rect::from_center_size(rect.center(), vec2(5.0, strip.height()));
    let fill = if response.hovered() || response.dragged() {
        ui.visuals().strong_text_color()
    } else {
        ui.visuals().text_color()
    };
    ui.painter().rect(handle, 2.0, fill, Stroke::new(1.0, ui.visuals().panel_fill), StrokeKind::Outside);
    let response = response.hint(format!("{name}: drag it.")).on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
    let pointer = response.interact_pointer_pos()?;
    (response.dragged() && response.drag_delta() != Vec2::ZERO).then(|| axes.logs(pointer)[0].to_radians())
}

/// The last samples at their angles: light samples as circles in the upper row, BSDF samples as squares in the lower one.
fn samples_ui(ui: &Ui, drawing: &Drawing<'_>, plan: &Plan, axes: &Axes) {
    let painter = ui.painter_at(plan.samples.expand2(vec2(2.0, 0.0)));
    painter.rect_filled(plan.samples, 0.0, ui.visuals().extreme_bg_color);
    let Some(samples) = drawing.shown.samples else { return };
    let last: &[Replayed] = &samples.list[samples.list.len().saturating_sub(LAST)..];
    let rays = || last.iter().flat_map(|sample| &sample.rays).filter(|ray| ray.valid);
    let largest = rays().map(|ray| luminance(ray.value)).fold(0.0, f64::max);
    let inks = Inks::of(ui.visuals());
    for ray in rays() {
        let x = axes.at([drawing.circle.angle_of(ray.wi).to_degrees(), axes.y[0]]).x;
        // Area in proportion to what it adds.
        let share = if largest > 0.0 { (luminance(ray.value) / largest).sqrt() as f32 } else { 0.0 };
        let (row, ink) = match ray.technique {
            Technique::Light => (0.25, inks.light),
            Technique::Bsdf => (0.75, inks.bsdf),
        };
        let at = pos2(x, plan.samples.top() + row * plan.samples.height());
        dot(&painter, at, ray.technique, share * LARGEST, ink);
    }
}

/// A sample: filled as far as it adds something, else a hollow point.
pub fn dot(painter: &Painter, at: egui::Pos2, technique: Technique, radius: f32, ink: Color32) {
    let (fill, edge) =
        if radius > 0.0 { (ink.gamma_multiply(0.7), ink) } else { (Color32::TRANSPARENT, ink.gamma_multiply(0.7)) };
    let (radius, stroke) = (radius.max(2.0), Stroke::new(1.0, edge));
    match technique {
        Technique::Light => {
            painter.circle(at, radius, fill, stroke);
        }
        Technique::Bsdf => {
            let square = Rect::from_center_size(at, Vec2::splat(1.8 * radius));
            painter.rect(square, 0.0, fill, stroke, StrokeKind::Middle);
        }
    }
}
