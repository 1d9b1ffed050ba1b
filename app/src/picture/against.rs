//! Two pictures as one: the first against the second, pixel by pixel, and what is sure of them in a sentence.

use std::sync::{Arc, Weak};
use std::time::{Duration, Instant};

use eframe::egui::{self, Color32, Rect, Stroke, StrokeKind, Ui};
use mislab_renderer::metrics::Region;
use mislab_renderer::metrics::ratio::{Noise, Ratio};
use mislab_renderer::{Frame, Lockstep, PixelRect};

use crate::look::versus::Versus;
use crate::picture::blind::BlindSpots;
use crate::picture::film_texture::FilmPipeline;
use crate::picture::legend::{Key, legend_overlay};
use crate::picture::planes::Planes;
use crate::picture::variance::{self, luminance};
use crate::picture::viewport::{Shown, Viewport};
use crate::state::document::Document;
use crate::state::placement::Geometry;
use crate::state::view::VarianceUnit;

/// Side of the blocks that variances are shown for, in pixels: those of single pixels are mostly noise themselves.
const BLOCK: usize = 8;
/// It follows the pictures at most this often: both are gone through for it.
const INTERVAL: Duration = Duration::from_millis(250);

/// Two pictures on screen as one.
pub struct Against {
    viewport: Viewport,
    blind: [BlindSpots; 2],
    /// What planes and sentence were worked out from.
    of: Option<Of>,
    made: Option<Instant>,
    planes: Option<Arc<Planes>>,
    found: String,
    /// The part that the sentence is about, in pixels of the full image; `None`: all of it.
    part: Option<PixelRect>,
    /// Where a part began to be selected.
    from: Option<[u32; 2]>,
}

#[derive(Clone, PartialEq)]
struct Of {
    frames: [(u64, u32, usize); 2],
    blind: [Option<usize>; 2],
    versus: Versus,
    equal: Lockstep,
    part: Option<PixelRect>,
}

impl Against {
    /// Drawn by the shader, or on the CPU without one.
    pub fn new(pipeline: Option<FilmPipeline>) -> Self {
        Self {
            viewport: Viewport::new(pipeline),
            blind: Default::default(),
            of: None,
            made: None,
            planes: None,
            found: String::new(),
            part: None,
            from: None,
        }
    }

    /// What was on screen in the last pass.
    pub fn planes(&self) -> Option<&Arc<Planes>> {
        self.planes.as_ref()
    }

    /// What is sure of the two pictures.
    pub fn found(&self) -> &str {
        &self.found
    }

    /// Draws them over all that is left of `ui`.
    pub fn ui(&mut self, ui: &mut Ui, document: &mut Document, frames: &[Option<Arc<Frame>>; 2]) {
        match frames {
            [Some(a), Some(b)] if same_pixels(a, b) => self.update(ui.ctx(), document, [a, b]),
            [Some(_), Some(_)] => self.nothing("The pictures have different sizes: nothing to compare."),
            [None, _] | [_, None] => self.nothing("Rendering the first pictures \u{2026}"),
        }
        let versus = document.view.versus;
        let shown = Shown { quantity: versus.into(), planes: self.planes.as_ref(), stale: None };
        let response = self.viewport.ui(ui, &mut document.view, shown);
        let rect = response.response.rect.intersect(ui.clip_rect());
        let (Some(geometry), Some(planes)) = (response.geometry, &self.planes) else { return };
        let bounds = planes.bounds();
        let here = response.hovered_pixel.map(|[x, y]| planes.value(x - bounds.min[0], y - bounds.min[1])[0]);
        self.select(ui, &response.response, &geometry, bounds);
        if let Some(part) = self.part {
            outline(ui, rect, &geometry, part);
        }
        let key = Key { quantity: versus.into(), view: &document.view, here };
        legend_overlay(ui, rect, geometry.picture_rect(), key);
    }

    fn nothing(&mut self, why: &str) {
        self.of = None;
        self.planes = None;
        self.found.clear();
        self.found.push_str(why);
    }

    /// With Shift a drag selects a part, and a click all.
    fn select(&mut self, ui: &Ui, response: &egui::Response, geometry: &Geometry, bounds: PixelRect) {
        let shift = ui.input(|input| input.modifiers.shift);
        let pixel = |at: egui::Pos2| {
            let at = geometry.to_image(at);
            [0, 1].map(|i| (at[i].max(0.0) as u32).clamp(bounds.min[i], bounds.max[i].saturating_sub(1)))
        };
        if shift && response.clicked() {
            self.part = None;
        }
        if shift && response.drag_started_by(egui::PointerButton::Primary) {
            self.from = ui.input(|input| input.pointer.press_origin()).map(pixel);
        }
        if let (Some(from), Some(to)) = (self.from, response.interact_pointer_pos().map(pixel)) {
            let (min, max) = ([0, 1].map(|i| from[i].min(to[i])), [0, 1].map(|i| from[i].max(to[i]) + 1));
            self.part = Some(PixelRect { min, max });
            ui.ctx().set_cursor_icon(egui::CursorIcon::Crosshair);
        }
        if !response.dragged() {
            self.from = None;
        }
    }

    fn update(&mut self, ctx: &egui::Context, document: &Document, [a, b]: [&Arc<Frame>; 2]) {
        let [first, second] = &mut self.blind;
        let blind = [first.of(ctx, a), second.of(ctx, b)];
        self.part = self.part.and_then(|part| inside(part, a.bounds()));
        let of = Of {
            frames: [a, b]
                .map(|frame| (frame.generation(), frame.spp(), Weak::as_ptr(&Arc::downgrade(frame)) as usize)),
            blind: blind.each_ref().map(|blind| blind.as_ref().map(|blind| Arc::as_ptr(blind) as usize)),
            versus: document.view.versus,
            equal: document.equal,
            part: self.part,
        };
        if self.of.as_ref() == Some(&of) {
            return;
        }
        let asked =
            self.of.as_ref().is_some_and(|old| (old.versus, old.equal, old.part) != (of.versus, of.equal, of.part));
        if let Some(made) = self.made.filter(|made| self.planes.is_some() && !asked && made.elapsed() < INTERVAL) {
            ctx.request_repaint_after(INTERVAL.saturating_sub(made.elapsed()));
            return;
        }
        let sides = [a, b].map(|frame| Side::of(frame, unit(document.equal)));
        let mut planes = match of.versus {
            Versus::Difference => difference(a, &sides),
            Versus::Variances => variances(a, &sides),
        };
        let sides = [(sides, blind)].map(|([a, b], [not_a, not_b])| {
            for not in [&not_a, &not_b].into_iter().flatten() {
                planes.mark(not);
            }
            [a.without(&planes), b.without(&planes)]
        });
        let [[side_a, side_b]] = sides;
        let width = a.bounds().width() as usize;
        let region = match self.part {
            Some(part) => Region::Rect { width, rect: relative(part, a.bounds()) },
            None => Region::All,
        };
        let place = if self.part.is_some() { "In the part" } else { "Over all" };
        let ratio = Ratio::of(&side_a.noise(), &side_b.noise(), width, &region);
        self.found = match ratio {
            Some(ratio) => format!("{place}: {}; variance {}", ratio.sentence(), per(document.equal)),
            None => format!("{place}: nothing to compare yet."),
        };
        self.planes = Some(Arc::new(planes));
        self.made = Some(Instant::now());
        self.of = Some(of);
    }
}

/// What variances are counted in where that is equal.
fn unit(equal: Lockstep) -> VarianceUnit {
    match equal {
        Lockstep::Spp => VarianceUnit::Relative,
        Lockstep::Rays => VarianceUnit::PerRay,
        Lockstep::CpuSeconds => VarianceUnit::PerSecond,
    }
}

fn per(equal: Lockstep) -> &'static str {
    match equal {
        Lockstep::Spp => "per sample",
        Lockstep::Rays => "per ray",
        Lockstep::CpuSeconds => "per second",
    }
}

fn same_pixels(a: &Frame, b: &Frame) -> bool {
    let resolution = |frame: &Frame| frame.request().settings.image.resolution;
    a.bounds() == b.bounds() && resolution(a) == resolution(b)
}

/// The part of `bounds` that is in `part`; `None` if there is none.
fn inside(part: PixelRect, bounds: PixelRect) -> Option<PixelRect> {
    let min = [0, 1].map(|i| part.min[i].max(bounds.min[i]));
    let max = [0, 1].map(|i| part.max[i].min(bounds.max[i]));
    (min[0] < max[0] && min[1] < max[1]).then_some(PixelRect { min, max })
}

/// The same pixels counted from the first one of `bounds`.
fn relative(part: PixelRect, bounds: PixelRect) -> PixelRect {
    let shift = |at: [u32; 2]| [0, 1].map(|i| at[i] - bounds.min[i]);
    PixelRect { min: shift(part.min), max: shift(part.max) }
}

/// One of the two pictures, as far as noise is concerned.
struct Side {
    mean: Vec<f32>,
    variance: Vec<f32>,
    cost: f64,
}

impl Side {
    fn of(frame: &Frame, unit: VarianceUnit) -> Self {
        let area = frame.bounds().area();
        let mut data = vec![0.0; variance::CHANNELS.len() * area];
        frame.resolve(&variance::CHANNELS, &mut data);
        let mean = (0..area).map(|i| luminance([0, 1, 2].map(|c| f64::from(data[c * area + i]))) as f32).collect();
        Self { mean, variance: data.split_off(3 * area), cost: variance::cost(unit, frame) }
    }

    /// Without the pixels that one of the pictures cannot sample.
    fn without(mut self, planes: &Planes) -> Self {
        for (variance, shown) in self.variance.iter_mut().zip(planes.channels().flatten()) {
            if *shown == crate::picture::planes::BLIND {
                *variance = f32::NAN;
            }
        }
        self
    }

    fn noise(&self) -> Noise<'_> {
        Noise { mean: &self.mean, variance: &self.variance, cost: self.cost }
    }
}

fn difference(frame: &Frame, [a, b]: &[Side; 2]) -> Planes {
    let data = a.mean.iter().zip(&b.mean).map(|(a, b)| if *a == 0.0 && *b == 0.0 { f32::NAN } else { a - b });
    Planes::new(Versus::Difference, frame.bounds(), frame.request().settings.image.resolution, data.collect())
}

/// log2 of the ratio of the variances of each block.
fn variances(frame: &Frame, [a, b]: &[Side; 2]) -> Planes {
    let bounds = frame.bounds();
    let [width, height] = [bounds.width() as usize, bounds.height() as usize];
    let mut data = vec![f32::NAN; bounds.area()];
    for top in (0..height).step_by(BLOCK) {
        for left in (0..width).step_by(BLOCK) {
            let rows = top..(top + BLOCK).min(height);
            let row = |y: usize| y * width + left..y * width + (left + BLOCK).min(width);
            let sum = |side: &Side| {
                let all = rows.clone().flat_map(|y| &side.variance[row(y)]).filter(|v| v.is_finite());
                side.cost * all.map(|v| f64::from(*v)).sum::<f64>()
            };
            // Of two that are 0 nothing is known; beyond a factor of a million the colour is the same.
            let log = (sum(a) / sum(b)).log2().clamp(-20.0, 20.0) as f32;
            for y in rows.clone() {
                data[row(y)].fill(log);
            }
        }
    }
    Planes::new(Versus::Variances, bounds, frame.request().settings.image.resolution, data)
}

fn outline(ui: &Ui, rect: Rect, geometry: &Geometry, part: PixelRect) {
    let [min, max] = [part.min, part.max].map(|at| geometry.to_screen(at.map(|v| v as f32)));
    let painter = ui.painter_at(rect);
    for (width, ink) in [(4.0, Color32::from_black_alpha(150)), (1.5, Color32::WHITE)] {
        painter.rect_stroke(Rect::from_min_max(min, max), 0.0, Stroke::new(width, ink), StrokeKind::Middle);
    }
}
