//! How much of the processor drawing may take: when the next pass of the window is due.
//!
//! Where a window is drawn in software, thirty passes a second take more than half of two cores, and the picture gets what is
//! left. So a pass owes the processor time that it took, and time pays for it. Nothing is owed for
//! passes that answer the user or a change.

use std::time::{Duration, Instant};

/// Share of the machine's processor time that drawing may take: a fifth, less what the estimate and the kernel's
/// caches lose to it.
const SHARE: f64 = 0.16;
/// After input or a change nothing is slowed for so long.
const FRESH: Duration = Duration::from_secs(1);
/// The longest time between two passes: something else may have taken the processor time.
const LONGEST: Duration = Duration::from_secs(2);

/// The account of drawing.
#[derive(Clone, Debug)]
pub struct Share {
    /// Processor seconds that drawing may take in a second.
    allowance: f64,
    /// Processor seconds that have been drawn and not been paid for.
    debt: f64,
    /// Processor seconds that had been drawn at the last pass, and when that was.
    last: Option<(f64, Instant)>,
    fresh_until: Option<Instant>,
    due: Option<Instant>,
}

impl Share {
    /// On so many cores, with nothing drawn yet.
    pub fn new(cores: usize) -> Self {
        Self { allowance: SHARE * cores as f64, debt: 0.0, last: None, fresh_until: None, due: None }
    }

    /// There was input or a change: passes come as they are asked for.
    pub fn freshen(&mut self, now: Instant) {
        self.fresh_until = Some(now + FRESH);
        self.due = None;
    }

    /// A pass begins; so many processor seconds have gone into drawing since the program started.
    pub fn begin_pass(&mut self, now: Instant, drawn: f64) {
        let (before, then) = self.last.replace((drawn, now)).unwrap_or((drawn, now));
        let cost = (drawn - before).max(0.0);
        let paid = self.allowance * now.saturating_duration_since(then).as_secs_f64();
        let fresh = self.fresh_until.is_some_and(|until| now < until);
        // A pass costs at its beginning, and the time until the next one pays: it is the one before that is paid by now.
        let unpaid = if fresh { 0.0 } else { (self.debt - paid).max(0.0) };
        self.debt = (unpaid + cost).min(self.allowance * LONGEST.as_secs_f64());
        // What is due is not put off by passes that come before it.
        if fresh {
            self.due = None;
        } else if self.due.is_none_or(|due| due <= now) {
            self.due = Some(now + Duration::from_secs_f64(self.debt / self.allowance));
        }
    }

    /// When the next pass is due that is not about input; perhaps already.
    pub fn due(&self, now: Instant) -> Instant {
        self.due.unwrap_or(now)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Passes that come as soon as they are due, but at most thirty a second, for so many seconds; when they came.
    struct Window {
        share: Share,
        start: Instant,
        drawn: f64,
    }

    impl Window {
        fn new(cores: usize) -> Self {
            Self { share: Share::new(cores), start: Instant::now(), drawn: 0.0 }
        }

        fn at(&self, seconds: f64) -> Instant {
            self.start + Duration::from_secs_f64(seconds)
        }

        fn run(&mut self, from: f64, to: f64, cost: f64) -> Vec<f64> {
            let (mut now, mut passes) = (from, Vec::new());
            while now < to {
                self.share.begin_pass(self.at(now), self.drawn);
                passes.push(now);
                self.drawn += cost;
                let due = self.share.due(self.at(now)).duration_since(self.start).as_secs_f64();
                now = due.max(now + 1.0 / 30.0);
            }
            passes
        }
    }

    #[test]
    fn dear_passes_take_their_share_and_no_more() {
        for (cores, cost) in [(2, 0.1), (2, 0.03), (8, 0.4), (1, 0.02)] {
            let mut window = Window::new(cores);
            let passes = window.run(0.0, 100.0, cost).len() as f64;
            let taken = passes * cost / (100.0 * cores as f64);
            assert!((0.9 * SHARE..1.05 * SHARE).contains(&taken), "{cost} s on {cores} cores take {taken}");
        }
    }

    #[test]
    fn cheap_passes_are_as_many_as_are_asked_for() {
        let passes = Window::new(8).run(0.0, 10.0, 0.004).len();
        assert!((299..=301).contains(&passes), "{passes} in ten seconds");
    }

    #[test]
    fn the_first_second_is_never_slowed_and_not_paid_for_later() {
        let mut window = Window::new(2);
        window.run(0.0, 10.0, 0.1);
        window.share.freshen(window.at(10.0));
        assert_eq!(window.share.due(window.at(10.0)), window.at(10.0), "at once");
        let fresh = window.run(10.0, 11.0, 0.1);
        assert!(fresh.len() >= 29, "{} in the first second", fresh.len());
        let after = window.run(11.0, 21.0, 0.1);
        assert!(after[1] - after[0] < 0.4, "a stall of {} s", after[1] - after[0]);
        assert!((28..=36).contains(&after.len()), "{} in the ten after", after.len());
    }

    #[test]
    fn passes_that_others_ask_for_are_paid_for_and_put_nothing_off() {
        let mut window = Window::new(2);
        window.run(0.0, 10.0, 0.1);
        // An animation that nobody's hand has begun, for ten seconds: pictures still move.
        let (mut now, mut moved, mut due) = (10.0, 0, window.share.due(window.at(10.0)));
        while now < 20.0 {
            window.share.begin_pass(window.at(now), window.drawn);
            window.drawn += 0.05;
            if due <= window.at(now) {
                moved += 1;
                due = window.share.due(window.at(now));
            }
            now += 0.05;
        }
        assert!((5..=6).contains(&moved), "every other second: {moved} in ten");
        // It ends, and has not to be paid for ten times over.
        let after = window.run(20.0, 30.0, 0.1);
        assert!(after[1] - after[0] <= 2.0 && after.len() > 20, "{after:?}");
    }

    #[test]
    fn a_clock_that_is_a_little_behind_itself_does_no_harm() {
        let mut window = Window::new(2);
        window.drawn = 1.0;
        window.run(0.0, 1.0, 0.1);
        window.drawn -= 0.01;
        let passes = window.run(1.0, 11.0, 0.1);
        assert!((30..=34).contains(&passes.len()), "{} in ten seconds", passes.len());
    }
}
