//! Something that is worked out on a thread of its own, and given up when something else is asked for.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use eframe::egui::Context;

use crate::state::passes;

/// What is known, and what is being worked out.
pub struct Background<About, Found> {
    name: &'static str,
    known: Option<(About, Option<Found>)>,
    running: Option<Running<About, Found>>,
}

/// Dropping it gives it up.
struct Running<About, Found> {
    about: About,
    found: Receiver<Found>,
    stop: Arc<AtomicBool>,
}

impl<About, Found> Drop for Running<About, Found> {
    fn drop(&mut self) {
        // Not waited for: it ends within a few milliseconds.
        self.stop.store(true, Ordering::Relaxed);
    }
}

impl<About: PartialEq + Clone + Send + 'static, Found: Clone + Send + 'static> Background<About, Found> {
    /// Nothing is known yet; the thread will have that name.
    pub fn new(name: &'static str) -> Self {
        Self { name, known: None, running: None }
    }

    /// What `work` finds about it, which may be nothing, and which is asked whether to go on. While it is not known there is nothing, and
    /// a pass is asked for when it is.
    pub fn of(
        &mut self,
        ctx: &Context,
        about: About,
        work: impl FnOnce(&About, &mut (dyn FnMut() -> bool + Send)) -> Option<Found> + Send + 'static,
    ) -> Option<Found> {
        if let Some((known, found)) = &self.known
            && *known == about
        {
            return found.clone();
        }
        let Some(running) = &self.running else {
            self.start(ctx, about, work);
            return None;
        };
        let wanted = running.about == about;
        if !wanted {
            running.stop.store(true, Ordering::Relaxed);
        }
        let found = match running.found.try_recv() {
            // The next one begins when this one has ended: what follows the mouse starts no crowd of threads.
            Err(TryRecvError::Empty) => return None,
            Ok(found) => Some(found),
            Err(TryRecvError::Disconnected) => None,
        };
        self.running = None;
        if !wanted {
            passes::for_news(ctx);
            return None;
        }
        self.known = Some((about, found.clone()));
        found
    }

    /// What is known of whatever was asked for last.
    pub fn known(&self) -> Option<&Found> {
        self.known.as_ref()?.1.as_ref()
    }

    /// Gives up what is being worked out.
    pub fn rest(&mut self) {
        self.running = None;
    }

    fn start(
        &mut self,
        ctx: &Context,
        about: About,
        work: impl FnOnce(&About, &mut (dyn FnMut() -> bool + Send)) -> Option<Found> + Send + 'static,
    ) {
        let stop = Arc::<AtomicBool>::default();
        let (sender, found) = channel();
        let (stopped, ctx, of) = (stop.clone(), ctx.clone(), about.clone());
        let work = move || {
            if let Some(found) = work(&of, &mut || !stopped.load(Ordering::Relaxed)) {
                // It may not be wanted any more.
                let _ = sender.send(found);
            }
            drop(sender);
            passes::for_news(&ctx);
        };
        // Without a thread it is tried again in the next pass.
        let thread = std::thread::Builder::new().name(self.name.into()).spawn(work);
        self.running = thread.ok().map(|_| Running { about, found, stop });
    }
}
