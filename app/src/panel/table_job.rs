//! The tutorial's table, filled in on a thread of its own.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use eframe::egui;
use mislab_renderer::table::{TableOptions, TableResult, Timing, run_table};
use mislab_renderer::{Scene, Spent};

use crate::state::passes::{self, Quiet};

/// How far a job is.
#[derive(Clone, Debug, Default)]
pub struct Progress {
    /// What is being rendered.
    pub step: String,
    /// Share of the work that is done.
    pub fraction: f32,
    /// Since the start.
    pub elapsed: Duration,
}

/// What came of it: the table, nothing if it was stopped, or why not.
type Outcome = Result<Option<TableResult>, String>;

/// A running job. Dropping it stops it.
pub struct TableJob {
    stop: Arc<AtomicBool>,
    progress: Arc<Mutex<Progress>>,
    thread: Option<JoinHandle<Outcome>>,
}

impl TableJob {
    /// Starts. The pictures of the live window should hold meanwhile, or they spoil the times.
    pub fn start(ctx: &egui::Context, scene: Arc<Scene>, options: TableOptions) -> std::io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let progress = Arc::new(Mutex::new(Progress::default()));
        let (ctx, stopped, shared) = (ctx.clone(), stop.clone(), progress.clone());
        let thread = std::thread::Builder::new().name("table".into()).spawn(move || {
            let mut quiet = None;
            let result = run_table(&scene, &options, &mut |now| {
                *lock(&shared) =
                    Progress { step: now.step.clone(), fraction: now.fraction as f32, elapsed: now.elapsed };
                match now.timing {
                    Timing::No => {
                        quiet = None;
                        passes::for_news(&ctx);
                    }
                    Timing::Next => {
                        ctx.request_repaint();
                        wait_for_rest(&stopped);
                        quiet = Some(Quiet::begin(&ctx));
                    }
                    Timing::Now => {}
                }
                !stopped.load(Ordering::Relaxed)
            });
            drop(quiet);
            ctx.request_repaint();
            result.map_err(|error| error.to_string())
        })?;
        Ok(Self { stop, progress, thread: Some(thread) })
    }

    /// How far it is.
    pub fn progress(&self) -> Progress {
        lock(&self.progress).clone()
    }

    /// Asks it to stop; [`Self::poll`] then brings the end.
    pub fn cancel(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// The outcome, once, when it is there.
    pub fn poll(&mut self) -> Option<Outcome> {
        self.thread.take_if(|thread| thread.is_finished()).map(join)
    }
}

impl Drop for TableJob {
    fn drop(&mut self) {
        // Not waited for: it ends at its next step, or with the program.
        self.cancel();
    }
}

/// How long a file waits for rest, at most.
const PATIENCE: Duration = Duration::from_secs(2);
/// Time between two looks, and the processor time in it up to which the process is at rest.
const LOOK: [Duration; 2] = [Duration::from_millis(50), Duration::from_millis(5)];

/// Waits until the window has drawn what there was to draw, and pictures have ended their passes.
fn wait_for_rest(stopped: &AtomicBool) {
    let begun = Instant::now();
    let mut before = Spent::now();
    while begun.elapsed() < PATIENCE && !stopped.load(Ordering::Relaxed) {
        std::thread::sleep(LOOK[0]);
        let now = Spent::now();
        if now.all - before.all < LOOK[1].as_secs_f64() {
            return;
        }
        before = now;
    }
}

fn join(thread: JoinHandle<Outcome>) -> Outcome {
    thread.join().unwrap_or_else(|_| Err("the table's thread broke down".into()))
}

fn lock(progress: &Mutex<Progress>) -> MutexGuard<'_, Progress> {
    progress.lock().unwrap_or_else(PoisonError::into_inner)
}
