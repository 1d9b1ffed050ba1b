//! The squares of a picture, plate by light, found on a thread of their own.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::Duration;

use eframe::egui::Context;
use mislab_renderer::study::Cells;
use mislab_renderer::{ImageSettings, PixelRect, Renderer, Request, Scene};

/// The squares of one picture, as far as they are known.
#[derive(Default)]
pub struct Squares {
    known: Option<(About, Option<Arc<Cells>>)>,
    search: Option<Search>,
}

/// What squares depend on: no strategy moves them.
#[derive(Clone)]
struct About {
    scene: Arc<Scene>,
    image: ImageSettings,
}

impl About {
    fn is(&self, other: &Self) -> bool {
        self.image == other.image && (Arc::ptr_eq(&self.scene, &other.scene) || self.scene == other.scene)
    }
}

/// Dropping it gives it up.
struct Search {
    about: About,
    found: Receiver<Cells>,
    stop: Arc<AtomicBool>,
}

impl Drop for Search {
    fn drop(&mut self) {
        // Not waited for: it ends within a few milliseconds.
        self.stop.store(true, Ordering::Relaxed);
    }
}

impl Squares {
    /// Those of a picture. Where they are not known yet there are none, and a pass is asked for when they are.
    pub fn of(&mut self, ctx: &Context, request: &Request) -> Option<Arc<Cells>> {
        let about = About { scene: request.scene.clone(), image: request.settings.image };
        if let Some((known, found)) = &self.known
            && known.is(&about)
        {
            return found.clone();
        }
        let Some(search) = &self.search else {
            self.search = start(ctx, about);
            return None;
        };
        let wanted = search.about.is(&about);
        if !wanted {
            search.stop.store(true, Ordering::Relaxed);
        }
        let found = match search.found.try_recv() {
            // The next one begins when this one has ended: dragging a light starts no crowd of them.
            Err(TryRecvError::Empty) => return None,
            Ok(cells) => Some(Arc::new(cells)),
            Err(TryRecvError::Disconnected) => None,
        };
        self.search = None;
        if !wanted {
            ctx.request_repaint_after(Duration::from_millis(1));
            return None;
        }
        self.known = Some((about, found.clone()));
        found
    }

    /// Which of them a pixel of the full image is in, of a picture of these bounds.
    pub fn at(&self, pixel: [u32; 2], bounds: PixelRect) -> Option<usize> {
        let cells = self.known.as_ref()?.1.as_ref()?;
        let index = (pixel[1] - bounds.min[1]) * bounds.width() + pixel[0] - bounds.min[0];
        cells.squares.iter().position(|square| square.pixels.binary_search(&index).is_ok())
    }
}

fn start(ctx: &Context, about: About) -> Option<Search> {
    let stop = Arc::<AtomicBool>::default();
    let (stopped, ctx, of) = (stop.clone(), ctx.clone(), about.clone());
    let (sender, found) = channel();
    let work = move || {
        let renderer = Renderer::in_background(1);
        // Where it fails, the picture itself does and says why.
        if let Ok(Some(cells)) = Cells::of(&renderer, &of.scene, of.image, &mut || !stopped.load(Ordering::Relaxed)) {
            // The window may have closed meanwhile.
            let _ = sender.send(cells);
        }
        drop(sender);
        ctx.request_repaint_after(Duration::from_millis(1));
    };
    // Without a thread there are no squares, and a part can still be selected.
    std::thread::Builder::new().name("squares".into()).spawn(work).ok()?;
    Some(Search { about, found, stop })
}
