//! Frames on their way to the screen: the layer that is looked at is worked out of each on a thread, and laid out for the graphics device,
//! before the pass of the window that shows it.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Instant;

use eframe::egui::Context;
use mislab_renderer::{Frame, Frames, Request};

use crate::picture::dark::{self, Darks};
use crate::picture::film_texture::{FilmPipeline, Staged};
use crate::picture::planes::{Asked, Planes};
use crate::state::passes;

/// So many pictures wait for a pass with their numbers laid out. Each takes the memory of its layer once more.
const AT_ONCE: usize = 2;

/// How a picture is shown.
#[derive(Clone)]
pub struct Look {
    /// What of it.
    pub asked: Asked,
    /// What is hatched, in pictures of this request and the like.
    pub dark: Darks,
    /// Of the frame that is shown.
    pub request: Arc<Request>,
    /// What it is drawn with; `None`: on the CPU.
    pub pipeline: Option<FilmPipeline>,
}

impl Look {
    fn is(&self, other: &Self) -> bool {
        let about = |look: &Self| (look.asked, look.dark.as_ref().map(Arc::as_ptr), look.pipeline.is_some());
        about(self) == about(other)
    }
}

/// A frame, and what is to be seen of it.
pub struct Arrived {
    /// How it is shown.
    pub look: Look,
    /// The numbers.
    pub planes: Arc<Planes>,
    /// The same for the graphics device.
    pub staged: Option<Staged>,
}

/// The frames of one picture.
pub struct Incoming {
    frames: Frames,
    state: Mutex<State>,
    /// Gone with the thread that works layers out.
    thread: Weak<()>,
}

#[derive(Default)]
struct State {
    /// How the picture was shown in the last pass; `None` if it was not.
    look: Option<Look>,
    /// How often that has changed.
    changes: u64,
    /// When the next frame is wanted.
    next: Option<Instant>,
    /// A frame has been taken and its layer is being worked out.
    working: bool,
    /// That is done, and no pass has come yet; without its layer where the pass has to work that out.
    arrived: Option<(Arc<Frame>, Option<Arrived>)>,
}

impl Incoming {
    /// The frame for this pass of the window, if there is a new one. One that is on its way comes in a later pass.
    pub fn take(&self) -> Option<(Arc<Frame>, Option<Arrived>)> {
        let mut state = self.lock();
        if let Some(arrived) = state.arrived.take() {
            return Some(arrived);
        }
        if self.is_looked_at(&state) {
            return None;
        }
        self.frames.take().map(|frame| (frame, None))
    }

    /// The pass shows it like that (`None`: not at all), and so should the next. Whether a newer frame is on its way.
    pub fn look(&self, look: Option<Look>) -> bool {
        let mut state = self.lock();
        let same = match (&state.look, &look) {
            (Some(old), Some(new)) => old.is(new),
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        };
        if !same {
            state.changes += 1;
            state.arrived = None;
        }
        state.look = look;
        same && self.is_looked_at(&state) && self.comes(&state)
    }

    /// Whether there is a newer frame than any pass has taken.
    pub fn is_coming(&self) -> bool {
        self.comes(&self.lock())
    }

    fn comes(&self, state: &State) -> bool {
        self.is_working(state) || state.arrived.is_some() || self.frames.is_waiting()
    }

    /// The pass is over, in which a new frame was shown or not. The next pass is due at `next`: a frame that is still to come is not put
    /// off, or those who ask for passes just before it would keep it away for ever.
    pub fn release(&self, shown: bool, next: Instant) {
        let mut state = self.lock();
        let next = state.next.filter(|_| !shown).map_or(next, |before| before.min(next));
        state.next = Some(next);
        self.frames.not_before(next);
        if !self.is_working(&state) && state.arrived.is_none() {
            self.frames.release();
        }
    }

    fn is_working(&self, state: &State) -> bool {
        state.working && self.thread.strong_count() > 0
    }

    fn is_looked_at(&self, state: &State) -> bool {
        state.look.is_some() && self.thread.strong_count() > 0
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Numbers are laid out, and no pass has come yet.
    fn waits(&self) -> bool {
        self.lock().arrived.is_some()
    }

    /// Works out what is to be seen of the newest frame, if there is one and somebody looks. Whether there was. `memory` holds numbers
    /// that go to the device alone.
    fn work_out(&self, ctx: &Context, memory: &mut Vec<f32>) -> bool {
        let mut state = self.lock();
        let Some(look) = state.look.clone() else { return false };
        let Some(frame) = self.frames.take() else { return false };
        if !dark::are_alike(&look.request, frame.request()) {
            // What is hatched in it is not known here.
            state.arrived = Some((frame, None));
            return true;
        }
        state.working = true;
        let changes = state.changes;
        drop(state);
        let dark = look.dark.as_ref().map(|dark| dark.as_slice());
        let mut planes = Planes::shown_in(std::mem::take(memory), &frame, look.asked.layer, look.asked.unit, dark);
        let staged = look.pipeline.as_ref().and_then(|pipeline| pipeline.stage(&planes));
        if staged.is_some() && !look.asked.numbers {
            (planes, *memory) = planes.without_numbers();
        }
        let planes = Arc::new(planes);
        let mut state = self.lock();
        state.working = false;
        // It may be looked at in another way by now: then the window has worked that out itself.
        if state.changes == changes {
            state.arrived = Some((frame, Some(Arrived { look, planes, staged })));
            // It is shown then, and no other one is wanted before: passes of the renderer are the better the longer they are.
            let next = passes::due(ctx);
            state.next = Some(next);
            self.frames.not_before(next);
        }
        true
    }
}

/// The thread that works out what is to be seen. Dropping it ends the thread.
pub struct Developer {
    shared: Arc<Shared>,
    thread: Weak<()>,
}

#[derive(Default)]
struct Shared {
    state: Mutex<Work>,
    changed: Condvar,
}

#[derive(Default)]
struct Work {
    pictures: Vec<Weak<Incoming>>,
    /// The renderer has news, of whatever kind.
    news: bool,
    /// A pass is over, and there are frames that it has not taken.
    again: bool,
    ended: bool,
}

impl Developer {
    /// Starts it. Where the system grants no thread the window works layers out itself, in its passes.
    pub fn new(ctx: &Context) -> Self {
        let shared = Arc::<Shared>::default();
        let alive = Arc::new(());
        let thread = Arc::downgrade(&alive);
        let (ctx, work) = (ctx.clone(), shared.clone());
        let run = move || {
            let _alive = Alive(Some(alive), ctx.clone());
            let mut memory = Vec::new();
            while let Some(told) = work.next() {
                let found = work.work_out(&ctx, &mut memory);
                if told || found {
                    passes::for_news(&ctx);
                }
            }
        };
        let _ = std::thread::Builder::new().name("layers".into()).spawn(run);
        Self { shared, thread }
    }

    /// Frames of one more picture come by this thread.
    pub fn add(&self, frames: Frames) -> Arc<Incoming> {
        let incoming = Arc::new(Incoming { frames, state: Mutex::default(), thread: self.thread.clone() });
        let mut work = self.shared.lock();
        work.pictures.retain(|picture| picture.strong_count() > 0);
        work.pictures.push(Arc::downgrade(&incoming));
        incoming
    }

    /// What the renderer calls when there is news.
    pub fn bell(&self, ctx: &Context) -> impl Fn() + Send + Sync + 'static {
        let (shared, thread, ctx) = (self.shared.clone(), self.thread.clone(), ctx.clone());
        move || {
            if thread.strong_count() > 0 {
                shared.tell(|work| work.news = true);
            } else {
                passes::for_news(&ctx);
            }
        }
    }

    /// A pass is over: there may be room for a frame that had none, or another way to show it.
    pub fn look_again(&self) {
        self.shared.tell(|work| work.again = true);
    }
}

/// The thread lives. Without it the window goes on by itself, with a pass for what it has missed.
struct Alive(Option<Arc<()>>, Context);

impl Drop for Alive {
    fn drop(&mut self) {
        self.0 = None;
        passes::for_news(&self.1);
    }
}

impl Drop for Developer {
    fn drop(&mut self) {
        self.shared.tell(|work| work.ended = true);
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Work> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn tell(&self, what: impl FnOnce(&mut Work)) {
        what(&mut self.lock());
        self.changed.notify_one();
    }

    /// Waits until there may be something to work out: whether the renderer has said so. `None` at the end.
    fn next(&self) -> Option<bool> {
        let idle = |work: &mut Work| !(work.news || work.again || work.ended);
        let mut work = self.changed.wait_while(self.lock(), idle).unwrap_or_else(PoisonError::into_inner);
        work.again = false;
        (!work.ended).then(|| std::mem::take(&mut work.news))
    }

    /// Works out what there is, but no more than may wait for a pass. Whether there was anything.
    fn work_out(&self, ctx: &Context, memory: &mut Vec<f32>) -> bool {
        let pictures: Vec<_> = self.lock().pictures.iter().filter_map(Weak::upgrade).collect();
        let mut waiting = pictures.iter().filter(|picture| picture.waits()).count();
        let mut found = false;
        for picture in pictures.iter().filter(|picture| !picture.waits()) {
            if waiting == AT_ONCE {
                break;
            }
            if picture.work_out(ctx, memory) {
                found = true;
                waiting += 1;
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use mislab_renderer::{Renderer, Subscription};

    use super::*;

    #[test]
    fn passes_without_a_frame_do_not_put_it_off() {
        let renderer = Renderer::new(1, || {});
        let picture = renderer.add_picture();
        let incoming = Developer::new(&Context::default()).add(picture.subscribe(Subscription::live()));
        let start = Instant::now();
        let after = |shown, seconds| {
            incoming.release(shown, start + Duration::from_secs(seconds));
            incoming.lock().next.map(|next| (next - start).as_secs())
        };
        assert_eq!(after(false, 4), Some(4));
        assert_eq!(after(false, 6), Some(4), "a frame is wanted from then on");
        assert_eq!(after(false, 2), Some(2), "or earlier");
        assert_eq!(after(true, 8), Some(8), "the next one");
    }
}
