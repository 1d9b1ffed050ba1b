//! The tutorial's Table 1, measured: execution time of its files and where each is good.

use std::sync::Arc;
use std::time::Duration;

use serde::Serialize;

use crate::error::Error;
use crate::frame::Frame;
use crate::scene::Scene;
use crate::settings::{Settings, Strategy};

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
        let _ = (size, seed);
        unimplemented!()
    }
}

/// How to fill the table in.
#[derive(Clone, Debug, PartialEq)]
pub struct TableOptions {
    /// Image size of every file; `None`: the tutorial's own (600 x 600 for `mis_all`, else 800 x 800).
    pub size: Option<[u32; 2]>,
    /// Camera rays per pixel of the reference, for each light.
    pub reference_spp: u32,
    /// Renders of each file with different seeds, at least 2; the first is the file itself.
    pub replicates: u32,
    /// Worker threads; 0: one per core.
    pub threads: usize,
    /// Seed of the files.
    pub seed: u32,
}

impl Default for TableOptions {
    fn default() -> Self {
        Self { size: None, reference_spp: 256, replicates: 4, threads: 0, seed: 1 }
    }
}

/// How far [`run_table`] is.
#[derive(Clone, Debug)]
pub struct TableProgress {
    /// What is being rendered, for people: "veachMIS_L.exr", "reference 800 x 800, light 2 of 4".
    pub step: String,
    /// Share of all the work that is done, in [0, 1]. Counted in secondary rays.
    pub fraction: f64,
    /// Since the start.
    pub elapsed: Duration,
    /// A file that has just been finished, with its picture: reported once each, so that it can be shown or saved at once.
    pub finished: Option<(TutorialRun, Arc<Frame>)>,
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
    /// Probability that any file of the table misses a cross although it is as good as the best.
    pub significance: f64,
    /// The files, in the tutorial's order.
    pub rows: Vec<TableRow>,
}

impl Table {
    /// For people: a Markdown table and what its numbers mean.
    pub fn to_markdown(&self) -> String {
        unimplemented!()
    }

    /// For spreadsheets: a head line, then one line per file and square.
    pub fn to_csv(&self) -> String {
        unimplemented!()
    }

    /// For programs: this struct, indented.
    pub fn to_json(&self) -> String {
        unimplemented!()
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
/// thread of its own. `progress` is called after every pass and returns false to stop, upon which the result is `None`.
///
/// # Errors
/// [`Error::Invalid`] if the scene has no plates or lights to sort the pixels by, an option is out of range, or the scene
/// cannot be rendered.
pub fn run_table(
    scene: &Arc<Scene>,
    options: &TableOptions,
    progress: &mut dyn FnMut(&TableProgress) -> bool,
) -> Result<Option<TableResult>, Error> {
    let _ = (scene, options, progress);
    unimplemented!()
}
