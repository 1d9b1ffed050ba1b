//! How the error falls with the samples: relMSE of each strategy at given samples per pixel, with the slope of the line that
//! it draws on logarithmic axes.
//!
//! 1. *Points.* Every point is the mean over [`Options::replicates`] pictures, each rendered to just that many samples per pixel
//!    with a seed of its own. The samples of one pixel are stratified and so not independent; whole pictures are, and so
//!    are the points of a curve: the standard errors need no model.
//! 2. *Reference.* Two halves that share no sample, so that the reference's own noise does not add to the error
//!    ([`metrics::Reference::Halves`]); or a file, which is taken as exact.
//! 3. *Slope.* Least squares over log relMSE against log spp, and its 95 % interval by the jackknife over the replicates
//!    ([`slope`]). Independent samples have -1: four times the samples, half the error.

mod report;
pub mod slope;

use std::num::NonZeroU32;
use std::sync::Arc;

use mislab_kernel::request::{Estimator, Request, SamplerSettings, Sampling, Settings, Strategy};
use serde::Serialize;

use crate::batch::{Batch, Step, rays};
use crate::error::Error;
use crate::frame::Frame;
use crate::metrics::{self, Errors, Region};
use crate::snapshot::{Image, Window};
use crate::table::quality::{self, mean_and_error};
use crate::table::reference::{Plan, SortedReference, rgb, work};
use crate::table::regions::{Groups, Square};
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
    /// Relative mean squared error ([`metrics::rel_mse`]), mean over the replicates; `None` without pixels. Measured against
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

/// What there is to measure against, and the pixels that are measured by themselves.
struct Against {
    exact: Option<[Vec<f32>; 3]>,
    halves: Option<quality::Reference>,
    squares: Option<Vec<Option<Square>>>,
    noise: ReferenceNoise,
}

/// Errors of each replicate at each point: of the whole picture and, if asked for, its squares.
struct Measured {
    whole: Vec<Vec<f64>>,
    squares: [Vec<Vec<f64>>; 4],
    cpu_seconds: Vec<f64>,
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
    let settings: Vec<Vec<Settings>> =
        options.strategies.iter().map(|&s| options.at.iter().map(|&spp| with(request, s, spp)).collect()).collect();
    for settings in settings.iter().flatten() {
        settings.check().map_err(Error::Invalid)?;
    }
    let groups = options.by_square.then(|| Groups::of(&request.scene)).transpose()?;
    let exact = options.reference.as_ref().map(|image| exact(image, &settings[0][0])).transpose()?;
    let (image, spp) = (request.settings.image, options.reference_spp());
    let lights = match &groups {
        Some(groups) => groups.lights().count(),
        None => usize::from(exact.is_none()),
    };
    let points: f64 = settings.iter().flatten().map(rays).sum();
    let total = points * f64::from(options.replicates) + work(image, spp, lights);
    let mut batch = Batch::new(options.threads, total);

    let plan = Plan { image, spp, seed: request.settings.sampling.seed };
    let Some(against) = Against::measure(&plan, &mut batch, request, options, (groups, exact), goes_on)? else {
        return Ok(None);
    };
    let mut curves = Vec::new();
    for settings in &settings {
        let Some(measured) = measure(&mut batch, request, options, settings, &against, goes_on)? else {
            return Ok(None);
        };
        curves.push(curve(options, settings, &against, &measured));
    }
    let [width, height] = image.resolution;
    let scene = request.scene.name.clone();
    Ok(Some(Convergence { scene, width, height, replicates: options.replicates, reference: against.noise, curves }))
}

/// The request's settings with another strategy and spp, strata as square as can be.
fn with(request: &Request, strategy: Strategy, spp: u32) -> Settings {
    let Settings { estimator, sampling, image } = request.settings.clone();
    let sampler = SamplerSettings { strata: SamplerSettings::strata_for(spp), ..sampling.sampler };
    Settings {
        estimator: Estimator { strategy, ..estimator },
        sampling: Sampling { sampler, spp: NonZeroU32::new(spp), ..sampling },
        image,
    }
}

/// The planes of a reference file.
///
/// # Errors
/// [`Error::Invalid`] unless it holds the pixels of `settings` as numbers.
pub(crate) fn exact(image: &Image, settings: &Settings) -> Result<[Vec<f32>; 3], Error> {
    let bounds = settings.pixel_bounds();
    let expected = Window { min: bounds.min.map(|v| v as i32), size: [bounds.width(), bounds.height()] };
    if image.window != expected {
        return Err(Error::Invalid(format!(
            "the reference holds {}, the pictures {expected}: expected the same",
            image.window
        )));
    }
    let mut planes = [const { Vec::new() }; 3];
    for (plane, name) in planes.iter_mut().zip(["R", "G", "B"]) {
        let values = image.channel(name);
        let values = values.ok_or_else(|| Error::Invalid(format!("the reference has no channel {name}")))?;
        if let Some(at) = values.iter().position(|value| !value.is_finite()) {
            let (x, y) = (at as u32 % bounds.width(), at as u32 / bounds.width());
            return Err(Error::Invalid(format!(
                "the reference's channel {name} is {} at pixel {}, {}: expected numbers",
                values[at],
                bounds.min[0] + x,
                bounds.min[1] + y
            )));
        }
        *plane = values.to_vec();
    }
    Ok(planes)
}

impl Against {
    fn measure(
        plan: &Plan,
        batch: &mut Batch,
        request: &Request,
        options: &Options,
        (groups, exact): (Option<Groups>, Option<[Vec<f32>; 3]>),
        goes_on: &mut dyn FnMut(&Step<'_>) -> bool,
    ) -> Result<Option<Self>, Error> {
        let (halves, squares) = match groups {
            Some(groups) => match plan.by_light(batch, &request.scene, &groups, goes_on)? {
                Some(SortedReference { reference, squares }) => (Some(reference), Some(squares)),
                None => return Ok(None),
            },
            None if exact.is_some() => (None, None),
            None => match plan.whole(batch, &request.scene, goes_on)? {
                Some(reference) => (Some(reference), None),
                None => return Ok(None),
            },
        };
        let noise = match &options.reference {
            Some(image) => ReferenceNoise { spp: samples_per_pixel(image), rel_mse: None },
            None => ReferenceNoise { spp: Some(plan.spp), rel_mse: halves.as_ref().and_then(quality::Reference::own) },
        };
        Ok(Some(Self { halves: halves.filter(|_| exact.is_none()), exact, squares, noise }))
    }

    /// relMSE of a picture's pixels in a region.
    fn rel_mse(&self, picture: [&[f32]; 3], region: &Region<'_>) -> Option<f64> {
        match (&self.exact, &self.halves) {
            (Some(planes), _) => {
                let planes = planes.each_ref().map(Vec::as_slice);
                Errors::of(&picture, &metrics::Reference::Exact(&planes), region).rel_mse()
            }
            (None, Some(halves)) => halves.errors(picture, region).rel_mse(),
            (None, None) => None,
        }
    }

    fn mask(&self, square: Square) -> Option<Vec<bool>> {
        self.squares.as_ref().map(|squares| squares.iter().map(|&s| s == Some(square)).collect())
    }
}

/// What an EXR file says of its samples: an attribute of pbrt-v4 and of this program.
pub(crate) fn samples_per_pixel(image: &Image) -> Option<u32> {
    image.attributes.iter().find(|(name, _)| name == "samplesPerPixel").and_then(|(_, text)| text.parse().ok())
}

/// All pictures of one strategy.
fn measure(
    batch: &mut Batch,
    request: &Request,
    options: &Options,
    settings: &[Settings],
    against: &Against,
    goes_on: &mut dyn FnMut(&Step<'_>) -> bool,
) -> Result<Option<Measured>, Error> {
    let masks = Square::ALL.map(|square| against.mask(square));
    let mut measured = Measured { whole: Vec::new(), squares: Default::default(), cpu_seconds: Vec::new() };
    for (i, settings) in settings.iter().enumerate() {
        let (mut whole, mut squares) = (Vec::new(), [const { Vec::<f64>::new() }; 4]);
        let mut seconds = 0.0;
        for replicate in 0..options.replicates {
            let mut settings = settings.clone();
            // No two pictures of a curve share their numbers.
            let number = i as u32 * options.replicates + replicate;
            settings.sampling.seed = settings.sampling.seed.wrapping_add(number);
            let name = settings.estimator.strategy.name();
            let step = format!("{name}, {} spp, {} of {}", options.at[i], replicate + 1, options.replicates);
            let frame: Option<Arc<Frame>> = batch.render(&request.scene, settings, &step, goes_on)?;
            let Some(frame) = frame else { return Ok(None) };
            seconds += frame.stats().cpu_seconds;
            let planes = rgb(&frame);
            let picture = [&planes[0][..], &planes[1], &planes[2]];
            whole.extend(against.rel_mse(picture, &Region::All));
            for (errors, mask) in squares.iter_mut().zip(&masks) {
                errors.extend(mask.as_ref().and_then(|mask| against.rel_mse(picture, &Region::Mask(mask))));
            }
        }
        measured.whole.push(whole);
        for (all, errors) in measured.squares.iter_mut().zip(squares) {
            all.push(errors);
        }
        measured.cpu_seconds.push(seconds / f64::from(options.replicates));
    }
    Ok(Some(measured))
}

/// The numbers of one strategy.
fn curve(options: &Options, settings: &[Settings], against: &Against, measured: &Measured) -> Curve {
    let Settings { estimator, sampling, .. } = &settings[0];
    let points = |errors: &[Vec<f64>]| -> Vec<CurvePoint> {
        let point = |(i, errors): (usize, &Vec<f64>)| {
            let found = (!errors.is_empty()).then(|| mean_and_error(errors));
            CurvePoint {
                spp: options.at[i],
                rays: u64::from(options.at[i]) * u64::from(estimator.strategy.rays_per_sample()),
                cpu_seconds: measured.cpu_seconds[i],
                rel_mse: found.map(|(mean, _)| mean),
                standard_error: found.map(|(_, error)| error),
            }
        };
        errors.iter().enumerate().map(point).collect()
    };
    let fit = |errors: &[Vec<f64>]| slope::fit(&options.at, errors);
    let square = |(i, square): (usize, Square), squares: &[Option<Square>]| {
        let fit = fit(&measured.squares[i]);
        SquareCurve {
            light: square.light,
            bsdf: square.bsdf,
            pixels: squares.iter().filter(|s| **s == Some(square)).count(),
            slope: fit.map(|fit| fit.slope),
            slope_interval: fit.map(|fit| fit.interval),
            heavy_tailed: is_heavy_tailed(&measured.squares[i]),
            points: points(&measured.squares[i]),
        }
    };
    let whole = fit(&measured.whole);
    Curve {
        strategy: estimator.strategy.name(),
        heuristic: estimator.heuristic.name(),
        weights: estimator.weights.name(),
        light_prob: estimator.light_prob,
        sampler: sampling.sampler.kind.name(),
        slope: whole.map(|fit| fit.slope),
        slope_interval: whole.map(|fit| fit.interval),
        heavy_tailed: is_heavy_tailed(&measured.whole),
        bias: estimator.bias(),
        points: points(&measured.whole),
        squares: against
            .squares
            .as_ref()
            .map(|squares| Square::ALL.into_iter().enumerate().map(|each| square(each, squares)).collect()),
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
