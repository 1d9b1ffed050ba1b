//! Which frames somebody wants, and their way to him.
//!
//! A frame shares its sums with the renderer, which has to copy them (51 MB at 800 x 800) before it adds more. So none
//! is made that nobody has subscribed to, other than the first of a request, the last before a pause and the final one.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use arc_swap::ArcSwapOption;

use crate::frame::Frame;

/// Samples per pixel up to which every pass is a frame for whoever has a rate: a new picture is not to be waited for.
const FIRST_FRAMES: u32 = 4;
/// Longest time that a frame waits until the last one is released, in seconds. A window gains nothing from a frame that
/// comes while it still draws, however slowly; a subscriber who forgets to release one still sees the picture move.
const PATIENCE: f64 = 3.0;
/// Time after which a frame that nobody has taken counts as one that nobody will take soon, in seconds.
const ATTENTION: f64 = 0.1;

/// Which frames of a picture are wanted. Says nothing about how they are rendered: passes are cut to end where
/// frames are wanted, and pictures are the same bits however passes are cut.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Subscription {
    /// Frames per second, at most (passes up to four samples per pixel are frames at any rate); infinity for one after every
    /// pass, `None` for none by time. A frame that is not taken in time is replaced by a newer one.
    pub max_hz: Option<f32>,
    /// Frames at exactly these samples per pixel, each once a request. All of them wait until they are taken.
    pub at_spp: Marks,
    /// A frame by [`Self::max_hz`] waits until the last one has been taken ([`Frames::take`]) and, at full pace and for three
    /// seconds at most, until it has been released ([`Frames::release`]). Then a picture needs two sets of sums and not three, and
    /// while nobody looks no frame is made.
    pub one_at_a_time: bool,
}

impl Subscription {
    /// For a live window: thirty frames a second, one at a time. Noise melts smoothly at this rate; more frames would take
    /// the time of samples where the window is drawn in software.
    pub fn live() -> Self {
        Self { max_hz: Some(30.0), at_spp: Marks::None, one_at_a_time: true }
    }

    /// Frames at marks only.
    pub fn at(at_spp: Marks) -> Self {
        Self { at_spp, ..Self::default() }
    }
}

/// Samples per pixel at which a frame is wanted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Marks {
    /// Nowhere.
    #[default]
    None,
    /// At these, in any order.
    At(Vec<u32>),
    /// At 1, 2, 4, 8 and so on: even steps of a convergence plot.
    PowersOfTwo,
}

impl Marks {
    /// The first mark above so many samples per pixel.
    pub fn after(&self, spp: u32) -> Option<u32> {
        match self {
            Self::None => None,
            Self::At(marks) => marks.iter().copied().filter(|&mark| mark > spp).min(),
            Self::PowersOfTwo => spp.checked_add(1)?.checked_next_power_of_two(),
        }
    }

    fn holds(&self, spp: u32) -> bool {
        spp > 0 && self.after(spp - 1) == Some(spp)
    }
}

/// The frames of one subscription. Dropping it ends the subscription.
pub struct Frames {
    feed: Arc<Feed>,
    latest: Arc<ArcSwapOption<Frame>>,
}

impl Frames {
    /// The next frame that has not been taken yet, perhaps of an older generation; never waits. Frames at marks come in their
    /// order, those of a generation that a newer mark has replaced do not come any more; then the newest one by rate. To
    /// keep a frame delays no other.
    pub fn take(&self) -> Option<Arc<Frame>> {
        let mut state = self.feed.lock();
        if let Some(marked) = state.marked.pop_front() {
            return Some(marked);
        }
        if !std::mem::take(&mut state.offered) {
            return None;
        }
        state.held = true;
        drop(state);
        self.latest.load_full()
    }

    /// Whether there is one to [`Self::take`].
    pub fn is_waiting(&self) -> bool {
        let state = self.feed.lock();
        state.offered || !state.marked.is_empty()
    }

    /// The frame taken last is no longer looked at: see [`Subscription::one_at_a_time`].
    pub fn release(&self) {
        self.feed.lock().held = false;
    }

    /// No frame by rate is wanted before `next`, but the first few of a request: whoever shows them has the time then.
    /// Until then a later call may set another moment, earlier or not.
    pub fn not_before(&self, next: Instant) {
        self.feed.lock().not_before = Some(next);
    }
}

/// A subscription as the workers see it.
pub(super) struct Feed {
    wants: Subscription,
    state: Mutex<FeedState>,
}

#[derive(Default)]
struct FeedState {
    /// Frames at marks, not taken yet.
    marked: VecDeque<Arc<Frame>>,
    /// Generation and spp of the last frame at a mark, taken or not.
    last_mark: (u64, u32),
    /// There is a frame by rate that has not been taken.
    offered: bool,
    /// A frame by rate has been taken and not been released.
    held: bool,
    /// When the last frame came.
    last: Option<Instant>,
    /// When the next frame by rate is wanted, at the earliest.
    not_before: Option<Instant>,
}

/// The end of a pass, or the moment before the next one.
#[derive(Clone, Copy)]
pub(super) struct Moment {
    pub(super) now: Instant,
    pub(super) generation: u64,
    pub(super) spp: u32,
    pub(super) full_pace: bool,
}

/// What a frame is to a subscription.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wanted {
    No,
    ByRate,
    AtMark,
}

impl Feed {
    pub(super) fn new(wants: Subscription) -> Self {
        Self { wants, state: Mutex::default() }
    }

    pub(super) fn frames(self: Arc<Self>, latest: Arc<ArcSwapOption<Frame>>) -> Frames {
        Frames { feed: self, latest }
    }

    fn lock(&self) -> MutexGuard<'_, FeedState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether a frame of this moment is wanted.
    pub(super) fn wants(&self, moment: &Moment) -> Wanted {
        let state = self.lock();
        // A generation that a worker's panic has started again passes its marks twice.
        if self.wants.at_spp.holds(moment.spp) && (moment.generation, moment.spp) > state.last_mark {
            return Wanted::AtMark;
        }
        let Some(max_hz) = self.wants.max_hz else { return Wanted::No };
        let since = state.since(moment.now);
        let rested = state.rest(moment.now) == 0.0;
        let due = moment.spp <= FIRST_FRAMES || (since >= 1.0 / f64::from(max_hz) && rested);
        let waits = self.wants.one_at_a_time && (state.offered || (state.held && moment.full_pace && since < PATIENCE));
        if due && !waits { Wanted::ByRate } else { Wanted::No }
    }

    /// Seconds until a frame by rate is wanted; infinity if none is. Passes need not be shorter than that.
    pub(super) fn seconds_to_next(&self, now: Instant) -> f64 {
        let Some(max_hz) = self.wants.max_hz else { return f64::INFINITY };
        let state = self.lock();
        let unseen = self.wants.one_at_a_time && state.offered && state.since(now) >= ATTENTION;
        if unseen { f64::INFINITY } else { state.rest(now).max(1.0 / f64::from(max_hz)) }
    }

    /// The next mark above `spp`.
    pub(super) fn next_mark(&self, spp: u32) -> Option<u32> {
        self.wants.at_spp.after(spp)
    }

    /// Hands over a frame. What it replaces comes back, to be dropped where no lock is held.
    pub(super) fn offer(&self, frame: &Arc<Frame>, wanted: Wanted, now: Instant) -> Vec<Arc<Frame>> {
        let mut replaced = Vec::new();
        let mut state = self.lock();
        match wanted {
            Wanted::No => return replaced,
            Wanted::ByRate => state.offered = self.wants.max_hz.is_some(),
            Wanted::AtMark => {
                state.last_mark = (frame.generation(), frame.spp());
                while state.marked.front().is_some_and(|old| old.generation() != frame.generation()) {
                    replaced.extend(state.marked.pop_front());
                }
                state.marked.push_back(frame.clone());
                // It is newer than what was offered by rate, and would come twice.
                state.offered = false;
            }
        }
        state.last = Some(now);
        replaced
    }
}

impl FeedState {
    /// Seconds since the last frame.
    fn since(&self, now: Instant) -> f64 {
        self.last.map_or(f64::INFINITY, |last| (now - last).as_secs_f64())
    }

    /// Seconds during which none by rate is wanted.
    fn rest(&self, now: Instant) -> f64 {
        self.not_before.map_or(0.0, |next| next.saturating_duration_since(now).as_secs_f64())
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::frame::FrameStats;
    use crate::pbrt::embedded_scene;
    use mislab_kernel::request::Request;
    use mislab_kernel::world::BuiltScene;

    fn frame(generation: u64, spp: u32) -> Arc<Frame> {
        let file = embedded_scene();
        let scene = Arc::new(BuiltScene::new(&file.scene, &file.settings).expect("can be built"));
        let (paths, invalid_samples, simd) = (0, 0, "");
        let stats = FrameStats { paths, render_seconds: 0.0, cpu_seconds: 0.0, threads: 0, simd, invalid_samples };
        let bounds = file.settings.pixel_bounds();
        let request = Arc::new(Request { scene: Arc::new(file.scene), settings: file.settings });
        Arc::new(Frame { request, scene, generation, spp, bounds, stats, tiles: Vec::new() })
    }

    #[test]
    fn a_live_window_is_waited_for_and_not_for_long() {
        let start = Instant::now();
        let latest = Arc::new(ArcSwapOption::from(Some(frame(1, 10))));
        let feed = Arc::new(Feed::new(Subscription::live()));
        let frames = feed.clone().frames(latest.clone());
        let wants = |milliseconds, spp, full_pace| {
            let now = start + Duration::from_millis(milliseconds);
            feed.wants(&Moment { now, generation: 1, spp, full_pace })
        };
        assert_eq!(wants(0, 10, true), Wanted::ByRate, "it has just come");
        assert!(frames.take().is_none(), "nothing new yet");
        feed.offer(&frame(1, 10), Wanted::ByRate, start);
        assert_eq!(wants(60_000, 10, false), Wanted::No, "it does not come");
        let late = start + Duration::from_secs(60);
        assert_eq!(feed.seconds_to_next(late), f64::INFINITY, "passes need not be short");

        let held = frames.take().expect("offered");
        assert!(frames.take().is_none(), "each frame once");
        assert_eq!([40, 2999].map(|t| wants(t, 10, true)), [Wanted::No; 2], "it draws");
        assert_eq!(wants(3000, 10, true), Wanted::ByRate, "too slowly");
        assert_eq!(wants(40, 10, false), Wanted::ByRate, "at another pace there is time for a third set of sums");
        frames.release();
        assert_eq!([33, 34].map(|t| wants(t, 10, true)), [Wanted::No, Wanted::ByRate], "thirty a second");
        assert_eq!(wants(1, 4, true), Wanted::ByRate, "the first few as they come");
        assert!(feed.seconds_to_next(late) < 0.04);
        assert_eq!(held.spp(), 10);
    }

    #[test]
    fn marks_of_a_generation_come_once_even_if_it_passes_them_twice() {
        let now = Instant::now();
        let feed = Feed::new(Subscription::at(Marks::At(vec![2, 5])));
        let wants = |generation, spp| feed.wants(&Moment { now, generation, spp, full_pace: true });
        assert_eq!([1, 2, 3].map(|spp| wants(1, spp)), [Wanted::No, Wanted::AtMark, Wanted::No]);
        feed.offer(&frame(1, 2), Wanted::AtMark, now);
        // A worker panicked: again from the first sample.
        assert_eq!([2, 5].map(|spp| wants(1, spp)), [Wanted::No, Wanted::AtMark]);
        assert_eq!(wants(2, 2), Wanted::AtMark);
        let replaced = feed.offer(&frame(2, 2), Wanted::AtMark, now);
        assert_eq!(replaced.len(), 1, "the frame of the generation before");
    }

    #[test]
    fn marks_are_found_in_any_order() {
        let chosen = Marks::At(vec![10, 3, 7]);
        assert_eq!([0, 3, 9, 10].map(|spp| chosen.after(spp)), [Some(3), Some(7), Some(10), None]);
        let powers = [0, 1, 2, 4, 5, u32::MAX].map(|spp| Marks::PowersOfTwo.after(spp));
        assert_eq!(powers, [Some(1), Some(2), Some(4), Some(8), Some(8), None]);
        assert_eq!(Marks::None.after(0), None);
        assert!(Marks::PowersOfTwo.holds(8) && !Marks::PowersOfTwo.holds(9) && !Marks::PowersOfTwo.holds(0));
    }
}
