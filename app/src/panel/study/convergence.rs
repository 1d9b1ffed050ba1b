//! Error against samples, on logarithmic axes.

use eframe::egui::{
    self, Align2, Button, Id, Label, Pos2, Rect, Response, RichText, Role, Sense, Stroke, TextStyle, Ui, Vec2, vec2,
};
use mislab_renderer::study::curves::Value;
use mislab_renderer::study::{Cells, Curves, Measure, Part, Plan};
use mislab_renderer::{Estimator, Strategy};

use super::Subject;
use super::curves_job::{CurvesJob, State};
use super::parts::{Chosen, part_name};
use super::plot::Axes;
use super::tiles::{caption_lines, caption_that_fits, is_large, words};
use crate::look::names::strategy_name;
use crate::look::theme::{GRID, Inks};
use crate::panel::hint::Hint as _;
use crate::panel::number::{seconds, signed, two_digits};
use crate::panel::widgets::{segmented, text_width, title};
use crate::picture::reference::REFERENCE_SPP;
use crate::picture::sheet::Recorder;
use crate::picture::slot_errors::SlotErrors;
use crate::state::command::Command;

/// What errors are drawn over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Over {
    #[default]
    Spp,
    Rays,
    Seconds,
}

/// What is kept of it while it is open and after.
#[derive(Default)]
pub struct Convergence {
    measure: Measure,
    over: Over,
    part: Chosen,
    /// A drag draws a prediction.
    drawing: bool,
    /// Logarithms of what was drawn by hand, by ascending x, and on which axes.
    prediction: Vec<[f64; 2]>,
    job: Option<CurvesJob>,
}

/// Samples per pixel of the points.
const AT: [u32; 8] = [1, 2, 4, 8, 16, 32, 64, 128];
/// Pictures of each point.
const REPLICATES: u32 = 8;

impl Convergence {
    /// Measures nothing while it is held.
    pub fn hold(&self, hold: bool) {
        if let Some(job) = &self.job {
            job.hold(hold);
        }
    }

    /// Measures what the document says by now, from the beginning if that is something else.
    fn match_subject(&mut self, ctx: &egui::Context, subject: &Subject<'_>) {
        let active = subject.document.active();
        let estimators = Strategy::ALL.map(|strategy| Estimator { strategy, ..active.estimator }).to_vec();
        let plan = Plan { estimators, at: AT.to_vec(), replicates: REPLICATES, by_block: true };
        let request = subject.document.request(active);
        if self.job.as_ref().is_some_and(|job| !job.is_about(&request, &plan)) {
            self.job = None;
        }
        if self.job.is_none()
            && let Some(source) = subject.references.source()
        {
            self.job = CurvesJob::start(ctx, request, plan, subject.threads, source, REFERENCE_SPP).ok();
        }
    }

    /// Something is said of a line drawn by hand.
    fn is_predicted(&self) -> bool {
        self.drawing || !self.prediction.is_empty()
    }

    fn x(&self, curves: &Curves, curve: usize, point: usize, value: &Value) -> f64 {
        let spp = f64::from(curves.plan.at[point]);
        self.x_of(spp, &curves.plan.estimators[curve], value.cpu_seconds)
    }

    fn x_of(&self, spp: f64, estimator: &Estimator, cpu_seconds: f64) -> f64 {
        match self.over {
            Over::Spp => spp,
            Over::Rays => spp * f64::from(estimator.strategy.rays_per_sample()),
            Over::Seconds => cpu_seconds.max(1e-6),
        }
    }
}

/// Draws it over all that is left of `ui`.
pub fn convergence_ui(ui: &mut Ui, study: &mut Convergence, subject: &Subject<'_>, out: &mut Vec<Command>) {
    study.match_subject(ui.ctx(), subject);
    let against = subject.references.latest();
    let cells = against.as_ref().map(|against| &*against.cells);
    let before = study.part.part();
    study.part.follow(subject.selected, cells.map_or(0, |cells| cells.squares.len()));
    let state = study.job.as_ref().map(CurvesJob::state);
    title(ui, "Convergence");
    Recorder::on_screen_only(ui, |ui| head_ui(ui, study, cells, out));
    if before != study.part.part() {
        study.prediction.clear();
    }
    let room = ui.available_size();
    let foot = foot_height(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(room.x, (room.y - foot).max(140.0)), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(Role::Image, true, "Plot of errors"));
    let curves = state.as_ref().map(|state| &state.curves);
    let axes = axes(ui, study, subject, curves, rect);
    plot_ui(ui, study, subject, curves, &axes);
    draw_ui(study, &axes, &response);
    slopes_ui(ui, study, curves, &axes);
    if let (Some(pointer), Some(curves), false) = (response.hover_pos(), curves, study.drawing) {
        hover_ui(ui, study, curves, &axes, pointer);
    }
    foot_ui(ui, study, subject, state.as_ref(), cells, out);
}

/// Room for the reference and a remark; at a desk also for what the prediction was worth.
fn foot_height(ui: &Ui) -> f32 {
    ui.spacing().interact_size.y + caption_lines(ui, [1.0, 4.0]) + 4.0 * GRID
}

fn measure_name(measure: Measure) -> &'static str {
    match measure {
        Measure::RelMse => "relMSE",
        Measure::Rmse => "RMSE",
    }
}

fn formula(measure: Measure) -> &'static str {
    match measure {
        Measure::RelMse => "relMSE = mean of (x \u{2212} r)\u{b2} / (r\u{b2} + 0.01)",
        Measure::Rmse => "RMSE = \u{221a} mean of (x \u{2212} r)\u{b2}",
    }
}

fn head_ui(ui: &mut Ui, study: &mut Convergence, cells: Option<&Cells>, out: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        let half = 0.5 * (ui.available_width() - 2.0 * GRID);
        ui.allocate_ui(vec2(0.8 * half, ui.spacing().interact_size.y), |ui| {
            let choices = Measure::ALL.map(|measure| (measure, measure_name(measure)));
            let hint = |ui: &mut Ui, measure| drop(ui.label(formula(measure)));
            if let Some(measure) = segmented(ui, "Error", study.measure, &choices, true, &hint) {
                study.measure = measure;
                study.prediction.clear();
            }
        });
        let choices = [(Over::Spp, "samples"), (Over::Rays, "rays"), (Over::Seconds, "seconds")];
        let hint = |ui: &mut Ui, over| {
            ui.label(match over {
                Over::Spp => "Against samples per pixel.",
                Over::Rays => "Against second rays per pixel: \u{201c}MIS, both\u{201d} traces two a sample.",
                Over::Seconds => "Against seconds of processor time.",
            });
        };
        if let Some(over) = segmented(ui, "Over", study.over, &choices, true, &hint) {
            study.over = over;
            study.prediction.clear();
        }
    });
    ui.horizontal(|ui| {
        let width = 0.42 * ui.available_width();
        study.part.menu(ui, cells, width);
        let button = Button::selectable(study.drawing, "Draw your prediction");
        if ui.add(button).hint("Drag in the plot: how will the error fall? Then compare.").clicked() {
            study.drawing = !study.drawing;
            study.prediction.clear();
        }
        let state = study.job.as_ref().map(CurvesJob::state);
        if ui.button("CSV").accessible_name("Save the curves as CSV").clicked()
            && let Some(State { curves, .. }) = state
        {
            let named = |part: Part| (part, part_name(cells, part));
            let parts: Vec<_> = study.part.all(cells).into_iter().map(named).collect();
            out.push(Command::SaveCsv { name: "convergence", text: curves.to_csv(&parts) });
        }
    });
}

/// Axes around all that is known, in whole decades of the error and at least three of them.
fn axes(ui: &Ui, study: &Convergence, subject: &Subject<'_>, curves: Option<&Curves>, rect: Rect) -> Axes {
    let mut y: Option<[f64; 2]> = None;
    let mut x = match study.over {
        Over::Spp => [0.0, f64::from(AT[7]).log10()],
        Over::Rays => [0.0, f64::from(2 * AT[7]).log10()],
        Over::Seconds => [f64::INFINITY, f64::NEG_INFINITY],
    };
    for (curve, point, value) in values(study, curves) {
        let log = value.error.log10();
        y = Some(y.map_or([log, log], |[low, high]| [low.min(log), high.max(log)]));
        let at = curves.map_or(0.0, |curves| study.x(curves, curve, point, &value).log10());
        x = [x[0].min(at), x[1].max(at)];
    }
    for [at, error] in live(study, subject).into_iter().map(|(_, at)| at) {
        y = Some(y.map_or([error, error], |[low, high]| [low.min(error), high.max(error)]));
        x = [x[0].min(at), x[1].max(at)];
    }
    if x[0] >= x[1] || !x[0].is_finite() {
        x = [x[0].min(x[1]).clamp(-2.0, 2.0) - 1.0, x[0].min(x[1]).clamp(-2.0, 2.0) + 1.0];
    }
    let [low, high] = y.unwrap_or([-3.0, 0.0]);
    let (low, high) = ((low - 0.2).floor(), (high + 0.2).ceil());
    Axes::within(ui, rect, "0.0001", [[x[0] - 0.08, x[1] + 0.08], [low.min(high - 3.0), high]])
}

/// All points that are known: curve, point, value.
fn values(study: &Convergence, curves: Option<&Curves>) -> Vec<(usize, usize, Value)> {
    let Some(curves) = curves else { return Vec::new() };
    let each = (0..curves.plan.estimators.len()).flat_map(|c| (0..curves.plan.at.len()).map(move |p| (c, p)));
    each.filter_map(|(c, p)| Some((c, p, curves.value(c, p, study.part.part(), study.measure)?))).collect()
}

fn plot_ui(ui: &Ui, study: &Convergence, subject: &Subject<'_>, curves: Option<&Curves>, axes: &Axes) {
    let over = match study.over {
        Over::Spp => "samples per pixel",
        Over::Rays => "rays per pixel",
        Over::Seconds => "seconds of processor time",
    };
    axes.grid_ui(ui, [over, measure_name(study.measure)]);
    let painter = ui.painter_at(axes.rect);
    let (inks, weak) = (Inks::of(ui.visuals()), ui.visuals().weak_text_color());
    let all = values(study, curves);
    if let Some((_, _, first)) = all.iter().max_by(|a, b| a.2.error.total_cmp(&b.2.error)) {
        let x = axes.x[0] + 0.08;
        for k in 0..3 {
            let through = [x, first.error.log10() - 1.2 * f64::from(k)];
            axes.guide(&painter, through, study.measure.slope(), Stroke::new(1.0, weak.gamma_multiply(0.5)));
        }
    }
    let round = subject.measuring.round();
    if let Some(noise) = round.and_then(|round| round.noise.as_ref()?.get(round.index(study.part.part())?).copied()) {
        floor_ui(ui, &painter, axes, study.measure.of(noise));
    }
    for curve in 0..curves.map_or(0, |curves| curves.plan.estimators.len()) {
        let Some(curves) = curves else { break };
        let ink = inks.strategy(curves.plan.estimators[curve].strategy);
        let points: Vec<_> = all.iter().filter(|(c, _, _)| *c == curve).collect();
        let x = |point: usize, value: &Value| study.x(curves, curve, point, value).log10();
        let band: Vec<_> =
            points.iter().filter_map(|(_, p, v)| Some((x(*p, v), v.interval?.map(f64::log10)))).collect();
        axes.band(&painter, &band, ink.gamma_multiply(0.25));
        let line: Vec<[f64; 2]> = points.iter().map(|(_, p, v)| [x(*p, v), v.error.log10()]).collect();
        axes.line(&painter, &line, Stroke::new(2.0, ink));
        for at in &line {
            painter.circle_filled(axes.at(*at), 3.0, ink);
        }
    }
    for (strategy, at) in live(study, subject) {
        painter.circle(axes.at(at), 6.0, inks.strategy(strategy), Stroke::new(2.0, ui.visuals().text_color()));
    }
    axes.line(&painter, &study.prediction, Stroke::new(3.0, ui.visuals().text_color()));
    if all.is_empty() {
        let font = TextStyle::Body.resolve(ui.style());
        painter.text(axes.rect.center(), Align2::CENTER_CENTER, subject.references.words(), font, weak);
    }
}

/// Where the pictures on screen are by now, in logarithms.
fn live(study: &Convergence, subject: &Subject<'_>) -> Vec<(Strategy, [f64; 2])> {
    let Some(round) = subject.measuring.round() else { return Vec::new() };
    let Some(index) = round.index(study.part.part()) else { return Vec::new() };
    let place = |slot: &SlotErrors| {
        let error = study.measure.of(*slot.errors.get(index)?);
        let x = study.x_of(f64::from(slot.spp), &slot.estimator, slot.cpu_seconds);
        (error > 0.0).then(|| (slot.estimator.strategy, [x.log10(), error.log10()]))
    };
    round.slots.iter().flatten().filter_map(place).collect()
}

/// The reference's own noise, below which nothing is known.
fn floor_ui(ui: &Ui, painter: &egui::Painter, axes: &Axes, noise: f64) {
    let y = axes.at([axes.x[0], noise.log10()]).y;
    if noise <= 0.0 || !axes.rect.y_range().contains(y) {
        return;
    }
    let weak = ui.visuals().weak_text_color();
    painter.rect_filled(axes.rect.with_min_y(y), 0.0, weak.gamma_multiply(0.18));
    let font = TextStyle::Small.resolve(ui.style());
    // At the left stand the slopes.
    let at = egui::pos2(axes.rect.right() - 2.0 * GRID, y + 0.5 * GRID);
    painter.text(at, Align2::RIGHT_TOP, "noise of the reference", font, weak);
}

/// A drag in the plot draws, from left to right; going back takes away.
fn draw_ui(study: &mut Convergence, axes: &Axes, response: &Response) {
    let Some(pointer) = response.interact_pointer_pos().filter(|_| study.drawing && response.dragged()) else { return };
    if response.drag_started() {
        study.prediction.clear();
    }
    let at = axes.logs(axes.rect.clamp(pointer));
    study.prediction.retain(|before| before[0] < at[0]);
    study.prediction.push(at);
}

/// The point nearest to the mouse, read aloud.
fn hover_ui(ui: &Ui, study: &Convergence, curves: &Curves, axes: &Axes, pointer: Pos2) {
    const NEAR: f32 = 24.0;
    let all = values(study, Some(curves));
    let place = |(c, p, v): &(usize, usize, Value)| axes.at([study.x(curves, *c, *p, v).log10(), v.error.log10()]);
    let nearest = all.iter().min_by(|a, b| place(a).distance(pointer).total_cmp(&place(b).distance(pointer)));
    let Some(found) = nearest.filter(|found| place(found).distance(pointer) < NEAR) else { return };
    let (curve, point, value) = found;
    let name = strategy_name(curves.plan.estimators[*curve].strategy);
    let interval = value
        .interval
        .map_or_else(String::new, |[low, high]| format!("\n95 %: {} to {}", two_digits(low), two_digits(high)));
    let text = format!(
        "{name}, {} spp, {}\n{} {}{interval}\n{} pictures",
        curves.plan.at[*point],
        seconds(value.cpu_seconds),
        measure_name(study.measure),
        two_digits(value.error),
        value.replicates
    );
    ui.painter().circle_stroke(place(found), 6.0, Stroke::new(2.0, ui.visuals().text_color()));
    let layer = egui::LayerId::new(egui::Order::Tooltip, Id::unique("reading of the plot"));
    let painter = ui.ctx().layer_painter(layer);
    let galley = painter.layout_no_wrap(text, TextStyle::Body.resolve(ui.style()), ui.visuals().text_color());
    let size = galley.size() + vec2(4.0 * GRID, 3.0 * GRID);
    let right = pointer.x + 4.0 * GRID + size.x < axes.rect.right();
    let left = if right { pointer.x + 4.0 * GRID } else { pointer.x - 4.0 * GRID - size.x };
    let plate = Rect::from_min_size(egui::pos2(left, (pointer.y - size.y).max(axes.rect.top())), size);
    painter.rect_filled(plate, GRID, ui.visuals().panel_fill);
    painter.galley(plate.min + vec2(2.0 * GRID, 1.5 * GRID), galley, ui.visuals().text_color());
}

/// The slopes, in the corner of the plot where curves seldom go: errors fall.
fn slopes_ui(ui: &mut Ui, study: &Convergence, curves: Option<&Curves>, axes: &Axes) {
    let inks = Inks::of(ui.visuals());
    let between = if is_large(ui) { " " } else { ": slope " };
    let lines: Vec<_> = Strategy::ALL
        .into_iter()
        .enumerate()
        .map(|(curve, strategy)| {
            let slope = curves.and_then(|curves| curves.slope(curve, study.part.part(), study.measure));
            let text = slope.map_or("\u{2013}".to_owned(), |fit| {
                let [low, high] = fit.interval;
                let half = 0.5 * (high - low);
                // Never "\u{b1} 0".
                let decimals = if half < 0.01 { 3 } else { 2 };
                format!("{} \u{b1} {:.decimals$}", signed(fit.slope, decimals), half.max(0.001))
            });
            (format!("{}{between}{text}", strategy_name(strategy)), inks.strategy(strategy))
        })
        .collect();
    let (height, font) = (ui.text_style_height(&TextStyle::Small), TextStyle::Small.resolve(ui.style()));
    let width = lines.iter().map(|(text, _)| text_width(ui, text, &font)).fold(0.0, f32::max);
    let size = vec2(width, height * lines.len() as f32) + Vec2::splat(2.0 * GRID);
    let inside = axes.rect.shrink(2.0 * GRID);
    let plate = Align2::LEFT_BOTTOM.align_size_within_rect(size, inside).intersect(inside);
    // Where a curve goes there all the same, both can be read.
    ui.painter().rect_filled(plate, GRID, ui.visuals().extreme_bg_color.gamma_multiply(0.6));
    for (row, (text, ink)) in lines.into_iter().enumerate() {
        let corner = plate.min + vec2(GRID, GRID + row as f32 * height);
        let place = Rect::from_min_size(corner, vec2(width, height)).intersect(inside);
        words(ui, place, Align2::LEFT_CENTER, &text, TextStyle::Small, ink)
            .hint("Slope of the line through the points on logarithmic axes, and its 95 % interval.");
    }
}

/// Under the plot: how far it is, and what the prediction was worth.
fn foot_ui(
    ui: &mut Ui,
    study: &Convergence,
    subject: &Subject<'_>,
    state: Option<&State>,
    cells: Option<&Cells>,
    out: &mut Vec<Command>,
) {
    let curves = state.map(|state| &state.curves);
    reference_ui(ui, subject, out);
    if study.is_predicted() {
        let words = prediction_words(study, curves, subject.document.active().estimator.strategy);
        ui.add(Label::new(RichText::new(words).text_style(TextStyle::Small)).truncate());
        if is_large(ui) {
            // There is room for one of both.
            return;
        }
    }
    let done = state.map_or_else(String::new, |state| match &state.error {
        Some(error) => format!("; {error}"),
        None => format!("; {} of {} pictures, {REPLICATES} a point", state.curves.count(), state.curves.total()),
    });
    let part = part_name(cells, study.part.part());
    let measured = format!("over the {part}{done}");
    let all = format!(
        "{} {measured}. Bands: 95 %; dashed: slope \u{2212}1, as independent samples have.",
        formula(study.measure)
    );
    caption_that_fits(ui, &all, &format!("{} {measured}", measure_name(study.measure)));
}

/// Where the reference stands and what can be done about it.
pub fn reference_ui(ui: &mut Ui, subject: &Subject<'_>, out: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        let (text, command, hint) = match subject.references.file() {
            Some(_) => ("Render it", Command::RenderReference, "Renders the reference here instead of taking a file."),
            None => {
                ("From a file \u{2026}", Command::OpenReference, "Opens an EXR of the same pixels as the reference.")
            }
        };
        let button = |ui: &mut Ui| ui.button(text).accessible_name("Reference from elsewhere").hint(hint);
        if Recorder::on_screen_only(ui, button).clicked() {
            out.push(command);
        }
        ui.add(egui::Label::new(subject.references.words()).truncate());
    });
}

/// How far the drawn line is from the measured one.
fn prediction_words(study: &Convergence, curves: Option<&Curves>, strategy: Strategy) -> String {
    let [Some(first), Some(last)] = [study.prediction.first(), study.prediction.last()] else {
        let drag = "Drag in the plot: how will the error fall?";
        return if study.drawing { drag.to_owned() } else { String::new() };
    };
    let Some((curves, curve)) = curves.and_then(|curves| {
        let of = |estimator: &Estimator| estimator.strategy == strategy;
        Some((curves, curves.plan.estimators.iter().position(of)?))
    }) else {
        return String::new();
    };
    let drawn = |x: f64| {
        let after = study.prediction.windows(2).find(|pair| pair[0][0] <= x && x <= pair[1][0])?;
        let share = (x - after[0][0]) / (after[1][0] - after[0][0]);
        Some(after[0][1] + share * (after[1][1] - after[0][1]))
    };
    let gaps: Vec<f64> = values(study, Some(curves))
        .into_iter()
        .filter(|(c, _, _)| *c == curve)
        .filter_map(|(c, p, v)| Some(drawn(study.x(curves, c, p, &v).log10())? - v.error.log10()))
        .collect();
    if gaps.is_empty() || last[0] <= first[0] {
        return "Your line passes no measured point yet.".to_owned();
    }
    let gap = gaps.iter().sum::<f64>() / gaps.len() as f64;
    let side = if gap > 0.0 { "above" } else { "below" };
    let slope = (last[1] - first[1]) / (last[0] - first[0]);
    format!(
        "Yours: {}\u{d7} {side} {} on average, with slope {}.",
        two_digits(10_f64.powf(gap.abs())),
        strategy_name(strategy),
        signed(slope, 2)
    )
}
