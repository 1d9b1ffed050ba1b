//! The tutorial's Table 1, measured: execution time of its files and where each is good.
//!
//! The tutorial asks for a cross in the squares (light small or large, BSDF sharp or broad) where a file looks best. Here
//! each square gets a number, and the cross follows from it:
//!
//! 1. *Files.* The four pictures of [`TutorialRun::ALL`], with the tutorial's strata and image sizes.
//! 2. *Reference.* For each image size that occurs, and for each light alone (the others off), two independent halves
//!    of [`TableOptions::reference_spp`]. Their sum over the lights is the converged picture at that size, pixel for
//!    pixel comparable to the files of the size; one light's part says whose pixel it is ([`regions`]).
//! 3. *Replicates.* The files again, with other seeds. The samples inside a pixel are stratified and so not independent:
//!    their own scatter is no error bar, but whole pictures with different seeds are independent. The relMSE of a square
//!    ([`quality`]) is the mean over the replicates, its uncertainty their standard error.
//! 4. *Crosses.* The smallest relMSE of a square, and all that a rank test cannot tell from it: with five replicates, a file
//!    misses the cross if each of its renders is worse than each of the best file's.
//!
//! relMSE is an average per pixel, so that files of different sizes share a square fairly; their times do not compare.
//! [`TableOptions::size`] puts all four on one size.

pub mod quality;
pub(crate) mod reference;
pub mod regions;
pub(crate) mod report;

use std::cell::RefCell;
use std::num::NonZeroU32;
use std::sync::Arc;
use std::time::Duration;

use mislab_kernel::request::scene::Scene;
use mislab_kernel::request::{Estimator, ImageSettings, SamplerKind, SamplerSettings, Sampling, Settings, Strategy};
use serde::Serialize;

pub use self::report::with_error;

use self::quality::{crosses, mean_and_error, sidak};
use self::reference::{SortedReference, rgb};
use self::regions::{Groups, Square};
use crate::batch::{Batch, Step, rays};
use crate::error::Error;
use crate::frame::Frame;

/// One file the tutorial asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct TutorialRun {
    /// Its name.
    pub file: &'static str,
    /// How directions are chosen.
    pub strategy: Strategy,
    /// Stratified samples per pixel, along x and y.
    pub strata: [u32; 2],
    /// Width and height as the tutorial's header says.
    pub size: [u32; 2],
}

impl TutorialRun {
    /// The four files, in the tutorial's order.
    pub const ALL: [Self; 4] = [
        Self { file: "veachMIS_L.exr", strategy: Strategy::Light, strata: [8, 8], size: [800, 800] },
        Self { file: "veachMIS_BSDF.exr", strategy: Strategy::Bsdf, strata: [8, 8], size: [800, 800] },
        Self { file: "veach_MIS_ALLx36.exr", strategy: Strategy::MisAll, strata: [6, 6], size: [600, 600] },
        Self { file: "veachMIS_MIS.exr", strategy: Strategy::Mis, strata: [8, 8], size: [800, 800] },
    ];

    /// The settings of the file: c = 1/2, the balance heuristic, jittered strata.
    /// `size` replaces the tutorial's own.
    pub fn settings(&self, size: Option<[u32; 2]>, seed: u32) -> Settings {
        let [nx, ny] = self.strata;
        Settings {
            estimator: Estimator { strategy: self.strategy, ..Estimator::default() },
            sampling: Sampling {
                sampler: SamplerSettings { kind: SamplerKind::Stratified, strata: self.strata, jitter: true },
                spp: NonZeroU32::new(nx * ny),
                seed,
            },
            image: ImageSettings { resolution: size.unwrap_or(self.size), ..ImageSettings::default() },
        }
    }
}

/// How to fill the table in.
#[derive(Clone, Debug, PartialEq)]
pub struct TableOptions {
    /// Image size of every file; `None`: the tutorial's own (600 x 600 for `mis_all`, else 800 x 800).
    pub size: Option<[u32; 2]>,
    /// Camera rays per pixel of the reference, for each light.
    pub reference_spp: u32,
    /// Renders of each file with different seeds, [`MIN_REPLICATES`] to 100; the first is the file itself.
    pub replicates: u32,
    /// Worker threads; 0: one per core.
    pub threads: usize,
    /// Seed of the files.
    pub seed: u32,
}

impl Default for TableOptions {
    fn default() -> Self {
        Self { size: None, reference_spp: 256, replicates: MIN_REPLICATES, threads: 0, seed: 1 }
    }
}

/// With fewer, not even a file whose every render is worse than the best file's could be told from it: the rank test's
/// smallest p-value, one over the number of ways to order the renders (252 for 5 and 5), is above the significance.
pub const MIN_REPLICATES: u32 = 5;

/// How far [`run_table`] is.
#[derive(Clone, Debug)]
pub struct TableProgress {
    /// What is being rendered, for people: "veachMIS_L.exr", "reference 800 x 800, light 2 of 4".
    pub step: String,
    /// Share of all the work that is done, in [0, 1]. Counted in secondary rays.
    pub fraction: f64,
    /// Since the start.
    pub elapsed: Duration,
    /// Whether execution time counts.
    pub timing: Timing,
    /// A file that has just been finished, with its picture: reported once each, so that it can be shown or saved at once.
    pub finished: Option<(TutorialRun, Arc<Frame>)>,
}

/// Whether the time of what is rendered goes into the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Timing {
    /// It does not.
    No,
    /// It does, and begins when this report returns.
    Next,
    /// It does, and runs: whoever draws progress spoils it.
    Now,
}

/// Size of the light a pixel reflects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LightSize {
    /// The smaller half of the lights.
    Small,
    /// The larger half.
    Large,
}

/// Width of the BSDF lobe of a plate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LobeWidth {
    /// The rougher half of the plates (3 and 4).
    Broad,
    /// The smoother half (1 and 2).
    Sharp,
}

/// One of the four squares of a file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cell {
    /// The row.
    pub light: LightSize,
    /// The column.
    pub bsdf: LobeWidth,
    /// Pixels that belong to it.
    pub pixels: usize,
    /// Relative mean squared error, mean over the replicates; `None` without pixels.
    pub rel_mse: Option<f64>,
    /// Standard error of `rel_mse` over the replicates.
    pub standard_error: Option<f64>,
    /// The reference's own relMSE. It does not add to `rel_mse`, but the choice of pixels rests on it.
    pub reference_rel_mse: Option<f64>,
    /// The best file of this square, or not distinguishable from it.
    pub cross: bool,
}

/// One file of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TableRow {
    /// Which.
    #[serde(flatten)]
    pub run: TutorialRun,
    /// Image size it was rendered at.
    pub resolution: [u32; 2],
    /// Camera rays per pixel.
    pub spp: u32,
    /// Secondary rays traced for the file.
    pub paths: u64,
    /// Execution time of the file: wall-clock seconds.
    pub render_seconds: f64,
    /// Execution time summed over threads.
    pub cpu_seconds: f64,
    /// Worker threads.
    pub threads: usize,
    /// Small/broad, small/sharp, large/broad, large/sharp.
    pub cells: [Cell; 4],
}

/// The tutorial's Table 1, filled in.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Table {
    /// The scene's name.
    pub scene: String,
    /// Names of the materials that count as sharp and as broad.
    pub sharp: Vec<String>,
    /// See `sharp`.
    pub broad: Vec<String>,
    /// Names of the lights that count as small.
    pub small: Vec<String>,
    /// See `small`.
    pub large: Vec<String>,
    /// Camera rays per pixel of the reference, for each light.
    pub reference_spp: u32,
    /// Renders of each file.
    pub replicates: u32,
    /// Probability that any file of the table misses a cross although it is as good as the best of its square.
    pub significance: f64,
    /// The files, in the tutorial's order.
    pub rows: Vec<TableRow>,
}

impl Table {
    /// For people: a Markdown table and what its numbers mean.
    pub fn to_markdown(&self) -> String {
        report::markdown(self)
    }

    /// For spreadsheets: a head line, then one line per file and square.
    pub fn to_csv(&self) -> String {
        report::csv(self)
    }

    /// For programs: this struct, indented.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("a struct of numbers and names is always JSON")
    }
}

/// A finished table.
#[derive(Debug)]
pub struct TableResult {
    /// The numbers.
    pub table: Table,
    /// The pictures of the four files, in the order of [`TutorialRun::ALL`].
    pub frames: Vec<Arc<Frame>>,
}

/// Renders the tutorial's files, the references they are measured against, and fills the table in. Blocks; call it from a
/// thread of its own. `progress` is called several times a second, before each file and after it, and returns false to stop,
/// upon which the result is `None`.
///
/// # Errors
/// [`Error::Invalid`] if the scene has no plates or lights to sort the pixels by, an option is out of range, or the scene
/// cannot be rendered.
pub fn run_table(
    scene: &Arc<Scene>,
    options: &TableOptions,
    progress: &mut dyn FnMut(&TableProgress) -> bool,
) -> Result<Option<TableResult>, Error> {
    const MAX_REPLICATES: u32 = 100;
    if !(MIN_REPLICATES..=MAX_REPLICATES).contains(&options.replicates) || options.reference_spp < 2 {
        return Err(Error::Invalid(format!(
            "{} replicates and {} reference samples, expected {MIN_REPLICATES} to {MAX_REPLICATES} and at least 2",
            options.replicates, options.reference_spp
        )));
    }
    let groups = Groups::of(scene)?;
    let mut sizes: Vec<[u32; 2]> = TutorialRun::ALL.map(|run| options.size.unwrap_or(run.size)).into();
    sizes.sort_unstable();
    sizes.dedup();
    for run in TutorialRun::ALL {
        run.settings(options.size, options.seed).check().map_err(Error::Invalid)?;
    }
    let image = |size| ImageSettings { resolution: size, ..ImageSettings::default() };
    let work: f64 = TutorialRun::ALL.map(|run| rays(&run.settings(options.size, 0))).iter().sum();
    let references: f64 =
        sizes.iter().map(|&size| reference::work(image(size), options.reference_spp, groups.lights().count())).sum();
    let mut batch = Batch::new(options.threads, work * f64::from(options.replicates) + references);
    let progress = RefCell::new(progress);
    let report = |step: &Step<'_>, timing: Timing, finished: Option<(TutorialRun, Arc<Frame>)>| {
        let Step { step, fraction, elapsed } = *step;
        (progress.borrow_mut())(&TableProgress { step: step.to_owned(), fraction, elapsed, timing, finished })
    };
    let mut goes_on = |step: &Step<'_>| report(step, Timing::No, None);

    // The files first: they are what a waiting person looks at.
    let mut frames = Vec::new();
    for run in TutorialRun::ALL {
        let settings = run.settings(options.size, options.seed);
        if !report(&batch.step(run.file), Timing::Next, None) {
            return Ok(None);
        }
        let mut timed = |step: &Step<'_>| report(step, Timing::Now, None);
        let Some(frame) = batch.render(scene, settings, run.file, &mut timed)? else { return Ok(None) };
        if !report(&batch.step(run.file), Timing::No, Some((run, Arc::clone(&frame)))) {
            return Ok(None);
        }
        frames.push(frame);
    }
    let mut references = Vec::new();
    for &size in &sizes {
        let plan = reference::Plan { image: image(size), spp: options.reference_spp, seed: options.seed };
        let Some(reference) = plan.by_light(&mut batch, scene, &groups, &mut goes_on)? else { return Ok(None) };
        references.push((size, reference));
    }

    let reference_of = |run: &TutorialRun| {
        let size = options.size.unwrap_or(run.size);
        &references.iter().find(|(s, _)| *s == size).expect("every size has a reference").1
    };
    // errors[file][square][replicate]
    let mut errors: [[Vec<f64>; 4]; 4] = Default::default();
    for (file, run) in TutorialRun::ALL.into_iter().enumerate() {
        let sorted = reference_of(&run);
        for replicate in 0..options.replicates {
            let frame = if replicate == 0 {
                Arc::clone(&frames[file])
            } else {
                let settings = run.settings(options.size, options.seed.wrapping_add(replicate));
                let step = format!("{}, replicate {} of {}", run.file, replicate + 1, options.replicates);
                let Some(frame) = batch.render(scene, settings, &step, &mut goes_on)? else { return Ok(None) };
                frame
            };
            let rgb = rgb(&frame);
            let found = sorted.reference.rel_mse([&rgb[0], &rgb[1], &rgb[2]], &sorted.squares);
            for (list, value) in errors[file].iter_mut().zip(found) {
                list.extend(value);
            }
        }
    }

    Ok(Some(TableResult { table: fill_in(scene, options, &groups, &frames, &errors, reference_of), frames }))
}

/// Probability of any false alarm in the whole table.
const SIGNIFICANCE: f64 = 0.05;

/// The numbers, once everything is rendered.
fn fill_in<'a>(
    scene: &Scene,
    options: &TableOptions,
    groups: &Groups,
    frames: &[Arc<Frame>],
    errors: &[[Vec<f64>; 4]; 4],
    reference_of: impl Fn(&TutorialRun) -> &'a SortedReference,
) -> Table {
    // In each square, every file but the best is compared with it.
    let comparisons = Square::ALL.len() * (TutorialRun::ALL.len() - 1);
    let each = sidak(SIGNIFICANCE, comparisons as u32);
    let cross: Vec<Vec<bool>> =
        (0..4).map(|square| crosses(&errors.each_ref().map(|file| file[square].as_slice()), each)).collect();
    let measured = |values: &[f64]| (!values.is_empty()).then(|| mean_and_error(values));
    let row = |(file, run): (usize, TutorialRun)| {
        let (stats, sorted) = (frames[file].stats(), reference_of(&run));
        let own = sorted.reference.own_rel_mse(&sorted.squares);
        TableRow {
            run,
            resolution: options.size.unwrap_or(run.size),
            spp: frames[file].spp(),
            paths: stats.paths,
            render_seconds: stats.render_seconds,
            cpu_seconds: stats.cpu_seconds,
            threads: stats.threads,
            cells: std::array::from_fn(|i| Cell {
                light: Square::ALL[i].light,
                bsdf: Square::ALL[i].bsdf,
                pixels: sorted.squares.iter().filter(|s| **s == Some(Square::ALL[i])).count(),
                rel_mse: measured(&errors[file][i]).map(|(mean, _)| mean),
                standard_error: measured(&errors[file][i]).map(|(_, error)| error),
                reference_rel_mse: own[i],
                cross: cross[i][file],
            }),
        }
    };
    let materials = |list: &[usize]| list.iter().map(|&m| scene.materials[m].name.clone()).collect();
    let light_name = |&s: &usize| scene.shapes[s].light.as_ref().map_or(String::new(), |light| light.name.clone());
    Table {
        scene: scene.name.clone(),
        sharp: materials(&groups.sharp),
        broad: materials(&groups.broad),
        small: groups.small.iter().map(light_name).collect(),
        large: groups.large.iter().map(light_name).collect(),
        reference_spp: options.reference_spp,
        replicates: options.replicates,
        significance: SIGNIFICANCE,
        rows: TutorialRun::ALL.into_iter().enumerate().map(row).collect(),
    }
}
