//! Something that is worked out on a thread of its own, and given up when something else is asked for.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use eframe::egui::Context;
use mislab_renderer::step_aside;

use crate::state::passes;

/// How something is worked out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// A few milliseconds, at once. It is found even if something else is asked for by then: what follows the mouse would never be known
    /// while it moves, if each move gave up what the one before had begun.
    Brief,
    /// As long as it takes, at once.
    Soon,
    /// As long as it takes, with the time that the pictures leave.
    Aside,
}

/// What is known, and what is being worked out.
pub struct Background<About, Found> {
    name: &'static str,
    known: Option<(About, Option<Found>)>,
    running: Option<Running<About, Found>>,
}

/// Dropping it gives it up.
struct Running<About, Found> {
    about: About,
    effort: Effort,
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
        effort: Effort,
        work: impl FnOnce(&About, &mut (dyn FnMut() -> bool + Send)) -> Option<Found> + Send + 'static,
    ) -> Option<Found> {
        if let Some((known, found)) = &self.known
            && *known == about
        {
            return found.clone();
        }
        if let Some(running) = &self.running {
            let wanted = running.about == about;
            if !wanted && running.effort != Effort::Brief {
                running.stop.store(true, Ordering::Relaxed);
            }
            let found = match running.found.try_recv() {
                // The next one begins when this one has ended: what follows the mouse starts no crowd of threads.
                Err(TryRecvError::Empty) => return None,
                Ok(found) => Some(found),
                Err(TryRecvError::Disconnected) => None,
            };
            if wanted || (running.effort == Effort::Brief && found.is_some()) {
                self.known = Some((running.about.clone(), found.clone()));
            }
            self.running = None;
            if wanted {
                return found;
            }
        }
        self.start(ctx, about, effort, work);
        None
    }

    /// The same, found at once on this thread: for what takes a fraction of a millisecond.
    pub fn at_once(&mut self, about: About, work: impl FnOnce(&About) -> Option<Found>) -> Option<Found> {
        if self.known.as_ref().is_none_or(|(known, _)| *known != about) {
            self.rest();
            let found = work(&about);
            self.known = Some((about, found));
        }
        self.known().cloned()
    }

    /// What is known of whatever has been found last.
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
        effort: Effort,
        work: impl FnOnce(&About, &mut (dyn FnMut() -> bool + Send)) -> Option<Found> + Send + 'static,
    ) {
        let stop = Arc::<AtomicBool>::default();
        let (sender, found) = channel();
        let (stopped, ctx, of) = (stop.clone(), ctx.clone(), about.clone());
        let work = move || {
            if effort == Effort::Aside {
                step_aside();
            }
            if let Some(found) = work(&of, &mut || !stopped.load(Ordering::Relaxed)) {
                // It may not be wanted any more.
                let _ = sender.send(found);
            }
            drop(sender);
            match effort {
                Effort::Brief => passes::for_hand(&ctx),
                Effort::Soon | Effort::Aside => passes::for_news(&ctx),
            }
        };
        // Without a thread it is tried again in the next pass.
        let thread = std::thread::Builder::new().name(self.name.into()).spawn(work);
        self.running = thread.ok().map(|_| Running { about, effort, found, stop });
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    /// Asks about one thing after another, as for a mouse that never rests, and returns what was ever known.
    fn asked_in_turn(effort: Effort) -> Vec<u32> {
        let (ctx, mut background) = (Context::default(), Background::new("test"));
        let mut known = Vec::new();
        for about in 0..20 {
            background.of(&ctx, about, effort, |about, goes_on| {
                std::thread::sleep(Duration::from_millis(1));
                goes_on().then_some(*about)
            });
            std::thread::sleep(Duration::from_millis(20));
            known.extend(background.known().copied());
        }
        known.dedup();
        known
    }

    #[test]
    fn what_is_brief_is_known_while_the_mouse_moves() {
        let known = asked_in_turn(Effort::Brief);
        assert!(known.len() >= 15, "{known:?} of twenty");
        assert_eq!(asked_in_turn(Effort::Aside), [0_u32; 0], "what takes long is given up");
    }

    #[test]
    fn at_once_is_asked_once() {
        let mut background = Background::new("test");
        let mut times = 0;
        for about in [1, 1, 2, 2, 2] {
            let found = background.at_once(about, |about| {
                times += 1;
                (*about < 2).then_some(*about)
            });
            assert_eq!(found, (about < 2).then_some(about));
        }
        assert_eq!(times, 2, "nothing found is known, too");
    }
}
