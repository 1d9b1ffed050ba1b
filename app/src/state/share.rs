//! How much of the processor drawing may take: when the next pass of the window is due.
//!
//! Where a window is drawn in software, thirty passes a second take more than half of two cores, and the picture gets what is
//! left. So a pass owes the processor time that it took, and time pays for it. Nothing is owed for
//! passes that answer the user or a change.

use std::time::{Duration, Instant};

use mislab_renderer::Spent;

/// Share of the processor time that drawing may take while pictures are rendered: a fifth, less what rendering loses to it
/// in caches and in passes that end for a frame.
const SHARE: f64 = 0.12;
/// After input or a change nothing is slowed for so long.
const FRESH: Duration = Duration::from_secs(1);
/// The longest time between two passes: something else may have taken the processor time.
const LONGEST: Duration = Duration::from_secs(2);
/// Time in seconds over which the processor time is averaged that the process gets.
const AVERAGED: f64 = 1.0;
/// Pictures are rendered where this share of the processor time goes into them.
const RENDERING: f64 = 0.3;

/// The account of drawing. Times are processor seconds but for instants; rates are processor seconds in a second.
#[derive(Clone, Debug)]
pub struct Share {
    cores: f64,
    /// The last pass, and what had been spent by then.
    last: Option<(Spent, Instant)>,
    /// The last pass followed the mouse: it is nothing that the next picture has to wait for.
    followed: bool,
    /// What the process spends in a second.
    rate: Spent,
    /// What passes have cost that has not been paid.
    debt: f64,
    fresh_until: Option<Instant>,
    due: Option<Instant>,
}

impl Share {
    /// On so many cores, with nothing drawn yet.
    pub fn new(cores: usize) -> Self {
        let rate = Spent::default();
        Self { cores: cores as f64, last: None, followed: false, rate, debt: 0.0, fresh_until: None, due: None }
    }

    /// There was input or a change: passes come as they are asked for.
    pub fn freshen(&mut self, now: Instant) {
        self.fresh_until = Some(now + FRESH);
        self.due = None;
    }

    /// A pass begins, perhaps only because the mouse was moved; so much has been spent since the program started, beside rendering
    /// by drawing.
    pub fn begin_pass(&mut self, now: Instant, spent: Spent, follows: bool) {
        let (before, then) = self.last.replace((spent, now)).unwrap_or((spent, now));
        let seconds = now.saturating_duration_since(then).as_secs_f64();
        self.follow(seconds, [spent.all - before.all, spent.beside_rendering - before.beside_rendering]);
        let allowance = self.allowance();
        // A pass costs at its beginning, and the time until the next one pays: it is the one before that is paid by now.
        let cost = if self.followed { 0.0 } else { (spent.beside_rendering - before.beside_rendering).max(0.0) };
        self.followed = follows && self.due.is_some_and(|due| now < due);
        let fresh = self.fresh_until.is_some_and(|until| now < until);
        let owed = (self.debt - allowance * seconds).max(0.0) + cost;
        self.debt = if fresh { 0.0 } else { owed.min(allowance * LONGEST.as_secs_f64()) };
        // What is due is not put off by passes that come before it.
        if fresh {
            self.due = None;
        } else if self.due.is_none_or(|due| due <= now) {
            let wait = (self.debt / allowance).min(LONGEST.as_secs_f64());
            self.due = Some(now + Duration::from_secs_f64(wait));
        }
    }

    /// When the next pass is due that is not about input; perhaps already.
    pub fn due(&self, now: Instant) -> Instant {
        self.due.unwrap_or(now)
    }

    /// Takes in what was spent in the last so many seconds, all and beside rendering.
    fn follow(&mut self, seconds: f64, [all, beside_rendering]: [f64; 2]) {
        if seconds > 0.0 {
            let blend = 1.0 - (-seconds / AVERAGED).exp();
            self.rate.all += blend * (all / seconds - self.rate.all);
            self.rate.beside_rendering += blend * (beside_rendering / seconds - self.rate.beside_rendering);
        }
    }

    /// What drawing may spend in a second: its share of what the process gets, which on a busy machine is less than all; of
    /// all, where nothing is rendered.
    fn allowance(&self) -> f64 {
        let rendering = self.rate.all - self.rate.beside_rendering;
        SHARE * if rendering > RENDERING * self.rate.all { self.rate.all } else { self.cores }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A window whose passes come as soon as they are due, but at most thirty a second.
    struct Window {
        share: Share,
        start: Instant,
        spent: Spent,
        /// Processor seconds that the process gets in a second, to draw and to render with the rest.
        gets: f64,
    }

    impl Window {
        fn new(cores: usize, gets: f64) -> Self {
            Self { share: Share::new(cores), start: Instant::now(), spent: Spent::default(), gets }
        }

        fn at(&self, seconds: f64) -> Instant {
            self.start + Duration::from_secs_f64(seconds)
        }

        /// Lets time go by after a pass of that cost.
        fn draw(&mut self, cost: f64, seconds: f64) {
            self.spent.beside_rendering += cost;
            self.spent.all += (self.gets * seconds).max(cost);
        }

        /// When the passes came.
        fn run(&mut self, from: f64, to: f64, cost: f64) -> Vec<f64> {
            let (mut now, mut passes) = (from, Vec::new());
            while now < to {
                self.share.begin_pass(self.at(now), self.spent, false);
                passes.push(now);
                let due = self.share.due(self.at(now)).duration_since(self.start).as_secs_f64();
                let next = due.max(now + 1.0 / 30.0);
                self.draw(cost, next - now);
                now = next;
            }
            passes
        }
    }

    #[test]
    fn dear_passes_take_their_share_and_no_more() {
        for (cores, gets, cost) in [(2, 2.0, 0.1), (2, 2.0, 0.03), (8, 8.0, 0.5), (1, 1.0, 0.02), (2, 0.5, 0.1)] {
            let mut window = Window::new(cores, gets);
            window.run(0.0, 10.0, cost);
            let taken = window.run(10.0, 110.0, cost).len() as f64 * cost / (100.0 * gets);
            assert!((0.9 * SHARE..1.05 * SHARE).contains(&taken), "{cost} s of {gets} take {taken}");
        }
    }

    #[test]
    fn cheap_passes_are_as_many_as_are_asked_for() {
        let passes = Window::new(8, 8.0).run(0.0, 10.0, 0.004).len();
        assert!((296..=301).contains(&passes), "{passes} in ten seconds");
    }

    #[test]
    fn where_nothing_is_rendered_the_whole_machine_is_there() {
        // All that the process does is to draw.
        let mut window = Window::new(8, 0.0);
        let passes = window.run(0.0, 10.0, 0.03).len();
        assert!(passes >= 296, "{passes} in ten seconds take no more than a share of eight cores");
    }

    #[test]
    fn the_first_second_is_never_slowed_and_not_paid_for_later() {
        let mut window = Window::new(2, 2.0);
        window.run(0.0, 10.0, 0.05);
        window.share.freshen(window.at(10.0));
        assert_eq!(window.share.due(window.at(10.0)), window.at(10.0), "at once");
        let fresh = window.run(10.0, 11.0, 0.05);
        assert!(fresh.len() >= 29, "{} in the first second", fresh.len());
        let after = window.run(11.0, 21.0, 0.05);
        assert!(after[1] - after[0] < 0.25, "a stall of {} s", after[1] - after[0]);
        assert!((44..=54).contains(&after.len()), "{} in the ten after", after.len());
    }

    #[test]
    fn passes_that_others_ask_for_are_paid_for_and_put_nothing_off() {
        let mut window = Window::new(2, 2.0);
        window.run(0.0, 10.0, 0.1);
        // An animation that nobody's hand has begun, for ten seconds: pictures still move.
        let (mut now, mut moved, mut due) = (10.0, 0, window.share.due(window.at(10.0)));
        while now < 20.0 {
            window.share.begin_pass(window.at(now), window.spent, false);
            window.draw(0.05, 0.05);
            if due <= window.at(now) {
                moved += 1;
                due = window.share.due(window.at(now));
            }
            now += 0.05;
        }
        assert!((5..=7).contains(&moved), "every other second: {moved} in ten");
        // It ends, and has not to be paid for ten times over.
        let after = window.run(20.0, 30.0, 0.1);
        assert!(after[1] - after[0] <= 2.0 && after.len() > 20, "{after:?}");
    }

    #[test]
    fn pictures_come_as_often_while_the_mouse_is_followed() {
        let mut window = Window::new(2, 2.0);
        let still = window.run(0.0, 20.0, 0.1).len();
        // Ten times a second, as dear as all the others.
        let (mut now, mut moved) = (20.0, 0);
        while now < 40.0 {
            let pictures = window.share.due(window.at(now)) <= window.at(now);
            window.share.begin_pass(window.at(now), window.spent, true);
            window.draw(0.1, 0.1);
            moved += usize::from(pictures);
            now += 0.1;
        }
        assert!(moved.abs_diff(still) <= still / 4, "{moved} in twenty seconds instead of {still}");
    }

    #[test]
    fn tiles_in_hand_do_no_harm() {
        // What is being rendered counts as drawing until it is done, and comes back.
        let mut window = Window::new(2, 2.0);
        let mut passes = window.run(0.0, 10.0, 0.1).len();
        for i in 0..100 {
            window.spent.beside_rendering += if i % 2 == 0 { 0.01 } else { -0.01 };
            passes += window.run(10.0 + f64::from(i), 11.0 + f64::from(i), 0.1).len();
        }
        assert!((300..=450).contains(&passes), "{passes} in 110 seconds");
    }
}
