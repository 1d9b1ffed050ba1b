//! What the colours of the picture mean: name, colour bar with its range, hatchings for what has no number.

use std::sync::Arc;

use eframe::egui::{
    self, Align2, Color32, FontId, Galley, Mesh, Pos2, Rect, Role, Sense, Shape, TextStyle, Vec2, pos2, vec2,
};
use mislab_renderer::{Layer, Technique};

use crate::look::layer::{Colouring, LayerLook, Quantity};
use crate::look::versus::Versus;
use crate::picture::pixel::{NEVER, NO_LIGHT, NOTHING_YET, value_text};
use crate::picture::planes::{BLIND, UNLIT};
use crate::picture::tone::{self, HATCH_PERIOD};
use crate::state::view::ViewState;

const BAR_HEIGHT: f32 = 16.0;
const BAR_WIDTH: f32 = 280.0;
const MIN_BAR_WIDTH: f32 = 140.0;
/// From this width the surround of a picture has room for the words at both ends of a bar.
const ROOM_BESIDE: f32 = 200.0;
const TICK: f32 = 4.0;
const GAP: f32 = 4.0;
const PLATE_MARGIN: f32 = 8.0;
/// Height of the mark of the number under the mouse, above the bar.
const MARK: f32 = 7.0;

/// What a legend is about.
#[derive(Clone, Copy)]
pub struct Key<'a> {
    /// Whose colours it explains.
    pub quantity: Quantity,
    /// How they come about.
    pub view: &'a ViewState,
    /// The number under the mouse, which it marks.
    pub here: Option<f32>,
}

/// The legend on a plate in the lower left corner of the viewport: beside the `picture` if there is room for one, else
/// on it.
pub fn legend_overlay(ui: &mut egui::Ui, viewport: Rect, picture: Rect, key: Key<'_>) {
    let margins = 4.0 * PLATE_MARGIN;
    let beside = picture.left() - viewport.left() - margins;
    let width = if beside >= ROOM_BESIDE { beside } else { viewport.width() - margins };
    let legend = Legend::new(ui, key, width);
    let size = legend.size + Vec2::splat(2.0 * PLATE_MARGIN);
    let corner = viewport.left_bottom() + vec2(PLATE_MARGIN, -PLATE_MARGIN - size.y);
    let plate = Rect::from_min_size(corner, size);
    let painter = ui.painter_at(viewport);
    painter.rect_filled(plate, 4.0, ui.visuals().panel_fill);
    legend.paint(&painter, plate.min + Vec2::splat(PLATE_MARGIN));
    let response = ui.interact(plate, ui.scope_id().with("legend"), Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(Role::Image, true, &legend.spoken));
}

/// The legend in a column, over its width, off every picture.
pub fn legend_ui(ui: &mut egui::Ui, key: Key<'_>) {
    let legend = Legend::new(ui, key, ui.available_width());
    let (rect, response) = ui.allocate_exact_size(legend.size, Sense::hover());
    legend.paint(ui.painter(), rect.min);
    response.widget_info(|| egui::WidgetInfo::labeled(Role::Image, true, &legend.spoken));
}

/// How much room [`legend_ui`] takes in so wide a column.
pub fn legend_size(ui: &egui::Ui, key: Key<'_>, available: f32) -> Vec2 {
    Legend::new(ui, key, available).size
}

/// The legend without a plate, its upper left corner at `at`, no wider than `available`; returns its size.
pub fn legend_on_paper(ui: &egui::Ui, at: Pos2, layer: Layer, view: &ViewState, available: f32) -> Vec2 {
    let legend = Legend::new(ui, Key { quantity: layer.into(), view, here: None }, available);
    legend.paint(ui.painter(), at);
    legend.size
}

/// The hatchings of colours alone, in a line, for where nothing else has to be said of them.
pub fn hatched_ui(ui: &mut egui::Ui) {
    let hatched = Hatched::new(ui, Layer::Picture.into(), None, f32::INFINITY);
    let (rect, response) = ui.allocate_exact_size(hatched.size, Sense::hover());
    hatched.paint(ui.painter(), rect.min, ui.visuals().strong_text_color());
    response.widget_info(|| egui::WidgetInfo::labeled(Role::Image, true, Hatched::spoken(Layer::Picture.into())));
}

/// The same without a place in a layout, its upper left corner at `at`; returns its height.
pub fn hatched_on_paper(ui: &egui::Ui, at: Pos2) -> f32 {
    let hatched = Hatched::new(ui, Layer::Picture.into(), None, f32::INFINITY);
    hatched.paint(ui.painter(), at, ui.visuals().strong_text_color());
    hatched.size.y
}

/// A legend laid out.
struct Legend {
    title: Arc<Galley>,
    /// Under the title for colour layers, which have no bar.
    note: Option<Arc<Galley>>,
    bar: Option<Bar>,
    hatched: Hatched,
    text: Color32,
    size: Vec2,
    /// For screen readers and tests.
    spoken: String,
}

struct Bar {
    width: f32,
    /// Colours from left to right, evenly spaced.
    colours: Vec<Color32>,
    /// Position in [0, 1] and the text, where there is room for one; the first and the last are aligned to the ends.
    ticks: Vec<(f32, Option<Arc<Galley>>)>,
    /// Height of the tallest of those.
    tick_height: f32,
    /// Where the number under the mouse is, in [0, 1].
    here: Option<f32>,
}

/// Between two hatchings and their words.
const BETWEEN: f32 = 3.0 * GAP;
/// Size in points that their words may have to fit into a row.
const LEAST: f32 = 14.0;

/// What the hatchings mean: no sample has hit yet, none can, or there is nothing to hit.
struct Hatched {
    entries: Vec<Entry>,
    colours: [Color32; 2],
    /// What is under the mouse.
    here: Option<Here>,
    size: Vec2,
}

struct Entry {
    means: Here,
    /// The swatch's upper left corner in the legend's part.
    at: Vec2,
    words: Arc<Galley>,
}

/// Where on the legend the number under the mouse is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Here {
    /// On the bar, in [0, 1].
    At(f32),
    /// At the hatching of what has not been hit.
    NothingYet,
    /// At that of what cannot be hit.
    Never,
    /// At the plain colour of what reflects no light.
    NoLight,
}

impl Legend {
    fn new(ui: &egui::Ui, key: Key<'_>, available: f32) -> Self {
        let Key { quantity, view, here } = key;
        let look = LayerLook::of(quantity);
        let text = ui.visuals().strong_text_color();
        let small = small(ui);
        let line = |words: String, font: &FontId| ui.painter().layout_no_wrap(words, font.clone(), text);
        let name = title(quantity, view);
        let title = line(name.to_owned(), &TextStyle::Body.resolve(ui.style()));
        let hatched = Hatched::new(ui, quantity, here.map(|value| position(quantity, view, value)), available);
        if look.is_colour() {
            let words = colour_note(view);
            let spoken = format!("Legend: {name}, {words}, {}", Hatched::spoken(quantity));
            let note = line(words, &small);
            let width = title.size().x.max(note.size().x).max(hatched.size.x);
            let size = vec2(width, title.size().y + note.size().y + GAP + hatched.size.y);
            return Self { title, note: Some(note), bar: None, hatched, text, size, spoken };
        }
        let width = available.clamp(MIN_BAR_WIDTH, BAR_WIDTH).floor();
        let words = tick_words(quantity, view);
        let mut spoken = format!(
            "Legend: {name}, {}, {}",
            words.iter().map(|(_, words)| words.as_str()).collect::<Vec<_>>().join(", "),
            Hatched::spoken(quantity)
        );
        if let Some(here) = here {
            spoken += &format!(", marked: {}", value_text(here));
        }
        let galleys: Vec<_> = words.into_iter().map(|(at, words)| (at, line(words, &small))).collect();
        let tick_height = galleys.iter().map(|(_, galley)| galley.size().y).fold(0.0, f32::max);
        let ticks = fitting(galleys, width);
        let here = match hatched.here {
            Some(Here::At(at)) => Some(at),
            Some(Here::NothingYet | Here::Never | Here::NoLight) | None => None,
        };
        let bar = Bar { width, colours: bar_colours(quantity, ui.visuals().dark_mode), ticks, tick_height, here };
        let height = title.size().y + GAP + bar.height() + GAP + hatched.size.y;
        let size = vec2(title.size().x.max(width).max(hatched.size.x), height);
        Self { title, note: None, bar: Some(bar), hatched, text, size, spoken }
    }

    fn paint(&self, painter: &egui::Painter, at: Pos2) {
        painter.galley(at, self.title.clone(), self.text);
        let mut below = at + vec2(0.0, self.title.size().y);
        if let Some(note) = &self.note {
            painter.galley(below, note.clone(), self.text);
            below.y += note.size().y;
        }
        if let Some(bar) = &self.bar {
            below.y += GAP;
            bar.paint(painter, below, self.text);
            below.y += bar.height();
        }
        self.hatched.paint(painter, below + vec2(0.0, GAP), self.text);
    }
}

/// Type of all but the title.
fn small(ui: &egui::Ui) -> FontId {
    let body = TextStyle::Body.resolve(ui.style());
    FontId { size: TextStyle::Small.resolve(ui.style()).size.max(12.0), ..body }
}

fn outline(ink: Color32) -> egui::Stroke {
    egui::Stroke::new(1.0, ink.gamma_multiply(0.6))
}

impl Bar {
    fn height(&self) -> f32 {
        MARK + BAR_HEIGHT + TICK + self.tick_height
    }

    fn paint(&self, painter: &egui::Painter, at: Pos2, ink: Color32) {
        let rect = Rect::from_min_size(at + vec2(0.0, MARK), vec2(self.width, BAR_HEIGHT));
        painter.add(gradient(rect, &self.colours));
        painter.rect_stroke(rect, 0.0, outline(ink), egui::StrokeKind::Outside);
        for (i, (position, galley)) in self.ticks.iter().enumerate() {
            let x = rect.left() + position * rect.width();
            painter.vline(x, rect.bottom()..=rect.bottom() + TICK, outline(ink));
            let anchor = if i == 0 {
                Align2::LEFT_TOP
            } else if i + 1 == self.ticks.len() {
                Align2::RIGHT_TOP
            } else {
                Align2::CENTER_TOP
            };
            if let Some(galley) = galley {
                let place = anchor.anchor_size(pos2(x, rect.bottom() + TICK), galley.size());
                painter.galley(place.min, galley.clone(), ink);
            }
        }
        if let Some(at) = self.here {
            paint_mark(painter, rect, rect.left() + at * rect.width(), ink);
        }
    }
}

impl Hatched {
    /// In the colours of the picture of that quantity, in as many rows as so little room needs.
    fn new(ui: &egui::Ui, quantity: Quantity, here: Option<Here>, available: f32) -> Self {
        let (mut font, ink) = (small(ui), ui.visuals().strong_text_color());
        let colours = tone::hatch_of(quantity, ui.visuals().dark_mode);
        let meanings = Self::meanings(quantity);
        let set = |means: &Here, font: &FontId| {
            ui.painter().layout_no_wrap(words(quantity, *means).to_owned(), font.clone(), ink)
        };
        let wide = |words: &Galley| BAR_HEIGHT + GAP + words.size().x;
        // A little smaller rather than another row.
        let text: f32 = meanings.iter().map(|means| set(means, &font).size().x).sum();
        let room = available - meanings.len() as f32 * (BAR_HEIGHT + GAP + BETWEEN) + BETWEEN;
        let fitting = (font.size * room / text).floor();
        if (LEAST..font.size).contains(&fitting) {
            font.size = fitting;
        }
        let (mut entries, mut size, mut at) = (Vec::new(), Vec2::ZERO, Vec2::ZERO);
        for means in meanings {
            let words = set(means, &font);
            let [width, height] = [wide(&words), words.size().y.max(BAR_HEIGHT)];
            if at.x > 0.0 && at.x + width > available {
                at = vec2(0.0, size.y + GAP);
            }
            size = size.max(at + vec2(width, height));
            entries.push(Entry { means: *means, at: at + vec2(0.0, 0.5 * (height - BAR_HEIGHT)), words });
            at.x += width + BETWEEN;
        }
        Self { entries, colours, here, size }
    }

    /// Black is no light in colours; where there is one number, it has a colour of its own.
    fn meanings(quantity: Quantity) -> &'static [Here] {
        let all = &[Here::NothingYet, Here::Never, Here::NoLight];
        if LayerLook::of(quantity).is_colour() { &all[..2] } else { all }
    }

    fn spoken(quantity: Quantity) -> String {
        let look = |means: &Here| match means {
            Here::NothingYet => "hatched: ",
            Here::Never => "cross-hatched: ",
            Here::NoLight | Here::At(_) => "plain: ",
        };
        let spoken = Self::meanings(quantity).iter().map(|means| look(means).to_owned() + words(quantity, *means));
        spoken.collect::<Vec<_>>().join(", ")
    }

    fn paint(&self, painter: &egui::Painter, at: Pos2, ink: Color32) {
        for Entry { means, at: offset, words } in &self.entries {
            let swatch = Rect::from_min_size(at + *offset, Vec2::splat(BAR_HEIGHT));
            paint_hatch(painter, swatch, self.colours, *means);
            let marked = egui::Stroke::new(2.0, ink);
            let stroke = if self.here == Some(*means) { marked } else { outline(ink) };
            painter.rect_stroke(swatch, 0.0, stroke, egui::StrokeKind::Outside);
            let place = Align2::LEFT_CENTER.anchor_size(swatch.right_center() + vec2(GAP, 0.0), words.size());
            painter.galley(place.min, words.clone(), ink);
        }
    }
}

/// Of two pictures, neither of which has an error there: no light in both, or lamps.
const BOTH_EXACT: &str = "both exact";

/// What a pixel without a number is.
fn words(quantity: Quantity, means: Here) -> &'static str {
    match means {
        Here::NoLight if matches!(quantity, Quantity::Versus(_)) => BOTH_EXACT,
        Here::NothingYet => NOTHING_YET,
        Here::Never => NEVER,
        Here::NoLight => NO_LIGHT,
        Here::At(_) => "",
    }
}

/// A pointer from above onto the bar, and a line across it.
fn paint_mark(painter: &egui::Painter, bar: Rect, x: f32, ink: Color32) {
    painter.vline(x, bar.y_range(), egui::Stroke::new(3.0, Color32::BLACK));
    painter.vline(x, bar.y_range(), egui::Stroke::new(1.0, Color32::WHITE));
    let tip = pos2(x, bar.top());
    let corners = vec![tip, tip - vec2(MARK * 0.7, MARK), tip + vec2(MARK * 0.7, -MARK)];
    painter.add(Shape::convex_polygon(corners, ink, egui::Stroke::NONE));
}

/// What the numbers are called.
fn title(quantity: Quantity, view: &ViewState) -> &'static str {
    if quantity == Layer::Variance.into() { view.variance_unit.title() } else { LayerLook::of(quantity).name }
}

/// Where a number of the layer is on the legend.
fn position(quantity: Quantity, view: &ViewState, value: f32) -> Here {
    let at = match LayerLook::of(quantity).colouring {
        Colouring::Signed => 0.5 + 0.5 * value / tone::signed_range(quantity, view),
        Colouring::Magnitude => {
            let [low, high] = tone::variance_range(view);
            // Zero has no logarithm, and a place at the lower end.
            (value.max(f32::MIN_POSITIVE).log10() - low) / (high - low)
        }
        Colouring::Share { .. } | Colouring::Radiance => value,
    };
    if value.is_nan() {
        Here::NothingYet
    } else if value == BLIND {
        Here::Never
    } else if value == UNLIT {
        Here::NoLight
    } else {
        Here::At(at.clamp(0.0, 1.0))
    }
}

/// Exposure, offset and tone map in words.
pub fn colour_note(view: &ViewState) -> String {
    let offset = if view.offset == 0.0 { String::new() } else { format!(", offset {:+.2}", view.offset) };
    format!("EV {:+.1}{offset}, {}", view.exposure_ev, view.tone_map.name())
}

/// What stands under the bar, from left to right.
fn tick_words(quantity: Quantity, view: &ViewState) -> Vec<(f32, String)> {
    match LayerLook::of(quantity).colouring {
        Colouring::Signed if quantity == Versus::Difference.into() => {
            let range = tone::signed_range(quantity, view);
            vec![(0.0, format!("\u{2264}\u{2212}{range}")), (0.5, "0".to_owned()), (1.0, format!("\u{2265}{range}"))]
        }
        Colouring::Signed => {
            let words = ["1/8", "1/4", "1/2", "1", "2", "4", "8"];
            words.iter().enumerate().map(|(i, words)| (i as f32 / 6.0, (*words).to_owned())).collect()
        }
        Colouring::Share { ends: [low, high], .. } => {
            vec![(0.0, low.to_owned()), (0.5, "1/2".to_owned()), (1.0, high.to_owned())]
        }
        Colouring::Magnitude => decades(tone::variance_range(view)),
        Colouring::Radiance => Vec::new(),
    }
}

/// The two ends, which stand for all beyond them, and the whole decades between.
fn decades([low, high]: [f32; 2]) -> Vec<(f32, String)> {
    let at = |log10: f32| (log10 - low) / (high - low);
    let mut ticks = vec![(0.0, format!("≤{}", power(low)))];
    // Keeps clear of the ends, whose text is wider.
    let inner = (low.floor() as i32 + 1..high.ceil() as i32).filter(|n| (0.05..0.95).contains(&at(*n as f32)));
    ticks.extend(inner.map(|n| (at(n as f32), power(n as f32))));
    ticks.push((1.0, format!("≥{}", power(high))));
    ticks
}

/// 10 to a power as people read it.
fn power(log10: f32) -> String {
    let value = 10_f64.powf(f64::from(log10));
    let whole = (log10 - log10.round()).abs() < 1e-4;
    match log10 {
        ..-3.01 | 4.01.. if whole => format!("1e{log10:.0}"),
        ..-3.01 | 4.01.. => format!("{value:.1e}"),
        _ if whole && log10 < 0.0 => format!("{value:.*}", -log10.round() as usize),
        _ if whole => format!("{value:.0}"),
        _ if value >= 10.0 => format!("{value:.0}"),
        _ => format!("{value:.*}", (1.0 - log10).ceil().max(1.0) as usize),
    }
}

/// Takes away the text that would run into its neighbour's; the two ends keep theirs.
fn fitting(ticks: Vec<(f32, Arc<Galley>)>, width: f32) -> Vec<(f32, Option<Arc<Galley>>)> {
    const BETWEEN: f32 = 8.0;
    let last = ticks.len().saturating_sub(1);
    let last_left = ticks.last().map_or(width, |(_, galley)| width - galley.size().x - BETWEEN);
    let mut free_from = 0.0;
    let keep = |(i, (at, galley)): (usize, (f32, Arc<Galley>))| {
        let half = galley.size().x / 2.0;
        let middle = if i == 0 { half } else { at * width };
        let fits = i == 0 || i == last || (middle - half >= free_from && middle + half <= last_left);
        if fits {
            free_from = middle + half + BETWEEN;
        }
        (at, fits.then_some(galley))
    };
    ticks.into_iter().enumerate().map(keep).collect()
}

/// The colours along the bar, as the picture shows them.
fn bar_colours(quantity: Quantity, dark: bool) -> Vec<Color32> {
    const STEPS: usize = 64;
    let map = tone::colour_map(quantity, dark);
    let from_amber = matches!(LayerLook::of(quantity).colouring, Colouring::Share { of: Technique::Bsdf, .. });
    (0..=STEPS)
        .map(|i| {
            let t = i as f32 / STEPS as f32;
            // The number grows to the right; amber stays with the light technique.
            let t = if from_amber { 1.0 - t } else { t };
            let [r, g, b] = map.at(t).map(|v| (v * 255.0).round() as u8);
            Color32::from_rgb(r, g, b)
        })
        .collect()
}

fn gradient(rect: Rect, colours: &[Color32]) -> Shape {
    let mut mesh = Mesh::default();
    let last = (colours.len().max(2) - 1) as f32;
    for (i, colour) in colours.iter().enumerate() {
        let x = rect.left() + rect.width() * i as f32 / last;
        mesh.colored_vertex(pos2(x, rect.top()), *colour);
        mesh.colored_vertex(pos2(x, rect.bottom()), *colour);
        if i > 0 {
            let next = 2 * i as u32;
            mesh.add_triangle(next - 2, next - 1, next);
            mesh.add_triangle(next - 1, next, next + 1);
        }
    }
    Shape::mesh(mesh)
}

/// The hatchings of the shader, in shapes.
fn paint_hatch(painter: &egui::Painter, rect: Rect, [ground, stripe]: [Color32; 2], means: Here) {
    let painter = painter.with_clip_rect(rect.intersect(painter.clip_rect()));
    painter.rect_filled(rect, 0.0, ground);
    if means == Here::NoLight {
        return;
    }
    let stroke = egui::Stroke::new(HATCH_PERIOD / 2.0 * std::f32::consts::FRAC_1_SQRT_2, stripe);
    let (mut x, end) = (rect.left(), rect.right() + rect.height());
    while x <= end {
        painter.line_segment([pos2(x, rect.top()), pos2(x - rect.height(), rect.bottom())], stroke);
        if means == Here::Never {
            painter.line_segment([pos2(x, rect.bottom()), pos2(x - rect.height(), rect.top())], stroke);
        }
        x += HATCH_PERIOD;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mark_is_where_the_number_is() {
        let view = ViewState { variance_range: [-4.0, 2.0], ..ViewState::default() };
        assert_eq!(position(Layer::ShareLight.into(), &view, 0.25), Here::At(0.25));
        assert_eq!(
            position(Layer::WeightBsdf.into(), &view, 1.0),
            Here::At(1.0),
            "the number grows to the right, whatever the colour"
        );
        assert!(matches!(position(Layer::Variance.into(), &view, 0.1), Here::At(at) if (at - 0.5).abs() < 1e-6));
        assert_eq!(position(Layer::Variance.into(), &view, 0.0), Here::At(0.0));
        assert_eq!(position(Layer::Variance.into(), &view, f32::NAN), Here::NothingYet);
        assert_eq!(position(Layer::Variance.into(), &view, BLIND), Here::Never, "that is no noise of 0");
        assert_eq!(position(Layer::Variance.into(), &view, UNLIT), Here::NoLight);
    }
}
