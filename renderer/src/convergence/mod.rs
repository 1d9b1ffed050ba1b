//! How the error falls with the samples: relMSE of each strategy at given samples per pixel, with the slope of the line that
//! it draws on logarithmic axes.
//!
//! 1. *Points.* Every point is the mean over [`Options::replicates`] pictures, each rendered to just that many samples per pixel
//!    with a seed of its own. The samples of one pixel are stratified and so not independent; whole pictures are, and so
//!    are the points of a curve: the standard errors need no model.
//! 2. *Reference.* Two halves that share no sample, so that the reference's own noise does not add to the error
//!    ([`crate::metrics::Reference::Halves`]); or a file, which is taken as exact.
//! 3. *Slope.* Least squares over log relMSE against log spp, and its 95 % interval by the jackknife over the replicates
//!    ([`crate::study::slope`]). Independent samples have -1: four times the samples, half the error.

mod report;

use std::sync::Arc;

use mislab_kernel::request::scene::Scene;
use mislab_kernel::request::{Estimator, Request, Settings, Strategy};
use serde::Serialize;

use crate::batch::{Batch, Step, rays};
use crate::error::Error;
use crate::snapshot::Image;
use crate::study::{Against, Cells, Curves, Measure, Part, Plan, cells, measure};
use crate::table::quality::mean_and_error;
use crate::table::reference::{self, SortedReference, work};
use crate::table::regions::{Groups, Square};
use crate::table::report::{bsdf_name, light_name};
use crate::table::{LightSize, LobeWidth};

/// What is measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// A curve for each.
    pub strategies: Vec<Strategy>,
    /// Samples per pixel of the points, ascending.
    pub at: Vec<u32>,
    /// Pictures of each point with different seeds, 2 to 1000.
    pub replicates: u32,
    /// Each of the tutorial's squares (light small or large, BSDF broad or sharp) by itself, too.
    pub by_square: bool,
    /// A converged picture of the same pixels to measure against, taken as exact; `None`: one is rendered.
    pub reference: Option<Image>,
    /// Worker threads; 0: one per core.
    pub threads: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            strategies: Strategy::ALL.to_vec(),
            at: (0..=8).map(|power| 1 << power).collect(),
            replicates: 8,
            by_square: false,
            reference: None,
            threads: 0,
        }
    }
}

/// A reference is rendered with so many times the samples of the last point, ...
const REFERENCE_FACTOR: u32 = 4;
/// ... and at least and at most so many.
const REFERENCE_SPP: [u32; 2] = [512, 1 << 20];

impl Options {
    fn check(&self) -> Result<(), Error> {
        const MAX_REPLICATES: u32 = 1000;
        let wrong = if self.strategies.is_empty() {
            Some("no strategy, expected at least one".to_owned())
        } else if self.at.is_empty() || self.at[0] == 0 || !self.at.is_sorted_by(|a, b| a < b) {
            Some(format!("samples per pixel {:?}, expected ascending numbers from 1", self.at))
        } else if !(2..=MAX_REPLICATES).contains(&self.replicates) {
            Some(format!("{} replicates, expected 2 to {MAX_REPLICATES}", self.replicates))
        } else {
            None
        };
        wrong.map_or(Ok(()), |wrong| Err(Error::Invalid(wrong)))
    }

    /// The pictures, all of the request's estimator but for the strategy.
    fn plan(&self, estimator: Estimator) -> Plan {
        let estimators = self.strategies.iter().map(|&strategy| Estimator { strategy, ..estimator }).collect();
        Plan { estimators, at: self.at.clone(), replicates: self.replicates, by_block: false }
    }

    fn reference_spp(&self) -> u32 {
        let last = self.at.last().copied().unwrap_or_default();
        last.saturating_mul(REFERENCE_FACTOR).clamp(REFERENCE_SPP[0], REFERENCE_SPP[1])
    }
}

/// One point of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CurvePoint {
    /// Samples per pixel.
    pub spp: u32,
    /// Secondary rays per pixel.
    pub rays: u64,
    /// Processor seconds of the whole picture, mean over the replicates.
    pub cpu_seconds: f64,
    /// Relative mean squared error ([`crate::metrics::rel_mse`]), mean over the replicates; `None` without pixels. Measured against
    /// two halves it may be negative by chance where there is hardly any error.
    pub rel_mse: Option<f64>,
    /// Standard error of `rel_mse` over the replicates.
    pub standard_error: Option<f64>,
}

/// The points of one square of the picture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SquareCurve {
    /// Size of the light that contributes most to its pixels.
    pub light: LightSize,
    /// Lobes of the plates that its pixels show.
    pub bsdf: LobeWidth,
    /// How many they are.
    pub pixels: usize,
    /// See [`Curve::slope`].
    pub slope: Option<f64>,
    /// See [`Curve::slope_interval`].
    pub slope_interval: Option<[f64; 2]>,
    /// See [`Curve::heavy_tailed`].
    pub heavy_tailed: bool,
    /// By ascending spp.
    pub points: Vec<CurvePoint>,
}

/// The error of one estimator against its samples.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Curve {
    /// Its strategy, ...
    pub strategy: &'static str,
    /// ... heuristic, ...
    pub heuristic: &'static str,
    /// ... one-sample weights, ...
    pub weights: &'static str,
    /// ... and c.
    pub light_prob: f32,
    /// Pattern of the samples.
    pub sampler: &'static str,
    /// Power of the samples that the error falls with; `None` with fewer than two points above 0.
    pub slope: Option<f64>,
    /// Its 95 % interval.
    pub slope_interval: Option<[f64; 2]>,
    /// At some point one replicate carries more than half of the error (of three, two thirds): rare bright samples make the
    /// error, and what has not been drawn yet is in no interval.
    pub heavy_tailed: bool,
    /// Why the error cannot fall to 0, if so: [`Estimator::bias`].
    pub bias: Option<&'static str>,
    /// By ascending spp.
    pub points: Vec<CurvePoint>,
    /// With [`Options::by_square`], small/broad, small/sharp, large/broad, large/sharp.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub squares: Option<Vec<SquareCurve>>,
}

/// What a curve is measured against.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ReferenceNoise {
    /// Camera rays per pixel (with [`Options::by_square`] for each light); `None` if a file does not say.
    pub spp: Option<u32>,
    /// Its own relMSE; `None` of a file, whose noise counts as error of the curves.
    pub rel_mse: Option<f64>,
}

/// All curves.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Convergence {
    /// The scene's name.
    pub scene: String,
    /// Full image.
    pub width: u32,
    /// See `width`.
    pub height: u32,
    /// Pictures of each point.
    pub replicates: u32,
    /// What errors are measured against.
    pub reference: ReferenceNoise,
    /// By strategy.
    pub curves: Vec<Curve>,
}

impl Convergence {
    /// For people: a table of errors, a column for each strategy. `file` names the reference if it came from one.
    pub fn to_text(&self, file: Option<&str>) -> String {
        report::text(self, file)
    }

    /// For spreadsheets: a head line, then one line for each point.
    pub fn to_csv(&self) -> String {
        report::csv(self)
    }
}

/// Renders everything and measures. `request` says all but strategy and spp. Blocks; call it from a thread of its own.
/// `goes_on` is called several times a second and returns false to stop, upon which the result is `None`.
///
/// # Errors
/// [`Error::Invalid`] if an option is out of range, the reference does not hold the same pixels, the scene has no plates and
/// lights to sort the pixels by, or it cannot be rendered.
pub fn converge(
    request: &Request,
    options: &Options,
    goes_on: &mut dyn FnMut(&Step<'_>) -> bool,
) -> Result<Option<Convergence>, Error> {
    options.check()?;
    let plan = options.plan(request.settings.estimator);
    let pictures: Vec<Settings> = plan.order().map(|index| plan.settings(request, index)).collect();
    for settings in &pictures {
        settings.check().map_err(Error::Invalid)?;
    }
    let groups = options.by_square.then(|| Groups::of(&request.scene)).transpose()?;
    let whole = Arc::new(Cells::none(pictures[0].pixel_bounds()));
    let given = options.reference.as_ref().map(|image| Against::of_image(image, &pictures[0], whole));
    let given = given.transpose()?;
    let (image, spp) = (request.settings.image, options.reference_spp());
    let lights = match &groups {
        Some(groups) => groups.lights().count(),
        None => usize::from(given.is_none()),
    };
    let total = pictures.iter().map(rays).sum::<f64>() + work(image, spp, lights);
    let mut batch = Batch::new(options.threads, total);

    let halves = reference::Plan { image, spp, seed: request.settings.sampling.seed };
    let Some(against) = measured_against(&halves, &mut batch, &request.scene, (groups, given), goes_on)? else {
        return Ok(None);
    };
    let against = Arc::new(against);
    let mut curves = Curves::new(plan.clone());
    let mut render = |settings: Settings, [_, _, replicate]: [usize; 3]| {
        let (name, spp) = (settings.estimator.strategy.name(), settings.sampling.target().unwrap_or_default());
        let step = format!("{name}, {spp} spp, {} of {}", replicate + 1, options.replicates);
        batch.render(&request.scene, settings, &step, goes_on)
    };
    measure(request, &plan, &mut render, &mut |_| Some(Arc::clone(&against)), &mut |found| curves.add(found))?;
    if curves.count() < curves.total() {
        return Ok(None);
    }
    let sampler = request.settings.sampling.sampler.kind.name();
    let noise = against.noise(Part::Whole).and_then(|errors| errors.rel_mse());
    let [width, height] = image.resolution;
    Ok(Some(Convergence {
        scene: request.scene.name.clone(),
        width,
        height,
        replicates: options.replicates,
        reference: ReferenceNoise { spp: against.spp, rel_mse: noise },
        curves: (0..plan.estimators.len()).map(|index| curve(&curves, index, sampler, &against.cells)).collect(),
    }))
}

/// What errors are measured against: `given`, or else rendered; with the four squares of the table if they are asked for. `None` if
/// `goes_on` says no.
fn measured_against(
    halves: &reference::Plan,
    batch: &mut Batch,
    scene: &Arc<Scene>,
    (groups, given): (Option<Groups>, Option<Against>),
    goes_on: &mut dyn FnMut(&Step<'_>) -> bool,
) -> Result<Option<Against>, Error> {
    let mut cells = Cells::none(halves.half(0).pixel_bounds());
    let rendered = match (groups, &given) {
        (Some(groups), _) => match halves.by_light(batch, scene, &groups, goes_on)? {
            Some(SortedReference { reference, squares }) => {
                cells.squares = in_squares(&squares);
                Some(reference)
            }
            None => return Ok(None),
        },
        (None, Some(_)) => None,
        (None, None) => match halves.whole(batch, scene, goes_on)? {
            Some(reference) => Some(reference),
            None => return Ok(None),
        },
    };
    let cells = Arc::new(cells);
    Ok(match (given, rendered) {
        (Some(mut given), _) => {
            given.cells = cells;
            Some(given)
        }
        (None, rendered) => rendered.map(|rendered| Against::of_halves(rendered, halves.spp, cells)),
    })
}

/// The pixels of each of [`Square::ALL`], also of those that have none.
fn in_squares(squares: &[Option<Square>]) -> Vec<cells::Square> {
    let pixels = |square: Square| (0_u32..).zip(squares).filter(move |(_, s)| **s == Some(square)).map(|(i, _)| i);
    let cell = |square: Square| cells::Square {
        plate: bsdf_name(square.bsdf).to_owned(),
        light: light_name(square.light).to_owned(),
        pixels: pixels(square).collect(),
    };
    Square::ALL.map(cell).into()
}

/// The numbers of one estimator.
fn curve(curves: &Curves, index: usize, sampler: &'static str, cells: &Cells) -> Curve {
    let estimator = &curves.plan.estimators[index];
    let errors = |part: Part| -> Vec<Vec<f64>> {
        (0..curves.plan.at.len()).map(|point| curves.squares([index, point], part, Measure::RelMse)).collect()
    };
    let points = |errors: &[Vec<f64>]| -> Vec<CurvePoint> {
        let point = |(point, errors): (usize, &Vec<f64>)| {
            let found = (!errors.is_empty()).then(|| mean_and_error(errors));
            let spp = curves.plan.at[point];
            CurvePoint {
                spp,
                rays: u64::from(spp) * u64::from(estimator.strategy.rays_per_sample()),
                cpu_seconds: curves.cpu_seconds(index, point),
                rel_mse: found.map(|(mean, _)| mean),
                standard_error: found.map(|(_, error)| error),
            }
        };
        errors.iter().enumerate().map(point).collect()
    };
    let square = |(i, (square, cell)): (usize, (Square, &cells::Square))| {
        let part = Part::Square(i);
        let (fit, errors) = (curves.slope(index, part, Measure::RelMse), errors(part));
        SquareCurve {
            light: square.light,
            bsdf: square.bsdf,
            pixels: cell.pixels.len(),
            slope: fit.map(|fit| fit.slope),
            slope_interval: fit.map(|fit| fit.interval),
            heavy_tailed: is_heavy_tailed(&errors),
            points: points(&errors),
        }
    };
    let (fit, whole) = (curves.slope(index, Part::Whole, Measure::RelMse), errors(Part::Whole));
    Curve {
        strategy: estimator.strategy.name(),
        heuristic: estimator.heuristic.name(),
        weights: estimator.weights.name(),
        light_prob: estimator.light_prob,
        sampler,
        slope: fit.map(|fit| fit.slope),
        slope_interval: fit.map(|fit| fit.interval),
        heavy_tailed: is_heavy_tailed(&whole),
        bias: estimator.bias(),
        points: points(&whole),
        squares: (!cells.squares.is_empty())
            .then(|| Square::ALL.into_iter().zip(&cells.squares).enumerate().map(square).collect()),
    }
}

/// See [`Curve::heavy_tailed`].
fn is_heavy_tailed(errors: &[Vec<f64>]) -> bool {
    let one_carries_it = |errors: &Vec<f64>| {
        let most = (2.0 / errors.len() as f64).max(0.5);
        errors.iter().copied().fold(0.0, f64::max) > most * errors.iter().sum::<f64>()
    };
    errors.iter().any(one_carries_it)
}
