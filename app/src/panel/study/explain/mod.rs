//! What happens at one pixel: exact numbers, directions, samples.

mod axis;
mod circle;
mod curves;
mod dome;
mod dome_ui;
mod fireflies;
mod fireflies_ui;
mod first;
mod number;
mod numbers;
mod over_c;
mod over_c_ui;
mod part_over_c;
mod place;
mod sample;
mod samples;
mod shown;
mod sketch;
mod slice;
mod slice_plot;
mod tables;
mod trace;

use eframe::egui::{Context, Key, Modifiers, Ui};
use mislab_renderer::State;

use self::dome_ui::{Hemisphere, dome_ui};
use self::fireflies::FirefliesJob;
use self::fireflies_ui::{Chosen, fireflies_ui};
use self::first::FirstPixel;
use self::numbers::{Numbers, numbers_ui};
use self::over_c::OverCJob;
use self::over_c_ui::{Over, OverChoice, choice_ui, over_c_ui, part_over_c_ui};
use self::part_over_c::PartsJob;
use self::place::{Facts, Place};
use self::sample::{Sample, sample_ui};
use self::samples::SamplesJob;
use self::shown::Shown;
use self::sketch::sketch_ui;
use self::slice::{Slice, slice_ui};
use self::tables::TablesJob;
use super::Subject;
use crate::panel::widgets::{caption, segmented, title_with_note};
use crate::state::command::Command;

/// How long the mouse rests until more than the coarsest numbers are worked out, in seconds.
const REST: f32 = 0.2;

/// What of the pixel is looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Tab {
    #[default]
    Numbers,
    Slice,
    Dome,
    OverC,
    Sample,
    Fireflies,
    Sketch,
}

impl Tab {
    const ALL: [Self; 7] =
        [Self::Numbers, Self::Slice, Self::Dome, Self::OverC, Self::Sample, Self::Fireflies, Self::Sketch];

    fn name(self) -> &'static str {
        match self {
            Self::Numbers => "Numbers",
            Self::Slice => "Slice",
            Self::Dome => "Sphere",
            Self::OverC => "Best c",
            Self::Sample => "Sample",
            Self::Fireflies => "Fireflies",
            Self::Sketch => "Sketch",
        }
    }

    fn hint(self) -> &'static str {
        match self {
            Self::Numbers => "Exact mean and standard deviation of every strategy, beside what was measured.",
            Self::Slice => "f, the densities and the weights along a great circle of directions.",
            Self::Dome => "The same over all directions of the hemisphere, with lights and samples.",
            Self::OverC => {
                "The exact variance of the one-sample model over c, and where it is least: of the pixel, of its square, of the picture."
            }
            Self::Sample => "One sample after the other: the formula with its numbers.",
            Self::Fireflies => "The samples of the whole picture that outshine all others of their pixel.",
            Self::Sketch => "Eye ray, plate, lobe, lights and the last rays in the plane of incidence.",
        }
    }
}

/// What is kept of it while it is open and after.
#[derive(Default)]
pub struct Explain {
    pinned: Option<[u32; 2]>,
    /// The last one under the mouse: it stays when the mouse comes here.
    last: Option<[u32; 2]>,
    /// The one that is shown, where no mouse is on it.
    marked: Option<[u32; 2]>,
    first: FirstPixel,
    tab: Tab,
    tables: TablesJob,
    numbers: Numbers,
    slice: Slice,
    dome: Hemisphere,
    samples: SamplesJob,
    over_c: OverCJob,
    over: OverChoice,
    parts: PartsJob,
    sample: Sample,
    fireflies: FirefliesJob,
    /// Pixels of the fireflies on screen.
    listed: Vec<[u32; 2]>,
}

impl Explain {
    /// The pixel that is to be marked in the pictures.
    pub fn marked(&self) -> Option<[u32; 2]> {
        self.marked
    }

    /// The pixels that are listed, to be marked in the pictures as well.
    pub fn listed(&self) -> &[[u32; 2]] {
        &self.listed
    }

    /// Stays with that pixel; `None` follows the mouse again.
    pub fn pin(&mut self, pixel: Option<[u32; 2]>) {
        self.pinned = pixel;
    }

    /// Lets the pinned pixel go. False if there is none.
    pub fn step_back(&mut self) -> bool {
        let pinned = self.pinned.take();
        self.last = pinned.or(self.last);
        pinned.is_some()
    }

    /// Not on screen: nothing is worked out for it.
    pub fn rest(&mut self) {
        self.first.rest();
        self.tables.rest();
        self.numbers.rest();
        self.slice.rest();
        self.dome.rest();
        self.samples.rest();
        self.over_c.rest();
        self.parts.rest();
        self.fireflies.rest();
    }

    /// The pixel that it is about: the one that is pinned or under the mouse, or before there is any, a highlight.
    fn pixel(&mut self, ctx: &Context, subject: &Subject<'_>) -> Option<[u32; 2]> {
        self.last = subject.cursor.or(self.last);
        self.pinned.or(self.last).or_else(|| self.first.of(ctx, subject.document))
    }
}

/// Draws it over all that is left of `ui`.
pub fn explain_ui(ui: &mut Ui, study: &mut Explain, subject: &Subject<'_>, out: &mut Vec<Command>) {
    step(ui.ctx(), study, subject, out);
    let frame = subject.pictures[subject.document.active_index()].frame();
    let place = study.pixel(ui.ctx(), subject).zip(frame.as_ref()).and_then(|(pixel, frame)| Place::of(frame, pixel));
    let moving = study.pinned.is_none() && is_moving(ui.ctx());
    let tables = place.as_ref().and_then(|place| study.tables.of(ui.ctx(), place, moving));
    let shown = tables.as_ref().map(|tables| tables.place.pixel);
    let marked = shown.filter(|_| study.pinned.is_some() || subject.cursor.is_none());
    mark_again(ui.ctx(), &mut study.marked, marked);
    // What is shown is said, also while another pixel is being worked out.
    let name = tables.as_ref().map_or_else(
        || "A pixel".to_owned(),
        |tables| {
            let [x, y] = tables.place.pixel;
            format!("Pixel x {x}, y {y}")
        },
    );
    let notes = if study.pinned.is_some() {
        ["pinned: arrow keys move, Escape lets go", "pinned: arrows, Escape"]
    } else {
        ["a click in the picture pins, arrow keys move", "a click pins it"]
    };
    title_with_note(ui, &name, &notes);
    let (Some(place), Some(tables), Some(frame)) = (place, tables, frame) else {
        mark_again(ui.ctx(), &mut study.listed, Vec::new());
        let file = subject.document.active().is_file();
        ui.label(if file {
            "This picture is from a file: how it was made is not known."
        } else {
            "Point at a pixel of the picture. A click pins it."
        });
        return;
    };
    let choices = Tab::ALL.map(|tab| (tab, tab.name()));
    let hint = |ui: &mut Ui, tab: Tab| drop(ui.label(tab.hint()));
    if let Some(tab) = segmented(ui, "Explain", study.tab, &choices, true, &hint) {
        study.tab = tab;
    }
    if study.tab == Tab::Fireflies {
        let live = &subject.pictures[subject.document.active_index()];
        let found = study.fireflies.of(ui.ctx(), &frame, live.status().is_none_or(|status| is_still(status.state)));
        let listed = found.iter().flat_map(|found| &found.fireflies.outliers).map(|outlier| outlier.pixel).collect();
        mark_again(ui.ctx(), &mut study.listed, listed);
        let exact = tables.place.is_same(&place).then_some(tables.truth);
        let chosen = Chosen { pixel: study.pinned, exact };
        fireflies_ui(ui, &frame, found.as_deref(), &chosen, out);
        return;
    }
    mark_again(ui.ctx(), &mut study.listed, Vec::new());
    let place = if tables.place.is_same(&place) { &place } else { &tables.place };
    let surface = match &tables.facts {
        Facts::Surface(surface) if study.tab != Tab::Numbers => surface,
        Facts::Surface(_) | Facts::Nothing | Facts::Light => {
            numbers_ui(ui, &mut study.numbers, &tables, place, subject);
            return;
        }
    };
    let samples = study.samples.of(ui.ctx(), place, frame.spp());
    let estimator = subject.document.active().estimator;
    let shown = Shown { place, surface, estimator, samples: samples.as_deref(), document: subject.document };
    match study.tab {
        Tab::Numbers | Tab::Fireflies => {}
        Tab::Slice => slice_ui(ui, &mut study.slice, &shown, out),
        Tab::Dome => dome_ui(ui, &mut study.dome, &shown),
        Tab::OverC => match choice_ui(ui, &mut study.over) {
            Over::Pixel => match study.over_c.of(ui.ctx(), &tables, estimator.heuristic) {
                Some(over_c) => over_c_ui(ui, &over_c, &shown, subject, out),
                None => drop(caption(ui, "Working \u{2026}")),
            },
            Over::Square | Over::Picture => match study.parts.of(ui.ctx(), &frame) {
                Some(parts) => out.extend(part_over_c_ui(ui, &mut study.over, &parts, &shown, subject)),
                None => drop(caption(ui, "Working \u{2026}")),
            },
        },
        Tab::Sample => sample_ui(ui, &mut study.sample, &shown, tables.truth),
        Tab::Sketch => sketch_ui(ui, &shown),
    }
}

/// What is to be marked in the pictures; those of this pass have been drawn.
fn mark_again<T: PartialEq>(ctx: &Context, marks: &mut T, new: T) {
    if *marks != new {
        *marks = new;
        ctx.request_repaint_after(std::time::Duration::from_millis(1));
    }
}

/// Whether a picture gets no samples for now.
fn is_still(state: State) -> bool {
    match state {
        State::Idle | State::Paused | State::Finished | State::Failed => true,
        State::Building | State::Rendering => false,
    }
}

/// Whether the mouse was moved just now. Asks for a pass once it may have come to rest.
fn is_moving(ctx: &Context) -> bool {
    let still = ctx.input(|i| i.pointer.time_since_last_movement());
    let moving = still < REST;
    if moving {
        ctx.request_repaint_after(std::time::Duration::from_secs_f32(REST));
    }
    moving
}

/// Arrow keys move the pixel that is pinned, or pin the one that is shown beside it; with Shift by ten. What the keyboard is on has them first.
fn step(ctx: &Context, study: &Explain, subject: &Subject<'_>, out: &mut Vec<Command>) {
    let shown = study.pinned.or(study.marked);
    let Some(pixel) = shown.filter(|_| ctx.memory(|m| m.focused().is_none())) else { return };
    let mut moved = pixel.map(i64::from);
    ctx.input_mut(|input| {
        for (modifiers, by) in [(Modifiers::SHIFT, 10), (Modifiers::NONE, 1)] {
            for (key, [x, y]) in [
                (Key::ArrowLeft, [-1, 0]),
                (Key::ArrowRight, [1, 0]),
                (Key::ArrowUp, [0, -1]),
                (Key::ArrowDown, [0, 1]),
            ] {
                let times = input.count_and_consume_key(modifiers, key) as i64;
                moved = [moved[0] + times * by * x, moved[1] + times * by * y];
            }
        }
    });
    let size = subject.document.image.resolution;
    let moved = [0, 1].map(|i| moved[i].clamp(0, i64::from(size[i]) - 1) as u32);
    if moved != pixel {
        out.push(Command::Pin(Some(moved)));
    }
}
