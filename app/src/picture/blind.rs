//! The pixels that a strategy cannot sample, found on a thread of their own.

use std::sync::Arc;

use eframe::egui::Context;
use mislab_renderer::blind::{blind_materials, blind_pixels};
use mislab_renderer::{Frame, Request};

use crate::picture::background::Background;

/// For each pixel of the full image whether the strategy cannot sample it; `None` if there are none.
pub type Blind = Option<Arc<Vec<bool>>>;

/// The blind pixels of one picture, as far as they are known.
pub struct BlindSpots(Background<About, Arc<Vec<bool>>>);

/// Two of them are equal if the same pixels are blind in both.
#[derive(Clone)]
struct About(Arc<Request>);

impl PartialEq for About {
    fn eq(&self, Self(other): &Self) -> bool {
        let Self(this) = self;
        let same_scene = Arc::ptr_eq(&this.scene, &other.scene) || this.scene == other.scene;
        let blind = |request: &Request| blind_materials(&request.scene, &request.settings.estimator);
        let same_pixels = this.settings.image.resolution == other.settings.image.resolution;
        Arc::ptr_eq(this, other) || (same_scene && same_pixels && blind(this) == blind(other))
    }
}

impl Default for BlindSpots {
    fn default() -> Self {
        Self(Background::new("blind spots"))
    }
}

impl BlindSpots {
    /// Those of a frame. Where they are not known yet there are none, and a pass is asked for when they are.
    pub fn of(&mut self, ctx: &Context, frame: &Frame) -> Blind {
        let request = frame.request();
        if blind_materials(&request.scene, &request.settings.estimator).is_empty() {
            return None;
        }
        // Without a thread nothing is marked; the caption says it all the same.
        self.0.of(ctx, About(request.clone()), |About(request), _| blind_pixels(request).map(Arc::new))
    }
}
