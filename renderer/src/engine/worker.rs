//! The worker threads: they build scenes, render tiles, and survive panics.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use mislab_kernel::film::Tile;
use mislab_kernel::lanes::Lanewise;
use mislab_kernel::request::{Invalid, Request};
use mislab_kernel::stop::{Stop, Stopped};
use mislab_kernel::tile::render_tile;
use mislab_kernel::world::{BuiltScene, Unbuilt};
use thread_priority::ThreadPriority;

use super::core::Core;
use super::schedule::{Outcome, PictureState, Task, TileTask};
use super::spent;
use crate::memory::{self, Need};

/// What workers and handles have in common.
pub(super) struct Shared {
    pub(super) core: Mutex<Core>,
    /// Signalled when there may be something to do.
    pub(super) work: Condvar,
    /// Signalled with `wake`, for those who wait for a picture.
    news: Condvar,
    wake: Box<dyn Fn() + Send + Sync>,
    how: Lanewise,
}

impl Shared {
    pub(super) fn new(core: Core, how: Lanewise, wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self { core: Mutex::new(core), work: Condvar::new(), news: Condvar::new(), wake: Box::new(wake), how }
    }

    pub(super) fn lock(&self) -> MutexGuard<'_, Core> {
        // No code that can panic runs under this lock, so a poisoned one is still sound.
        self.core.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Looks at a picture or changes it; it is there as long as its handle.
    pub(super) fn look<T>(&self, id: u64, act: impl FnOnce(&mut PictureState) -> T) -> T {
        act(self.lock().picture(id).expect("a picture lives as long as its handle"))
    }

    /// Changes a picture in a way that may give the workers something to do.
    pub(super) fn with<T>(&self, id: u64, act: impl FnOnce(&mut PictureState) -> T) -> T {
        let result = self.look(id, act);
        self.work.notify_all();
        result
    }

    /// Waits until there is news of any picture and `done` says so of this one, but no longer than `timeout`.
    pub(super) fn wait_for(&self, id: u64, timeout: Duration, done: impl Fn(&PictureState) -> bool) {
        let on = |core: &mut Core| !core.picture(id).is_none_or(|p| done(p));
        // Woken or timed out: the caller looks anyway.
        drop(self.news.wait_timeout_while(self.lock(), timeout, on));
    }

    fn tell(&self) {
        self.news.notify_all();
        (self.wake)();
    }

    /// A worker's life, at a priority from 0 to 99. Where the system refuses, everything still works.
    pub(super) fn run(&self, priority: u8) {
        set_priority(priority);
        while let Some(task) = self.next_task() {
            let news = match task {
                Task::Build { picture, generation, request } => self.build(picture, generation, request),
                Task::Tile(task) => self.render(task),
                Task::Published(replaced) => {
                    drop(replaced);
                    true
                }
            };
            if news {
                self.tell();
            }
        }
    }

    /// Waits for something to do; `None` at shutdown.
    fn next_task(&self) -> Option<Task> {
        let mut core = self.lock();
        loop {
            if core.shutdown {
                return None;
            }
            match core.claim(Instant::now()) {
                Ok(task) => return Some(task),
                Err(wait) => core = self.work.wait_timeout(core, wait).unwrap_or_else(PoisonError::into_inner).0,
            }
        }
    }

    /// Builds a scene; true if there is news for the window. Given up as soon as nobody wants it any more.
    fn build(&self, picture: u64, generation: u64, request: Arc<Request>) -> bool {
        if let Err(message) = self.grant(picture, &request) {
            return self.hand_over(picture, generation, request, Some(Err(Invalid(message))));
        }
        let known: Vec<_> = self.lock().pictures.iter().filter_map(|p| p.built.clone()).collect();
        let judged = Cell::new((generation, true));
        let stopped = || !self.still_wants(picture, &request, &judged);
        let start = ThreadTime::now();
        let build = || BuiltScene::with_known(&request.scene, &request.settings, &known, Stop::when(&stopped));
        let built = match catch_unwind(AssertUnwindSafe(build)) {
            Ok(Ok(scene)) => Some(Ok(Arc::new(scene))),
            Ok(Err(Unbuilt::Invalid(invalid))) => Some(Err(invalid)),
            Ok(Err(Unbuilt::Stopped)) => None,
            Err(panic) => Some(Err(Invalid(format!("building the scene failed: {}", panic_text(&*panic))))),
        };
        spent::add(start.elapsed());
        let news = self.hand_over(picture, generation, request, built);
        // To free a large scene takes its time: not under the lock.
        drop(known);
        news
    }

    /// Whether there is memory for a picture. What it had for its last scene goes into it.
    fn grant(&self, picture: u64, request: &Request) -> Result<(), String> {
        let need = Need::of(request);
        let granted = self.lock().picture(picture).map_or(0, |p| p.granted);
        memory::check(&need, granted)?;
        if let Some(p) = self.lock().picture(picture) {
            p.granted = need.kept();
        }
        Ok(())
    }

    /// Gives a picture what became of its scene; true if there is news for the window.
    fn hand_over(
        &self,
        picture: u64,
        generation: u64,
        request: Arc<Request>,
        built: Option<Result<Arc<BuiltScene>, Invalid>>,
    ) -> bool {
        let mut core = self.lock();
        let machine = core.machine;
        let Some(p) = core.picture(picture) else { return false };
        let (replaced, news) = p.take_built(generation, request, built, machine);
        drop(core);
        drop(replaced);
        self.work.notify_all();
        news
    }

    /// Whether a picture still has use for the scene of a request: it may have moved on to another one with the same
    /// geometry, which is what takes long. `judged` keeps the last generation looked at, and the answer.
    fn still_wants(&self, picture: u64, request: &Request, judged: &Cell<(u64, bool)>) -> bool {
        let newest = {
            let mut core = self.lock();
            if core.shutdown {
                return false;
            }
            let Some(p) = core.picture(picture) else { return false };
            if p.generation == judged.get().0 {
                return judged.get().1;
            }
            p.request.clone().map(|newest| (p.generation, newest))
        };
        let Some((generation, newest)) = newest else { return false };
        let wanted = BuiltScene::same_geometry(&request.scene, &newest.scene);
        judged.set((generation, wanted));
        wanted
    }

    /// Renders one tile; true if there is news for the window.
    fn render(&self, task: TileTask) -> bool {
        let TileTask { picture, job, index, rect, count, request, scene, tile, recycled, halted } = task;
        let start = ThreadTime::now();
        // Frames share tiles: one that is shared is copied before it is written to.
        let mut copied = None;
        let mut tile = match tile {
            None => Tile::new(rect, request.settings.estimator.strategy, recycled),
            Some(tile) => Arc::try_unwrap(tile).unwrap_or_else(|shared| {
                let copy = shared.copy(recycled);
                copied = Some(shared);
                copy
            }),
        };
        // What frames cost is no rendering.
        let copying = start.elapsed();
        let stopped = || halted.load(Ordering::Relaxed);
        let render = || render_tile(self.how, &scene, &request.settings, &mut tile, count, Stop::when(&stopped));
        let rendered = catch_unwind(AssertUnwindSafe(render));
        let time = start.elapsed();
        spent::add(time.saturating_sub(copying));
        let rendered = match rendered {
            Ok(Ok(invalid)) => Ok(invalid),
            // The job is gone, and its tiles with it.
            Ok(Err(Stopped)) => return false,
            Err(panic) => Err(panic_text(&*panic)),
        };

        let mut core = self.lock();
        let Some(p) = core.picture(picture) else { return false };
        let outcome = p.take_tile(job, index, tile, copied, rendered, time.as_secs_f64());
        drop(core);
        match &outcome {
            Outcome::Nothing => return false,
            Outcome::Pass(_) | Outcome::Panic => self.work.notify_all(),
        }
        matches!(outcome, Outcome::Pass(Some(_)) | Outcome::Panic)
    }
}

fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(ToString::to_string).or(panic.downcast_ref::<String>().cloned());
    text.unwrap_or_else(|| "panic without a message".into())
}

/// Gives the calling thread a priority from 0 to 99. Where the system refuses, everything still works.
pub(super) fn set_priority(priority: u8) {
    if let Ok(priority) = priority.try_into() {
        let _ = ThreadPriority::Crossplatform(priority).set_for_current();
    }
}
