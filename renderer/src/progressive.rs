//! The progressive renderer: worker threads that turn requests into a stream of frames.
//!
//! A picture's request goes through a one-slot mailbox: the latest wins. Submitting bumps the
//! picture's generation, and that is also how work is cancelled: workers hold a tile for about
//! 2 ms and drop whatever belongs to an older generation. A pass adds the same number of samples to every
//! tile and is published whole or not at all, so that spp is uniform over a frame.
//!
//! Workers and windows share one lock, held for moments only: to claim a tile, to hand it back, to
//! submit. Tiles are rendered, scenes built and frames looked at without it.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, mpsc};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use arc_swap::ArcSwapOption;
use cpu_time::ThreadTime;
use thread_priority::ThreadPriority;

use crate::error::Error;
use crate::frame::{Frame, FrameStats};
use crate::job::{Job, Pass, recycle};
use mislab_kernel::film::Tile;
use mislab_kernel::lanes::Lanewise;
use mislab_kernel::request::{Invalid, PixelRect, Request};
use mislab_kernel::tile::render_tile;
use mislab_kernel::world::BuiltScene;

/// Panics of one generation after which it is given up.
const MAX_PANICS: u64 = 3;

/// How fast passes follow each other. Never changes the bits of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// Only on [`Picture::step`], and once for a new request, so that it is seen at all.
    Paused,
    /// At most so many passes per second.
    PassesPerSecond(f32),
    /// As fast as the machine goes.
    Full,
}

/// What a picture is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Nothing submitted yet.
    Idle,
    /// The scene is being built.
    Building,
    /// Passes are running.
    Rendering,
    /// Held by [`Pace::Paused`].
    Paused,
    /// The spp target is reached.
    Finished,
    /// The request cannot be rendered; [`Status::error`] says why.
    Failed,
}

/// A moment's view of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Status {
    /// Generation being worked on.
    pub generation: u64,
    /// Complete passes of it.
    pub spp: u32,
    /// What it is doing.
    pub state: State,
    /// Why it failed, or what a worker died of.
    pub error: Option<String>,
    /// Times this picture was started again because a worker panicked.
    pub worker_panics: u64,
}

/// Worker threads and the pictures they work on. Dropping it cancels and joins them.
pub struct Renderer {
    shared: Arc<Shared>,
    workers: Vec<JoinHandle<()>>,
}

struct Shared {
    core: Mutex<Core>,
    /// Signalled when there may be something to do.
    work: Condvar,
    wake: Box<dyn Fn() + Send + Sync>,
    threads: usize,
    how: Lanewise,
}

#[derive(Default)]
struct Core {
    shutdown: bool,
    pictures: Vec<PictureState>,
    /// Where the next search for work starts, so that pictures take turns.
    turn: usize,
    next_id: u64,
}

struct PictureState {
    id: u64,
    generation: u64,
    /// What was asked for last, whatever has become of it.
    request: Option<Arc<Request>>,
    mailbox: Option<Arc<Request>>,
    building: bool,
    job: Option<Job>,
    /// The last scene built, whose geometry the next one may share.
    built: Option<Arc<BuiltScene>>,
    pace: Pace,
    steps: u32,
    error: Option<String>,
    worker_panics: u64,
    latest: Arc<Latest>,
    /// Tiles no longer worked on; their buffers are used again once no frame shares them.
    retired: Vec<Arc<Tile>>,
}

/// Something for a worker to do, taken from the core under its lock.
#[expect(clippy::large_enum_variant, reason = "moved once per task, never stored")]
enum Task {
    Build {
        picture: u64,
        generation: u64,
        request: Arc<Request>,
    },
    Tile(TileTask),
    /// Nothing, but a frame was published.
    Published,
}

struct TileTask {
    picture: u64,
    job: u64,
    index: usize,
    rect: PixelRect,
    count: u32,
    request: Arc<Request>,
    scene: Arc<BuiltScene>,
    tile: Option<Arc<Tile>>,
    recycled: Option<Tile>,
}

impl Renderer {
    /// Starts `threads` workers (0: one per core). `wake` is called from a worker whenever a new
    /// frame or state is there to be fetched.
    pub fn new(threads: usize, wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self::with_lanes(threads, Lanewise::best(), wake)
    }

    /// The same at a given SIMD level, for tests and comparisons.
    pub fn with_lanes(threads: usize, how: Lanewise, wake: impl Fn() + Send + Sync + 'static) -> Self {
        let threads = match threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            n => n,
        };
        let shared =
            Arc::new(Shared { core: Mutex::default(), work: Condvar::new(), wake: Box::new(wake), threads, how });
        let workers = (0..threads)
            .map(|i| {
                let shared = shared.clone();
                std::thread::Builder::new()
                    .name(format!("render-{i}"))
                    .spawn(move || shared.run())
                    .expect("the system can start a thread")
            })
            .collect();
        Self { shared, workers }
    }

    /// A new picture, idle.
    pub fn add_picture(&self) -> Picture {
        let latest = Arc::<Latest>::default();
        let mut core = self.shared.lock();
        core.next_id += 1;
        let id = core.next_id;
        core.pictures.push(PictureState {
            id,
            generation: 0,
            request: None,
            mailbox: None,
            building: false,
            job: None,
            built: None,
            pace: Pace::Full,
            steps: 0,
            error: None,
            worker_panics: 0,
            latest: latest.clone(),
            retired: Vec::new(),
        });
        drop(core);
        Picture { id, latest, shared: self.shared.clone() }
    }

    /// Number of workers.
    pub fn threads(&self) -> usize {
        self.shared.threads
    }
}

impl Drop for Renderer {
    fn drop(&mut self) {
        self.shared.lock().shutdown = true;
        self.shared.work.notify_all();
        for worker in self.workers.drain(..) {
            // A worker that panicked outside a tile has said so already.
            let _ = worker.join();
        }
    }
}

/// Handle of one picture; dropping it takes the picture away from the workers.
pub struct Picture {
    id: u64,
    latest: Arc<Latest>,
    shared: Arc<Shared>,
}

/// The newest frame of a picture.
#[derive(Default)]
struct Latest {
    frame: ArcSwapOption<Frame>,
    /// Somebody has come for it. If nobody does, no other is made: what a frame shares has to be copied.
    taken: AtomicBool,
}

impl Latest {
    fn put(&self, frame: Frame) {
        // In this order: a frame may be taken for one that somebody has come for, but never the other way round.
        self.taken.store(false, Ordering::SeqCst);
        self.frame.store(Some(Arc::new(frame)));
    }

    fn take(&self) -> Option<Arc<Frame>> {
        let frame = self.frame.load_full();
        self.taken.store(true, Ordering::SeqCst);
        frame
    }
}

impl Picture {
    /// Replaces the request; the latest wins. Returns its generation at once.
    /// If only the spp target changed, rendering goes on from where it is.
    pub fn submit(&self, request: Request) -> u64 {
        let request = Arc::new(request);
        self.with(|p| {
            p.request = Some(request.clone());
            if p.mailbox.is_none()
                && let Some(job) = &mut p.job
                && job.generation == p.generation
                && job.request.same_samples(&request)
                && request
                    .settings
                    .sampling
                    .target()
                    .is_none_or(|n| n >= job.samples + job.pass.as_ref().map_or(0, |pass| pass.count))
            {
                job.request = request;
                // The frame on show was made with another target: let it be replaced.
                job.published = 0;
                return p.generation;
            }
            p.generation += 1;
            p.error = None;
            p.worker_panics = 0;
            p.mailbox = Some(request);
            p.generation
        })
    }

    /// Starts the same request again from the first sample.
    pub fn restart(&self) -> u64 {
        self.with(|p| {
            // Not that of the job: it is an older one while a scene is built.
            p.mailbox = p.request.clone();
            p.generation += 1;
            p.error = None;
            p.worker_panics = 0;
            p.generation
        })
    }

    /// Sets how fast passes follow each other.
    pub fn set_pace(&self, pace: Pace) {
        self.with(|p| {
            p.pace = pace;
            p.steps = 0;
        });
    }

    /// Allows one more pass while paused.
    pub fn step(&self) {
        self.with(|p| p.steps += 1);
    }

    /// The newest complete frame, perhaps of an older generation. Never waits. While nobody asks, no newer one is made,
    /// but for that of the last pass before a pause or the target.
    pub fn latest(&self) -> Option<Arc<Frame>> {
        self.latest.take()
    }

    /// What is going on.
    pub fn status(&self) -> Status {
        self.with(|p| p.status())
    }

    fn with<T>(&self, act: impl FnOnce(&mut PictureState) -> T) -> T {
        let mut core = self.shared.lock();
        let picture =
            core.pictures.iter_mut().find(|p| p.id == self.id).expect("a picture lives as long as its handle");
        let result = act(picture);
        drop(core);
        self.shared.work.notify_all();
        result
    }
}

impl Drop for Picture {
    fn drop(&mut self) {
        self.shared.lock().pictures.retain(|p| p.id != self.id);
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Core> {
        // No code that can panic runs under this lock, so a poisoned one is still sound.
        self.core.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A worker's life.
    fn run(&self) {
        // The window comes first (nice 5 where the system counts so; the lowest priority would
        // starve next to any other busy program). Where the system refuses, everything still works.
        if let Ok(below_normal) = 37u8.try_into() {
            let _ = ThreadPriority::Crossplatform(below_normal).set_for_current();
        }
        while let Some(task) = self.next_task() {
            let news = match task {
                Task::Build { picture, generation, request } => self.build(picture, generation, request),
                Task::Tile(task) => self.render(task),
                Task::Published => true,
            };
            if news {
                (self.wake)();
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
            let now = Instant::now();
            let mut wait = Duration::from_secs(3600);
            let count = core.pictures.len();
            for k in 0..count {
                let i = (core.turn + k) % count;
                match core.pictures[i].claim(now) {
                    Ok(task) => {
                        core.turn = (i + 1) % count;
                        return Some(task);
                    }
                    Err(next) => wait = wait.min(next),
                }
            }
            core = self.work.wait_timeout(core, wait).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Builds a scene; true if there is news for the window.
    fn build(&self, picture: u64, generation: u64, request: Arc<Request>) -> bool {
        let known: Vec<_> = self.lock().pictures.iter().filter_map(|p| p.built.clone()).collect();
        let built = catch_unwind(|| BuiltScene::with_known(&request.scene, &request.settings, &known).map(Arc::new))
            .unwrap_or_else(|panic| Err(Invalid(format!("building the scene failed: {}", panic_text(&*panic)))));
        let mut core = self.lock();
        let Some(p) = core.pictures.iter_mut().find(|p| p.id == picture) else { return false };
        // Even where the request has changed since: the next one may want the same geometry.
        let replaced = match &built {
            Ok(scene) => p.built.replace(scene.clone()),
            Err(_) => None,
        };
        if p.generation != generation {
            return false;
        }
        p.building = false;
        p.retire_job();
        match built {
            Ok(scene) => p.job = Some(Job::new(generation, request, scene)),
            Err(error) => p.error = Some(error.to_string()),
        }
        drop(core);
        // To free a large scene takes its time: not under the lock.
        drop((replaced, known));
        self.work.notify_all();
        true
    }

    /// Renders one tile; true if there is news for the window.
    fn render(&self, task: TileTask) -> bool {
        let TileTask { picture, job, index, rect, count, request, scene, tile, recycled } = task;
        let start = ThreadTime::now();
        // Frames share tiles: one that is shared is copied before it is written to.
        let mut retired = None;
        let mut tile = match tile {
            None => Tile::new(rect, request.settings.estimator.strategy, recycled),
            Some(tile) => Arc::try_unwrap(tile).unwrap_or_else(|shared| {
                let copy = shared.copy(recycled);
                retired = Some(shared);
                copy
            }),
        };
        let rendered =
            catch_unwind(AssertUnwindSafe(|| render_tile(self.how, &scene, &request.settings, &mut tile, count)));
        let seconds = start.elapsed().as_secs_f64();

        let mut core = self.lock();
        let Some(p) = core.pictures.iter_mut().find(|p| p.id == picture) else { return false };
        p.retired.extend(retired);
        // A third set of sums would be needed while the window draws the last frame, and the new one be drawn no sooner.
        let wait =
            p.pace == Pace::Full && p.latest.frame.load().as_ref().is_some_and(|last| Arc::strong_count(last) > 1);
        let taken = p.latest.taken.load(Ordering::SeqCst);
        let current = p.generation;
        let Some(work) = p.job.as_mut().filter(|work| work.id == job && work.generation == current) else {
            p.retired.push(Arc::new(tile));
            return false;
        };
        let news = match rendered {
            Ok(invalid) => {
                work.tiles[index] = Some(Arc::new(tile));
                work.invalid += invalid;
                work.cpu_seconds += seconds;
                match work.finish_tile(taken, wait) {
                    None => return false,
                    Some(Some(stats)) => {
                        let frame = work.frame(FrameStats { threads: self.threads, simd: self.how.name(), ..stats });
                        let needed = work.rects.len();
                        p.latest.put(frame);
                        p.trim(needed);
                        true
                    }
                    Some(None) => false,
                }
            }
            Err(panic) => {
                p.recover(&panic_text(&*panic));
                true
            }
        };
        drop(core);
        self.work.notify_all();
        news
    }
}

impl PictureState {
    fn status(&self) -> Status {
        let (state, spp) = match &self.job {
            _ if self.error.is_some() && self.job.is_none() && self.mailbox.is_none() && !self.building => {
                (State::Failed, 0)
            }
            Some(job) if job.generation == self.generation => {
                let state = if job.finished() {
                    State::Finished
                } else if self.pace == Pace::Paused && job.pass.is_none() && self.steps == 0 && job.samples > 0 {
                    State::Paused
                } else {
                    State::Rendering
                };
                (state, job.samples)
            }
            _ if self.mailbox.is_some() || self.building => (State::Building, 0),
            _ => (State::Idle, 0),
        };
        Status { generation: self.generation, spp, state, error: self.error.clone(), worker_panics: self.worker_panics }
    }

    /// Something to do for this picture, or how long until there may be.
    fn claim(&mut self, now: Instant) -> Result<Task, Duration> {
        const LONG: Duration = Duration::from_secs(3600);
        if let Some(request) = self.mailbox.take() {
            self.building = true;
            return Ok(Task::Build { picture: self.id, generation: self.generation, request });
        }
        let Some(job) = self.job.as_mut().filter(|job| job.generation == self.generation) else {
            return Err(LONG);
        };
        if job.pass.is_none() {
            let paused = self.pace == Pace::Paused && self.steps == 0 && job.samples > 0;
            if (paused || job.finished()) && job.published != job.samples {
                // Only the target moved, and the frame on show still names the old one; or the last pass made no frame.
                let frame = job.frame(FrameStats { ..job.stats() });
                let shown = self.latest.frame.load_full();
                let (threads, simd) = shown.map_or((0, ""), |f| (f.stats.threads, f.stats.simd));
                let stats = FrameStats { threads, simd, ..frame.stats };
                self.latest.put(Frame { stats, ..frame });
                job.published = job.samples;
                return Ok(Task::Published);
            }
            if paused || job.finished() {
                return Err(LONG);
            }
            let mut count = 1;
            if job.samples > 0 {
                match self.pace {
                    Pace::Paused => self.steps -= 1,
                    Pace::PassesPerSecond(rate) => {
                        let period = Duration::from_secs_f64(1.0 / f64::from(rate.clamp(1e-3, 1e4)));
                        let due = job.last_start.map_or(now, |start| start + period);
                        if now < due {
                            return Err(due - now);
                        }
                    }
                    Pace::Full => count = job.burst(self.latest.taken.load(Ordering::SeqCst)),
                }
            }
            job.last_start = Some(now);
            job.pass = Some(Pass { count, next_tile: 0, done: 0, start: now });
        }
        let Some(pass) = job.pass.as_mut().filter(|pass| pass.next_tile < job.rects.len()) else {
            return Err(LONG);
        };
        let index = pass.next_tile;
        pass.next_tile += 1;
        let tile = job.tiles[index].take();
        let needs_buffer = tile.as_ref().is_none_or(|tile| Arc::strong_count(tile) > 1);
        let recycled = if needs_buffer { recycle(&mut self.retired, job.rects[index]) } else { None };
        Ok(Task::Tile(TileTask {
            picture: self.id,
            job: job.id,
            index,
            rect: job.rects[index],
            count: pass.count,
            request: job.request.clone(),
            scene: job.scene.clone(),
            tile,
            recycled,
        }))
    }

    fn retire_job(&mut self) {
        if let Some(job) = self.job.take() {
            let needed = job.rects.len();
            self.retired.extend(job.tiles.into_iter().flatten());
            self.trim(needed);
        }
    }

    /// Keeps as many free buffers as a pass needs, one per tile. What frames still share costs nothing and may be the next
    /// to be free.
    fn trim(&mut self, needed: usize) {
        let excess = self.retired.len().saturating_sub(2 * needed);
        self.retired.drain(..excess);
        let mut free = 0;
        self.retired.retain(|tile| {
            free += usize::from(Arc::strong_count(tile) == 1);
            Arc::strong_count(tile) > 1 || free <= needed
        });
    }

    /// After a panic: the pass is lost with its tile. Starts the generation again, a few times.
    fn recover(&mut self, what: &str) {
        self.worker_panics += 1;
        let message = format!("a render thread failed: {what}");
        let job = self.job.as_ref().map(|job| (job.generation, job.request.clone(), job.scene.clone()));
        self.retire_job();
        if self.worker_panics < MAX_PANICS {
            self.job = job.map(|(generation, request, scene)| Job::new(generation, request, scene));
        }
        self.error = Some(message);
    }
}

fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(ToString::to_string).or(panic.downcast_ref::<String>().cloned());
    text.unwrap_or_else(|| "panic without a message".into())
}

/// How far a blocking render is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Complete passes.
    pub spp: u32,
    /// Passes asked for.
    pub target: Option<u32>,
    /// Since the start.
    pub elapsed: Duration,
    /// Secondary rays traced.
    pub paths: u64,
}

/// Renders to the spp target and returns the final frame: the same engine and the same bits as in
/// a window. `on_progress` returns false to stop early, after the running pass.
///
/// # Errors
/// [`Error::Invalid`] if the scene or a setting cannot be rendered, if no spp target is given, or
/// if `on_progress` stopped it before the first pass was complete.
pub fn render(
    request: &Request,
    threads: usize,
    on_progress: &mut dyn FnMut(&Progress) -> bool,
) -> Result<Arc<Frame>, Error> {
    render_with(request, threads, Lanewise::best(), on_progress)
}

/// [`render`] at a given SIMD level, for tests and comparisons.
///
/// # Errors
/// As [`render`].
pub fn render_with(
    request: &Request,
    threads: usize,
    how: Lanewise,
    on_progress: &mut dyn FnMut(&Progress) -> bool,
) -> Result<Arc<Frame>, Error> {
    let target = request.settings.sampling.target();
    if target.is_none() {
        return Err(Error::Invalid("endless spp, expected a number of samples per pixel".into()));
    }
    let (send, news) = mpsc::channel();
    let renderer = Renderer::with_lanes(threads, how, move || {
        // The receiver is gone only when nobody waits any more.
        let _ = send.send(());
    });
    let picture = renderer.add_picture();
    let pixels = request.settings.pixel_bounds().area() as u64;
    let start = Instant::now();
    picture.submit(request.clone());
    loop {
        // The time-out is for the progress report; every change of state sends a message.
        let _ = news.recv_timeout(Duration::from_millis(100));
        let status = picture.status();
        match status.state {
            State::Failed => return Err(Error::Invalid(status.error.unwrap_or_default())),
            State::Finished | State::Paused => {
                if let Some(frame) = picture.latest().filter(|frame| frame.spp() == status.spp) {
                    return Ok(frame);
                }
            }
            State::Idle | State::Building | State::Rendering => {}
        }
        let paths = pixels * u64::from(status.spp) * u64::from(request.settings.estimator.strategy.rays_per_sample());
        if !on_progress(&Progress { spp: status.spp, target, elapsed: start.elapsed(), paths }) {
            if status.spp == 0 {
                return Err(Error::Invalid("stopped before the first pass was complete".into()));
            }
            // The frame of the last pass follows.
            picture.set_pace(Pace::Paused);
        }
    }
}

/// The SIMD level the kernels run at on this machine, e.g. "AVX-512".
pub fn simd_level_name() -> &'static str {
    Lanewise::best().name()
}
