//! A live picture: what was asked of the renderer for it, and what came back.
//!
//! The only place that talks to [`mislab_renderer::Picture`].

use std::cell::{Cell, RefCell};
use std::sync::Arc;
use std::time::{Duration, Instant};

use mislab_renderer::{Frame, Pace, Picture, Request, Status, Subscription};

use crate::picture::content::Content;
use crate::picture::foreign::Foreign;
use crate::picture::incoming::{Arrived, Developer, Incoming, Look};

/// How long the old picture may stand unmarked after a change: shorter than one notices, longer
/// than the first pass of a usual picture takes, so that dragging a slider does not flicker.
const GRACE: Duration = Duration::from_millis(120);

/// One picture in progress.
pub struct LivePicture {
    /// `None` once the workers have been stopped.
    picture: Option<Picture>,
    /// What the window has asked for: a frame at a time.
    incoming: Arc<Incoming>,
    submitted: Option<Request>,
    generation: u64,
    changed_at: Instant,
    /// Held during a pass of the window only: the room of a frame that nobody holds goes to the next one.
    frame: Option<Arc<Frame>>,
    /// What is to be seen of it, where that has been worked out.
    arrived: RefCell<Option<Arrived>>,
    /// Shown in this pass.
    looked_at: Cell<bool>,
    /// The frame of this pass has come since the last one.
    new: bool,
    /// Generation of the frame on screen.
    shown: Option<u64>,
    pace: Pace,
    /// Shown instead of anything rendered.
    held: Option<Content>,
}

impl LivePicture {
    /// Nothing asked for yet.
    pub fn new(picture: Picture, developer: &Developer) -> Self {
        Self {
            incoming: developer.add(picture.subscribe(Subscription::live())),
            picture: Some(picture),
            submitted: None,
            generation: 0,
            changed_at: Instant::now(),
            frame: None,
            arrived: RefCell::default(),
            looked_at: Cell::default(),
            new: false,
            shown: None,
            pace: Pace::Full,
            held: None,
        }
    }

    /// A frame that was kept or a file, on a picture of which nothing is asked.
    pub fn of_held(picture: Picture, developer: &Developer, held: Option<Content>) -> Self {
        Self { held, ..Self::new(picture, developer) }
    }

    /// What is shown instead of anything rendered: a frame that was kept, or a file.
    pub fn held(&self) -> Option<&Content> {
        self.held.as_ref()
    }

    /// The frame that was kept and is shown.
    pub fn kept(&self) -> Option<&Arc<Frame>> {
        match &self.held {
            Some(Content::Frame(frame)) => Some(frame),
            Some(Content::File(_)) | None => None,
        }
    }

    /// The file that is shown.
    pub fn file(&self) -> Option<&Arc<Foreign>> {
        match &self.held {
            Some(Content::File(file)) => Some(file),
            Some(Content::Frame(_)) | None => None,
        }
    }

    /// What is shown: what is held, or else [`Self::frame`].
    pub fn content(&self) -> Option<Content> {
        self.held.clone().or_else(|| self.frame().map(Content::Frame))
    }

    /// Hands over what should be rendered, if that has changed, and says whether it has. Returns at once.
    pub fn submit(&mut self, request: Request) -> bool {
        let Some(picture) = self.picture.as_ref().filter(|_| self.held.is_none()) else { return false };
        let same = self.submitted.as_ref().is_some_and(|old| {
            // A scene is compared by its numbers only if it is not the very same one.
            old.settings == request.settings && (Arc::ptr_eq(&old.scene, &request.scene) || old.scene == request.scene)
        });
        if !same {
            let before = self.generation;
            self.generation = picture.submit(request.clone());
            self.submitted = Some(request);
            if self.generation != before {
                self.changed_at = Instant::now();
            }
        }
        !same
    }

    /// Whether this is what it was asked for last.
    pub fn is_about(&self, request: &Request) -> bool {
        self.submitted.as_ref().is_some_and(|submitted| {
            submitted.settings == request.settings && Arc::ptr_eq(&submitted.scene, &request.scene)
        })
    }

    /// What the renderer knows it as; `None` once the workers have been stopped.
    pub fn picture(&self) -> Option<&Picture> {
        self.picture.as_ref()
    }

    /// Starts again from the first sample.
    pub fn restart(&mut self) {
        if let Some(picture) = self.picture.as_ref().filter(|_| self.held.is_none()) {
            self.generation = picture.restart();
            self.changed_at = Instant::now();
        }
    }

    /// Sets the pace, if it is another.
    pub fn set_pace(&mut self, pace: Pace) {
        if let Some(picture) = &self.picture
            && self.pace != pace
        {
            picture.set_pace(pace);
            self.pace = pace;
        }
    }

    /// One more pass while held.
    pub fn step(&self) {
        if let Some(picture) = &self.picture {
            picture.step();
        }
    }

    /// Takes the newest frame for a pass of the window, unless it holds one.
    pub fn hold(&mut self) {
        if self.frame.is_some() {
            return;
        }
        let (frame, arrived) = self.incoming.take().unzip();
        self.new = frame.is_some();
        self.frame = frame.or_else(|| self.picture.as_ref()?.latest());
        self.arrived = RefCell::new(arrived.flatten());
        self.shown = self.frame.as_ref().map(|frame| frame.generation());
    }

    /// What is to be seen of the frame of this pass, where that has been worked out already.
    pub fn arrived(&self) -> Option<Arrived> {
        self.arrived.take()
    }

    /// The pass shows it like that. Whether a newer frame than it has shown is on its way to be shown like that, too.
    pub fn look(&self, look: Look) -> bool {
        self.looked_at.set(true);
        self.incoming.look(Some(look))
    }

    /// Whether there is a newer frame than any pass has shown.
    pub fn is_coming(&self) -> bool {
        self.incoming.is_coming()
    }

    /// Gives it back: the pass is over, and the next one for a frame is due at `next`.
    pub fn release(&mut self, next: Instant) {
        self.frame = None;
        self.arrived = RefCell::default();
        if !self.looked_at.take() {
            self.incoming.look(None);
        }
        self.incoming.release(std::mem::take(&mut self.new), next);
    }

    /// The frame of this pass or, between passes, the newest one; perhaps of older settings. None of a file.
    pub fn frame(&self) -> Option<Arc<Frame>> {
        match &self.held {
            Some(Content::Frame(frame)) => Some(frame.clone()),
            Some(Content::File(_)) => None,
            None => self.frame.clone().or_else(|| self.picture.as_ref().and_then(Picture::latest)),
        }
    }

    /// The same, if it was made with the current settings.
    pub fn current_frame(&self) -> Option<Arc<Frame>> {
        self.frame().filter(|frame| self.held.is_some() || frame.generation() == self.generation)
    }

    /// Generation of the frame on screen.
    pub fn shown(&self) -> Option<u64> {
        self.shown
    }

    /// Whether the frame on screen is of older settings.
    pub fn is_behind(&self) -> bool {
        self.shown.is_some_and(|generation| generation != self.generation)
    }

    /// How long until an old picture must be marked as one; `None` if there is nothing to mark.
    pub fn marked_in(&self) -> Option<Duration> {
        self.is_behind().then(|| GRACE.saturating_sub(self.changed_at.elapsed()))
    }

    /// What the renderer is doing.
    pub fn status(&self) -> Option<Status> {
        self.picture.as_ref().map(Picture::status)
    }

    /// Version of the settings last handed over.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// The picture, for whoever has the time to take it away from the workers; there will be no more frames.
    pub fn stop(&mut self) -> Option<Picture> {
        self.picture.take()
    }
}
