//! The pictures of error curves, rendered and measured on a thread of their own.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use eframe::egui;
use mislab_renderer::Request;
use mislab_renderer::study::{Against, Curves, Plan, in_background, measure};

use crate::state::passes;

/// What a job has found, and why it found no more.
#[derive(Clone)]
pub struct State {
    /// All pictures so far.
    pub curves: Curves,
    /// What went wrong.
    pub error: Option<String>,
}

/// A running or finished job. Dropping it stops it.
pub struct CurvesJob {
    request: Request,
    plan: Plan,
    state: Arc<Mutex<State>>,
    stop: Arc<AtomicBool>,
    hold: Arc<AtomicBool>,
}

/// A picture is measured against a reference of at least so many times its samples, or the final one.
const FACTOR: u32 = 4;
/// How often is looked whether there is one.
const LOOK: Duration = Duration::from_millis(50);

impl CurvesJob {
    /// Starts. `reference` gives the best one so far, which is complete at `last` samples per pixel.
    ///
    /// # Errors
    /// If the system grants no thread.
    pub fn start(
        ctx: &egui::Context,
        request: Request,
        plan: Plan,
        threads: usize,
        reference: impl Fn() -> Option<Arc<Against>> + Send + 'static,
        last: u32,
    ) -> std::io::Result<Self> {
        let state = Arc::new(Mutex::new(State { curves: Curves::new(plan.clone()), error: None }));
        let job = Self { request, plan, state, stop: Arc::default(), hold: Arc::default() };
        let (state, stop, hold, ctx) = (job.state.clone(), job.stop.clone(), job.hold.clone(), ctx.clone());
        let (request, plan) = (job.request.clone(), job.plan.clone());
        let work = move || {
            let mut against = |spp: u32| {
                while !stop.load(Ordering::Relaxed) {
                    let enough = |found: &Arc<Against>| {
                        found.exact || found.spp.is_some_and(|has| has >= last.min(FACTOR * spp))
                    };
                    let found = reference().filter(|found| !hold.load(Ordering::Relaxed) && enough(found));
                    if found.is_some() {
                        return found;
                    }
                    std::thread::sleep(LOOK);
                }
                None
            };
            let scene = Arc::clone(&request.scene);
            let mut render = in_background(scene, threads, || !stop.load(Ordering::Relaxed));
            let outcome = measure(&request, &plan, &mut render, &mut against, &mut |found| {
                state.lock().unwrap_or_else(PoisonError::into_inner).curves.add(found);
                passes::for_news_in(&ctx, Duration::from_millis(50));
            });
            if let Err(error) = outcome {
                state.lock().unwrap_or_else(PoisonError::into_inner).error = Some(error.to_string());
            }
        };
        std::thread::Builder::new().name("curves".into()).spawn(work)?;
        Ok(job)
    }

    /// Whether this is what it measures.
    pub fn is_about(&self, request: &Request, plan: &Plan) -> bool {
        let same_scene = Arc::ptr_eq(&self.request.scene, &request.scene) || self.request.scene == request.scene;
        let own = &self.request.settings;
        let same = own.image == request.settings.image && own.sampling == request.settings.sampling;
        same && same_scene && self.plan == *plan
    }

    /// Begins no picture while held.
    pub fn hold(&self, hold: bool) {
        self.hold.store(hold, Ordering::Relaxed);
    }

    /// What it has found so far.
    pub fn state(&self) -> State {
        self.state.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl Drop for CurvesJob {
    fn drop(&mut self) {
        // Not waited for: it ends within a picture's first moments.
        self.stop.store(true, Ordering::Relaxed);
    }
}
