//! The best c of every pixel as a picture, and what c = 1/2 costs instead.

use std::sync::Arc;

use eframe::egui::{
    self, Align2, Color32, ColorImage, Pos2, Rect, Role, Sense, Stroke, StrokeKind, TextStyle, TextureHandle,
    TextureOptions, Ui, UiBuilder, pos2, vec2,
};
use mislab_renderer::inspect::BestMap;
use mislab_renderer::{OneSampleWeights, PixelRect};

use super::Subject;
use super::best_map_job::{self, BestMapJob, Question};
use super::tiles::{caption_lines, caption_that_fits, words};
use crate::look::colormap::{ColourMap, TABLE_LEN};
use crate::look::names::{heuristic_name, weights_name};
use crate::look::theme::GRID;
use crate::panel::number::three_digits;
use crate::panel::widgets::{caption, segmented, title_with_note};
use crate::picture::tone;
use crate::state::command::Command;
use crate::state::study::Study;

/// The loss from which its colours are at full strength.
const FULL: f32 = 10.0;

/// Which of the two maps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Map {
    #[default]
    Best,
    Loss,
}

/// What is kept of it while it is open and after.
#[derive(Default)]
pub struct BestC {
    map: Map,
    job: Option<BestMapJob>,
    /// What was known last: it stays, faintly, until there is something of the new scene.
    last: Option<Arc<BestMap>>,
    drawn: Option<Drawn>,
}

/// The map on screen, and what it was made of.
struct Drawn {
    of: Arc<BestMap>,
    map: Map,
    dark: bool,
    size: [usize; 2],
    texture: TextureHandle,
}

impl BestC {
    /// Not on screen: nothing is worked out for it. What is finished stays.
    pub fn rest(&mut self) {
        if self.job.as_ref().is_some_and(|job| job.found().is_none_or(|map| map.step != 1)) {
            self.job = None;
        }
    }
}

/// Draws it over all that is left of `ui`.
pub fn best_map_ui(ui: &mut Ui, study: &mut BestC, subject: &Subject<'_>, out: &mut Vec<Command>) {
    let Some(frame) = subject.pictures[subject.document.active_index()].frame() else {
        title_with_note(ui, "Best c of every pixel", &[]);
        let file = subject.document.active().is_file();
        ui.label(if file {
            "This picture is from a file: how it was made is not known."
        } else {
            "Waiting for the picture \u{2026}"
        });
        return;
    };
    let question = Question::of(&frame);
    drop(frame);
    if study.job.as_ref().is_none_or(|job| !job.question().has_map_of(&question)) {
        study.job = Some(best_map_job::start(ui.ctx(), question.clone(), subject.threads));
    }
    let current = study.job.as_ref().and_then(BestMapJob::found);
    let is_current = current.is_some();
    study.last = current.or_else(|| study.last.take());
    let found = study.last.clone();
    let note = match found.as_ref().filter(|_| is_current).map(|map| map.step) {
        Some(1) => "a click explains a pixel".to_owned(),
        Some(2) => "coarse so far: every other pixel \u{2026}".to_owned(),
        Some(step) => format!("coarse so far: each {step}th pixel \u{2026}"),
        None => "working \u{2026}".to_owned(),
    };
    title_with_note(ui, "Best c of every pixel", &[&note]);
    let choices = [(Map::Best, "Best c"), (Map::Loss, "Loss at c = 1/2")];
    let hint = |ui: &mut Ui, map: Map| {
        ui.label(match map {
            Map::Best => "The probability of the light technique at which one sample of MIS, one has least variance.",
            Map::Loss => "V(1/2) / V(best c): how many times more samples c = 1/2 needs for the same error.",
        });
    };
    if let Some(map) = segmented(ui, "Map", study.map, &choices, true, &hint) {
        study.map = map;
    }
    let Some(found) = found else {
        caption(ui, "Asking some hundred directions of every eighth pixel \u{2026}");
        return;
    };
    let area = ui.available_rect_before_wrap();
    let plan = Plan::new(ui, area, &found.bounds);
    ui.scope(|ui| {
        if !is_current {
            ui.multiply_opacity(0.5);
        }
        let under = map_ui(ui, study, &found, plan.map, subject.cursor);
        if let Under { pixel: Some(pixel), clicked: true } = under {
            out.push(Command::ToggleStudy(Study::Explain));
            out.push(Command::Pin(Some(pixel)));
        }
        let here = under.pixel;
        ui.scope_builder(UiBuilder::new().id_salt("about").max_rect(plan.below), |ui| {
            ui.set_clip_rect(plan.below.intersect(ui.clip_rect()));
            legend_ui(ui, study.map, here.and_then(|at| position(&found, study.map, at)));
            reading_ui(ui, &found, here);
            let [all, few] = about(study.map, &question);
            caption_that_fits(ui, &all, &few);
        });
    });
    ui.advance_cursor_after_rect(area);
}

/// Where the map is, and what is under it.
struct Plan {
    map: Rect,
    below: Rect,
}

impl Plan {
    fn new(ui: &Ui, area: Rect, bounds: &PixelRect) -> Self {
        // Legend, reading, and the caption.
        let under = caption_lines(ui, [5.0, 7.5]) + 10.0 * GRID;
        let (upper, below) = area.split_top_bottom_at_y((area.bottom() - under).max(area.center().y - 40.0));
        let scale = (upper.width() / bounds.width() as f32).min(upper.height() / bounds.height() as f32);
        let size = vec2(bounds.width() as f32, bounds.height() as f32) * scale;
        let map = Align2::CENTER_TOP.align_size_within_rect(size, upper);
        Self { map, below: below.with_min_y(map.bottom() + GRID) }
    }
}

/// What the mouse is on, here or in a picture.
struct Under {
    /// In coordinates of the full image.
    pixel: Option<[u32; 2]>,
    /// It was clicked, here.
    clicked: bool,
}

/// Draws the map over the rectangle `map`.
fn map_ui(ui: &mut Ui, study: &mut BestC, found: &Arc<BestMap>, map: Rect, cursor: Option<[u32; 2]>) -> Under {
    let dark = ui.visuals().dark_mode;
    let bounds = found.bounds;
    let pixels = [bounds.width() as usize, bounds.height() as usize];
    let screen = [map.width(), map.height()].map(|n| (n * ui.pixels_per_point()).clamp(16.0, 2048.0) as usize);
    // A texel for each pixel of the picture or of the screen, whichever are fewer.
    let size = if pixels[0] <= screen[0] { pixels } else { screen };
    let current =
        |drawn: &Drawn| Arc::ptr_eq(&drawn.of, found) && (drawn.map, drawn.dark, drawn.size) == (study.map, dark, size);
    if !study.drawn.as_ref().is_some_and(current) {
        let texels = image(found, study.map, size, dark);
        let texture = ui.ctx().load_texture("best c", texels, TextureOptions::NEAREST);
        study.drawn = Some(Drawn { of: found.clone(), map: study.map, dark, size, texture });
    }
    let response = ui.interact(map, ui.scope_id().with("map"), Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(Role::Image, true, "Map over the pixels"));
    if let Some(drawn) = &study.drawn {
        let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
        ui.painter().image(drawn.texture.id(), map, whole, Color32::WHITE);
    }
    let own = response.hover_pos().map(|at| {
        let share = [(at.x - map.left()) / map.width(), (at.y - map.top()) / map.height()];
        let [width, height] = [bounds.width(), bounds.height()];
        let offset = [(share[0] * width as f32) as u32, (share[1] * height as f32) as u32];
        [bounds.min[0] + offset[0].min(width - 1), bounds.min[1] + offset[1].min(height - 1)]
    });
    // The mouse itself shows where it is.
    if let Some(at) = cursor.filter(|at| own.is_none() && index(found, *at).is_some()) {
        let share = |axis: usize, size: u32| (at[axis] - bounds.min[axis]) as f32 / size as f32;
        let at = map.lerp_inside(vec2(share(0, bounds.width()), share(1, bounds.height())));
        for (width, ink) in [(4.0, Color32::from_black_alpha(170)), (2.0, Color32::WHITE)] {
            ui.painter().circle_stroke(at, 1.5 * GRID, (width, ink));
        }
    }
    Under { pixel: own.or(cursor), clicked: own.is_some() && response.clicked() }
}

/// Where a pixel is in the lists of the map.
fn index(found: &BestMap, [x, y]: [u32; 2]) -> Option<usize> {
    let PixelRect { min, max } = found.bounds;
    let inside = (min[0]..max[0]).contains(&x) && (min[1]..max[1]).contains(&y);
    inside.then(|| ((y - min[1]) * found.bounds.width() + x - min[0]) as usize)
}

/// From blue (0: BSDF samples) over the middle (1/2) to amber (1: light samples); `None` where nothing is reflected.
fn shade(map: Map, c: f32, loss: f32) -> Option<f32> {
    let strength = (loss.ln() / FULL.ln()).clamp(0.0, 1.0);
    let share = match map {
        Map::Best => c,
        Map::Loss if c < 0.5 => 0.5 - 0.5 * strength,
        Map::Loss => 0.5 + 0.5 * strength,
    };
    (!c.is_nan()).then_some(share)
}

/// The shade of a pixel, as a place on the bar.
fn position(found: &BestMap, map: Map, at: [u32; 2]) -> Option<f32> {
    let index = index(found, at)?;
    shade(map, found.c[index], found.loss[index])
}

/// The map as `size` texels.
fn image(found: &BestMap, map: Map, size: [usize; 2], dark: bool) -> ColorImage {
    let table = ColourMap::technique(dark).table();
    // The same as in the layers of pictures.
    let [plain, _] = tone::hatch(dark);
    let [width, height] = [found.bounds.width() as usize, found.bounds.height() as usize];
    let mut texels = Vec::with_capacity(size[0] * size[1]);
    for y in 0..size[1] {
        let row = y * height / size[1] * width;
        for x in 0..size[0] {
            let index = row + x * width / size[0];
            texels.push(match shade(map, found.c[index], found.loss[index]) {
                Some(share) => {
                    let [r, g, b, _] = table[(share * (TABLE_LEN - 1) as f32).round() as usize];
                    Color32::from_rgb(r, g, b)
                }
                None => plain,
            });
        }
    }
    ColorImage::new(size, texels)
}

/// The bar of colours with its numbers; `here`: what the mouse is on.
fn legend_ui(ui: &mut Ui, map: Map, here: Option<f32>) {
    let small = ui.text_style_height(&TextStyle::Small);
    let font = TextStyle::Small.resolve(ui.style());
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), small + 5.0 * GRID), Sense::hover());
    let bar =
        rect.with_min_y(rect.top() + 1.5 * GRID).with_max_y(rect.top() + 4.0 * GRID).shrink2(vec2(2.0 * GRID, 0.0));
    let table = ColourMap::technique(ui.visuals().dark_mode).table();
    let steps = 64;
    for i in 0..steps {
        let [r, g, b, _] = table[i * (TABLE_LEN - 1) / (steps - 1)];
        let x = |i: usize| bar.left() + bar.width() * i as f32 / steps as f32;
        let part = Rect::from_x_y_ranges(x(i)..=x(i + 1), bar.y_range());
        ui.painter().rect_filled(part, 0.0, Color32::from_rgb(r, g, b));
    }
    let ink = ui.visuals().text_color();
    ui.painter().rect_stroke(bar, 0.0, Stroke::new(1.0, ui.visuals().weak_text_color()), StrokeKind::Outside);
    let names = match map {
        Map::Best => ["0: BSDF samples only", "0.5", "1: light samples only"],
        Map::Loss => ["\u{d7} 10: fewer light samples", "no loss", "\u{d7} 10: more light samples"],
    };
    for (align, at, name) in [
        (Align2::LEFT_TOP, bar.left(), names[0]),
        (Align2::CENTER_TOP, bar.center().x, names[1]),
        (Align2::RIGHT_TOP, bar.right(), names[2]),
    ] {
        ui.painter().text(pos2(at, bar.bottom() + 0.5 * GRID), align, name, font.clone(), ink);
    }
    if let Some(share) = here {
        let tip = pos2(bar.left() + share * bar.width(), bar.top());
        let corners = vec![tip, tip + vec2(-GRID, -1.5 * GRID), tip + vec2(GRID, -1.5 * GRID)];
        ui.painter().add(egui::Shape::convex_polygon(corners, ink, Stroke::NONE));
    }
    let spoken = format!("{} to {}", names[0], names[2]);
    response.widget_info(|| egui::WidgetInfo::labeled(Role::Image, true, &spoken));
}

/// The numbers of the pixel under the mouse.
fn reading_ui(ui: &mut Ui, found: &BestMap, here: Option<[u32; 2]>) {
    let height = ui.text_style_height(&TextStyle::Body) + GRID;
    let (row, _) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::hover());
    let ink = ui.visuals().text_color();
    let known = here.and_then(|at| Some((at, index(found, at)?)));
    let text = match known {
        None => "Point at a pixel, here or in the picture.".to_owned(),
        Some(([x, y], index)) if found.c[index].is_nan() => format!("x {x}, y {y}: nothing is reflected here"),
        Some(([x, y], index)) => {
            let loss = found.loss[index];
            let more = if loss >= BestMap::MOST { "> " } else { "" };
            let loss = three_digits(f64::from(loss));
            format!("x {x}, y {y}: best c {:.2}, loss at 1/2 {more}{loss} \u{d7}", found.c[index])
        }
    };
    words(ui, row, Align2::LEFT_CENTER, &text, TextStyle::Body, ink);
}

/// What was computed, precisely.
fn about(map: Map, question: &Question) -> [String; 2] {
    let estimator = question.settings().estimator;
    let first = match map {
        Map::Best => "Best c: where one sample of MIS, one has least variance.",
        Map::Loss => {
            "Loss: variance of one sample at c = 1/2 over that at the best c; blue where fewer light samples would be better, \
                      amber where more."
        }
    };
    let c = match estimator.weights {
        OneSampleWeights::Veach => "",
        OneSampleWeights::Tutorial => ", without c in the weights",
    };
    let how =
        format!("{} heuristic, weights: {}{c}", heuristic_name(estimator.heuristic), weights_name(estimator.weights));
    let all = format!(
        "{first} {how}. No samples: by quadrature over some hundred directions at the centres of pixels, c to 0.02 and loss to 8 % at \
         99 of 100 pixels. Grey: nothing is reflected."
    );
    [all, format!("{how}. Grey: nothing is reflected.")]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_say_which_technique_is_missing() {
        assert_eq!(shade(Map::Best, 0.25, 2.0), Some(0.25));
        assert_eq!(shade(Map::Loss, 0.25, 1.0), Some(0.5));
        assert_eq!(shade(Map::Loss, 0.25, FULL), Some(0.0));
        assert_eq!(shade(Map::Loss, 0.75, 2.0 * FULL), Some(1.0));
        assert_eq!(shade(Map::Loss, f32::NAN, f32::NAN), None);
    }

    #[test]
    fn a_map_of_fewer_texels_shows_the_same_places() {
        let bounds = PixelRect { min: [10, 20], max: [14, 22] };
        let c = vec![0.0, 0.0, 1.0, 1.0, f32::NAN, f32::NAN, 0.5, 0.5];
        let map = BestMap { bounds, step: 1, c, loss: vec![1.0; 8] };
        let image = image(&map, Map::Best, [2, 2], true);
        let [_, low] = [0, 1].map(|i| image.pixels[i]);
        assert_eq!(low, {
            let [r, g, b, _] = ColourMap::TechniqueOnBlack.table()[TABLE_LEN - 1];
            Color32::from_rgb(r, g, b)
        });
        assert_eq!((index(&map, [13, 21]), index(&map, [14, 21]), index(&map, [9, 20])), (Some(7), None, None));
        assert_eq!(position(&map, Map::Best, [12, 21]), Some(0.5));
        assert_eq!(position(&map, Map::Best, [10, 21]), None);
    }
}
