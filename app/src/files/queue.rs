//! Work that is done one piece after the other, and finished before the program ends.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Sender, channel};
use std::thread::JoinHandle;

type Job = Box<dyn FnOnce() + Send>;

/// A queue with a thread of its own. Dropping it finishes what is in it.
pub struct Queue {
    sender: Option<Sender<Job>>,
    thread: Option<JoinHandle<()>>,
}

impl Queue {
    /// An empty queue.
    pub fn new() -> Self {
        let (sender, jobs) = channel::<Job>();
        let work = move || {
            for job in jobs {
                // What breaks down costs itself, not what waits behind it; whoever asked for it has to notice.
                let _ = catch_unwind(AssertUnwindSafe(job));
            }
        };
        let thread = std::thread::Builder::new().name("saving".into()).spawn(work).ok();
        Self { sender: Some(sender), thread }
    }

    /// Adds something to the end. Without a thread it is done here and now: late is better than lost.
    pub fn push(&self, job: impl FnOnce() + Send + 'static) {
        let job: Job = Box::new(job);
        match &self.sender {
            Some(sender) if self.thread.is_some() => {
                if let Err(refused) = sender.send(job) {
                    (refused.0)();
                }
            }
            Some(_) | None => job(),
        }
    }

    /// Waits until all is done.
    pub fn finish(&mut self) {
        self.sender = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Default for Queue {
    fn default() -> Self {
        Self::new()
    }
}

impl Drop for Queue {
    fn drop(&mut self) {
        self.finish();
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};
    use std::time::Duration;

    use super::*;

    #[test]
    fn jobs_are_done_in_order_and_all_of_them() {
        let done = Arc::new(Mutex::new(Vec::new()));
        let mut queue = Queue::new();
        for n in 0..20_u64 {
            let done = done.clone();
            queue.push(move || {
                std::thread::sleep(Duration::from_millis((20 - n) / 4));
                assert_ne!(n, 7, "one breaks down");
                done.lock().expect("not poisoned").push(n);
            });
        }
        queue.finish();
        let expected: Vec<u64> = (0..20).filter(|n| *n != 7).collect();
        assert_eq!(*done.lock().expect("not poisoned"), expected);
        let late = done.clone();
        queue.push(move || late.lock().expect("not poisoned").push(99));
        assert_eq!(done.lock().expect("not poisoned").last(), Some(&99), "late is better than lost");
    }
}
