//! How fast a picture goes and what it is doing.

/// How fast passes follow each other. Never changes the bits of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// Only on [`super::Picture::step`], and once for a new request, so that it is seen at all.
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
