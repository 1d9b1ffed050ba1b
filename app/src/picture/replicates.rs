//! What the samples of the picture's pattern are worth, measured over replicates on a thread while that is shown.

use std::sync::Arc;

use eframe::egui::Context;
use mislab_renderer::Request;
use mislab_renderer::study::Replicated;

use crate::picture::background::{Background, Effort};

/// Of the active picture, as far as it is known.
pub struct Replicates {
    background: Background<About, Replicated>,
    found: Option<Replicated>,
}

/// A request, whatever its number of samples.
#[derive(Clone)]
struct About(Request);

impl PartialEq for About {
    fn eq(&self, Self(other): &Self) -> bool {
        // A scene is compared by its numbers only if it is not the very same one.
        self.0.settings == other.settings && (Arc::ptr_eq(&self.0.scene, &other.scene) || self.0.scene == other.scene)
    }
}

impl Default for Replicates {
    fn default() -> Self {
        Self { background: Background::new("replicates"), found: None }
    }
}

impl Replicates {
    /// To be called in each pass: measures that of `request`; `None` gives up.
    pub fn keep(&mut self, ctx: &Context, request: Option<Request>) {
        let Some(mut request) = request else {
            self.background.rest();
            return;
        };
        request.settings.sampling.spp = None;
        self.found = self.background.of(ctx, About(request), Effort::Soon, |About(request), goes_on| {
            // Where it fails, the picture itself does and says why.
            Replicated::measure(request, 1, goes_on).ok().flatten()
        });
    }

    /// What came of it.
    pub fn found(&self) -> Option<Replicated> {
        self.found
    }
}
