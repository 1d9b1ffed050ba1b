//! The workers, and the live pictures that they work on.

use std::time::Duration;

use eframe::egui;
use mislab_renderer::{Pace, Renderer};

use super::live::LivePicture;

/// One renderer for all pictures of the window.
pub struct Engine {
    // Dropped first: pictures leave before the renderer joins its threads.
    pictures: Vec<LivePicture>,
    renderer: Option<Renderer>,
    threads: usize,
}

impl Engine {
    /// Starts the workers; each new frame asks `ctx` for one pass. No pictures yet: see [`Self::set_count`].
    pub fn new(ctx: &egui::Context, threads: usize) -> Self {
        let ctx = ctx.clone();
        // A repaint at once would cost two passes.
        let renderer = Renderer::new(threads, move || ctx.request_repaint_after(Duration::from_millis(1)));
        Self { pictures: Vec::new(), threads: renderer.threads(), renderer: Some(renderer) }
    }

    /// As many pictures as the document has slots: the last ones go, or new ones come.
    pub fn set_count(&mut self, count: usize) {
        if let Some(renderer) = &self.renderer {
            self.pictures.resize_with(count, || LivePicture::new(renderer.add_picture()));
        }
    }

    /// The pictures, one for each slot of the document.
    pub fn pictures(&self) -> &[LivePicture] {
        &self.pictures
    }

    /// The same, to hand requests over and to take frames.
    pub fn pictures_mut(&mut self) -> &mut [LivePicture] {
        &mut self.pictures
    }

    /// Sets the pace of all pictures, where it is another.
    pub fn set_pace(&mut self, pace: Pace) {
        for picture in &mut self.pictures {
            picture.set_pace(pace);
        }
    }

    /// Worker threads.
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// Stops the workers and waits for nothing: what they are in the middle of ends on its own, or with the program.
    pub fn stop(&mut self) {
        let Some(renderer) = self.renderer.take() else { return };
        let pictures: Vec<_> = self.pictures.iter_mut().filter_map(LivePicture::stop).collect();
        // Taking pictures away frees their memory, and the workers are joined: neither is for whoever closes a window.
        let leave = move || {
            drop(pictures);
            drop(renderer);
        };
        let _ = std::thread::Builder::new().name("leaving".into()).spawn(leave);
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        self.stop();
    }
}
