//! A bar with rate and time left, on a terminal only.

use std::time::Duration;

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};
use mislab_renderer::Progress;
use mislab_renderer::batch::Step;
use mislab_renderer::table::TableProgress;

use crate::panel::number::three_digits;

/// Ticks of a whole bar: fine enough for any terminal.
const TICKS: u64 = 10_000;

/// A progress bar on standard error; nothing is drawn where that is no terminal.
pub(super) struct Bar(ProgressBar);

impl Bar {
    /// An empty bar; `quiet` never draws.
    pub(super) fn new(quiet: bool) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let style = ProgressStyle::with_template("{bar:32} {percent:>3} %  {msg}")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        Self(ProgressBar::with_draw_target(Some(TICKS), target).with_style(style))
    }

    /// One picture's progress.
    pub(super) fn show_picture(&self, progress: &Progress) {
        let Progress { spp, target, elapsed, paths } = *progress;
        let rate = paths as f64 * 1e-6 / elapsed.as_secs_f64().max(1e-9);
        let (of, fraction) = match target {
            Some(target) => (format!(" of {target}"), f64::from(spp) / f64::from(target.max(1))),
            None => (String::new(), 0.0),
        };
        self.show(fraction, elapsed, &format!("{spp}{of} spp, {} Mpaths/s", three_digits(rate)));
    }

    /// The table's progress.
    pub(super) fn show_table(&self, progress: &TableProgress) {
        self.show(progress.fraction, progress.elapsed, &progress.step);
    }

    /// The progress of several pictures.
    pub(super) fn show_step(&self, step: &Step<'_>) {
        self.show(step.fraction, step.elapsed, step.step);
    }

    fn show(&self, fraction: f64, elapsed: Duration, text: &str) {
        let left = if fraction > 0.0 {
            let seconds = elapsed.as_secs_f64() * (1.0 - fraction) / fraction;
            // Bounded, so that a first slow moment of a long render cannot leave the range of a duration.
            format!(", {} left", HumanDuration(Duration::from_secs_f64(seconds.clamp(0.0, 1e9))))
        } else {
            String::new()
        };
        self.0.set_message(format!("{text}{left}"));
        self.0.set_position((fraction * TICKS as f64) as u64);
    }

    /// A line above the bar.
    pub(super) fn message(&self, text: &str) {
        self.0.suspend(|| super::output::message(text));
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
