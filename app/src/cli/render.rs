//! `mislab render`: one picture.

use std::sync::Arc;

use mislab_renderer::black::why_black;
use mislab_renderer::blind::why_blind;
use mislab_renderer::{
    Estimator, Frame, FrameStats, ImageSettings, PixelRect, Request, SamplerSettings, Sampling, Scene, Settings,
};
use serde::Serialize;

use super::args::{Alpha, NumbersArgs, PictureArgs, PlaceArgs, RenderArgs, SampleArgs};
use super::failure::Failure;
use super::input::Input;
use super::output::{self, PictureFile};
use super::progress::Bar;
use crate::panel::number::{seconds, si, three_digits};

/// `--quick`: width and height are divided by this (pbrt-v3: the same) ...
const QUICK_SHRINK: u32 = 4;
/// ... and samples per pixel are at most this. pbrt-v3 takes one; of one sample no variance is known.
const QUICK_SPP: u32 = 4;

pub(super) fn run(args: RenderArgs) -> Result<(), Failure> {
    let input = Input::load(args.picture.scene.as_deref())?;
    input.warn(args.how.quiet);
    let mut settings = input.settings.clone();
    if args.quick {
        settings.image.resolution = settings.image.resolution.map(|side| (side / QUICK_SHRINK).max(1));
    }
    let quick_spp =
        settings.sampling.spp.filter(|spp| args.quick && spp.get() > QUICK_SPP).and(QUICK_SPP.try_into().ok());
    let SampleArgs { strategy, spp } = args.samples;
    let settings = with_samples(SampleArgs { strategy, spp: spp.or(quick_spp) }, settings);
    let request = request(&args.picture, Request { scene: input.scene.clone(), settings })?;

    // Only a file that is named here is replaced.
    let asked_for = args.outfile.is_some();
    let mut outfile = match args.outfile {
        Some(file) => file,
        None => {
            let name = input.picture_name(request.settings.estimator.strategy);
            PictureFile::new(name.clone().into()).ok_or_else(|| {
                Failure::Run(format!(
                    "{}: Film's filename is \"{name}\", expected a name that ends in .exr or .png; name one with --outfile",
                    input.source
                ))
            })?
        }
    };
    outfile.check()?;
    if let Some(json) = &args.json {
        json.check()?;
    }

    let frame = {
        let bar = Bar::new(args.how.quiet);
        mislab_renderer::render(&request, args.how.nthreads, &mut |progress| {
            bar.show_picture(progress);
            true
        })?
    };
    let (notice, kept) = if asked_for { (outfile.save(&frame)?, None) } else { outfile.save_beside(&frame)? };
    if let Some(kept) = kept {
        // Also with --quiet: the picture is not where it is looked for.
        output::message(&output::kept(&kept, outfile.path()));
    }
    let Request { scene, settings } = &**frame.request();
    let bias = settings.estimator.bias().map(str::to_owned).or_else(|| why_blind(scene, &settings.estimator));
    let mut report = Report::new(&input, &frame, &outfile);
    let about_picture: Vec<String> = notice.into_iter().chain(report.invalid()).chain(bias).collect();
    let black = why_black(&frame);
    for warning in about_picture.iter().filter(|_| !args.how.quiet).chain(&black) {
        // That a picture is black is said even with --quiet: it is not what anybody wants.
        output::message(&format!("{}: warning: {warning}", outfile.path().display()));
    }
    if !args.how.quiet {
        output::message(&report.summary());
    }
    report.warnings.extend(about_picture.into_iter().chain(black));
    args.json.map_or(Ok(()), |json| json.write(&report))
}

/// Puts strategy and samples per pixel that the command line names over what the scene file says.
pub(super) fn with_samples(args: SampleArgs, mut settings: Settings) -> Settings {
    settings.estimator.strategy = args.strategy.unwrap_or(settings.estimator.strategy);
    if let Some(spp) = args.spp {
        settings.sampling.spp = Some(spp);
        settings.sampling.sampler.strata = SamplerSettings::strata_for(spp.get());
    }
    settings
}

/// What is known of the one pixel that is asked about: where its picture comes from, the picture, and the pixel.
pub(super) fn place(args: &PlaceArgs, numbers: &NumbersArgs) -> Result<(Input, Request, [u32; 2]), Failure> {
    if let Some(json) = &numbers.json {
        json.check()?;
    }
    let input = Input::load(args.picture.scene.as_deref())?;
    input.warn(numbers.quiet);
    let settings = with_samples(args.samples, input.settings.clone());
    let request = request(&args.picture, Request { scene: input.scene.clone(), settings })?;
    let pixel = args.pixel_of(&request.settings)?;
    Ok((input, request, pixel))
}

/// Puts what else the command line names over what the scene file says.
pub(super) fn request(args: &PictureArgs, from: Request) -> Result<Request, Failure> {
    let Request { mut scene, mut settings } = from;
    settings.image.resolution = args.size.unwrap_or(settings.image.resolution);
    if let Some(&[x0, x1, y0, y1]) = args.cropwindow.as_deref() {
        settings.image.crop = [x0, x1, y0, y1];
    }
    settings.estimator.light_prob = args.light_prob.unwrap_or(settings.estimator.light_prob);
    settings.estimator.heuristic = args.heuristic.unwrap_or(settings.estimator.heuristic);
    settings.estimator.weights = args.weights.unwrap_or(settings.estimator.weights);
    settings.sampling.seed = args.seed.unwrap_or(settings.sampling.seed);
    settings.sampling.sampler.kind = args.sampler.unwrap_or(settings.sampling.sampler.kind);
    settings.check().map_err(Failure::Usage)?;
    for edit in &args.alpha {
        set_alpha(Arc::make_mut(&mut scene), edit)?;
    }
    Ok(Request { scene, settings })
}

fn set_alpha(scene: &mut Scene, edit: &Alpha) -> Result<(), Failure> {
    let Alpha { material: name, value } = edit;
    if let Some(alpha) = scene.material_mut(name).and_then(|material| material.bsdf.alpha_mut()) {
        *alpha = *value;
        return Ok(());
    }
    let found = if scene.material(name).is_some() { "has no roughness" } else { "is not in the scene" };
    let rough = scene.materials.iter().filter(|material| material.bsdf.alpha().is_some());
    let names: Vec<&str> = rough.map(|material| material.name.as_str()).collect();
    let expected = if names.is_empty() {
        "no material here has one".to_owned()
    } else {
        format!("expected one of {}", names.join(", "))
    };
    Err(Failure::Usage(format!("--alpha: material \"{name}\" {found}, {expected}")))
}

/// What was rendered and what it took: the object of `--json`. Its keys are an interface.
#[derive(Serialize)]
struct Report {
    scene: String,
    outfile: String,
    strategy: &'static str,
    heuristic: &'static str,
    weights: &'static str,
    light_prob: f32,
    sampler: &'static str,
    /// Strata along x and y; null for other samplers.
    strata: Option<[u32; 2]>,
    jitter: Option<bool>,
    spp: u32,
    seed: u32,
    /// Full image.
    width: u32,
    height: u32,
    /// Pixels rendered: x0, x1, y0, y1, the ends excluded.
    pixel_bounds: [u32; 4],
    paths: u64,
    render_seconds: f64,
    cpu_seconds: f64,
    mpaths_per_second: f64,
    threads: usize,
    simd: &'static str,
    invalid_samples: u64,
    /// What is to be known about the scene file and the picture, one sentence each.
    warnings: Vec<String>,
    version: &'static str,
}

impl Report {
    fn new(input: &Input, frame: &Frame, outfile: &PictureFile) -> Self {
        let stats = frame.stats();
        let FrameStats { paths, render_seconds, cpu_seconds, threads, simd, invalid_samples } = stats;
        let Settings { estimator, sampling, image } = frame.request().settings;
        let Estimator { strategy, light_prob, heuristic, weights } = estimator;
        let Sampling { sampler, seed, spp: _ } = sampling;
        let ImageSettings { resolution, crop: _ } = image;
        let PixelRect { min, max } = frame.bounds();
        let is_stratified = sampler.kind.has_strata();
        Self {
            scene: input.source.clone(),
            outfile: outfile.path().display().to_string(),
            strategy: strategy.name(),
            heuristic: heuristic.name(),
            weights: weights.name(),
            light_prob,
            sampler: sampler.kind.name(),
            strata: is_stratified.then_some(sampler.strata),
            jitter: is_stratified.then_some(sampler.jitter),
            spp: frame.spp(),
            seed,
            width: resolution[0],
            height: resolution[1],
            pixel_bounds: [min[0], max[0], min[1], max[1]],
            paths,
            render_seconds,
            cpu_seconds,
            mpaths_per_second: stats.mpaths_per_second(),
            threads,
            simd,
            invalid_samples,
            warnings: input.warnings().collect(),
            version: env!("CARGO_PKG_VERSION"),
        }
    }

    fn invalid(&self) -> Option<String> {
        (self.invalid_samples > 0)
            .then(|| format!("{} samples were not finite numbers and are left out", self.invalid_samples))
    }

    fn summary(&self) -> String {
        format!(
            "{}: {}, {} spp, {} paths in {}, {} Mpaths/s",
            self.outfile,
            self.strategy,
            self.spp,
            si(self.paths as f64),
            seconds(self.render_seconds),
            three_digits(self.mpaths_per_second)
        )
    }
}
