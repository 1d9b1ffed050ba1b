//! Something that is worked out on a thread of its own from coarse to fine, each round to be seen at once.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use eframe::egui::Context;
use mislab_renderer::step_aside;

use crate::state::passes;

/// A running or finished job. Dropping it stops it.
pub struct Rounds<Question, Found> {
    question: Question,
    stop: Arc<AtomicBool>,
    found: Arc<Mutex<Option<Arc<Found>>>>,
}

impl<Question: Clone + Send + 'static, Found: Clone + Send + Sync + 'static> Rounds<Question, Found> {
    /// Starts a thread of that name, in the time that the pictures leave. `work` is told the question, asks whether to go on and
    /// reports what it has found after each round; `ctx` is then asked for a pass. Without a thread nothing is ever found.
    pub fn start(
        ctx: &Context,
        name: &str,
        question: Question,
        work: impl FnOnce(&Question, &(dyn Fn() -> bool + Sync), &mut dyn FnMut(&Found)) + Send + 'static,
    ) -> Self {
        let (stop, found) = (Arc::<AtomicBool>::default(), Arc::new(Mutex::new(None)));
        let (asked, stopped, shared, ctx) = (question.clone(), stop.clone(), Arc::clone(&found), ctx.clone());
        let work = move || {
            step_aside();
            work(&asked, &|| !stopped.load(Ordering::Relaxed), &mut |now| {
                *shared.lock().unwrap_or_else(PoisonError::into_inner) = Some(Arc::new(now.clone()));
                passes::for_news(&ctx);
            });
        };
        let _ = std::thread::Builder::new().name(name.into()).spawn(work);
        Self { question, stop, found }
    }

    /// What it is about.
    pub fn question(&self) -> &Question {
        &self.question
    }

    /// What is known so far, if anything is.
    pub fn found(&self) -> Option<Arc<Found>> {
        self.found.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl<Question, Found> Drop for Rounds<Question, Found> {
    fn drop(&mut self) {
        // Not waited for: it ends within some milliseconds.
        self.stop.store(true, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;
    use std::time::Duration;

    use super::*;

    #[test]
    fn each_round_is_seen_and_dropping_ends_it() {
        let (go, rounds) = channel::<()>();
        let (ended, end) = channel();
        let job = Rounds::start(&Context::default(), "test", 7, move |question, goes_on, report| {
            let mut found = *question;
            while goes_on() && rounds.recv().is_ok() {
                found += 1;
                report(&found);
            }
            let _ = ended.send(goes_on());
        });
        assert_eq!(*job.question(), 7);
        for expected in [8, 9] {
            go.send(()).expect("it is running");
            let deadline = std::time::Instant::now() + Duration::from_secs(10);
            while job.found().as_deref() != Some(&expected) {
                assert!(std::time::Instant::now() < deadline, "{:?} instead of {expected}", job.found());
                std::thread::sleep(Duration::from_millis(1));
            }
        }
        drop(job);
        let _ = go.send(());
        assert_eq!(end.recv_timeout(Duration::from_secs(10)), Ok(false), "nobody wants more");
    }
}
