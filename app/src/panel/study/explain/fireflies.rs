//! The brightest outliers of the picture, looked for beside it.

use std::sync::{Arc, Mutex, PoisonError};

use eframe::egui::Context;
use mislab_renderer::inspect::{Fireflies, Search, fireflies, suspects_of_frame};
use mislab_renderer::kernel::lanes::Lanewise;
use mislab_renderer::{Frame, Request};

use crate::picture::background::{Background, Effort};

/// How many are listed.
pub const COUNT: usize = 8;
/// Most samples that are drawn again: some seconds' on two cores.
const MOST_SAMPLES: u64 = 10_000_000;

/// The outliers of a picture at so many samples.
pub struct Found {
    /// What they are of.
    pub about: About,
    /// The brightest first, at most [`COUNT`].
    pub fireflies: Fireflies,
}

/// A picture at some moment.
#[derive(Clone)]
pub struct About {
    request: Arc<Request>,
    /// Samples per pixel.
    pub spp: u32,
}

impl PartialEq for About {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.request, &other.request) && self.spp == other.spp
    }
}

impl About {
    fn of(frame: &Frame) -> Self {
        Self { request: frame.request().clone(), spp: frame.spp() }
    }

    /// Whether outliers of that moment still tell of this one: fewer than twice the samples have come since.
    fn is_told_by(&self, before: &Self) -> bool {
        let samples = before.spp..before.spp.saturating_mul(2);
        Arc::ptr_eq(&self.request, &before.request) && samples.contains(&self.spp)
    }
}

/// Looks for them.
pub struct FirefliesJob {
    job: Background<About, Arc<Found>>,
    /// What is looked for, or was found.
    asked: Option<About>,
}

impl Default for FirefliesJob {
    fn default() -> Self {
        Self { job: Background::new("fireflies"), asked: None }
    }
}

impl FirefliesJob {
    /// Those of a frame or of an earlier one of the same picture: they are looked for again once it has twice the samples, since a
    /// list that changed with every pass could not be read, and when it is the `last`. `None` while nothing is known.
    pub fn of(&mut self, ctx: &Context, frame: &Arc<Frame>, last: bool) -> Option<Arc<Found>> {
        let now = About::of(frame);
        let told = self.asked.as_ref().filter(|asked| now.is_told_by(asked));
        let asked = told.unwrap_or(&now).clone();
        self.asked = Some(asked.clone());
        let looked_at = frame.clone();
        let found = self.job.of(ctx, asked, Effort::Aside, |_, goes_on| search(looked_at, goes_on).map(Arc::new));
        if last && found.as_ref().is_some_and(|found| found.about.spp < now.spp) {
            self.asked = Some(now);
            ctx.request_repaint();
        }
        let of_this = |found: &&Arc<Found>| Arc::ptr_eq(&found.about.request, frame.request());
        found.or_else(|| self.job.known().filter(of_this).cloned())
    }

    /// Gives up looking.
    pub fn rest(&mut self) {
        self.job.rest();
    }
}

/// Of that frame, which is let go as soon as its sums have told which pixels to look at.
fn search(frame: Arc<Frame>, goes_on: &mut (dyn FnMut() -> bool + Send)) -> Option<Found> {
    let (about, scene, suspects) = (About::of(&frame), frame.scene().clone(), suspects_of_frame(&frame));
    drop(frame);
    let search = Search {
        scene: &scene,
        settings: &about.request.settings,
        spp: about.spp,
        how: Lanewise::best(),
        count: COUNT,
        threads: 0,
        most_samples: MOST_SAMPLES,
    };
    let goes_on = Mutex::new(goes_on);
    let wanted = || goes_on.lock().unwrap_or_else(PoisonError::into_inner)();
    let fireflies = fireflies(&search, suspects, &wanted)?;
    Some(Found { about, fireflies })
}

#[cfg(test)]
mod tests {
    use super::super::tables::tests::place;
    use super::*;
    use mislab_renderer::Strategy;

    fn frame(spp: u32) -> Arc<Frame> {
        let mut place = place();
        place.settings.sampling.spp = std::num::NonZeroU32::new(spp);
        place.settings.estimator.strategy = Strategy::Bsdf;
        let request = Request { scene: place.scene, settings: place.settings };
        mislab_renderer::render(&request, 1, &mut |_| true).expect("the shipped scene renders")
    }

    #[test]
    fn a_frame_has_bsdf_samples_that_hit_by_chance() {
        let found = search(frame(16), &mut || true).expect("wanted");
        assert_eq!((found.about.spp, found.fireflies.outliers.len()), (16, COUNT));
        assert!(found.fireflies.complete && found.fireflies.different == 0);
        for outlier in &found.fireflies.outliers {
            assert!(outlier.share_of_pixel > 0.5 && outlier.mean_without.length() < outlier.mean.length());
        }
        assert!(search(frame(4), &mut || false).is_none());
    }

    #[test]
    fn a_list_stands_until_there_are_twice_the_samples() {
        let request = frame(1).request().clone();
        let at = |spp| About { request: request.clone(), spp };
        assert!(at(8).is_told_by(&at(8)) && at(15).is_told_by(&at(8)));
        assert!(!at(16).is_told_by(&at(8)) && !at(7).is_told_by(&at(8)));
        let other = About { request: frame(1).request().clone(), spp: 8 };
        assert!(!other.is_told_by(&at(8)), "another picture");
    }
}
