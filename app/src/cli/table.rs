//! `mislab table`: the tutorial's pictures and its table of times and qualities.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use mislab_renderer::table::{Table, TableOptions, TutorialRun, run_table};
use mislab_renderer::{Frame, Settings};

use super::args::{HowArgs, TableArgs};
use super::failure::Failure;
use super::input::Input;
use super::output::{self, PictureFile};
use super::progress::Bar;

pub(super) fn run(args: TableArgs) -> Result<(), Failure> {
    let TableArgs { scene, size, outdir, format, how } = args;
    let table = render(scene.as_deref(), size, &outdir, &how)?;
    output::print(&match format.as_str() {
        "csv" => table.to_csv(),
        "json" => table.to_json(),
        _ => table.to_markdown(),
    })
}

/// What `mislab` does where no window can be opened: the lesson's results all the same.
pub(super) fn instead_of_window(scene: Option<PathBuf>, reason: &str) -> Result<(), Failure> {
    output::message(&format!(
        "No window: {reason}. Rendering the tutorial's pictures and table into this folder instead; \
         `mislab --help` lists what else works without a window."
    ));
    let how = HowArgs { nthreads: 0, quiet: false };
    let table = render(scene.as_deref(), None, Path::new("."), &how)?;
    output::print(&table.to_markdown())
}

/// Renders everything, saves the pictures in `outdir` as they are finished and returns the table.
fn render(scene: Option<&Path>, size: Option<[u32; 2]>, outdir: &Path, how: &HowArgs) -> Result<Table, Failure> {
    let input = Input::load(scene)?;
    input.warn(how.quiet);
    // The tutorial's own scene has one size, its headers have two; other scenes have their own.
    let own_size = Some(input.settings.image.resolution).filter(|size| *size != Settings::default().image.resolution);
    let options = TableOptions { size: size.or(own_size), threads: how.nthreads, ..TableOptions::default() };
    std::fs::create_dir_all(outdir)
        .map_err(|error| Failure::Run(format!("{}: cannot create this folder: {error}", outdir.display())))?;

    let bar = Bar::new(how.quiet);
    let mut failure = None;
    let result = run_table(&input.scene, &options, &mut |progress| {
        bar.show_table(progress);
        if let Some((run, frame)) = &progress.finished {
            match save(run, frame, outdir) {
                Ok(line) if !how.quiet => bar.message(&line),
                Ok(_) => {}
                Err(error) => failure = Some(error),
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

/// Saves one of the pictures and says so.
fn save(run: &TutorialRun, frame: &Arc<Frame>, outdir: &Path) -> Result<String, Failure> {
    let path = outdir.join(run.file);
    let stats = frame.stats();
    let line =
        format!("{}: {}, {} spp, {:.2} s", path.display(), run.strategy.name(), frame.spp(), stats.render_seconds);
    let file = PictureFile::new(path).ok_or_else(|| Failure::Run(format!("{}: not a picture", run.file)))?;
    let notice = file.save(frame)?.map_or_else(String::new, |notice| format!("\n{}: warning: {notice}", run.file));
    Ok(line + &notice)
}
