//! The status bar: how far, how fast, and everything that must never be hidden.

use std::num::NonZeroU32;

use eframe::egui::{self, Align2, Color32, ProgressBar, RichText, TextStyle, Ui};
use mislab_renderer::{Frame, Sampling, State, Status, simd_level_name};

use crate::look::layer::LayerLook;
use crate::look::theme::{GRID, Inks};
use crate::panel::hint::Hint as _;
use crate::panel::number::{seconds, si, three_digits};
use crate::panel::table_job::Progress;
use crate::panel::widgets::cell;
use crate::state::command::Command;
use crate::state::document::Document;

/// What is being done about a picture.
pub struct Work<'a> {
    /// Its newest frame, if that was made with the current settings.
    pub frame: Option<&'a Frame>,
    /// What the renderer says.
    pub status: &'a Status,
    /// Worker threads.
    pub threads: usize,
    /// How far the tutorial's table is, while one is being made.
    pub table: Option<Progress>,
}

/// One number or word of the bar.
struct Field {
    text: String,
    /// As wide as it gets.
    template: String,
    hint: String,
    ink: Option<Color32>,
    /// In a narrow window the highest goes first.
    rank: u8,
    /// At the right end.
    right: bool,
}

/// Width of the bar of progress.
const PROGRESS: f32 = 120.0;

/// The bar.
pub fn status_ui(ui: &mut Ui, work: &Work<'_>, document: &Document, out: &mut Vec<Command>) {
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        let save = ui.button("Save EXR").hint("Writes the picture with all layers and settings. (Ctrl+S)");
        if save.clicked() {
            out.push(Command::Save);
        }
        ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
            if let Some(progress) = &work.table {
                table_ui(ui, progress, out);
                return;
            }
            let mut fields = fields(ui, work, document);
            fit(ui, &mut fields);
            let (right, left): (Vec<&Field>, Vec<&Field>) = fields.iter().partition(|field| field.right);
            for (index, field) in left.into_iter().enumerate() {
                field_ui(ui, field, Align2::RIGHT_CENTER);
                if index == 0 && !document.active().is_file() {
                    let spp = work.frame.map_or(0, Frame::spp);
                    progress_ui(ui, spp, sampling(document).spp, work.status);
                }
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                for field in right {
                    field_ui(ui, field, Align2::LEFT_CENTER);
                }
            });
        });
    });
}

/// The samples of the picture that controls are about.
fn sampling(document: &Document) -> Sampling {
    document.settings(document.active()).sampling
}

impl Field {
    fn new(text: String, template: &str, rank: u8, hint: &str) -> Self {
        Self { text, template: template.into(), hint: hint.into(), ink: None, rank, right: false }
    }

    fn right(text: String, template: &str, rank: u8, hint: &str) -> Self {
        Self { right: true, ..Self::new(text, template, rank, hint) }
    }
}

/// Everything there is to say, from left to right; those at the right end from right to left.
fn fields(ui: &Ui, work: &Work<'_>, document: &Document) -> Vec<Field> {
    let made = !document.active().is_file();
    let mut fields = if made {
        making_fields(ui, work, document)
    } else {
        vec![Field::new("Picture from a file".into(), "", 0, "What made it, and how long that took, is not known.")]
    };
    let view = &document.view;
    if made {
        let text = format!("{} \u{d7} {}", simd_level_name(), work.threads);
        fields.push(Field::right(text, "", 8, "Vector unit and worker threads."));
    }
    if LayerLook::of(document.active().layer).is_colour() {
        let hint = "How numbers become light on the screen.";
        fields.push(Field::right(view.tone_map.name().to_owned(), "Linear", 3, hint));
        let exposure = "Exposure in stops: the picture times 2^EV.";
        fields.push(Field::right(format!("EV {:+.1}", view.exposure_ev), "EV +88.8", 2, exposure));
    } else {
        fields.push(Field::right("false colour".into(), "", 3, "Colours stand for numbers: see the colour bar."));
    }
    if made {
        let seed = "Where all random numbers start: the same seed gives the same noise.";
        fields.push(Field::right(format!("seed {}", sampling(document).seed), "", 6, seed));
    }
    // Last, where nothing stands that it would push.
    if view.offset != 0.0 && LayerLook::of(document.active().layer).is_colour() {
        fields.push(Field::right(format!("offset {:+.2}", view.offset), "", 2, "Added after exposure."));
    }
    fields
}

/// How far a picture that is made here is, and what is wrong with it.
fn making_fields(ui: &Ui, work: &Work<'_>, document: &Document) -> Vec<Field> {
    let Work { frame, status, .. } = *work;
    let sampling = sampling(document);
    let spp = frame.map_or(0, Frame::spp);
    let stats = frame.map(Frame::stats);
    let target = sampling.spp.map_or("\u{221e}".into(), |n| n.to_string());
    // As wide as the target, or as an hour of endless passes.
    let widest = "8".repeat(if sampling.spp.is_some() { target.len() } else { 6 });
    let wrong = Inks::of(ui.visuals()).wrong;
    let mut fields = vec![Field::new(
        format!("{spp} / {target} spp"),
        &format!("{widest} / {target} spp"),
        0,
        "Samples per pixel so far, and where the picture stops. The tutorial: xsamples times ysamples.",
    )];
    let invalid = stats.map_or(0, |s| s.invalid_samples);
    if invalid > 0 {
        let hint = "Samples that were not a finite number. They were left out of the picture.";
        let text = format!("{} invalid samples", si(invalid as f64));
        fields.push(Field { ink: Some(wrong), ..Field::new(text, "", 1, hint) });
    }
    if status.worker_panics > 0 {
        let text = format!("{} passes redone", status.worker_panics);
        let why = status.error.as_deref().unwrap_or_default();
        fields.push(Field { ink: Some(wrong), ..Field::new(text, "", 1, why) });
    }
    fields.extend([Field::new(
        format!("{} paths", si(stats.map_or(0.0, |s| s.paths as f64))),
        "88.8 M paths",
        5,
        "Paths of the whole picture: pixels times samples per pixel, and twice as many in strategy 3.",
    )]);
    // Of several pictures each has its processor time in its caption; the seconds that have gone by are those of all.
    if document.slots().len() > 1 {
        return fields;
    }
    fields.extend([
        Field::new(
            format!("{} Mpaths/s", three_digits(stats.map_or(0.0, |s| s.mpaths_per_second()))),
            "8888 Mpaths/s",
            7,
            "Paths in a second, in millions. A path has two segments; strategy 3 draws two second ones, which are two paths.",
        ),
        Field::new(
            seconds(stats.map_or(0.0, |s| s.render_seconds)),
            "88:88 min",
            4,
            "Seconds spent rendering. The tutorial's Table 1: Time (secs).",
        ),
    ]);
    fields
}

/// Drops what the bar has no room for, the least important first.
fn fit(ui: &Ui, fields: &mut Vec<Field>) {
    let font = TextStyle::Body.resolve(ui.style());
    let measure = |s: &str| ui.painter().layout_no_wrap(s.to_owned(), font.clone(), Color32::WHITE).size().x;
    let gap = ui.spacing().item_spacing.x;
    let width = |field: &Field| measure(&field.text).max(measure(&field.template)) + gap;
    let room = ui.available_width() - PROGRESS - gap;
    while fields.iter().map(width).sum::<f32>() > room {
        let Some(last) = fields.iter().map(|field| field.rank).max().filter(|rank| *rank > 0) else { return };
        let Some(index) = fields.iter().rposition(|field| field.rank == last) else { return };
        fields.remove(index);
    }
}

fn field_ui(ui: &mut Ui, field: &Field, align: Align2) {
    let font = TextStyle::Body.resolve(ui.style());
    cell(ui, &field.text, &field.template, font, field.ink, align).hint(field.hint.as_str());
}

/// The table that is being made, wherever its window is.
pub fn table_ui(ui: &mut Ui, progress: &Progress, out: &mut Vec<Command>) {
    ui.label("Table");
    let stop = ui.button("Cancel").accessible_name("Stop the table");
    if stop.hint("Stops the table; the live picture goes on.").clicked() {
        out.push(Command::StopTable);
    }
    let time = seconds(progress.elapsed.as_secs_f64());
    let font = TextStyle::Body.resolve(ui.style());
    cell(ui, &time, "88:88 min", font, None, Align2::RIGHT_CENTER);
    let bar = ProgressBar::new(progress.fraction).desired_width((ui.available_width() - 2.0 * GRID).min(480.0));
    let text = RichText::new(&progress.step).small().color(ui.visuals().text_color());
    let fill = ui.visuals().text_color().gamma_multiply(0.35);
    let height = 0.8 * ui.spacing().interact_size.y;
    let bar = bar.desired_height(height).fill(fill).corner_radius(2.0).text(text);
    ui.add(bar)
        .accessible_name("Progress of the table")
        .hint("The live picture holds meanwhile: it would spoil the times.");
}

fn progress_ui(ui: &mut Ui, spp: u32, target: Option<NonZeroU32>, status: &Status) {
    let text = match status.state {
        State::Paused => "paused",
        State::Building => "building",
        State::Failed => "failed",
        State::Idle | State::Rendering | State::Finished => "",
    };
    let fraction = match target {
        Some(target) => spp as f32 / target.get() as f32,
        // Nothing to be a fraction of: the bar shows the way to the next power of two.
        None if spp > 0 => spp as f32 / (spp + 1).next_power_of_two() as f32,
        None => 0.0,
    };
    // Faint enough for the words on it.
    let fill = ui.visuals().text_color().gamma_multiply(0.35);
    let height = 0.7 * ui.spacing().interact_size.y;
    let bar = ProgressBar::new(fraction.clamp(0.0, 1.0)).desired_width(PROGRESS).desired_height(height).fill(fill);
    let bar = bar.corner_radius(2.0).text(RichText::new(text).small().color(ui.visuals().text_color()));
    ui.add(bar).accessible_name("Progress").hint("How much of the picture's samples is there.");
}
