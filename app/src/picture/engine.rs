//! The workers, and the live pictures that they work on.

use eframe::egui;
use mislab_renderer::{Abreast, Lockstep, Pace, Renderer, Request, State};

use crate::picture::content::Content;
use crate::picture::incoming::Developer;
use crate::picture::live::LivePicture;
use crate::state::passes;

/// One renderer for all pictures of the window.
pub struct Engine {
    /// What holds the pictures abreast, and by what.
    abreast: Option<(Lockstep, Abreast)>,
    // Dropped first: pictures leave before the renderer joins its threads.
    pictures: Vec<LivePicture>,
    renderer: Option<Renderer>,
    developer: Developer,
    threads: usize,
}

impl Engine {
    /// Starts the workers; each new frame asks `ctx` for one pass. No pictures yet: see [`Self::match_requests`].
    pub fn new(ctx: &egui::Context, threads: usize) -> Self {
        let developer = Developer::new(ctx);
        let renderer = Renderer::new(threads, developer.bell(ctx));
        Self { abreast: None, pictures: Vec::new(), threads: renderer.threads(), renderer: Some(renderer), developer }
    }

    /// As many pictures as requests. Where their number changes, those that work on one of the requests go on with it;
    /// those that nobody asks for any more go, and with them their memory. `None` asks for nothing.
    pub fn match_requests(&mut self, requests: &[Option<Request>]) {
        let Some(renderer) = self.renderer.as_ref().filter(|_| self.pictures.len() != requests.len()) else { return };
        self.abreast = None;
        let mut old: Vec<LivePicture> = std::mem::take(&mut self.pictures);
        let found: Vec<Option<LivePicture>> = requests
            .iter()
            .map(|request| {
                let request = request.as_ref()?;
                old.iter().position(|live| live.is_about(request)).map(|index| old.remove(index))
            })
            .collect();
        let mut spare = old.into_iter();
        let mut new = || spare.next().unwrap_or_else(|| LivePicture::new(renderer.add_picture(), &self.developer));
        self.pictures = found.into_iter().map(|live| live.unwrap_or_else(&mut new)).collect();
    }

    /// Shows what was kept as the picture of that index, or what is rendered again.
    pub fn show_kept(&mut self, index: usize, kept: Option<&Content>) {
        let (Some(renderer), Some(live)) = (&self.renderer, self.pictures.get_mut(index)) else { return };
        let same = match (live.held(), kept) {
            (Some(shown), Some(kept)) => shown.is(kept),
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        };
        if !same {
            // A new one: what the old one was working on is not wanted any more.
            *live = LivePicture::of_held(renderer.add_picture(), &self.developer, kept.cloned());
            self.abreast = None;
        }
    }

    /// Each picture takes its newest frame for a pass of the window.
    pub fn hold(&mut self) {
        self.pictures.iter_mut().for_each(LivePicture::hold);
    }

    /// Each gives it back: the pass is over. The next ones come when a pass is due for them.
    pub fn release(&mut self, ctx: &egui::Context) {
        let next = passes::due(ctx);
        self.pictures.iter_mut().for_each(|picture| picture.release(next));
        if self.pictures.iter().any(LivePicture::is_coming) {
            self.developer.look_again();
        }
    }

    /// Keeps several pictures abreast by that; `None` lets them run freely.
    pub fn keep_abreast(&mut self, by: Option<Lockstep>) {
        if self.abreast.as_ref().map(|(by, _)| *by) == by {
            return;
        }
        self.abreast = None;
        if let (Some(renderer), Some(by)) = (&self.renderer, by) {
            let pictures: Vec<_> = self.pictures.iter().filter_map(LivePicture::picture).collect();
            self.abreast = Some((by, renderer.keep_abreast(&pictures, by)));
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

    /// Sets the pace of all pictures, where it is another. At equal seconds, the first that is finished sets how many
    /// there are, and those that have had as many hold.
    pub fn set_pace(&mut self, pace: Pace) {
        let seconds = |live: &LivePicture| live.current_frame().map_or(0.0, |frame| frame.stats().cpu_seconds);
        let finished = |live: &&LivePicture| live.status().is_some_and(|status| status.state == State::Finished);
        let by_seconds = matches!(self.abreast, Some((Lockstep::CpuSeconds, _)));
        let all = self.pictures.iter().filter(finished).map(seconds).reduce(f64::max).filter(|_| by_seconds);
        for picture in &mut self.pictures {
            let done = all.is_some_and(|all| seconds(picture) >= all);
            picture.set_pace(if done { Pace::Paused } else { pace });
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
