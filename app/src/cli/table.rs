//! `mislab table`: the tutorial's pictures and its table of times and qualities.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use mislab_renderer::black::why_black;
use mislab_renderer::snapshot::{self, SaveOptions};
use mislab_renderer::table::{Table, TableOptions, TutorialRun, run_table};
use mislab_renderer::{Frame, Settings};

use super::args::{HowArgs, TableArgs};
use super::failure::Failure;
use super::input::Input;
use super::output;
use super::progress::Bar;
use crate::files::saving::{write_free, write_over};

pub(super) fn run(args: TableArgs) -> Result<(), Failure> {
    let TableArgs { scene, size, outdir, format, how } = args;
    let input = Input::load(scene.as_deref())?;
    let table = render(&input, size, Place { folder: &outdir, asked_for: true }, &how)?;
    output::print(&match format.as_str() {
        "csv" => table.to_csv(),
        "json" => table.to_json(),
        _ => table.to_markdown(),
    })
}

/// What `mislab` does where no window can be opened: the lesson's results all the same.
pub(super) fn instead_of_window(scene: Option<PathBuf>, reason: &str) -> Result<(), Failure> {
    // A scene that cannot be read is all there is to say.
    let input = Input::load(scene.as_deref())?;
    output::message(&format!(
        "No window: {reason}.\nRendering the tutorial's pictures and table into this folder instead; \
         `mislab --help` lists what else works without a window."
    ));
    let how = HowArgs { nthreads: 0, quiet: false };
    let table = render(&input, None, Place { folder: Path::new("."), asked_for: false }, &how)?;
    output::print(&table.to_markdown())
}

/// Where the pictures go.
#[derive(Clone, Copy)]
struct Place<'a> {
    folder: &'a Path,
    /// By somebody who knows their names: only then do they replace older ones.
    asked_for: bool,
}

/// Renders everything, saves the pictures as they are finished and returns the table.
fn render(input: &Input, size: Option<[u32; 2]>, place: Place<'_>, how: &HowArgs) -> Result<Table, Failure> {
    input.warn(how.quiet);
    // The tutorial's own scene has one size, its headers have two; other scenes have their own.
    let own_size = Some(input.settings.image.resolution).filter(|size| *size != Settings::default().image.resolution);
    let options = TableOptions { size: size.or(own_size), threads: how.nthreads, ..TableOptions::default() };
    std::fs::create_dir_all(place.folder)
        .map_err(|error| Failure::Run(format!("{}: cannot create this folder: {error}", place.folder.display())))?;

    let bar = Bar::new(how.quiet);
    let mut failure = None;
    let result = run_table(&input.scene, &options, &mut |progress| {
        bar.show_table(progress);
        if let Some((run, frame)) = &progress.finished {
            match save(run, frame, place) {
                Ok(line) if !how.quiet => bar.message(&line),
                Ok(_) => {}
                Err(error) => failure = Some(error),
            }
            // Also with --quiet, as of a single picture.
            if let Some(why) = why_black(frame) {
                bar.message(&format!("{}: warning: {why}", run.file));
            }
        }
        failure.is_none()
    })?;
    match (failure, result) {
        (Some(failure), _) => Err(failure),
        (None, Some(result)) => Ok(result.table),
        (None, None) => Err(Failure::Run("stopped".to_owned())),
    }
}

/// Saves one of the pictures and says so, and what was kept.
fn save(run: &TutorialRun, frame: &Arc<Frame>, place: Place<'_>) -> Result<String, Failure> {
    let wanted = place.folder.join(run.file);
    let (bytes, notice) = snapshot::encode(frame, &SaveOptions::default())?;
    let (path, why) = if place.asked_for {
        write_over(&wanted, bytes)?
    } else {
        let stem = Path::new(run.file).file_stem().unwrap_or_default().to_string_lossy();
        (write_free(place.folder, &stem, &[("exr", bytes)])?, None)
    };
    let stats = frame.stats();
    let mut said =
        format!("{}: {}, {} spp, {:.2} s", path.display(), run.strategy.name(), frame.spp(), stats.render_seconds);
    if let Some(why) = why {
        said += &format!("\n{}", output::not_replaced(&why, &path));
    } else if path != wanted {
        said += &format!("\n{}", output::kept(&wanted, &path));
    }
    if let Some(notice) = notice {
        said += &format!("\n{}: warning: {notice}", run.file);
    }
    Ok(said)
}
