//! The best c of every pixel, worked out on threads of its own, from coarse to fine.

use std::sync::Arc;

use eframe::egui::Context;
use mislab_renderer::inspect::{BestMap, best_map};
use mislab_renderer::kernel::world::BuiltScene;
use mislab_renderer::{Frame, Request, Settings};

use crate::picture::rounds::Rounds;

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

/// Works it out beside the pictures.
pub type BestMapJob = Rounds<Question, BestMap>;

/// Starts it on so many threads (0: one per core).
pub fn start(ctx: &Context, question: Question, threads: usize) -> BestMapJob {
    Rounds::start(ctx, "best c", question, move |asked, goes_on, report| {
        best_map(&asked.built, asked.settings(), threads, goes_on, report);
    })
}
