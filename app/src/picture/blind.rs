//! The pixels that a strategy cannot sample, found on a thread of their own.

use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use eframe::egui::Context;
use mislab_renderer::blind::{blind_materials, blind_pixels};
use mislab_renderer::{Frame, Request};

/// For each pixel of the full image whether the strategy cannot sample it; `None` if there are none.
pub type Blind = Option<Arc<Vec<bool>>>;

/// The blind pixels of one picture, as far as they are known.
#[derive(Default)]
pub struct BlindSpots {
    known: Option<(Arc<Request>, Blind)>,
    search: Option<(Arc<Request>, JoinHandle<Blind>)>,
}

impl BlindSpots {
    /// Those of a frame. Where they are not known yet there are none, and a pass is asked for when they are.
    pub fn of(&mut self, ctx: &Context, frame: &Frame) -> Blind {
        let request = frame.request();
        if blind_materials(&request.scene, &request.settings.estimator).is_empty() {
            return None;
        }
        if let Some((about, thread)) = self.search.take_if(|(_, thread)| thread.is_finished()) {
            self.known = thread.join().ok().map(|found| (about, found));
        }
        if let Some((about, found)) = &self.known
            && alike(about, request)
        {
            return found.clone();
        }
        if self.search.is_none() {
            let (about, ctx) = (request.clone(), ctx.clone());
            let search = std::thread::Builder::new().name("blind spots".into()).spawn(move || {
                let found = blind_pixels(&about).map(Arc::new);
                ctx.request_repaint_after(Duration::from_millis(1));
                found
            });
            // Without a thread nothing is marked; the caption says it all the same.
            self.search = search.ok().map(|thread| (request.clone(), thread));
        }
        None
    }
}

/// Whether the same pixels are blind in both.
fn alike(a: &Arc<Request>, b: &Arc<Request>) -> bool {
    let same_scene = Arc::ptr_eq(&a.scene, &b.scene) || a.scene == b.scene;
    let blind = |request: &Request| blind_materials(&request.scene, &request.settings.estimator);
    Arc::ptr_eq(a, b)
        || (same_scene && a.settings.image.resolution == b.settings.image.resolution && blind(a) == blind(b))
}
