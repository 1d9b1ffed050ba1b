//! The reference of the window: what errors are measured against, made in the background while something needs it.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use eframe::egui;
use mislab_renderer::study::reference::Wish;
use mislab_renderer::study::{Against, Cells, News, grow};
use mislab_renderer::{ImageSettings, Request, Scene, Settings, snapshot};

use crate::state::passes;

/// Samples per pixel that the reference grows to.
pub const REFERENCE_SPP: u32 = 4096;

/// What came of it so far.
#[derive(Default)]
struct Made {
    latest: Option<Arc<Against>>,
    spp: u32,
    error: Option<String>,
}

/// The scene and the pixels that a reference is of, and the seed of the pictures that it must not share samples with.
#[derive(Clone, PartialEq)]
struct About {
    scene: Arc<Scene>,
    image: ImageSettings,
    seed: u32,
}

impl About {
    fn is(&self, other: &Self) -> bool {
        // A scene is compared by its numbers only if it is not the very same one.
        (self.image, self.seed) == (other.image, other.seed)
            && (Arc::ptr_eq(&self.scene, &other.scene) || self.scene == other.scene)
    }
}

/// One that is being made. Dropping it gives it up.
struct Job {
    about: About,
    made: Arc<Mutex<Made>>,
    stop: Arc<AtomicBool>,
    hold: Arc<AtomicBool>,
}

impl Drop for Job {
    fn drop(&mut self) {
        // Not waited for: it ends within a few milliseconds.
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// The reference. It is made anew when the scene, the image or the seed is another; strategies may change.
#[derive(Default)]
pub struct References {
    job: Option<Job>,
    file: Option<PathBuf>,
}

impl References {
    /// To be called in each pass: makes it while it is `wanted`, holds while it is not.
    pub fn keep(&mut self, ctx: &egui::Context, request: &Request, wanted: bool, threads: usize) {
        let Settings { image, sampling, .. } = &request.settings;
        let about = About { scene: request.scene.clone(), image: *image, seed: sampling.seed };
        if self.job.as_ref().is_some_and(|job| !job.about.is(&about)) {
            self.job = None;
        }
        if let Some(job) = &self.job {
            job.hold.store(!wanted, Ordering::Relaxed);
        } else if wanted {
            self.job = start(ctx, about, self.file.clone(), threads).ok();
        }
    }

    /// Measures against a picture from a file from here on; `None`: against a rendered one.
    pub fn use_file(&mut self, file: Option<PathBuf>) {
        self.file = file;
        self.job = None;
    }

    /// The file that it comes from.
    pub fn file(&self) -> Option<&PathBuf> {
        self.file.as_ref()
    }

    /// The best one so far.
    pub fn latest(&self) -> Option<Arc<Against>> {
        lock(&self.job.as_ref()?.made).latest.clone()
    }

    /// Asks for the best one so far from another thread: as long as the answer is of use.
    pub fn source(&self) -> Option<impl Fn() -> Option<Arc<Against>> + Send + use<>> {
        let made = self.job.as_ref()?.made.clone();
        Some(move || lock(&made).latest.clone())
    }

    /// How far it is, in words: "reference: 1024 of 4096 spp".
    pub fn words(&self) -> String {
        let Some(job) = &self.job else { return "no reference yet".to_owned() };
        let made = lock(&job.made);
        match (&made.error, &made.latest) {
            (Some(error), _) => format!("no reference: {error}"),
            (None, Some(latest)) if latest.exact => match latest.spp {
                Some(spp) => format!("reference: a file of {spp} spp"),
                None => "reference: a file".to_owned(),
            },
            // Before its first sample each light is rendered alone, or the file is read.
            (None, None) if made.spp == 0 => "reference: looking for plates and lights \u{2026}".to_owned(),
            (None, _) if made.spp >= REFERENCE_SPP => format!("reference: {REFERENCE_SPP} spp"),
            (None, _) => format!("reference: {} of {REFERENCE_SPP} spp", made.spp),
        }
    }
}

fn start(ctx: &egui::Context, about: About, file: Option<PathBuf>, threads: usize) -> std::io::Result<Job> {
    let job = Job { about: about.clone(), made: Arc::default(), stop: Arc::default(), hold: Arc::default() };
    let (made, stop, hold, ctx) = (job.made.clone(), job.stop.clone(), job.hold.clone(), ctx.clone());
    let work = move || {
        let mut on = |news: News| {
            match news {
                News::Growing { spp, .. } => lock(&made).spp = spp,
                News::Better(better) => {
                    let mut made = lock(&made);
                    made.spp = better.spp.unwrap_or_default();
                    made.latest = Some(better);
                }
            }
            let (stopped, held) = (stop.load(Ordering::Relaxed), hold.load(Ordering::Relaxed));
            if !stopped && !held {
                passes::for_news_in(&ctx, Duration::from_millis(100));
            }
            match (stopped, held) {
                (true, _) => Wish::Stop,
                (false, true) => Wish::Hold,
                (false, false) => Wish::GoOn,
            }
        };
        let About { scene, image, seed } = about;
        let outcome = match file {
            Some(file) => {
                let mut goes_on = || on(News::Growing { spp: 0, of: 0 }) != Wish::Stop;
                let found = from_file(&file, &scene, image, &mut goes_on);
                found.map(|found| {
                    if let Some(found) = found {
                        on(News::Better(Arc::new(found)));
                    }
                })
            }
            None => grow(&scene, image, [seed, REFERENCE_SPP], threads, &mut on),
        };
        if let Err(error) = outcome {
            lock(&made).error = Some(error.to_string());
        }
        passes::for_news(&ctx);
    };
    std::thread::Builder::new().name("reference".into()).spawn(work)?;
    Ok(job)
}

fn from_file(
    file: &std::path::Path,
    scene: &Arc<Scene>,
    image: ImageSettings,
    goes_on: &mut dyn FnMut() -> bool,
) -> Result<Option<Against>, mislab_renderer::Error> {
    let picture = snapshot::load_image(file)?;
    let renderer = mislab_renderer::Renderer::in_background(1);
    let Some(cells) = Cells::of(&renderer, scene, image, goes_on)? else { return Ok(None) };
    Against::of_image(&picture, &Settings { image, ..Settings::default() }, Arc::new(cells)).map(Some)
}

fn lock(made: &Mutex<Made>) -> MutexGuard<'_, Made> {
    made.lock().unwrap_or_else(PoisonError::into_inner)
}
