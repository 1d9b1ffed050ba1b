//! One generation of a picture being rendered: its tiles, its passes and what they have taken.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

use mislab_kernel::film::Tile;
use mislab_kernel::request::{PixelRect, Request};
use mislab_kernel::world::BuiltScene;

use crate::frame::{Frame, FrameStats};

/// Longest time a worker holds a tile, in seconds: bounds the wait for a cancelled pass.
const SLICE: f64 = 2e-3;

/// Who renders: for the statistics of frames.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Machine {
    /// Worker threads.
    pub(super) threads: usize,
    /// SIMD level of the kernel.
    pub(super) simd: &'static str,
}

/// Tells workers that nobody wants the tiles they are at any more: at the latest when the job goes that has it.
#[derive(Default)]
pub(super) struct Halt(Arc<AtomicBool>);

impl Halt {
    /// From here on.
    pub(super) fn now(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// For a worker: true once it is time to stop.
    pub(super) fn watch(&self) -> Arc<AtomicBool> {
        self.0.clone()
    }
}

impl Drop for Halt {
    fn drop(&mut self) {
        self.now();
    }
}

/// One generation being rendered.
pub(super) struct Job {
    pub(super) id: u64,
    pub(super) generation: u64,
    pub(super) request: Arc<Request>,
    pub(super) scene: Arc<BuiltScene>,
    pub(super) rects: Vec<PixelRect>,
    /// `None` while a worker has it, or before its first sample.
    pub(super) tiles: Vec<Option<Arc<Tile>>>,
    /// Samples per pixel of all complete passes.
    pub(super) samples: u32,
    pub(super) pass: Option<Pass>,
    /// Samples per pixel of the last frame; 0 if another one is to be made as soon as possible.
    pub(super) published: u32,
    pub(super) last_start: Option<Instant>,
    /// Processor time of all complete passes.
    pub(super) cpu_seconds: f64,
    pub(super) invalid: u64,
    pub(super) halt: Halt,
    bounds: PixelRect,
    render_seconds: f64,
    machine: Machine,
}

/// The same number of samples added to every tile.
pub(super) struct Pass {
    pub(super) count: u32,
    pub(super) next_tile: usize,
    done: usize,
    start: Instant,
    cpu_seconds: f64,
}

static NEXT_JOB: AtomicU64 = AtomicU64::new(1);

impl Job {
    pub(super) fn new(generation: u64, request: Arc<Request>, scene: Arc<BuiltScene>, machine: Machine) -> Self {
        let bounds = request.settings.pixel_bounds();
        let rects = Tile::cut(bounds);
        Self {
            id: NEXT_JOB.fetch_add(1, Ordering::Relaxed),
            generation,
            request,
            scene,
            tiles: rects.iter().map(|_| None).collect(),
            rects,
            samples: 0,
            pass: None,
            published: 0,
            last_start: None,
            cpu_seconds: 0.0,
            invalid: 0,
            halt: Halt::default(),
            bounds,
            render_seconds: 0.0,
            machine,
        }
    }

    /// The same from the first sample.
    pub(super) fn again(&self) -> Self {
        Self::new(self.generation, self.request.clone(), self.scene.clone(), self.machine)
    }

    pub(super) fn finished(&self) -> bool {
        self.request.settings.sampling.target().is_some_and(|target| self.samples >= target) || self.samples == u32::MAX
    }

    /// Samples per pixel at the end of the running pass.
    pub(super) fn planned(&self) -> u32 {
        self.samples + self.pass.as_ref().map_or(0, |pass| pass.count)
    }

    /// Samples per pixel of the next pass, if it should take `interval` seconds at most: as many as fit into that and into
    /// a slice. Each pass has to fetch all sums from memory and put them back: the longer the better.
    pub(super) fn burst(&self, interval: f64) -> u32 {
        if self.samples == 0 {
            return 1;
        }
        let per_sample = self.render_seconds / f64::from(self.samples);
        let per_tile = self.cpu_seconds / f64::from(self.samples) / self.rects.len() as f64;
        let fitting = (interval / per_sample).min(SLICE / per_tile).clamp(1.0, 4096.0) as u32;
        fitting.min(self.left())
    }

    /// Samples per pixel to the target.
    pub(super) fn left(&self) -> u32 {
        self.request.settings.sampling.target().unwrap_or(u32::MAX) - self.samples
    }

    pub(super) fn begin_pass(&mut self, count: u32, now: Instant) {
        self.last_start = Some(now);
        self.pass = Some(Pass { count, next_tile: 0, done: 0, start: now, cpu_seconds: 0.0 });
    }

    /// Counts a tile in that took so much processor time; true at the end of a pass.
    pub(super) fn finish_tile(&mut self, cpu_seconds: f64, now: Instant) -> bool {
        let Some(pass) = &mut self.pass else { return false };
        pass.cpu_seconds += cpu_seconds;
        pass.done += 1;
        if pass.done < self.rects.len() {
            return false;
        }
        self.samples += pass.count;
        self.cpu_seconds += pass.cpu_seconds;
        self.render_seconds += (now - pass.start).as_secs_f64();
        self.pass = None;
        true
    }

    /// The frame of the passes so far; between passes only.
    pub(super) fn frame(&self) -> Frame {
        let rays = u64::from(self.request.settings.estimator.strategy.rays_per_sample());
        let stats = FrameStats {
            paths: self.bounds.area() as u64 * u64::from(self.samples) * rays,
            render_seconds: self.render_seconds,
            cpu_seconds: self.cpu_seconds,
            threads: self.machine.threads,
            simd: self.machine.simd,
            invalid_samples: self.invalid,
        };
        Frame {
            request: self.request.clone(),
            scene: self.scene.clone(),
            generation: self.generation,
            spp: self.samples,
            bounds: self.bounds,
            stats,
            tiles: self.tiles.iter().flatten().cloned().collect(),
        }
    }
}

/// A buffer that no frame shares any more, of a tile of the same size.
pub(super) fn recycle(retired: &mut Vec<Arc<Tile>>, rect: PixelRect) -> Option<Tile> {
    let fits = |t: &Arc<Tile>| {
        Arc::strong_count(t) == 1 && t.bounds.width() == rect.width() && t.bounds.height() == rect.height()
    };
    let at = retired.iter().position(fits)?;
    Arc::try_unwrap(retired.swap_remove(at)).ok()
}
