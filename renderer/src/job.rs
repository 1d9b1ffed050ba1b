//! One generation of a picture being rendered: its tiles, its passes, when a frame is due.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use crate::frame::{Frame, FrameStats};
use mislab_kernel::film::Tile;
use mislab_kernel::request::PixelRect;
use mislab_kernel::request::Request;
use mislab_kernel::world::BuiltScene;

/// Longest time a worker holds a tile, in seconds: bounds the wait for a cancelled pass.
const SLICE: f64 = 2e-3;
/// Shortest time between two frames of a picture, in seconds, once the first few are out. Noise melts
/// smoothly at this rate; more frames would take the time of samples where the window is drawn in software.
const FRAME_INTERVAL: f64 = 1.0 / 30.0;
/// Longest time that a frame waits while somebody holds the last one, in seconds. A window gains nothing from a frame that
/// comes while it still draws, however slowly; whoever keeps one for longer saves it or compares with it.
const PATIENCE: f64 = 0.5;
/// Time after which a frame that nobody has come for counts as one that nobody wants, in seconds.
const ATTENTION: f64 = 0.1;
/// Samples per pixel up to which every pass is a frame.
const FIRST_FRAMES: u32 = 4;

/// One generation being rendered.
pub(crate) struct Job {
    pub(crate) id: u64,
    pub(crate) generation: u64,
    pub(crate) request: Arc<Request>,
    pub(crate) scene: Arc<BuiltScene>,
    pub(crate) bounds: PixelRect,
    pub(crate) rects: Arc<Vec<PixelRect>>,
    /// `None` while a worker has it, or before its first sample.
    pub(crate) tiles: Vec<Option<Arc<Tile>>>,
    pub(crate) samples: u32,
    pub(crate) pass: Option<Pass>,
    pub(crate) published: u32,
    pub(crate) last_publish: Option<Instant>,
    pub(crate) last_start: Option<Instant>,
    pub(crate) render_seconds: f64,
    pub(crate) cpu_seconds: f64,
    pub(crate) invalid: u64,
}

/// The same number of samples added to every tile.
pub(crate) struct Pass {
    pub(crate) count: u32,
    pub(crate) next_tile: usize,
    pub(crate) done: usize,
    pub(crate) start: Instant,
}

static NEXT_JOB: AtomicU64 = AtomicU64::new(1);

impl Job {
    pub(crate) fn new(generation: u64, request: Arc<Request>, scene: Arc<BuiltScene>) -> Self {
        let bounds = request.settings.pixel_bounds();
        let rects = Arc::new(Tile::cut(bounds));
        Self {
            id: NEXT_JOB.fetch_add(1, Ordering::Relaxed),
            generation,
            request,
            scene,
            bounds,
            tiles: rects.iter().map(|_| None).collect(),
            rects,
            samples: 0,
            pass: None,
            published: 0,
            last_publish: None,
            last_start: None,
            render_seconds: 0.0,
            cpu_seconds: 0.0,
            invalid: 0,
        }
    }

    pub(crate) fn finished(&self) -> bool {
        self.request.settings.sampling.target().is_some_and(|target| self.samples >= target) || self.samples == u32::MAX
    }

    /// Samples per pixel of the next pass: as many as fit into a slice and, where frames are `taken`, between two of them.
    /// Each pass has to fetch all sums from memory and put them back: the longer the better.
    pub(crate) fn burst(&self, taken: bool) -> u32 {
        let per_sample = self.render_seconds / f64::from(self.samples);
        let per_tile = self.cpu_seconds / f64::from(self.samples) / self.rects.len() as f64;
        let wanted = taken || self.since_publish(Instant::now()) < ATTENTION;
        let interval = if wanted { FRAME_INTERVAL } else { f64::INFINITY };
        let fitting = (interval / per_sample).min(SLICE / per_tile).clamp(1.0, 4096.0) as u32;
        let left = self.request.settings.sampling.target().unwrap_or(u32::MAX) - self.samples;
        fitting.min(left)
    }

    /// Seconds since the last frame.
    fn since_publish(&self, now: Instant) -> f64 {
        self.last_publish.map_or(f64::INFINITY, |last| (now - last).as_secs_f64())
    }

    /// Counts a tile in. `Some` at the end of a pass, with the totals if a frame is due: the first, the last, and others if
    /// the one before was `taken`. It may `wait` for a while.
    pub(crate) fn finish_tile(&mut self, taken: bool, wait: bool) -> Option<Option<FrameStats>> {
        let pass = self.pass.as_mut()?;
        pass.done += 1;
        if pass.done < self.rects.len() {
            return None;
        }
        self.samples += pass.count;
        let now = Instant::now();
        self.render_seconds += (now - pass.start).as_secs_f64();
        self.pass = None;
        let since = self.since_publish(now);
        let due = self.samples <= FIRST_FRAMES || since >= FRAME_INTERVAL;
        let due = due && (taken || self.published == 0) && !(wait && since < PATIENCE);
        Some((due || self.finished()).then(|| {
            self.last_publish = Some(now);
            self.published = self.samples;
            self.stats()
        }))
    }

    pub(crate) fn stats(&self) -> FrameStats {
        let rays = u64::from(self.request.settings.estimator.strategy.rays_per_sample());
        FrameStats {
            paths: self.bounds.area() as u64 * u64::from(self.samples) * rays,
            render_seconds: self.render_seconds,
            cpu_seconds: self.cpu_seconds,
            threads: 0,
            simd: "",
            invalid_samples: self.invalid,
        }
    }

    pub(crate) fn frame(&self, stats: FrameStats) -> Frame {
        Frame {
            request: self.request.clone(),
            generation: self.generation,
            spp: self.samples,
            bounds: self.bounds,
            stats,
            tiles: self.tiles.iter().flatten().cloned().collect(),
        }
    }
}

/// A buffer that no frame shares any more, preferably of a tile of the same size.
pub(crate) fn recycle(retired: &mut Vec<Arc<Tile>>, rect: PixelRect) -> Option<Tile> {
    let fits = |t: &Arc<Tile>| {
        Arc::strong_count(t) == 1 && t.bounds.width() == rect.width() && t.bounds.height() == rect.height()
    };
    let at = retired.iter().position(fits)?;
    Arc::try_unwrap(retired.swap_remove(at)).ok()
}
