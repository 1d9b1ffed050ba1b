//! A picture rendered to its target while the caller waits.

use std::sync::Arc;
use std::time::{Duration, Instant};

use mislab_kernel::lanes::Lanewise;
use mislab_kernel::request::Request;

use super::renderer::Renderer;
use super::schedule::PictureState;
use super::status::{Pace, State};
use crate::error::Error;
use crate::frame::Frame;

/// How far a blocking render is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Complete passes.
    pub spp: u32,
    /// Passes asked for.
    pub target: Option<u32>,
    /// Since the start.
    pub elapsed: Duration,
    /// Secondary rays traced.
    pub paths: u64,
}

/// Longest time between two reports.
const REPORT: Duration = Duration::from_millis(100);

impl Renderer {
    /// Renders to the spp target, beside the pictures there are, and returns the final frame: the same bits as in a
    /// window. `on_progress` is told at least ten times a second and returns false to stop early, after the running pass.
    ///
    /// # Errors
    /// [`Error::Invalid`] if the scene or a setting cannot be rendered, if no spp target is given, or
    /// if `on_progress` stopped it before the first pass was complete.
    pub fn render(
        &self,
        request: &Request,
        on_progress: &mut dyn FnMut(&Progress) -> bool,
    ) -> Result<Arc<Frame>, Error> {
        let target = request.settings.sampling.target();
        if target.is_none() {
            return Err(Error::Invalid("endless spp, expected a number of samples per pixel".into()));
        }
        let picture = self.add_picture();
        let rays = u64::from(request.settings.estimator.strategy.rays_per_sample());
        let per_sample = request.settings.pixel_bounds().area() as u64 * rays;
        let start = Instant::now();
        picture.submit(request.clone());
        loop {
            let status = picture.status();
            if status.state == State::Failed {
                return Err(Error::Invalid(status.error.unwrap_or_default()));
            }
            if let Some(frame) = self.shared.look(picture.id, |p| final_frame(p)) {
                return Ok(frame);
            }
            let progress = Progress {
                spp: status.spp,
                target,
                elapsed: start.elapsed(),
                paths: per_sample * u64::from(status.spp),
            };
            if !on_progress(&progress) {
                if status.spp == 0 {
                    return Err(Error::Invalid("stopped before the first pass was complete".into()));
                }
                // The frame of the last pass follows.
                picture.set_pace(Pace::Paused);
            }
            let seen = status.state;
            let news = |p: &PictureState| final_frame(p).is_some() || p.status().state != seen;
            self.shared.wait_for(picture.id, REPORT, news);
        }
    }
}

/// The frame of a picture that makes no more of them.
fn final_frame(picture: &PictureState) -> Option<Arc<Frame>> {
    let status = picture.status();
    let ended = matches!(status.state, State::Finished | State::Paused);
    picture.latest.load_full().filter(|frame| ended && frame.spp() == status.spp)
}

/// [`Renderer::render`] on threads of its own (0: one per core): for a single picture.
///
/// # Errors
/// As [`Renderer::render`].
pub fn render(
    request: &Request,
    threads: usize,
    on_progress: &mut dyn FnMut(&Progress) -> bool,
) -> Result<Arc<Frame>, Error> {
    Renderer::new(threads, || {}).render(request, on_progress)
}

/// [`render`] at a given SIMD level, for tests and comparisons.
///
/// # Errors
/// As [`Renderer::render`].
pub fn render_with(
    request: &Request,
    threads: usize,
    how: Lanewise,
    on_progress: &mut dyn FnMut(&Progress) -> bool,
) -> Result<Arc<Frame>, Error> {
    Renderer::with_lanes(threads, how, || {}).render(request, on_progress)
}
