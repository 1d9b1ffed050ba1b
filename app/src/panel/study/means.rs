//! Means of each picture against a reference: bias or noise.

use eframe::egui::{self, Align2, Rangef, Rect, RichText, Role, Sense, Stroke, TextStyle, Ui, vec2};
use mislab_renderer::study::{Mean, p_values};

use super::Subject;
use super::convergence::reference_ui;
use super::parts::{Chosen, part_name};
use super::tiles::{caption_lines, caption_that_fits};
use crate::look::names::strategy_name;
use crate::look::theme::{GRID, Inks};
use crate::panel::hint::Hint as _;
use crate::panel::number::two_digits;
use crate::panel::widgets::{SHEET_TYPE, text_width, title, type_of_at_most};
use crate::picture::sheet::Recorder;
use crate::picture::slot_errors::{Round, SlotErrors};
use crate::state::command::Command;

/// What is kept of it while it is open and after.
#[derive(Default)]
pub struct Means {
    /// The row that numbers are shown of.
    part: Chosen,
}

/// The widest that is said of a picture, in all columns, and the space between them.
const WIDEST_ROW: &str = "MIS, both0.33388 \u{b1} 0.00088biased, p < 1e-12eff. 8.8e8";
const BETWEEN: f32 = 4.0 * GRID;

/// Radius of the ring around a biased mean.
const MARK: f32 = 6.25;

/// A picture is called biased if so small a p-value comes by chance less often, over all rows and pictures together.
const SIGNIFICANCE: f64 = 0.01;

/// What the means of a picture say of one part.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Verdict {
    mean: Mean,
    /// Corrected for the number of tests; `None` where too few samples carried light.
    p: Option<f64>,
    /// A mirror that the strategy cannot sample: no test is needed.
    blind: bool,
}

impl Verdict {
    fn is_biased(&self) -> bool {
        self.blind || self.p.is_some_and(|p| p < SIGNIFICANCE)
    }

    fn words(&self) -> String {
        match self.p {
            _ if self.blind => "biased: cannot be sampled".to_owned(),
            None => "too few samples with light".to_owned(),
            // Beyond, the tail of the normal distribution is rounding.
            Some(p) if p < 1e-12 => "biased, p < 1e-12".to_owned(),
            Some(p) if p < SIGNIFICANCE => format!("biased, p = {}", two_digits(p)),
            Some(_) => "unbiased so far".to_owned(),
        }
    }
}

/// Verdicts of all slots in all parts, by part and slot; `None` where a slot has no means yet.
fn verdicts(round: &Round) -> Vec<Vec<Option<Verdict>>> {
    let means = |slot: &Option<SlotErrors>, part: usize| Some(*slot.as_ref()?.means.as_ref()?.get(part)?);
    let rows: Vec<Vec<Option<Mean>>> =
        (0..round.reference.len()).map(|part| round.slots.iter().map(|slot| means(slot, part)).collect()).collect();
    let single = rows.iter().zip(round.reference.iter());
    let single: Vec<Option<f64>> =
        single.flat_map(|(row, r)| row.iter().map(|mean| mean.as_ref()?.p_value(r))).collect();
    let mut corrected = p_values(&single).into_iter();
    let mut verdict = |part: usize, slot: usize, mean: Option<Mean>| {
        let p = corrected.next().flatten();
        let blind = round.slots[slot].as_ref().is_some_and(|slot| slot.blind[part]);
        mean.map(|mean| Verdict { mean, p, blind })
    };
    let mut row = |(part, row): (usize, &Vec<Option<Mean>>)| {
        row.iter().enumerate().map(|(slot, mean)| verdict(part, slot, *mean)).collect()
    };
    rows.iter().enumerate().map(&mut row).collect()
}

/// Draws it over all that is left of `ui`.
pub fn means_ui(ui: &mut Ui, study: &mut Means, subject: &Subject<'_>, out: &mut Vec<Command>) {
    title(ui, "Means: bias or noise");
    let Some(round) = subject.measuring.round() else {
        reference_ui(ui, subject, out);
        ui.label("Each picture's mean over each plate and light is compared with the reference's.");
        return;
    };
    study.part.follow(subject.selected, round.against.cells.squares.len());
    let verdicts = verdicts(round);
    let foot =
        (round.slots.len() as f32 + 2.0) * ui.spacing().interact_size.y + 6.0 * GRID + caption_lines(ui, [3.0, 6.0]);
    let height = (ui.available_height() - foot).max(100.0);
    let scale = scale(round, &verdicts);
    let rows = egui::ScrollArea::vertical().id_salt("means").max_height(height);
    let chart = rows.show(ui, |ui| rows_ui(ui, study, round, &verdicts, scale)).inner;
    scale_ui(ui, chart, scale);
    // A rectangle that has just been selected has no row yet.
    let chosen = round.index(study.part.part()).unwrap_or(0);
    ui.add_space(GRID);
    ui.scope(|ui| slots_ui(ui, round, &verdicts[chosen], chosen));
    ui.horizontal(|ui| {
        let button = |ui: &mut Ui| ui.button("CSV").accessible_name("Save the means as CSV");
        if Recorder::on_screen_only(ui, button).clicked() {
            out.push(Command::SaveCsv { name: "means", text: csv(round, &verdicts) });
        }
        reference_ui(ui, subject, out);
    });
    let tests = verdicts.iter().flatten().flatten().filter(|verdict| verdict.p.is_some()).count();
    let all = format!(
        "Mean luminance against the reference's, 95 % intervals. p: the chance that any of the {tests} tests differs as much \
         without bias, 1 \u{2212} (1 \u{2212} p)^{tests}; below 1 % a picture is called biased. eff.: 1 / (variance of the mean \u{d7} \
         seconds of processor time)."
    );
    let tested = verdicts.iter().flatten().flatten().any(|verdict| !verdict.blind && verdict.is_biased());
    let p = if tested { " p: by chance, of all tests." } else { "" };
    caption_that_fits(ui, &all, &format!("95 % intervals.{p} eff.: 1 / (variance \u{d7} seconds)."));
}

/// A row for each part: its name, a dot with its interval for each picture, the verdict. Returns from where to where the dots may lie.
fn rows_ui(ui: &mut Ui, study: &mut Means, round: &Round, verdicts: &[Vec<Option<Verdict>>], scale: f64) -> Rangef {
    let cells = &round.against.cells;
    // The ring of the first dot has room.
    ui.add_space(GRID);
    let slots = round.slots.len().max(1) as f32;
    let height = (6.0 * slots).max(ui.text_style_height(&TextStyle::Body)) + GRID;
    let width = ui.available_width();
    let chosen = study.part.part();
    let mut along = Rangef::NOTHING;
    for (index, part) in round.parts.iter().copied().enumerate() {
        let (rect, response) = ui.allocate_exact_size(vec2(width, height), Sense::click());
        let worst = verdicts[index].iter().flatten().find(|verdict| verdict.is_biased());
        let spoken = worst.map_or_else(
            || verdicts[index].iter().flatten().next().map_or_else(|| "no mean yet".to_owned(), Verdict::words),
            Verdict::words,
        );
        let name = part_name(Some(cells), part);
        response.widget_info(|| {
            egui::WidgetInfo::selected(Role::RadioButton, true, chosen == part, format!("{name}: {spoken}"))
        });
        if response.clicked() {
            study.part.set(part);
        }
        if chosen == part || response.hovered() {
            ui.painter().rect_filled(rect, GRID, ui.visuals().widgets.inactive.weak_bg_fill);
        }
        let (names, chart) = rect.split_left_right_at_fraction(0.42);
        let painter = ui.painter_at(names);
        let font = TextStyle::Body.resolve(ui.style());
        let wrong = Inks::of(ui.visuals()).wrong;
        let ink = if worst.is_some() { wrong } else { ui.visuals().text_color() };
        painter.text(names.left_center() + vec2(GRID, 0.0), Align2::LEFT_CENTER, &name, font, ink);
        let chart = chart.shrink2(vec2(2.0 * GRID, 1.0));
        along = chart.x_range();
        dots_ui(ui, chart, round, index, &verdicts[index], scale);
    }
    along
}

/// What the ends of all rows are, under them.
fn scale_ui(ui: &mut Ui, along: Rangef, scale: f64) {
    let size = vec2(ui.available_width(), ui.text_style_height(&TextStyle::Small));
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    let chart = Rect::from_x_y_ranges(along, rect.y_range());
    let font = TextStyle::Small.resolve(ui.style());
    let weak = ui.visuals().weak_text_color();
    let percent = two_digits(100.0 * scale);
    for (align, at, text) in [
        (Align2::LEFT_TOP, chart.left_top(), format!("\u{2212}{percent} %")),
        (Align2::CENTER_TOP, chart.center_top(), "reference".to_owned()),
        (Align2::RIGHT_TOP, chart.right_top(), format!("+{percent} %")),
    ] {
        ui.painter().text(at, align, text, font.clone(), weak);
    }
}

/// Half the width of all rows, relative to the reference: nine of ten intervals fit.
fn scale(round: &Round, verdicts: &[Vec<Option<Verdict>>]) -> f64 {
    let mut all: Vec<f64> = verdicts
        .iter()
        .zip(round.reference.iter())
        .flat_map(|(row, r)| row.iter().flatten().map(|v| relative(&v.mean, r)))
        .map(|[difference, half]| difference.abs() + half)
        .filter(|extent| extent.is_finite())
        .collect();
    all.sort_by(f64::total_cmp);
    let extent = all.get(all.len() * 9 / 10).or(all.last()).copied().unwrap_or(0.1);
    // One of a few steps, so that rows do not swim while numbers come in.
    [0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5].into_iter().find(|step| *step >= extent).unwrap_or(1.0)
}

/// Difference from the reference, and half the 95 % interval, both over the reference.
fn relative(mean: &Mean, reference: &Mean) -> [f64; 2] {
    [(mean.value - reference.value) / reference.value, 1.96 * mean.standard_error / reference.value]
}

fn dots_ui(ui: &Ui, rect: Rect, round: &Round, part: usize, row: &[Option<Verdict>], scale: f64) {
    // Wide enough for the mark of a mean at the very end.
    let painter = ui.painter_at(rect.expand(MARK));
    let inks = Inks::of(ui.visuals());
    let weak = ui.visuals().weak_text_color();
    let x = |relative: f64| {
        let share = (0.5 + 0.5 * relative / scale).clamp(0.0, 1.0) as f32;
        rect.left() + share * rect.width()
    };
    let reference = &round.reference[part];
    let own = 1.96 * reference.standard_error / reference.value;
    let band = Rect::from_x_y_ranges(x(-own)..=x(own), rect.y_range());
    painter.rect_filled(band, 0.0, weak.gamma_multiply(0.35));
    painter.vline(x(0.0), rect.y_range(), Stroke::new(1.0, weak));
    for (slot, verdict) in row.iter().enumerate() {
        let (Some(verdict), Some(found)) = (verdict, &round.slots[slot]) else { continue };
        let [difference, half] = relative(&verdict.mean, reference);
        if !difference.is_finite() {
            continue;
        }
        let ink = inks.strategy(found.estimator.strategy);
        let y = rect.top() + (slot as f32 + 0.5) / row.len() as f32 * rect.height();
        painter.hline(x(difference - half)..=x(difference + half), y, Stroke::new(2.0, ink));
        painter.circle_filled(egui::pos2(x(difference), y), 3.5, ink);
        if verdict.is_biased() {
            painter.circle_stroke(egui::pos2(x(difference), y), MARK - 0.75, Stroke::new(1.5, inks.wrong));
        }
    }
}

/// The numbers of one row, a line for each picture.
fn slots_ui(ui: &mut Ui, round: &Round, row: &[Option<Verdict>], part: usize) {
    let reference = &round.reference[part];
    let name = part_name(Some(&round.against.cells), round.parts[part]);
    let inks = Inks::of(ui.visuals());
    // In a hall rather small than cut.
    let font = TextStyle::Small.resolve(ui.style());
    let small = font.size;
    let room = ui.available_width() - 3.0 * BETWEEN;
    type_of_at_most(ui, (small * room / text_width(ui, WIDEST_ROW, &font)).clamp(SHEET_TYPE, small.max(SHEET_TYPE)));
    ui.label(format!("{name}: {} pixels, reference {}", reference.pixels, with_error(reference)));
    egui::Grid::new("means of the row").num_columns(4).spacing([BETWEEN, 0.0]).show(ui, |ui| {
        for (slot, verdict) in round.slots.iter().zip(row) {
            let (Some(slot), Some(verdict)) = (slot, verdict) else {
                ui.label("no mean yet");
                ui.end_row();
                continue;
            };
            ui.colored_label(inks.strategy(slot.estimator.strategy), strategy_name(slot.estimator.strategy));
            ui.label(with_error(&verdict.mean));
            let words = RichText::new(verdict.words());
            ui.label(if verdict.is_biased() { words.color(inks.wrong) } else { words });
            let efficiency = verdict.mean.efficiency(slot.cpu_seconds);
            ui.label(efficiency.map_or_else(|| "\u{2013}".to_owned(), |e| format!("eff. {e:.1e}")))
                .hint("Efficiency: 1 / (variance of the mean \u{d7} seconds of processor time).");
            ui.end_row();
        }
    });
}

fn with_error(mean: &Mean) -> String {
    mislab_renderer::table::with_error(mean.value, mean.standard_error)
}

/// A head line, then a line for each part and picture.
fn csv(round: &Round, verdicts: &[Vec<Option<Verdict>>]) -> String {
    let mut text = String::from(
        "part,pixels,picture,strategy,spp,cpu_seconds,reference,reference_error,mean,standard_error,p_corrected,efficiency\n",
    );
    for ((part, row), reference) in round.parts.iter().zip(verdicts).zip(round.reference.iter()) {
        for (number, (slot, verdict)) in round.slots.iter().zip(row).enumerate() {
            let (Some(slot), Some(Verdict { mean, p, blind: _ })) = (slot, verdict) else { continue };
            let optional = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
            text += &format!(
                "{},{},{},{},{},{},{},{},{},{},{},{}\n",
                part_name(Some(&round.against.cells), *part),
                mean.pixels,
                number + 1,
                slot.estimator.strategy.name(),
                slot.spp,
                slot.cpu_seconds,
                reference.value,
                reference.standard_error,
                mean.value,
                mean.standard_error,
                optional(*p),
                optional(mean.efficiency(slot.cpu_seconds))
            );
        }
    }
    text
}
