//! Small pictures of all strategies under all heuristics, or over c, each with its error.

use eframe::egui::{Align2, Color32, Context, Rect, TextStyle, Ui, UiBuilder, pos2, vec2};
use mislab_renderer::kernel::bsdf::MIRROR_ALPHA;
use mislab_renderer::metrics::{Errors, Reference, Region};
use mislab_renderer::{Estimator, Frame, Layer, Lockstep, Pace, Request, Scene, Strategy};

use super::Subject;
use super::cells::{Axes, Cell, REFERENCE_SPP, requests};
use super::tiles::{Tiles, Wanted, caption_that_fits, words};
use crate::look::theme::{GRID, Inks};
use crate::panel::hint::Hint as _;
use crate::panel::number::two_digits;
use crate::panel::widgets::segmented;
use crate::picture::dark::SharedDarkSpots;
use crate::picture::engine::Engine;
use crate::picture::live::LivePicture;
use crate::picture::planes::Planes;
use crate::picture::sheet::Recorder;
use crate::state::command::Command;
use crate::state::edit::Edit;
use crate::state::placement::Placement;
use crate::state::study::Study;

/// What is kept of it while it is open and after.
#[derive(Default)]
pub struct Grid {
    axes: Axes,
    shown: Option<Pictures>,
}

/// The cells' pictures.
struct Pictures {
    cells: Vec<Cell>,
    requests: (Vec<Request>, [Request; 2]),
    /// What renders the cells and the reference; not while the grid is closed.
    engines: Option<Engines>,
    tiles: Tiles,
    /// What of them is hatched.
    dark: SharedDarkSpots,
    /// relMSE of each cell as far as its picture is.
    errors: Vec<Option<f64>>,
    reference: Option<Halves>,
    /// Samples per pixel of the reference so far.
    reference_spp: u32,
    /// All cells and the reference are finished.
    complete: bool,
}

struct Engines {
    cells: Engine,
    reference: Engine,
}

/// A converged picture in two halves: red, green, blue of each.
type Halves = [Vec<Vec<f64>>; 2];

impl Grid {
    /// Not on screen: nothing is rendered for it.
    pub fn rest(&mut self) {
        if let Some(shown) = &mut self.shown {
            shown.engines = None;
        }
    }

    /// One picture has the whole place; now all have theirs again. False if none had.
    pub fn step_back(&mut self) -> bool {
        self.shown.as_mut().is_some_and(|shown| shown.tiles.enlarged.take().is_some())
    }
}

/// Draws it over all that is left of `ui`.
pub fn grid_ui(ui: &mut Ui, study: &mut Grid, subject: &Subject<'_>, out: &mut Vec<Command>) {
    let cells = study.axes.cells(&subject.document.active().estimator);
    if study.shown.as_ref().is_none_or(|shown| shown.tiles.count() != cells.len()) {
        study.shown = Some(Pictures::new(cells.len(), subject));
    }
    let Some(shown) = &mut study.shown else { return };
    shown.follow(ui.ctx(), cells, subject);
    match shown.tiles.enlarged {
        Some(index) => shown.enlarged_ui(ui, index, subject, out),
        None => {
            if let Some(axes) = Recorder::on_screen_only(ui, |ui| axes_ui(ui, study.axes)) {
                study.axes = axes;
                study.shown = None;
            } else {
                shown.all_ui(ui, study.axes, subject);
            }
        }
    }
}

fn axes_ui(ui: &mut Ui, axes: Axes) -> Option<Axes> {
    let choices = [(Axes::Heuristics, "Strategy \u{d7} heuristic"), (Axes::LightProb, "c \u{d7} one-sample weights")];
    segmented(ui, "Grid of", axes, &choices, true, &|ui, axes| {
        ui.label(match axes {
            Axes::Heuristics => "All strategies; those with weights under each heuristic.",
            Axes::LightProb => "MIS, one: from never to always the light technique, with c in the weights and without.",
        });
    })
}

impl Pictures {
    fn new(count: usize, subject: &Subject<'_>) -> Self {
        Self {
            cells: Vec::new(),
            requests: requests(subject.document, &[]),
            engines: None,
            // The document's zoom is in pixels of a larger picture.
            tiles: Tiles::new(count, subject.pipeline, Placement::Fit),
            dark: SharedDarkSpots::default(),
            errors: vec![None; count],
            reference: None,
            reference_spp: 0,
            complete: false,
        }
    }

    /// Hands over what is to be rendered, and takes what has been.
    fn follow(&mut self, ctx: &Context, cells: Vec<Cell>, subject: &Subject<'_>) {
        self.tiles.match_device(subject.pipeline);
        let asked = requests(subject.document, &cells);
        if asked != self.requests {
            self.errors.fill(None);
            (self.reference, self.complete) = (None, false);
            (self.cells, self.requests) = (cells, asked);
        }
        if self.complete {
            return;
        }
        let Engines { cells, reference } = self.engines.get_or_insert_with(|| Engines {
            cells: Engine::new(ctx, subject.threads),
            reference: Engine::new(ctx, subject.threads),
        });
        submit(cells, &self.requests.0);
        cells.keep_abreast(Some(Lockstep::Rays));
        cells.set_pace(subject.pace);
        submit(reference, &self.requests.1);
        reference.set_pace(if subject.pace == Pace::Paused { Pace::Paused } else { Pace::Full });
        self.reference_spp = reference.pictures().iter().filter_map(LivePicture::status).map(|status| status.spp).sum();
        if self.reference.is_none() && reference.pictures().iter().all(is_finished) {
            self.reference = halves(reference);
            // Those that were there before it are measured now.
            self.tiles.retake();
        }
        cells.hold();
        let mut wanted = Vec::new();
        for live in cells.pictures() {
            wanted.push(live.current_frame().map(|frame| {
                let dark = self.dark.of(ctx, &frame, Layer::Picture);
                Wanted { frame, layer: Layer::Picture, dark, behind: false }
            }));
        }
        let fresh = self.tiles.refresh(ctx, &wanted, 3);
        let current = fresh.is_empty() && wanted.iter().all(|wanted| wanted.as_ref().is_some_and(|w| w.dark.is_some()));
        for index in fresh {
            // A picture with its error has its hatchings.
            let frame = wanted[index].as_ref().filter(|wanted| wanted.dark.is_some()).map(|wanted| &wanted.frame);
            self.errors[index] = frame.zip(self.reference.as_ref()).and_then(|(frame, r)| rel_mse(frame, r));
        }
        drop(wanted);
        self.complete = current && self.reference.is_some() && cells.pictures().iter().all(is_finished);
        cells.release(ctx);
        if self.complete {
            self.engines = None;
        }
    }

    fn enlarged_ui(&mut self, ui: &mut Ui, index: usize, subject: &Subject<'_>, out: &mut Vec<Command>) {
        let Some(cell) = self.cells.get(index).cloned() else { return };
        ui.horizontal(|ui| {
            Recorder::on_screen_only(ui, |ui| {
                if ui.button("Back").hint("All pictures again (Escape, or a click on the picture).").clicked() {
                    self.tiles.enlarged = None;
                }
                let hint = "Strategy, heuristic, c and weights of this cell for the active picture, which is shown.";
                if ui.button("Use these settings").hint(hint).clicked() {
                    out.push(Edit::SetEstimator(cell.estimator).into());
                    out.push(Command::ToggleStudy(Study::Grid));
                }
            });
            ui.colored_label(Inks::of(ui.visuals()).strategy(cell.estimator.strategy), &cell.name);
            ui.label(self.error_text(index));
        });
        let place = ui.available_rect_before_wrap();
        self.tiles.tile_ui(ui, index, place, &subject.document.view, &cell.name);
    }

    fn all_ui(&mut self, ui: &mut Ui, axes: Axes, subject: &Subject<'_>) {
        ui.add_space(GRID);
        let area = ui.available_rect_before_wrap();
        let note = 3.0 * (ui.text_style_height(&TextStyle::Small) + GRID);
        let (pictures, below) = area.split_top_bottom_at_y(area.bottom() - note);
        let line = ui.text_style_height(&TextStyle::Small) + GRID;
        let font = TextStyle::Small.resolve(ui.style());
        let width =
            |text: &&str| ui.painter().layout_no_wrap((*text).to_owned(), font.clone(), Color32::WHITE).size().x;
        let head = axes.rows().iter().map(width).fold(0.0, f32::max) + 2.0 * GRID;
        let (heads, pictures) = pictures.split_left_right_at_x(pictures.left() + head);
        let places = places(pictures, axes.size(), Placement::Fit.aspect(self.resolution()), line);
        for (row, name) in axes.rows().iter().enumerate() {
            let place = Rect::from_x_y_ranges(heads.x_range(), places([0, row]).y_range());
            words(ui, place, Align2::LEFT_CENTER, name, TextStyle::Small, ui.visuals().text_color());
        }
        for (index, cell) in self.cells.clone().iter().enumerate() {
            let tile = places(cell.at);
            let ink = Inks::of(ui.visuals()).strategy(cell.estimator.strategy);
            let over = Rect::from_min_max(pos2(tile.left(), tile.top() - line), tile.right_top());
            let under = Rect::from_min_max(tile.left_bottom(), pos2(tile.right(), tile.bottom() + line));
            words(ui, over, Align2::LEFT_CENTER, &cell.short, TextStyle::Small, ink);
            let name = format!("Enlarge: {}", cell.name);
            self.tiles.tile_ui(ui, index, tile, &subject.document.view, &name).hint("A click enlarges it.");
            let (text, color) = self.verdict(ui, index, tile.width());
            words(ui, under, Align2::LEFT_CENTER, &text, TextStyle::Small, color);
        }
        ui.scope_builder(UiBuilder::new().id_salt("about").max_rect(below), |ui| {
            let [all, few] = self.about();
            caption_that_fits(ui, &all, &few);
        });
        ui.advance_cursor_after_rect(area);
    }

    /// The error under a cell, in as many words as fit; in red where no number of samples would help.
    fn verdict(&self, ui: &Ui, index: usize, width: f32) -> (String, Color32) {
        let estimator = &self.cells[index].estimator;
        let scene = &self.requests.1[0].scene;
        let biased = estimator.bias().is_some() || (never_bsdf(estimator) && has_mirror(scene));
        let text = self.error_text(index);
        let number = text.trim_start_matches("relMSE ");
        let (choices, color) = if biased {
            let choices = vec![format!("{text}, biased"), format!("biased, {number}"), "biased".to_owned()];
            (choices, Inks::of(ui.visuals()).wrong)
        } else {
            (vec![text.clone(), number.to_owned()], ui.visuals().text_color())
        };
        let font = TextStyle::Small.resolve(ui.style());
        let fits = |text: &&String| ui.painter().layout_no_wrap((*text).clone(), font.clone(), color).size().x <= width;
        let shown = choices.iter().find(fits).or(choices.last()).cloned().unwrap_or_default();
        (shown, color)
    }

    fn error_text(&self, index: usize) -> String {
        match self.errors[index] {
            Some(error) => format!("relMSE {}", two_digits(error)),
            None => "relMSE \u{2026}".to_owned(),
        }
    }

    fn resolution(&self) -> [u32; 2] {
        self.requests.1[0].settings.image.resolution
    }

    /// What is equal in all cells, and what the numbers are.
    fn about(&self) -> [String; 2] {
        let [width, height] = self.resolution();
        let rays = self.requests.0.iter().filter_map(|request| {
            let rays = request.settings.estimator.strategy.rays_per_sample();
            Some(request.settings.sampling.target()? * rays)
        });
        let (least, most) = rays.fold((u32::MAX, 0), |(least, most), n| (least.min(n), most.max(n)));
        let rays = if least == most { format!("{most} rays") } else { format!("{least} to {most} rays") };
        let seed = self.requests.0.first().map_or(0, |request| request.settings.sampling.seed);
        let most_spp = 2 * REFERENCE_SPP;
        let reference = match &self.reference {
            Some(_) => format!("a reference of {most_spp} spp"),
            None => format!("a reference, so far {} of {most_spp} spp", self.reference_spp),
        };
        let all = format!(
            "Each cell: {rays} a pixel, seed {seed}, {width} \u{d7} {height} pixels. relMSE of the whole picture against \
             {reference}. One picture each: small differences are chance."
        );
        [all, format!("Each cell: {rays} a pixel. relMSE against {reference}.")]
    }
}

/// It draws no BSDF samples.
fn never_bsdf(estimator: &Estimator) -> bool {
    match estimator.strategy {
        Strategy::Light => true,
        Strategy::Mis => estimator.light_prob >= 1.0,
        Strategy::Bsdf | Strategy::MisAll => false,
    }
}

/// Something in it reflects into one direction alone, which no light sample hits.
fn has_mirror(scene: &Scene) -> bool {
    let mirrors =
        scene.materials.iter().map(|material| material.bsdf.alpha().is_some_and(|alpha| alpha < MIRROR_ALPHA));
    let mirrors: Vec<bool> = mirrors.collect();
    scene.shapes.iter().any(|shape| shape.material.is_some_and(|m| mirrors.get(m) == Some(&true)))
}

/// As many pictures as requests, each about its own.
fn submit(engine: &mut Engine, requests: &[Request]) {
    let wanted: Vec<_> = requests.iter().cloned().map(Some).collect();
    engine.match_requests(&wanted);
    for (live, request) in engine.pictures_mut().iter_mut().zip(requests) {
        live.submit(request.clone());
    }
}

fn is_finished(live: &LivePicture) -> bool {
    let target = |frame: &Frame| frame.request().settings.sampling.target();
    live.current_frame().is_some_and(|frame| Some(frame.spp()) == target(&frame))
}

/// The reference, once both halves are finished.
fn halves(engine: &Engine) -> Option<Halves> {
    let halves: Vec<_> = engine
        .pictures()
        .iter()
        .filter_map(|live| {
            let planes = Planes::from_frame(&*live.current_frame()?, Layer::Picture);
            Some(planes.channels().map(|plane| plane.iter().map(|&v| f64::from(v)).collect()).collect())
        })
        .collect();
    halves.try_into().ok()
}

fn rel_mse(frame: &Frame, reference: &Halves) -> Option<f64> {
    let planes = Planes::from_frame(frame, Layer::Picture);
    let picture: Vec<&[f32]> = planes.channels().collect();
    let [first, second] = reference.each_ref().map(|half| half.iter().map(Vec::as_slice).collect::<Vec<_>>());
    Errors::of(&picture, &Reference::Halves([&first, &second]), &Region::All).rel_mse()
}

/// The place of the picture in each column and row, as large as they fit with a line over and one under each.
fn places(area: Rect, [columns, rows]: [usize; 2], aspect: f32, line: f32) -> impl Fn([usize; 2]) -> Rect {
    let gap = 2.0 * GRID;
    let across = (area.width() - (columns - 1) as f32 * gap) / columns as f32 / aspect;
    let down = (area.height() - (rows - 1) as f32 * gap) / rows as f32 - 2.0 * line;
    let height = across.min(down).max(1.0);
    let step = vec2(aspect * height + gap, height + 2.0 * line + gap);
    move |[column, row]| {
        let corner = area.min + vec2(column as f32 * step.x, row as f32 * step.y + line);
        Rect::from_min_size(corner, vec2(aspect * height, height))
    }
}
