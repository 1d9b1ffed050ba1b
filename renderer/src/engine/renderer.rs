//! The handles: a renderer with its threads, and the pictures it works on.

use std::sync::Arc;
use std::thread::JoinHandle;

use arc_swap::ArcSwapOption;
use mislab_kernel::lanes::Lanewise;
use mislab_kernel::request::Request;

use super::core::Core;
use super::job::Machine;
use super::lockstep::{Abreast, Group, Lockstep};
use super::schedule::PictureState;
use super::status::{Pace, Status};
use super::subscription::{Feed, Frames, Subscription};
use super::worker::{Shared, set_priority};
use crate::frame::Frame;

/// The window comes first: nice 5 where the system counts so. The lowest priority would starve next to any other busy program.
const BELOW_WINDOW: u8 = 37;
/// Nice 13: an eighth of the time beside a live picture.
const BELOW_PICTURES: u8 = 15;
/// Nice 15: a tenth of one core beside a live picture.
const ASIDE: u8 = 10;

/// Worker threads and the pictures they work on. Dropping it cancels and joins them.
pub struct Renderer {
    pub(super) shared: Arc<Shared>,
    workers: Vec<JoinHandle<()>>,
}

impl Renderer {
    /// Starts `threads` workers (0: one per core), or as many as the system grants. `wake` is called from a worker whenever a new
    /// frame or state is there to be fetched.
    pub fn new(threads: usize, wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self::start(threads, Lanewise::best(), BELOW_WINDOW, wake)
    }

    /// The same at a given SIMD level, for tests and comparisons.
    pub fn with_lanes(threads: usize, how: Lanewise, wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self::start(threads, how, BELOW_WINDOW, wake)
    }

    /// The same for what may take its time: live pictures of another renderer come first.
    pub fn in_background(threads: usize) -> Self {
        Self::start(threads, Lanewise::best(), BELOW_PICTURES, || {})
    }

    fn start(threads: usize, how: Lanewise, priority: u8, wake: impl Fn() + Send + Sync + 'static) -> Self {
        let threads = match threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            n => n,
        };
        let machine = Machine { threads, simd: how.name() };
        let shared = Arc::new(Shared::new(Core::new(machine), how, wake));
        let start = |i: usize| {
            let shared = shared.clone();
            std::thread::Builder::new().name(format!("render-{i}")).spawn(move || shared.run(priority))
        };
        let first = start(0).expect("the system can start a thread");
        let workers = std::iter::once(first).chain((1..threads).map_while(|i| start(i).ok())).collect();
        Self { shared, workers }
    }

    /// A new picture, idle.
    pub fn add_picture(&self) -> Picture {
        let mut core = self.shared.lock();
        let id = core.new_id();
        let state = PictureState::new(id);
        let latest = state.latest.clone();
        core.pictures.push(state);
        drop(core);
        Picture { id, latest, shared: self.shared.clone() }
    }

    /// Keeps pictures abreast as long as the answer is held: none begins a pass while it is ahead of the slowest, so that none
    /// is ever ahead by more than one pass; at equal samples or rays per pixel their passes end together. A picture is in one
    /// group: it leaves another one that it is in.
    ///
    /// Nobody waits for a picture that is idle, paused, finished or failed. One that has to build a scene, is started
    /// again or goes on after a pause is waited for until it has caught up, and a slow [`Pace`] is everybody's. The first
    /// pass of a request never waits.
    ///
    /// # Panics
    /// If a picture is another renderer's.
    pub fn keep_abreast(&self, pictures: &[&Picture], by: Lockstep) -> Abreast {
        let ours = |picture: &&Picture| Arc::ptr_eq(&picture.shared, &self.shared);
        assert!(pictures.iter().all(ours), "all pictures are of this renderer");
        let members: Vec<u64> = pictures.iter().map(|picture| picture.id).collect();
        let mut core = self.shared.lock();
        for group in &mut core.groups {
            group.members.retain(|id| !members.contains(id));
        }
        let id = core.new_id();
        core.groups.push(Group { id, by, members });
        drop(core);
        self.shared.work.notify_all();
        let shared = self.shared.clone();
        let end = move || {
            shared.lock().groups.retain(|group| group.id != id);
            shared.work.notify_all();
        };
        Abreast { end: Box::new(end) }
    }

    /// Number of workers.
    pub fn threads(&self) -> usize {
        self.workers.len()
    }
}

impl Drop for Renderer {
    fn drop(&mut self) {
        let mut core = self.shared.lock();
        core.shutdown = true;
        core.pictures.iter().for_each(PictureState::halt);
        drop(core);
        self.shared.work.notify_all();
        for worker in self.workers.drain(..) {
            // A worker that panicked outside a tile has said so already.
            let _ = worker.join();
        }
    }
}

/// Handle of one picture; dropping it takes the picture away from the workers.
pub struct Picture {
    pub(super) id: u64,
    pub(super) latest: Arc<ArcSwapOption<Frame>>,
    pub(super) shared: Arc<Shared>,
}

impl Picture {
    /// Replaces the request; the latest wins. Returns its generation at once.
    /// If only the spp target changed, rendering goes on from where it is.
    pub fn submit(&self, request: Request) -> u64 {
        let request = Arc::new(request);
        self.shared.with(self.id, |p| p.submit(request))
    }

    /// Starts the same request again from the first sample.
    pub fn restart(&self) -> u64 {
        self.shared.with(self.id, PictureState::restart)
    }

    /// Sets how fast passes follow each other.
    pub fn set_pace(&self, pace: Pace) {
        self.shared.with(self.id, |p| p.set_pace(pace));
    }

    /// Allows one more pass while paused.
    pub fn step(&self) {
        self.shared.with(self.id, PictureState::step);
    }

    /// Asks for frames until the answer is dropped. Those at marks begin with the next pass: who wants all of a request
    /// subscribes before he submits it.
    pub fn subscribe(&self, wanted: Subscription) -> Frames {
        let feed = Arc::new(Feed::new(wanted));
        self.shared.with(self.id, |p| p.subscribe(&feed));
        feed.frames(self.latest.clone())
    }

    /// The newest complete frame, perhaps of an older generation; never waits. Without a subscription that is the first one of
    /// a request, that of the last pass before a pause, or the final one.
    pub fn latest(&self) -> Option<Arc<Frame>> {
        self.latest.load_full()
    }

    /// What is going on.
    pub fn status(&self) -> Status {
        self.shared.look(self.id, |p| p.status())
    }
}

impl Drop for Picture {
    fn drop(&mut self) {
        let mut core = self.shared.lock();
        let at = core.pictures.iter().position(|p| p.id == self.id);
        let state = at.map(|at| core.pictures.remove(at));
        drop(core);
        // Others may have waited for it. To free its memory takes its time: not under the lock.
        self.shared.work.notify_all();
        drop(state);
    }
}

/// Lowers the calling thread to what follows the mouse: pictures and references come first.
pub fn step_aside() {
    set_priority(ASIDE);
}

/// The SIMD level the kernels run at on this machine, e.g. "AVX-512".
pub fn simd_level_name() -> &'static str {
    Lanewise::best().name()
}
