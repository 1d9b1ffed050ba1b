//! The pixel's numbers: what is seen, and of each strategy the exact mean and deviation beside what was measured.

use std::sync::Arc;

use eframe::egui::{Context, Grid, RichText, ScrollArea, TextStyle, Ui, vec2};
use mislab_renderer::{Channel, Estimator, Frame, Strategy};

use super::number::short;
use super::place::{Facts, Place, Surface, angle, luminance};
use super::tables::{Exact, PixelTables};
use crate::look::names::strategy_name;
use crate::look::theme::{GRID, Inks};
use crate::panel::hint::Hint as _;
use crate::panel::number::{signed, three_digits, two_digits};
use crate::panel::study::Subject;
use crate::panel::widgets::caption;
use crate::picture::background::{Background, Effort};

/// Further from the exact mean than so many standard errors, a measured one does not agree: chance does that once in 370.
const AGREES: f64 = 3.0;
/// With fewer samples that carry light a mean says little, and its error is not normal.
const FEW: f64 = 5.0;
/// A strategy whose mean is off by more than this is biased.
const SAME: f64 = 1e-3;

/// Means and deviations of all strategies, worked out beside the pictures.
pub struct Numbers {
    job: Background<About, Found>,
}

/// What was found, and of which pixel.
#[derive(Clone)]
struct Found {
    exact: [Exact; 4],
    place: Place,
}

#[derive(Clone)]
struct About {
    tables: Arc<PixelTables>,
    estimators: [Estimator; 4],
}

impl PartialEq for About {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.tables, &other.tables) && self.estimators == other.estimators
    }
}

impl Default for Numbers {
    fn default() -> Self {
        Self { job: Background::new("moments") }
    }
}

/// What a picture has for the pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Luminance.
    pub mean: f64,
    /// Standard deviation of one sample; `None` of a single one.
    pub deviation: Option<f64>,
    /// Samples.
    pub spp: u32,
}

impl Measured {
    /// Of a frame.
    pub fn of(frame: &Frame, [x, y]: [u32; 2]) -> Option<Self> {
        let value = |channel| frame.pixel(x, y, channel);
        let colour = glam::Vec3::new(value(Channel::R)?, value(Channel::G)?, value(Channel::B)?);
        let variance = value(Channel::VarianceY)?;
        Some(Self {
            mean: luminance(colour),
            deviation: (!variance.is_nan()).then(|| f64::from(variance).sqrt()),
            spp: frame.spp(),
        })
    }
}

/// Whether a measured mean is the exact one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// Too few samples have carried light: so many are to be expected.
    TooFew(f64),
    /// So many standard errors off, as chance would have it.
    Agrees(f64),
    /// So many standard errors off.
    Off(f64),
}

impl Verdict {
    /// Of a mean of independent samples; `tolerance` is the relative error of the exact one.
    pub fn new(measured: &Measured, exact: &Exact, tolerance: f64) -> Self {
        let n = f64::from(measured.spp);
        let hits = n * exact.lit;
        let error = (exact.variance / n + (tolerance * exact.mean).powi(2)).sqrt();
        let difference = (measured.mean - exact.mean).abs();
        let sigmas = if difference <= 1e-6 * exact.mean { 0.0 } else { difference / error };
        if exact.variance > 0.0 && hits < FEW && exact.lit > 0.0 {
            Self::TooFew(hits)
        } else if sigmas <= AGREES {
            Self::Agrees(sigmas)
        } else {
            Self::Off(sigmas)
        }
    }

    fn words(self) -> String {
        match self {
            Self::TooFew(_) => "too few hits".to_owned(),
            Self::Agrees(sigmas) => format!("agrees, {sigmas:.1} \u{3c3}"),
            Self::Off(sigmas) => format!("{sigmas:.1} \u{3c3} off"),
        }
    }
}

/// A strategy's estimator, and the picture that shows it.
struct Row {
    estimator: Estimator,
    measured: Option<Measured>,
}

impl Numbers {
    /// Gives up what is being worked out.
    pub fn rest(&mut self) {
        self.job.rest();
    }

    /// `None` until they are known of this pixel.
    fn exact(&mut self, ctx: &Context, tables: &Arc<PixelTables>, estimators: [Estimator; 4]) -> Option<[Exact; 4]> {
        let about = About { tables: tables.clone(), estimators };
        let find = |about: &About| {
            Some(Found {
                exact: about.estimators.map(|estimator| about.tables.sample(&estimator)),
                place: about.tables.place.clone(),
            })
        };
        // Of a single point: what follows the mouse would always be a pass behind the tables.
        let found = if tables.count == 1 {
            self.job.at_once(about, find)
        } else {
            self.job.of(ctx, about, Effort::Aside, move |about, goes_on| if goes_on() { find(about) } else { None })
        };
        let found = found.as_ref().or_else(|| self.job.known());
        found.filter(|found| found.place.is_same(&tables.place)).map(|found| found.exact)
    }
}

/// For each strategy the active picture's settings or, where another picture shows it, those of that.
fn rows(place: &Place, subject: &Subject<'_>) -> [Row; 4] {
    let active = subject.document.active_index();
    let mut order: Vec<usize> = (0..subject.pictures.len()).collect();
    order.sort_by_key(|slot| *slot != active);
    let frames: Vec<Arc<Frame>> = order.into_iter().filter_map(|slot| subject.pictures[slot].current_frame()).collect();
    Strategy::ALL.map(|strategy| {
        let shows = |frame: &&Arc<Frame>| {
            frame.request().settings.estimator.strategy == strategy
                && Place::of(frame, place.pixel).is_some_and(|there| there.is_same(place))
        };
        match frames.iter().find(shows) {
            Some(frame) => {
                Row { estimator: frame.request().settings.estimator, measured: Measured::of(frame, place.pixel) }
            }
            None => Row { estimator: Estimator { strategy, ..place.settings.estimator }, measured: None },
        }
    })
}

/// Draws them.
pub fn numbers_ui(ui: &mut Ui, numbers: &mut Numbers, tables: &Arc<PixelTables>, place: &Place, subject: &Subject<'_>) {
    ScrollArea::vertical().id_salt("numbers").auto_shrink(false).show(ui, |ui| {
        facts_ui(ui, &tables.facts);
        let rows = rows(place, subject);
        let exact = numbers.exact(ui.ctx(), tables, rows.each_ref().map(|row| row.estimator));
        ui.add_space(2.0 * GRID);
        ui.label(format!("Exact luminance of the pixel: {}", short(tables.truth)))
            .hint("The integral of f over all directions, averaged over the pixel, plus what it emits: no samples.");
        ui.add_space(GRID);
        // In a hall it is wider than the column.
        ScrollArea::horizontal().id_salt("table").show(ui, |ui| table_ui(ui, tables, &rows, exact.as_ref()));
        ui.add_space(2.0 * GRID);
        caption(ui, how(tables));
        caption(ui, "\u{3c3}: standard deviation of one sample's luminance. Per ray: times \u{221a}2 for two rays. Mean \u{b1} standard \
                     error of independent samples; other samplers may be closer.");
    });
}

/// What is seen, in a line each.
fn facts_ui(ui: &mut Ui, facts: &Facts) {
    match facts {
        Facts::Nothing => drop(ui.label("The camera sees nothing here.")),
        Facts::Light => drop(ui.label("The camera sees a light here: nothing is sampled.")),
        Facts::Surface(surface) => surface_ui(ui, surface),
    }
}

fn surface_ui(ui: &mut Ui, surface: &Surface) {
    let lobe = match surface.alpha {
        Some(0.0) => "a mirror".to_owned(),
        Some(alpha) => format!("GGX width \u{3b1} {}", three_digits(f64::from(alpha))),
        None => "matte: no lobe".to_owned(),
    };
    let tilt = angle(surface.normal, surface.wo).to_degrees();
    let [x, y, z] = surface.normal.to_array().map(|v| signed(f64::from(v), 2));
    ui.label(format!("Surface {}, {lobe}", surface.name));
    ui.label(format!("Seen {tilt:.1}\u{b0} from its normal ({x}, {y}, {z})"));
    ui.label(highlight_words(surface))
        .hint("The direction in which a mirror would reflect is about the peak of the lobe.");
}

/// Which light its highlight is.
fn highlight_words(surface: &Surface) -> String {
    let Some(light) = surface.highlight() else { return "No light is on".to_owned() };
    let (off, radius) = (light.off.to_degrees(), light.radius.to_degrees());
    if light.off <= light.radius {
        format!("Highlight of {}: the mirror direction hits it", light.name)
    } else {
        format!("Nearest light: {} (radius {radius:.1}\u{b0}), {off:.1}\u{b0} off the mirror", light.name)
    }
}

/// Head of the column that goes first where room is short.
const SEEN: &str = "\u{3c3} seen";
/// So many times the size of its type are wide enough for all columns.
const ALL_COLUMNS: f32 = 29.0;

/// `exact`: as far as it is known.
fn table_ui(ui: &mut Ui, tables: &PixelTables, rows: &[Row; 4], exact: Option<&[Exact; 4]>) {
    let inks = Inks::of(ui.visuals());
    // In large type the verdict is worth more than what it rests on.
    let all = ui.available_width() > ALL_COLUMNS * TextStyle::Small.resolve(ui.style()).size;
    Grid::new("exact and measured").num_columns(6).spacing(vec2(2.0 * GRID, GRID)).show(ui, |ui| {
        for (head, what) in [
            ("", ""),
            ("\u{3c3} exact", "Standard deviation of the luminance of one sample, by quadrature: \u{221a}(E Y\u{b2} \u{2212} (E Y)\u{b2})."),
            ("per ray", "The same at equal rays: times \u{221a}2 where a sample costs two rays."),
            (SEEN, "Standard deviation of the picture's samples in this pixel."),
            ("mean", "The picture's mean \u{b1} exact \u{3c3} / \u{221a}n."),
            ("", ""),
        ] {
            if head == SEEN && !all {
                continue;
            }
            let text = RichText::new(head).text_style(TextStyle::Small).color(ui.visuals().weak_text_color());
            let label = ui.label(text);
            if !what.is_empty() {
                label.hint(what);
            }
        }
        ui.end_row();
        for (index, (row, strategy)) in rows.iter().zip(Strategy::ALL).enumerate() {
            let exact = exact.map(|exact| exact[index]);
            let small = |text: String| RichText::new(text).text_style(TextStyle::Small);
            ui.label(small(strategy_name(strategy).to_owned()).color(inks.strategy(strategy)));
            let deviation = exact.map(|exact| exact.variance.sqrt());
            let times = |factor: f64| deviation.map_or_else(|| "\u{2026}".to_owned(), |deviation| short(factor * deviation));
            ui.label(small(times(1.0)));
            ui.label(small(times(f64::from(strategy.rays_per_sample()).sqrt())));
            match &row.measured {
                Some(measured) => {
                    if all {
                        ui.label(small(measured.deviation.map_or_else(|| "\u{2013}".to_owned(), short)));
                    }
                    let error = deviation.map(|deviation| two_digits(deviation / f64::from(measured.spp).sqrt()));
                    let error = error.unwrap_or_else(|| "\u{2026}".to_owned());
                    ui.label(small(format!("{} \u{b1} {error}", short(measured.mean))));
                }
                None => {
                    if all {
                        ui.label(small("\u{2013}".to_owned()));
                    }
                    ui.label(small("no picture".to_owned()).color(ui.visuals().weak_text_color()))
                        .hint("Lay out four pictures (Q) to measure all strategies.");
                }
            }
            // After the first round nobody knows how exact it is.
            if let Some(exact) = exact.filter(|_| tables.tolerance.is_finite()) {
                remark_ui(ui, &exact, row.measured.as_ref(), tables);
            }
            ui.end_row();
        }
    });
}

/// Whether a strategy has another mean, and whether the picture has that of its strategy.
fn remark_ui(ui: &mut Ui, exact: &Exact, measured: Option<&Measured>, tables: &PixelTables) {
    let off = (exact.mean - tables.truth) / tables.truth;
    let small = |text: String| RichText::new(text).text_style(TextStyle::Small);
    let wrong = Inks::of(ui.visuals()).wrong;
    if tables.truth > 0.0 && off.abs() > SAME.max(tables.tolerance) {
        let words = format!("biased {:+.1} %", 100.0 * off).replace('-', "\u{2212}");
        ui.label(small(words).color(wrong)).hint("Its mean is another one, however many samples there are.");
        return;
    }
    let Some(verdict) = measured.map(|measured| Verdict::new(measured, exact, tables.tolerance)) else { return };
    let text = small(verdict.words());
    match verdict {
        Verdict::TooFew(hits) => {
            let hits = three_digits(hits);
            ui.label(text)
                .hint(format!("Only {hits} samples that carry light are to be expected so far: nothing is known yet."));
        }
        Verdict::Agrees(_) => {
            ui.label(text)
                .hint("So many standard errors between the picture's mean and the exact one; up to 3 are chance.");
        }
        Verdict::Off(_) => {
            let rare = "More than 3 standard errors: chance does that once in 370 pixels, and more often where bright \
                        samples are rare.";
            ui.label(text.color(wrong)).hint(rare);
        }
    }
}

/// How exact it is by now.
pub fn how(tables: &PixelTables) -> String {
    let points =
        if tables.count == 1 { "at its centre".to_owned() } else { format!("at {} points of the pixel", tables.count) };
    let tolerance = if tables.tolerance.is_finite() {
        format!(", to {} %", two_digits(100.0 * tables.tolerance))
    } else {
        String::new()
    };
    let rest = if tables.is_final() { "" } else { "; coarse so far \u{2026}" };
    format!("Exact by quadrature over all directions {points}{tolerance}{rest}.")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_agrees_within_three_standard_errors_and_not_beyond() {
        let exact = Exact { mean: 1.0, variance: 4.0, lit: 0.5 };
        let measured = |mean: f64| Measured { mean, deviation: Some(2.0), spp: 400 };
        // The standard error is 0.1.
        assert!(matches!(Verdict::new(&measured(1.29), &exact, 0.0), Verdict::Agrees(s) if (s - 2.9).abs() < 1e-9));
        assert!(matches!(Verdict::new(&measured(0.69), &exact, 0.0), Verdict::Off(s) if (s - 3.1).abs() < 1e-9));
        // What the exact mean may be off by counts as well.
        assert!(matches!(Verdict::new(&measured(1.4), &exact, 0.1), Verdict::Agrees(_)));
        // One of 526 BSDF samples hits: after 64 nothing is known.
        let rare = Exact { lit: 1.0 / 526.0, ..exact };
        assert!(matches!(Verdict::new(&measured(9.0), &rare, 0.0), Verdict::TooFew(hits) if hits < 1.0));
        // Without any variance there is nothing to wait for.
        let sure = Exact { mean: 1.0, variance: 0.0, lit: 1.0 };
        assert!(matches!(Verdict::new(&measured(1.0), &sure, 0.0), Verdict::Agrees(s) if s == 0.0));
        assert!(matches!(Verdict::new(&measured(1.1), &sure, 1e-3), Verdict::Off(_)));
    }
}
