//! Several pictures, one after the other, with one progress for all of them.

use std::num::NonZeroU32;
use std::sync::Arc;
use std::time::{Duration, Instant};

use mislab_kernel::request::scene::Scene;
use mislab_kernel::request::{Request, Settings};

use crate::engine::Renderer;
use crate::error::Error;
use crate::frame::Frame;

/// How far a batch is.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// The picture that is rendered, for people.
    pub step: &'a str,
    /// Share of all the work that is done, in [0, 1]. Counted in secondary rays.
    pub fraction: f64,
    /// Since the start.
    pub elapsed: Duration,
}

/// Renders one picture after the other and keeps count. Its threads stay from one picture to the next.
pub(crate) struct Batch {
    renderer: Renderer,
    started: Instant,
    /// Secondary rays.
    done: f64,
    total: f64,
}

impl Batch {
    /// For `total` secondary rays; see [`rays`].
    pub(crate) fn new(threads: usize, total: f64) -> Self {
        Self { renderer: Renderer::new(threads, || {}), started: Instant::now(), done: 0.0, total }
    }

    /// How far it is.
    pub(crate) fn step<'a>(&self, step: &'a str) -> Step<'a> {
        Step { step, fraction: (self.done / self.total).min(1.0), elapsed: self.started.elapsed() }
    }

    /// The finished picture, or `None` if `goes_on` says no.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub(crate) fn render(
        &mut self,
        scene: &Arc<Scene>,
        settings: Settings,
        step: &str,
        goes_on: &mut dyn FnMut(&Step<'_>) -> bool,
    ) -> Result<Option<Arc<Frame>>, Error> {
        let (rays, target) = (rays(&settings), settings.sampling.target().unwrap_or(1));
        let request = Request { scene: Arc::clone(scene), settings };
        let (before, total, started) = (self.done, self.total, self.started);
        let mut stopped = false;
        let frame = self.renderer.render(&request, &mut |now| {
            let done = before + rays * f64::from(now.spp) / f64::from(target);
            stopped |= !goes_on(&Step { step, fraction: (done / total).min(1.0), elapsed: started.elapsed() });
            !stopped
        });
        self.done = before + rays;
        // Stopped early, there may be a frame or, before the first pass, an error that says so.
        if stopped { Ok(None) } else { frame.map(Some) }
    }
}

/// Secondary rays of a picture, as a measure of work.
pub(crate) fn rays(settings: &Settings) -> f64 {
    settings.pixel_bounds().area() as f64
        * f64::from(settings.sampling.spp.map_or(0, NonZeroU32::get))
        * f64::from(settings.estimator.strategy.rays_per_sample())
}
