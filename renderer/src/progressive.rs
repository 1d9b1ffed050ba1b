//! The progressive renderer: worker threads that turn requests into a stream of frames.

use std::sync::Arc;
use std::time::Duration;

use crate::error::Error;
use crate::frame::Frame;
use crate::scene::Scene;
use crate::settings::Settings;

/// What to render.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// The scene, with every edit applied.
    pub scene: Arc<Scene>,
    /// Strategy, samples and image.
    pub settings: Settings,
}

/// How fast passes follow each other. Never changes the bits of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// Only on [`Picture::step`].
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
    /// Passes redone because a worker panicked.
    pub worker_panics: u64,
}

/// Worker threads and the pictures they work on. Dropping it cancels and joins them.
pub struct Renderer {}

impl Renderer {
    /// Starts `threads` workers (0: one per core). `wake` is called from a worker whenever a new
    /// frame or state is there to be fetched.
    pub fn new(threads: usize, wake: impl Fn() + Send + Sync + 'static) -> Self {
        let _ = (threads, wake);
        unimplemented!()
    }

    /// A new picture, idle.
    pub fn add_picture(&self) -> Picture {
        unimplemented!()
    }

    /// Number of workers.
    pub fn threads(&self) -> usize {
        unimplemented!()
    }
}

/// Handle of one picture; dropping it takes the picture away from the workers.
pub struct Picture {}

impl Picture {
    /// Replaces the request; the latest wins. Returns its generation at once.
    /// If only the spp target changed, rendering goes on from where it is.
    pub fn submit(&self, request: Request) -> u64 {
        let _ = request;
        unimplemented!()
    }

    /// Starts the same request again from the first sample.
    pub fn restart(&self) -> u64 {
        unimplemented!()
    }

    /// Sets how fast passes follow each other.
    pub fn set_pace(&self, pace: Pace) {
        let _ = pace;
        unimplemented!()
    }

    /// Allows one more pass while paused.
    pub fn step(&self) {
        unimplemented!()
    }

    /// The newest complete frame, perhaps of an older generation.
    pub fn latest(&self) -> Option<Arc<Frame>> {
        unimplemented!()
    }

    /// What is going on.
    pub fn status(&self) -> Status {
        unimplemented!()
    }
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
/// [`Error::Invalid`] if the scene or a setting cannot be rendered, or no spp target is given.
pub fn render(
    request: &Request,
    threads: usize,
    on_progress: &mut dyn FnMut(&Progress) -> bool,
) -> Result<Arc<Frame>, Error> {
    let _ = (request, threads, on_progress);
    unimplemented!()
}

/// The SIMD level the kernels run at on this machine, e.g. "AVX-512".
pub fn simd_level_name() -> &'static str {
    unimplemented!()
}
