//! The best c of every pixel, worked out on threads of its own, from coarse to fine.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use eframe::egui::Context;
use mislab_renderer::inspect::{BestMap, best_map};
use mislab_renderer::kernel::world::BuiltScene;
use mislab_renderer::{Frame, Request, Settings, step_aside};

use crate::state::passes;

/// What the map is about.
#[derive(Clone)]
pub struct Question {
    request: Arc<Request>,
    built: Arc<BuiltScene>,
}

impl Question {
    /// The scene that a frame shows, with its heuristic and weights.
    pub fn of(frame: &Frame) -> Self {
        Self { request: frame.request().clone(), built: frame.scene().clone() }
    }

    /// How the picture was made.
    pub fn settings(&self) -> &Settings {
        &self.request.settings
    }

    /// Whether both have the same map, whatever strategy, c and samples.
    pub fn has_map_of(&self, other: &Self) -> bool {
        let [own, others] = [self, other].map(|question| {
            let Settings { estimator, image, .. } = &question.request.settings;
            (image, estimator.heuristic, estimator.weights)
        });
        Arc::ptr_eq(&self.request.scene, &other.request.scene) && own == others
    }
}

/// A running or finished job. Dropping it stops it.
pub struct BestMapJob {
    question: Question,
    stop: Arc<AtomicBool>,
    found: Arc<Mutex<Option<Arc<BestMap>>>>,
}

impl BestMapJob {
    /// Starts on so many threads (0: one per core); asks `ctx` for a pass after each round. Without a thread nothing is ever found.
    pub fn start(ctx: &Context, question: Question, threads: usize) -> Self {
        let (stop, found) = (Arc::new(AtomicBool::new(false)), Arc::new(Mutex::default()));
        let (asked, stopped, shared, ctx) = (question.clone(), stop.clone(), Arc::clone(&found), ctx.clone());
        let work = move || {
            step_aside();
            let goes_on = || !stopped.load(Ordering::Relaxed);
            best_map(&asked.built, asked.settings(), threads, &goes_on, &mut |map| {
                *shared.lock().unwrap_or_else(PoisonError::into_inner) = Some(Arc::new(map.clone()));
                passes::for_news(&ctx);
            });
        };
        let _ = std::thread::Builder::new().name("best c".into()).spawn(work);
        Self { question, stop, found }
    }

    /// What it is about.
    pub fn question(&self) -> &Question {
        &self.question
    }

    /// What is known so far, if anything is.
    pub fn found(&self) -> Option<Arc<BestMap>> {
        self.found.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl Drop for BestMapJob {
    fn drop(&mut self) {
        // Not waited for: it ends within some milliseconds.
        self.stop.store(true, Ordering::Relaxed);
    }
}
