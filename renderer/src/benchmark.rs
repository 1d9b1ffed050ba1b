//! How fast this machine renders: paths, first frames, cancelling, layers. What `mislab bench` prints.
//!
//! Rates are those of one thread, all of sampling, film and layers included. Each tile of the picture
//! is timed many times and its shortest time counts, so that other programs on the machine
//! do not; ratios come from one run. Latencies are as they are, other programs included.

pub mod efficiency;

use std::collections::BTreeMap;
use std::num::NonZeroU32;
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

use mislab_kernel::film::Tile;
use mislab_kernel::lanes::Lanewise;
use mislab_kernel::request::scene::Scene;
use mislab_kernel::request::{Estimator, ImageSettings, PixelRect, Request, Sampling, Settings, Strategy};
use mislab_kernel::stop::Stop;
use mislab_kernel::tile::render_tile;
use mislab_kernel::world::BuiltScene;
use serde::Serialize;

use crate::engine::{Picture, Renderer};
use crate::error::Error;
use efficiency::Efficiency;

/// Samples per pixel of one timed call, as the progressive renderer makes them in a running picture.
const BURST: u32 = 8;
/// Every n-th tile is timed: evenly over the picture.
const EVERY: usize = 5;
/// Longest wait for a frame before the renderer counts as hung.
const HUNG: Duration = Duration::from_secs(60);

/// Secondary rays per second of one strategy.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Rates {
    /// Million paths per second and core on the vector unit.
    pub simd: f64,
    /// The same text on one lane.
    pub scalar: f64,
    /// `simd / scalar`.
    pub ratio: f64,
}

/// One thread against all.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Threads {
    /// How many there are.
    pub count: usize,
    /// Time with one thread over time with all.
    pub speedup: f64,
}

/// Quantiles of a latency in milliseconds.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Latency {
    /// Half of the times are shorter.
    pub p50: f64,
    /// 99 of 100 times are shorter.
    pub p99: f64,
    /// How many times were taken.
    pub count: usize,
}

/// Everything measured.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Level of the vector unit, e.g. "AVX-512".
    pub simd: &'static str,
    /// By name of the strategy.
    pub strategies: BTreeMap<&'static str, Rates>,
    /// Whole pictures by all threads.
    pub threads: Threads,
    /// From a changed roughness to the first complete frame of 800 x 800 pixels.
    pub first_frame_ms: Latency,
    /// From a new request of 8 x 8 pixels to its frame, while a pass of 800 x 800 was running: cancelling,
    /// building the scene and a tiny picture together.
    pub cancel_ms: Latency,
    /// Time that variance, weights and shares take, as a fraction of the time of the bare picture.
    pub layers_cost: f64,
    /// What a second of one processor is worth.
    pub efficiency: Efficiency,
}

/// Measures for about `seconds`. `on_step` is told what comes next.
///
/// # Errors
/// [`Error::Invalid`] if the scene cannot be rendered.
pub fn run(scene: &Arc<Scene>, seconds: f64, on_step: &mut dyn FnMut(&str)) -> Result<Report, Error> {
    let share = |part: f64| Duration::from_secs_f64(seconds * part);
    let best = Lanewise::best();
    let mut strategies = BTreeMap::new();
    for strategy in Strategy::ALL {
        on_step(&format!("{} on {} and on one lane", strategy.name(), best.name()));
        let settings = Settings { estimator: Estimator { strategy, ..Estimator::default() }, ..Settings::default() };
        let built = BuiltScene::new(scene, &settings)?;
        let [simd, scalar] = [best, Lanewise::Single].map(|how| rate(how, &built, &settings, true, share(0.07)));
        strategies.insert(strategy.name(), Rates { simd, scalar, ratio: simd / scalar });
    }
    on_step("threads");
    let threads = threads(scene, share(0.14))?;
    on_step("first frames");
    let first_frame_ms = first_frame(scene, share(0.14))?;
    on_step("cancelling");
    let cancel_ms = cancel(scene, share(0.08))?;
    on_step("layers");
    let settings =
        Settings { estimator: Estimator { strategy: Strategy::MisAll, ..Estimator::default() }, ..Settings::default() };
    let built = BuiltScene::new(scene, &settings)?;
    let [bare, whole] = [false, true].map(|layers| rate(best, &built, &settings, layers, share(0.04)));
    let layers_cost = bare / whole - 1.0;
    on_step("error and time of each sampler");
    let efficiency = efficiency::efficiency(scene, share(0.003))?;
    Ok(Report { simd: best.name(), strategies, threads, first_frame_ms, cancel_ms, layers_cost, efficiency })
}

/// Million paths per second of one thread; `layers` false for the bare picture.
pub fn rate(how: Lanewise, scene: &BuiltScene, settings: &Settings, layers: bool, time: Duration) -> f64 {
    let whole = PixelRect { min: [0, 0], max: settings.image.resolution };
    let tiles: Vec<PixelRect> = Tile::cut(whole).into_iter().step_by(EVERY).collect();
    let mut shortest = vec![f64::INFINITY; tiles.len()];
    let mut buffers = None;
    let start = Instant::now();
    // Two rounds at least: the first one fills the caches.
    let mut round = 0;
    while round < 2 || start.elapsed() < time {
        for (bounds, shortest) in tiles.iter().zip(&mut shortest) {
            let mut tile = Tile::new(*bounds, settings.estimator.strategy, buffers.take());
            tile.bare = !layers;
            let start = Instant::now();
            render_tile(how, scene, settings, &mut tile, BURST, Stop::NEVER).expect("nobody stops it");
            *shortest = shortest.min(start.elapsed().as_secs_f64());
            buffers = Some(tile);
        }
        round += 1;
    }
    let pixels: u64 = tiles.iter().map(|t| u64::from(t.width()) * u64::from(t.height())).sum();
    let paths = pixels * u64::from(BURST * settings.estimator.strategy.rays_per_sample());
    paths as f64 * 1e-6 / shortest.iter().sum::<f64>()
}

/// Shortest of several renderings with one and with all threads, in turn.
fn threads(scene: &Arc<Scene>, time: Duration) -> Result<Threads, Error> {
    let count = std::thread::available_parallelism().map_or(1, usize::from);
    let settings = Settings {
        estimator: Estimator { strategy: Strategy::Mis, ..Estimator::default() },
        sampling: Sampling { spp: NonZeroU32::new(16), ..Sampling::default() },
        ..Settings::default()
    };
    let request = Request { scene: scene.clone(), settings };
    let renderers = [1, count].map(|threads| Renderer::new(threads, || {}));
    let mut shortest = [f64::INFINITY; 2];
    let start = Instant::now();
    let mut round = 0;
    while round < 2 || start.elapsed() < time {
        for (shortest, renderer) in shortest.iter_mut().zip(&renderers) {
            let start = Instant::now();
            renderer.render(&request, &mut |_| true)?;
            *shortest = shortest.min(start.elapsed().as_secs_f64());
        }
        round += 1;
    }
    Ok(Threads { count, speedup: shortest[0] / shortest[1] })
}

/// A picture that is asked for, and the signal that something new is there.
struct Live {
    picture: Picture,
    news: mpsc::Receiver<()>,
    // After the picture, which must go first.
    _renderer: Renderer,
}

impl Live {
    fn new() -> Self {
        let (send, news) = mpsc::channel();
        let renderer = Renderer::new(0, move || {
            // A receiver that is gone has nothing left to wait for.
            let _ = send.send(());
        });
        Self { picture: renderer.add_picture(), news, _renderer: renderer }
    }

    /// Milliseconds from the request to its first frame.
    fn first_frame(&self, request: Request) -> Result<f64, Error> {
        let start = Instant::now();
        let generation = self.picture.submit(request);
        while self.picture.latest().is_none_or(|frame| frame.generation() < generation) {
            if let Some(error) = self.picture.status().error {
                return Err(Error::Invalid(error));
            }
            if self.news.recv_timeout(HUNG).is_err() {
                return Err(Error::Invalid(format!("no frame after {} s", HUNG.as_secs())));
            }
        }
        Ok(start.elapsed().as_secs_f64() * 1e3)
    }
}

/// Changes one roughness after another, as a slider does.
fn first_frame(scene: &Arc<Scene>, time: Duration) -> Result<Latency, Error> {
    let live = Live::new();
    let settings = Settings { sampling: Sampling { spp: None, ..Sampling::default() }, ..Settings::default() };
    repeat(time, |i| {
        let mut scene = scene.clone();
        let edited = Arc::make_mut(&mut scene);
        if let Some(alpha) = edited.materials.iter_mut().find_map(|material| material.bsdf.alpha_mut()) {
            *alpha = 0.001 * (i % 500) as f32;
        }
        live.first_frame(Request { scene, settings: settings.clone() })
    })
}

/// Interrupts an endless large picture by a tiny one.
fn cancel(scene: &Arc<Scene>, time: Duration) -> Result<Latency, Error> {
    let live = Live::new();
    let endless = Settings { sampling: Sampling { spp: None, ..Sampling::default() }, ..Settings::default() };
    let tiny = Settings {
        sampling: Sampling { spp: NonZeroU32::new(1), ..Sampling::default() },
        image: ImageSettings { resolution: [8, 8], ..ImageSettings::default() },
        ..Settings::default()
    };
    repeat(time, |i| {
        live.first_frame(Request {
            scene: scene.clone(),
            settings: Settings { sampling: Sampling { seed: i, ..endless.sampling }, ..endless.clone() },
        })?;
        // Into the midst of a later pass, always another moment of it.
        std::thread::sleep(Duration::from_micros(5000 + u64::from(i % 37) * 311));
        live.first_frame(Request {
            scene: scene.clone(),
            settings: Settings { sampling: Sampling { seed: i, ..tiny.sampling }, ..tiny.clone() },
        })
    })
}

/// Takes times until the time is over, 20 at least and 1000 at most.
fn repeat(time: Duration, mut take: impl FnMut(u32) -> Result<f64, Error>) -> Result<Latency, Error> {
    let mut times = Vec::new();
    let start = Instant::now();
    while times.len() < 20 || (start.elapsed() < time && times.len() < 1000) {
        times.push(take(times.len() as u32)?);
    }
    times.sort_by(f64::total_cmp);
    let quantile = |q: f64| times[((times.len() - 1) as f64 * q).round() as usize];
    Ok(Latency { p50: quantile(0.5), p99: quantile(0.99), count: times.len() })
}
