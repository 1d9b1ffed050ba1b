//! The tutorial's table, filled in on a thread of its own.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use eframe::egui;
use mislab_renderer::Scene;
use mislab_renderer::table::{TableOptions, TableResult, run_table};

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
            let result = run_table(&scene, &options, &mut |now| {
                *lock(&shared) =
                    Progress { step: now.step.clone(), fraction: now.fraction as f32, elapsed: now.elapsed };
                ctx.request_repaint_after(Duration::from_millis(50));
                !stopped.load(Ordering::Relaxed)
            });
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

fn join(thread: JoinHandle<Outcome>) -> Outcome {
    thread.join().unwrap_or_else(|_| Err("the table's thread broke down".into()))
}

fn lock(progress: &Mutex<Progress>) -> MutexGuard<'_, Progress> {
    progress.lock().unwrap_or_else(PoisonError::into_inner)
}
