//! Which strategy is best for each size of light and roughness.

use std::sync::Arc;

use eframe::egui::{
    self, Align2, Color32, ComboBox, Pos2, Rect, Role, Sense, TextStyle, TextureHandle, TextureOptions, Ui, UiBuilder,
    pos2, vec2,
};
use mislab_renderer::plane::{NO_DIFFERENCE, Variances};
use mislab_renderer::{Estimator, Strategy};

use super::Subject;
use super::plane_job::{self, ALPHA, Dot, Found, PlaneJob, Question, along, share_of};
use super::plane_map::{FULL, axes, colour, dot, image};
use super::tiles::{caption_lines, caption_that_fits, words};
use crate::look::names::{heuristic_name, strategy_name, weights_name};
use crate::look::theme::{GRID, Inks, strategy_fill};
use crate::panel::hint::Hint as _;
use crate::panel::widgets::{caption, title};
use crate::picture::sheet::Recorder;
use crate::state::command::Command;

/// What is kept of it while it is open and after.
#[derive(Default)]
pub struct Plane {
    /// Which of the scene's squares; `None`: one in the middle.
    chosen: Option<usize>,
    job: Option<PlaneJob>,
    drawn: Option<Drawn>,
}

/// The map on screen, and what it was made of.
struct Drawn {
    found: Arc<Found>,
    dark: bool,
    size: [usize; 2],
    texture: TextureHandle,
}

/// What the mouse is on.
struct Reading {
    place: String,
    /// Of one ray over the square of the mean, as logarithms.
    logs: [f64; 4],
}

impl Plane {
    /// Not on screen: nothing is worked out for it. What is finished stays.
    pub fn rest(&mut self) {
        if self.job.as_ref().is_some_and(|job| job.found().is_none_or(|found| found.step != 1)) {
            self.job = None;
        }
    }
}

/// Draws it over all that is left of `ui`.
pub fn plane_ui(ui: &mut Ui, study: &mut Plane, subject: &Subject<'_>, _out: &mut Vec<Command>) {
    // The middle of four times four: plate 3 and light 2.
    let chosen = study.chosen.unwrap_or(9);
    // What all four strategies share; the strategy in use is none of it.
    let estimator = Estimator { strategy: Strategy::Mis, ..subject.document.active().estimator };
    let question = Question { scene: subject.document.scene.clone(), estimator, chosen };
    if study.job.as_ref().is_none_or(|job| *job.question() != question) {
        study.job = Some(plane_job::start(ui.ctx(), question));
    }
    let found = study.job.as_ref().and_then(PlaneJob::found);
    let Some(found) = found.as_ref().filter(|found| !found.dots.is_empty()) else {
        title(ui, "Light size and roughness");
        ui.label(match found {
            Some(_) => "This needs a flat plate with a roughness, and a round light that the camera sees in it. The scene has none.",
            None => "Looking for plates and lights \u{2026}",
        });
        return;
    };
    let chosen = chosen.min(found.dots.len() - 1);
    // The caption says whose distances they are.
    Recorder::on_screen_only(ui, |ui| chooser_ui(ui, study, found, chosen));
    let area = ui.available_rect_before_wrap();
    let plan = Plan::new(ui, area);
    let reading = map_ui(ui, study, found, chosen, plan.map);
    ui.scope_builder(UiBuilder::new().id_salt("about").max_rect(plan.below), |ui| {
        ui.set_clip_rect(plan.below.intersect(ui.clip_rect()));
        legend_ui(ui);
        reading_ui(ui, reading.as_ref());
        let [all, few] = about(&found.dots[chosen], &estimator);
        caption_that_fits(ui, &all, &few);
    });
    ui.advance_cursor_after_rect(area);
}

fn chooser_ui(ui: &mut Ui, study: &mut Plane, found: &Found, chosen: usize) {
    ui.horizontal(|ui| {
        ui.label("Distances of");
        let combo = ComboBox::from_id_salt("plate and light").selected_text(&found.dots[chosen].name);
        let response = combo.show_ui(ui, |ui| {
            for (index, dot) in found.dots.iter().enumerate() {
                if ui.selectable_label(index == chosen, &dot.name).clicked() {
                    study.chosen = Some(index);
                }
            }
        });
        let named = || egui::WidgetInfo::labeled(Role::ComboBox, true, "Plate and light");
        response.response.widget_info(named);
        response.response.hint("Whose place in the scene gives the distances and the angle.");
        let rest = match found.step {
            1 => "",
            0 => "working \u{2026}",
            _ => "coarse so far \u{2026}",
        };
        caption(ui, rest);
    });
}

/// Where the map is, and what is under it.
struct Plan {
    map: Rect,
    below: Rect,
}

impl Plan {
    fn new(ui: &Ui, area: Rect) -> Self {
        let (small, row) = (ui.text_style_height(&TextStyle::Small), ui.spacing().interact_size.y);
        // Legend, reading, and the caption.
        let under = 2.0 * row + caption_lines(ui, [3.0, 7.0]) + 6.0 * GRID;
        let (upper, below) = area.split_top_bottom_at_y((area.bottom() - under).max(area.center().y - 40.0));
        let left = 3.0 * small;
        let mut map = Rect::from_min_max(
            upper.min + vec2(left, small + 2.0 * GRID),
            upper.max - vec2(3.0 * GRID, 2.0 * small + 4.0 * GRID),
        );
        // Wider than that, bands look like walls.
        map.set_width(map.width().min(1.8 * map.height()));
        Self { map, below }
    }
}

/// Draws the map; returns what the mouse is on, or the chosen square.
fn map_ui(ui: &mut Ui, study: &mut Plane, found: &Arc<Found>, chosen: usize, map: Rect) -> Option<Reading> {
    let dark = ui.visuals().dark_mode;
    let size = [map.width(), map.height()].map(|n| (n * ui.pixels_per_point()).clamp(16.0, 800.0) as usize);
    let current = |drawn: &Drawn| Arc::ptr_eq(&drawn.found, found) && (drawn.dark, drawn.size) == (dark, size);
    if !study.drawn.as_ref().is_some_and(current) {
        let (paper, stripe) = (ui.visuals().panel_fill, ui.visuals().weak_text_color());
        let texels = image(found, size, paper, stripe);
        let texture = ui.ctx().load_texture("plane", texels, TextureOptions::LINEAR);
        study.drawn = Some(Drawn { found: found.clone(), dark, size, texture });
    }
    let response = ui.interact(map, ui.scope_id().with("map"), Sense::click());
    let name = "Map: best strategy by roughness and light radius";
    response.widget_info(|| egui::WidgetInfo::labeled(Role::Image, true, name));
    if let Some(drawn) = &study.drawn {
        let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
        ui.painter().image(drawn.texture.id(), map, whole, Color32::WHITE);
    }
    axes(ui, map, found.radius);
    let ring = if dark { Color32::WHITE } else { Color32::BLACK };
    for (index, square) in found.dots.iter().enumerate() {
        let paper = ui.visuals().panel_fill;
        let best = square.variances.and_then(|v| v.best());
        let fill = best.map_or(paper, |(best, margin)| colour(best, margin, paper));
        dot(ui.painter(), place(map, found.radius, square), fill, ring, index == chosen);
    }
    let near = |at: Pos2| {
        let distance = |dot: &Dot| place(map, found.radius, dot).distance(at);
        let nearest = found.dots.iter().enumerate().min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
        nearest.filter(|(_, dot)| distance(dot) < 3.0 * GRID)
    };
    let at = response.hover_pos();
    if let Some((index, _)) = response.interact_pointer_pos().filter(|_| response.clicked()).and_then(near) {
        study.chosen = Some(index);
    }
    match at.filter(|at| near(*at).is_none()) {
        Some(at) => {
            let share = [(at.x - map.left()) / map.width(), (map.bottom() - at.y) / map.height()];
            let (alpha, radius) = (along(ALPHA, share[0]), along(found.radius, share[1]));
            let place = format!("\u{3b1} {alpha:.3}, radius {radius:.3}");
            Some(Reading { place, logs: found.between(share)? })
        }
        None => {
            let square = at.and_then(near).map_or(&found.dots[chosen], |(_, dot)| dot);
            let Variances { per_ray, .. } = square.variances?;
            let logs = per_ray.map(|v| v.map_or(f64::INFINITY, |v| v.max(0.0).ln()));
            Some(Reading { place: square.name.clone(), logs })
        }
    }
}

/// Where a square of the scene is on the map; beside it if it is off an axis.
fn place(map: Rect, radius: [f32; 2], dot: &Dot) -> Pos2 {
    let clamp = |share: f32| if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
    let (x, y) = (clamp(share_of(ALPHA, dot.alpha)), clamp(share_of(radius, dot.radius)));
    pos2(map.left() + x * map.width(), map.bottom() - y * map.height())
}

fn legend_ui(ui: &mut Ui) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 1.5 * GRID;
        let paper = ui.visuals().panel_fill;
        for strategy in Strategy::ALL {
            swatch(ui, |painter, rect| {
                let (pale, full) = rect.split_left_right_at_fraction(0.5);
                painter.rect_filled(pale, 0.0, colour(strategy, NO_DIFFERENCE, paper));
                painter.rect_filled(full, 0.0, strategy_fill(strategy).0);
            });
            ui.label(strategy_name(strategy));
        }
        let stripe = ui.visuals().weak_text_color();
        swatch(ui, |painter, rect| {
            painter.rect_filled(rect, 0.0, paper);
            for i in 0..6 {
                let x = rect.left() + i as f32 * 6.0;
                let line = [pos2(x - rect.height(), rect.top()), pos2(x, rect.bottom())];
                painter.with_clip_rect(rect).line_segment(line, (2.5, stripe));
            }
        });
        ui.label("within 10 %");
    });
}

fn swatch(ui: &mut Ui, paint: impl FnOnce(&egui::Painter, Rect)) {
    let (rect, _) = ui.allocate_exact_size(vec2(5.0 * GRID, 3.5 * GRID), Sense::hover());
    paint(ui.painter(), rect);
}

/// The numbers at the mouse: each strategy in a place of its own.
fn reading_ui(ui: &mut Ui, reading: Option<&Reading>) {
    let (row, _) = ui.allocate_exact_size(vec2(ui.available_width(), ui.spacing().interact_size.y), Sense::hover());
    let Some(Reading { place, logs }) = reading else { return };
    let inks = Inks::of(ui.visuals());
    // The place needs more room than a number.
    let column = row.width() / 6.0;
    let cell = |from: f32, to: f32| {
        Rect::from_min_max(pos2(row.left() + from * column, row.top()), pos2(row.left() + to * column, row.bottom()))
    };
    let (text, style) = (ui.visuals().text_color(), TextStyle::Small);
    words(ui, cell(0.0, 2.0), Align2::LEFT_CENTER, place, style.clone(), text);
    for (i, strategy) in Strategy::ALL.into_iter().enumerate() {
        let number = match logs[i] {
            f64::INFINITY => "biased".into(),
            // A mirror shows a light, or does not.
            log if log < EXACT.ln() => "exact".into(),
            log => Number(log.exp()).to_string(),
        };
        let place = cell(2.0 + i as f32, 3.0 + i as f32);
        words(ui, place, Align2::LEFT_CENTER, &number, TextStyle::Body, inks.strategy(strategy));
    }
}

/// Variances over the squared mean that are below it are rounding.
const EXACT: f64 = 1e-9;

/// A variance in at most seven characters.
struct Number(f64);

impl std::fmt::Display for Number {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self(v) = *self;
        if (1e-3..1e4).contains(&v) {
            let decimals = (2.0 - v.log10().floor()).clamp(0.0, 5.0) as usize;
            write!(f, "{v:.decimals$}")
        } else {
            write!(f, "{v:.1e}")
        }
    }
}

/// What was computed, precisely.
fn about(square: &Dot, own: &Estimator) -> [String; 2] {
    let [camera, light] = square.distances;
    let (plate, light_name) = square.name.split_once(" \u{d7} ").unwrap_or((&square.name, ""));
    let all = format!(
        "Numbers: variance of one ray over the squared mean, independent samples, exact by quadrature ({} heuristic, c {:.2}; \
         weights: {}). Point: where {plate}, as a plane mirror, shows the centre of {light_name} to the camera, {camera:.1} \
         from the camera and {light:.1} from that centre. Power of the light constant, other lights as in the scene. \
         Pale: 1.1 \u{d7} less than the second best; full: {FULL:.0} \u{d7}; hatched: within 10 %. Dots: the scene's own \
         squares, each at its own point, mirrors at the left edge.",
        heuristic_name(own.heuristic).to_lowercase(),
        own.light_prob,
        weights_name(own.weights),
    );
    let few = "Variance of one ray over the squared mean, exact. Pale: 1.1 \u{d7} less than the second best.";
    [all, few.to_owned()]
}
