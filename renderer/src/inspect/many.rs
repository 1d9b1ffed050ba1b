//! The same question about many pixels, on all threads.

use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use mislab_kernel::request::Settings;
use mislab_kernel::world::BuiltScene;

use super::point::{Inspector, Point};

/// Pixels that a thread takes at a time.
const SHARE: usize = 64;

/// A picture whose pixels are asked about, and for how long.
pub struct Pixels<'a> {
    /// The scene as it was rendered.
    pub scene: &'a BuiltScene,
    /// The settings that it was rendered with.
    pub settings: &'a Settings,
    /// Threads; 0: one per core.
    pub threads: usize,
    /// Whether to go on, asked some hundred times a second.
    pub goes_on: &'a (dyn Fn() -> bool + Sync),
}

impl<'a> Pixels<'a> {
    /// The surface at a place of the picture, in pixels.
    pub(super) fn point(&self, x: f32, y: f32) -> Option<Point<'a>> {
        Inspector::new(self.scene, self.settings).at_pixel(x, y).point()
    }

    /// The answers for many pixels, on all threads; `None` if they are not wanted any more.
    pub(super) fn all<T: Clone + Default + Send>(
        &self,
        pixels: &[[u32; 2]],
        one: impl Fn([u32; 2]) -> T + Sync,
    ) -> Option<Vec<T>> {
        let threads = match self.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            threads => threads,
        };
        let found = Mutex::new(vec![T::default(); pixels.len()]);
        let (next, stopped) = (AtomicUsize::new(0), AtomicBool::new(false));
        let work = || {
            loop {
                let first = next.fetch_add(SHARE, Ordering::Relaxed);
                if first >= pixels.len() {
                    return;
                }
                if stopped.load(Ordering::Relaxed) || !(self.goes_on)() {
                    stopped.store(true, Ordering::Relaxed);
                    return;
                }
                let share = first..(first + SHARE).min(pixels.len());
                let values: Vec<T> = pixels[share.clone()].iter().map(|pixel| one(*pixel)).collect();
                found.lock().unwrap_or_else(PoisonError::into_inner)[share].clone_from_slice(&values);
            }
        };
        std::thread::scope(|scope| {
            for _ in 1..threads.min(pixels.len().div_ceil(SHARE)) {
                // Without another thread this one does it all.
                let _ = std::thread::Builder::new().name("pixels".into()).spawn_scoped(scope, work);
            }
            work();
        });
        (!stopped.into_inner()).then(|| found.into_inner().unwrap_or_else(PoisonError::into_inner))
    }
}
