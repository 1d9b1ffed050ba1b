//! `mislab fireflies`: the samples that outweigh all others of their pixel.

use std::fmt::Write as _;
use std::path::Path;

use mislab_renderer::inspect::{Fireflies, Outlier, Search, Suspect, fireflies, suspects_of_frame, suspects_of_layers};
use mislab_renderer::kernel::film::LUMINANCE;
use mislab_renderer::kernel::lanes::Lanewise;
use mislab_renderer::kernel::world::BuiltScene;
use mislab_renderer::snapshot::{self, Window};
use mislab_renderer::{Error, Request, Settings};
use serde::Serialize;

use super::args::{FirefliesArgs, HowArgs};
use super::failure::Failure;
use super::input::Input;
use super::output::{self, technique_name};
use super::progress::Bar;

/// Most samples that are drawn again: about a minute's.
const MOST_SAMPLES: u64 = 50_000_000;

pub(super) fn run(args: &FirefliesArgs) -> Result<(), Failure> {
    if let Some(json) = &args.json {
        json.check()?;
    }
    let input = Input::load(args.scene.as_deref())?;
    input.warn(args.how.quiet);
    let request = Request { scene: input.scene.clone(), settings: input.settings.clone() };
    let built = BuiltScene::new(&request.scene, &request.settings).map_err(Error::from)?;
    let (spp, suspects) = match args.scene.as_deref() {
        Some(path) if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) => of_file(path, &request)?,
        _ => of_scene(&request, &args.how)?,
    };
    let search = Search {
        scene: &built,
        settings: &request.settings,
        spp,
        how: Lanewise::best(),
        count: args.count,
        threads: args.how.nthreads,
        most_samples: MOST_SAMPLES,
    };
    let found = fireflies(&search, suspects, &|| true).ok_or_else(|| Failure::Run("stopped".to_owned()))?;
    if found.different > 0 && !args.how.quiet {
        let (different, examined) = (found.different, found.examined);
        output::message(&format!(
            "{}: warning: the samples of {different} of {examined} pixels do not add up to the picture, which was \
             rendered by another version or on another kind of processor",
            input.source
        ));
    }
    let report = Report::new(&input.source, &request.settings, spp, &found);
    output::report(args.json.as_ref(), &report, &report.text())
}

/// From the layers of a picture of ours; nothing is rendered.
fn of_file(path: &Path, request: &Request) -> Result<(u32, Vec<Suspect>), Failure> {
    let image = snapshot::load_image(path)?;
    let bounds = request.settings.pixel_bounds();
    let spp = request.settings.sampling.target().unwrap_or(1);
    let window = Window {
        min: bounds.min.map(|v| i32::try_from(v).unwrap_or(i32::MAX)),
        size: [bounds.width(), bounds.height()],
    };
    if image.window != window {
        let found = image.window;
        return Err(Failure::Run(format!("{}: pixels {found}, expected {window} by its settings", path.display())));
    }
    let suspects = suspects_of_layers(bounds, spp, &|channel| image.channel(channel.exr_name())).ok_or_else(|| {
        Failure::Run(format!("{}: a layer is missing, expected a picture as this program saves it", path.display()))
    })?;
    Ok((spp, suspects))
}

/// Renders the scene.
fn of_scene(request: &Request, how: &HowArgs) -> Result<(u32, Vec<Suspect>), Failure> {
    let frame = {
        let bar = Bar::new(how.quiet);
        mislab_renderer::render(request, how.nthreads, &mut |progress| {
            bar.show_picture(progress);
            true
        })?
    };
    Ok((frame.spp(), suspects_of_frame(&frame)))
}

/// The object of `--json`. Its keys are an interface.
#[derive(Serialize)]
struct Report<'a> {
    scene: &'a str,
    strategy: &'static str,
    spp: u32,
    /// The brightest first.
    outliers: Vec<Line>,
    /// True if no pixel left out can have a brighter one.
    complete: bool,
}

/// A sample whose secondary ray has more than half of the sum of squares of its pixel.
#[derive(Serialize)]
struct Line {
    pixel: [u32; 2],
    index: u32,
    technique: &'static str,
    /// Luminance.
    value: f64,
    share_of_pixel: f64,
    /// Per channel, of all samples and of all others.
    mean: [f64; 3],
    mean_without: [f64; 3],
    /// Luminance of the same direction under `mis_all`.
    under_mis_all: f64,
}

impl Line {
    fn new(outlier: &Outlier) -> Self {
        let Outlier { pixel, index, sample, ray, value, share_of_pixel, mean, mean_without, under_mis_all } = outlier;
        Self {
            pixel: *pixel,
            index: *index,
            technique: technique_name(sample.rays[*ray].technique),
            value: *value,
            share_of_pixel: *share_of_pixel,
            mean: mean.to_array(),
            mean_without: mean_without.to_array(),
            under_mis_all: *under_mis_all,
        }
    }
}

impl<'a> Report<'a> {
    fn new(source: &'a str, settings: &Settings, spp: u32, found: &Fireflies) -> Self {
        Self {
            scene: source,
            strategy: settings.estimator.strategy.name(),
            spp,
            outliers: found.outliers.iter().map(Line::new).collect(),
            complete: found.complete,
        }
    }

    /// For people.
    fn text(&self) -> String {
        let Self { scene, strategy, spp, outliers, complete } = self;
        let mut text = format!("{scene}: strategy {strategy}, {spp} spp\n");
        if outliers.is_empty() {
            text.push_str("No sample outweighs all others of its pixel.\n");
            return text;
        }
        let _ = writeln!(
            text,
            "{:>6} {:>6} {:>9}  {:<9} {:>12} {:>9} {:>12} {:>12} {:>12}",
            "x", "y", "index", "technique", "value", "of pixel", "pixel", "without it", "in mis_all"
        );
        for Line { pixel: [x, y], index, technique, value, share_of_pixel, mean, mean_without, under_mis_all } in
            outliers
        {
            let [mean, without] = [mean, mean_without].map(luminance);
            let _ = writeln!(
                text,
                "{x:>6} {y:>6} {index:>9}  {technique:<9} {value:>12.5e} {:>7.2} % {mean:>12.5e} {without:>12.5e} \
                 {under_mis_all:>12.5e}",
                100.0 * share_of_pixel
            );
        }
        text.push_str(
            "Luminances in W/(m^2 sr): of the sample, its share of the pixel's sum, the pixel's mean with and \
             without it, and the same direction under mis_all.\n",
        );
        if !complete {
            text.push_str("There may be brighter ones: not all suspicious pixels were drawn again.\n");
        }
        text
    }
}

fn luminance(rgb: &[f64; 3]) -> f64 {
    rgb.iter().zip(LUMINANCE).map(|(c, weight)| c * f64::from(weight)).sum()
}
