//! What is next for a picture: its request, when a pass begins, and when a frame is due.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Weak};
use std::time::{Duration, Instant};

use arc_swap::ArcSwapOption;
use mislab_kernel::film::Tile;
use mislab_kernel::request::{Invalid, PixelRect, Request};
use mislab_kernel::world::BuiltScene;

use super::job::{Job, Machine, recycle};
use super::lockstep::{Lockstep, Standing};
use super::status::{Pace, State, Status};
use super::subscription::{Feed, Moment, Wanted};
use crate::frame::Frame;

/// Panics of one generation after which it is given up.
const MAX_PANICS: u64 = 3;
/// Until something happens: who makes it happen wakes the workers.
pub(super) const LONG: Duration = Duration::from_secs(3600);

/// Something for a worker to do, taken from the core under its lock.
#[expect(clippy::large_enum_variant, reason = "moved once per task, never stored")]
pub(super) enum Task {
    Build {
        picture: u64,
        generation: u64,
        request: Arc<Request>,
    },
    Tile(TileTask),
    /// Nothing, but a frame was published in place of these.
    Published(Replaced),
}

pub(super) struct TileTask {
    pub(super) picture: u64,
    pub(super) job: u64,
    pub(super) index: usize,
    pub(super) rect: PixelRect,
    pub(super) count: u32,
    pub(super) request: Arc<Request>,
    pub(super) scene: Arc<BuiltScene>,
    pub(super) tile: Option<Arc<Tile>>,
    pub(super) recycled: Option<Tile>,
    /// See [`super::job::Halt`].
    pub(super) halted: Arc<AtomicBool>,
}

/// Frames that nobody may hold any more. With the last one of a generation goes its scene, and to free a large one takes its
/// time: to be dropped where no lock is held.
pub(super) type Replaced = Vec<Arc<Frame>>;

/// What came of a tile.
pub(super) enum Outcome {
    /// The pass goes on, or the tile is of one that has been cancelled.
    Nothing,
    /// The pass is complete; with a frame, if there are frames that it replaces.
    Pass(Option<Replaced>),
    /// The pass was lost.
    Panic,
}

/// One picture.
pub(super) struct PictureState {
    pub(super) id: u64,
    pub(super) generation: u64,
    /// What was asked for last.
    pub(super) request: Option<Arc<Request>>,
    /// It waits for a worker to build its scene.
    waiting: bool,
    building: bool,
    job: Option<Job>,
    /// The last scene built, whose geometry the next one may share.
    pub(super) built: Option<Arc<BuiltScene>>,
    /// Bytes that it keeps by now, as far as they were foreseen.
    pub(super) granted: u64,
    pace: Pace,
    steps: u32,
    error: Option<String>,
    worker_panics: u64,
    pub(super) latest: Arc<ArcSwapOption<Frame>>,
    /// A subscription lives as long as its handle.
    feeds: Vec<Weak<Feed>>,
    /// Tiles no longer worked on; their buffers are used again once no frame shares them.
    retired: Vec<Arc<Tile>>,
}

impl PictureState {
    pub(super) fn new(id: u64) -> Self {
        Self {
            id,
            generation: 0,
            request: None,
            waiting: false,
            building: false,
            job: None,
            built: None,
            granted: 0,
            pace: Pace::Full,
            steps: 0,
            error: None,
            worker_panics: 0,
            latest: Arc::default(),
            feeds: Vec::new(),
            retired: Vec::new(),
        }
    }

    /// See [`super::Picture::submit`].
    pub(super) fn submit(&mut self, request: Arc<Request>) -> u64 {
        if !self.waiting
            && let Some(job) = &mut self.job
            && job.generation == self.generation
            && job.request.same_samples(&request)
            && request.settings.sampling.target().is_none_or(|n| n >= job.planned())
        {
            job.request = request.clone();
            // The frame on show was made with another target: let it be replaced.
            job.published = 0;
            self.request = Some(request);
            return self.generation;
        }
        self.request = Some(request);
        self.restart()
    }

    /// See [`super::Picture::restart`].
    pub(super) fn restart(&mut self) -> u64 {
        self.generation += 1;
        self.halt();
        self.error = None;
        self.worker_panics = 0;
        self.waiting = self.request.is_some();
        self.generation
    }

    /// Nobody wants the tiles that are being worked on any more.
    pub(super) fn halt(&self) {
        self.job.iter().for_each(|job| job.halt.now());
    }

    pub(super) fn set_pace(&mut self, pace: Pace) {
        self.pace = pace;
        self.steps = 0;
    }

    pub(super) fn step(&mut self) {
        self.steps += 1;
    }

    pub(super) fn subscribe(&mut self, feed: &Arc<Feed>) {
        self.feeds.retain(|feed| feed.strong_count() > 0);
        self.feeds.push(Arc::downgrade(feed));
    }

    pub(super) fn status(&self) -> Status {
        let (state, spp) = match &self.job {
            _ if self.error.is_some() && self.job.is_none() && !self.waiting && !self.building => (State::Failed, 0),
            Some(job) if job.generation == self.generation => {
                let state = if job.finished() {
                    State::Finished
                } else if self.held(job) && job.pass.is_none() {
                    State::Paused
                } else {
                    State::Rendering
                };
                (state, job.samples)
            }
            _ if self.waiting || self.building => (State::Building, 0),
            _ => (State::Idle, 0),
        };
        Status { generation: self.generation, spp, state, error: self.error.clone(), worker_panics: self.worker_panics }
    }

    /// No pass may begin.
    fn held(&self, job: &Job) -> bool {
        self.pace == Pace::Paused && self.steps == 0 && job.samples > 0
    }

    /// How far it is for those in lock-step with it; `None` if they need not wait for it.
    pub(super) fn standing(&self, by: Lockstep, now: Instant) -> Option<Standing> {
        match self.status().state {
            State::Idle | State::Paused | State::Finished | State::Failed => return None,
            State::Building => return Some(Standing { done: 0.0, planned: 0.0, per_sample: 0.0, burst: 1 }),
            State::Rendering => {}
        }
        let job = self.job.as_ref()?;
        let (samples, planned) = (f64::from(job.samples), f64::from(job.planned()));
        let per_sample = match by {
            Lockstep::Spp => 1.0,
            Lockstep::Rays => f64::from(job.request.settings.estimator.strategy.rays_per_sample()),
            Lockstep::CpuSeconds if job.samples == 0 => 0.0,
            Lockstep::CpuSeconds => job.cpu_seconds / samples,
        };
        let done = if by == Lockstep::CpuSeconds { job.cpu_seconds } else { samples * per_sample };
        Some(Standing { done, planned: (planned * per_sample).max(done), per_sample, burst: self.burst(job, now) })
    }

    /// Samples per pixel of the next pass, for a picture of its own: none is longer than until a frame is wanted.
    fn burst(&self, job: &Job, now: Instant) -> u32 {
        if self.pace != Pace::Full {
            return 1;
        }
        let mut interval = f64::INFINITY;
        let mut most = u32::MAX;
        for feed in self.feeds.iter().filter_map(Weak::upgrade) {
            interval = interval.min(feed.seconds_to_next(now));
            if let Some(mark) = feed.next_mark(job.samples) {
                most = most.min(mark - job.samples);
            }
        }
        job.burst(interval).min(most)
    }

    /// No pass is running.
    pub(super) fn between_passes(&self) -> bool {
        self.job.as_ref().is_none_or(|job| job.pass.is_none())
    }

    /// Something to do for this picture, or how long until there may be. A pass that begins now has at most `room` samples
    /// per pixel.
    pub(super) fn claim(&mut self, now: Instant, room: u32) -> Result<Task, Duration> {
        // One scene at a time: the one being built is given up, or its geometry serves the next one.
        if self.waiting
            && !self.building
            && let Some(request) = self.request.clone()
        {
            (self.waiting, self.building) = (false, true);
            return Ok(Task::Build { picture: self.id, generation: self.generation, request });
        }
        let Some(job) = self.job.as_ref().filter(|job| job.generation == self.generation) else {
            return Err(LONG);
        };
        if job.pass.is_none() {
            if self.held(job) || job.finished() {
                if job.published != job.samples {
                    // Only the target moved, and the frame on show still names the old one; or the last pass made no frame.
                    let replaced = self.publish(now, true).unwrap_or_default();
                    return Ok(Task::Published(replaced));
                }
                return Err(LONG);
            }
            let count = self.burst(job, now).min(room);
            if let Pace::PassesPerSecond(rate) = self.pace
                && let Some(start) = job.last_start
            {
                let due = start + Duration::from_secs_f64(1.0 / f64::from(rate.clamp(1e-3, 1e4)));
                if now < due {
                    return Err(due - now);
                }
            }
            // The first pass of a request is free.
            if self.pace == Pace::Paused && job.samples > 0 {
                self.steps -= 1;
            }
            if let Some(job) = &mut self.job {
                job.begin_pass(count, now);
            }
        }
        self.claim_tile().ok_or(LONG)
    }

    /// The next tile of the running pass.
    fn claim_tile(&mut self) -> Option<Task> {
        let job = self.job.as_mut()?;
        let pass = job.pass.as_mut().filter(|pass| pass.next_tile < job.rects.len())?;
        let index = pass.next_tile;
        pass.next_tile += 1;
        let tile = job.tiles[index].take();
        let needs_buffer = tile.as_ref().is_none_or(|tile| Arc::strong_count(tile) > 1);
        let recycled = if needs_buffer { recycle(&mut self.retired, job.rects[index]) } else { None };
        Some(Task::Tile(TileTask {
            picture: self.id,
            job: job.id,
            index,
            rect: job.rects[index],
            count: pass.count,
            request: job.request.clone(),
            scene: job.scene.clone(),
            tile,
            recycled,
            halted: job.halt.watch(),
        }))
    }

    /// Takes a built scene, `None` if it was given up; what it replaces comes back, to be dropped where no lock is held.
    pub(super) fn take_built(
        &mut self,
        generation: u64,
        request: Arc<Request>,
        built: Option<Result<Arc<BuiltScene>, Invalid>>,
        machine: Machine,
    ) -> (Option<Arc<BuiltScene>>, bool) {
        self.building = false;
        // Even where the request has changed since: the next one may want the same geometry.
        let replaced = match &built {
            Some(Ok(scene)) => self.built.replace(scene.clone()),
            Some(Err(_)) | None => None,
        };
        let Some(built) = built.filter(|_| self.generation == generation) else { return (replaced, false) };
        self.retire_job();
        match built {
            Ok(scene) => self.job = Some(Job::new(generation, request, scene, machine)),
            Err(error) => self.error = Some(error.to_string()),
        }
        (replaced, true)
    }

    /// Takes a rendered tile, and what it was copied from; `rendered` is the number of samples that were not finite, or what
    /// the worker died of.
    pub(super) fn take_tile(
        &mut self,
        job: u64,
        index: usize,
        tile: Tile,
        copied: Option<Arc<Tile>>,
        rendered: Result<u64, String>,
        cpu_seconds: f64,
    ) -> Outcome {
        self.retired.extend(copied);
        let generation = self.generation;
        let Some(work) = self.job.as_mut().filter(|work| work.id == job && work.generation == generation) else {
            self.retired.push(Arc::new(tile));
            return Outcome::Nothing;
        };
        match rendered {
            Ok(invalid) => {
                work.tiles[index] = Some(Arc::new(tile));
                work.invalid += invalid;
                let now = Instant::now();
                if !work.finish_tile(cpu_seconds, now) {
                    return Outcome::Nothing;
                }
                let first_or_last = work.published == 0 || work.finished();
                let always = first_or_last || self.job.as_ref().is_some_and(|job| self.held(job));
                Outcome::Pass(self.publish(now, always))
            }
            Err(panic) => {
                self.recover(&panic);
                Outcome::Panic
            }
        }
    }

    /// Makes a frame for those who want one, or `always`. `Some` with what it replaces, if there is one.
    fn publish(&mut self, now: Instant, always: bool) -> Option<Replaced> {
        let job = self.job.as_mut()?;
        let full_pace = self.pace == Pace::Full;
        let moment = Moment { now, generation: job.generation, spp: job.samples, full_pace };
        let feeds: Vec<_> = self.feeds.iter().filter_map(Weak::upgrade).collect();
        let wanted: Vec<_> = feeds.iter().map(|feed| feed.wants(&moment)).collect();
        if !always && wanted.iter().all(|&wanted| wanted == Wanted::No) {
            return None;
        }
        let frame = Arc::new(job.frame());
        job.published = job.samples;
        let needed = job.rects.len();
        let mut replaced = Replaced::from_iter(self.latest.swap(Some(frame.clone())));
        for (feed, wanted) in feeds.iter().zip(wanted) {
            let wanted = if always && wanted == Wanted::No { Wanted::ByRate } else { wanted };
            replaced.extend(feed.offer(&frame, wanted, now));
        }
        self.trim(needed);
        Some(replaced)
    }

    fn retire_job(&mut self) {
        if let Some(job) = self.job.take() {
            let needed = job.rects.len();
            self.retired.extend(job.tiles.into_iter().flatten());
            self.trim(needed);
        }
    }

    /// Keeps as many buffers as a pass needs, one per tile: first those that frames still share, which cost nothing and are the next to be
    /// free. A set that was needed once, when a frame was held for long, goes.
    fn trim(&mut self, needed: usize) {
        let excess = self.retired.len().saturating_sub(2 * needed);
        self.retired.drain(..excess);
        let shared = self.retired.iter().filter(|tile| Arc::strong_count(tile) > 1).count();
        let mut free = 0;
        self.retired.retain(|tile| {
            free += usize::from(Arc::strong_count(tile) == 1);
            Arc::strong_count(tile) > 1 || free <= needed.saturating_sub(shared)
        });
    }

    /// After a panic: the pass is lost with its tile. Starts the generation again, a few times.
    fn recover(&mut self, what: &str) {
        self.worker_panics += 1;
        let again = self.job.as_ref().map(Job::again);
        self.retire_job();
        if self.worker_panics < MAX_PANICS {
            self.job = again;
        }
        self.error = Some(format!("a render thread failed: {what}"));
    }
}

#[cfg(test)]
mod tests {
    use mislab_kernel::request::{ImageSettings, Sampling};

    use super::*;
    use crate::pbrt::embedded_scene;
    use mislab_kernel::request::Settings;

    /// Makes all tiles of a pass without a sample in them.
    fn pass(p: &mut PictureState) -> Outcome {
        loop {
            let Ok(Task::Tile(task)) = p.claim(Instant::now(), u32::MAX) else { panic!("no pass may begin") };
            let tile = Tile::new(task.rect, task.request.settings.estimator.strategy, None);
            match p.take_tile(task.job, task.index, tile, None, Ok(0), 0.0) {
                Outcome::Nothing => {}
                end => return end,
            }
        }
    }

    #[test]
    fn the_pass_that_a_pause_ends_with_makes_its_frame_at_once() {
        let file = embedded_scene();
        let settings = Settings {
            sampling: Sampling { spp: None, ..file.settings.sampling },
            image: ImageSettings { resolution: [16, 16], ..file.settings.image },
            ..file.settings
        };
        let request = Arc::new(Request { scene: Arc::new(file.scene), settings });
        let built = BuiltScene::new(&request.scene, &request.settings).map(Arc::new);
        let mut p = PictureState::new(1);
        p.set_pace(Pace::Paused);
        let generation = p.submit(request.clone());
        assert!(matches!(p.claim(Instant::now(), 1), Ok(Task::Build { .. })));
        p.take_built(generation, request, Some(built), Machine::default());
        for spp in 1..9 {
            assert!(matches!(pass(&mut p), Outcome::Pass(Some(_))), "a frame at {spp} spp");
            assert_eq!((p.status().state, p.status().spp), (State::Paused, spp));
            assert!(matches!(p.claim(Instant::now(), 1), Err(LONG)), "nothing is left to do");
            p.step();
        }
        // Two steps: a pause comes after the second.
        p.step();
        assert!(matches!(pass(&mut p), Outcome::Pass(None)), "nobody asked for it");
        assert!(matches!(pass(&mut p), Outcome::Pass(Some(_))));
    }
}
