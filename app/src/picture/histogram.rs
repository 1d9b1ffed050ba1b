//! How bright the pixels of a picture are: what exposure has to do with.

use std::sync::{Arc, Weak};
use std::time::{Duration, Instant};

use eframe::egui::Context;
use mislab_renderer::{Frame, Layer};

use crate::picture::content::Content;
use crate::picture::foreign::Foreign;
use crate::picture::tone::clipped_from;
use crate::state::passes;
use crate::state::view::ViewState;

/// Pixels on each side of the grid that is looked at: enough for a shape and a share.
const SIDE: u32 = 96;
/// They lie in groups of so many by so many: the film keeps pixels in blocks, and a whole one is worked out for each that is asked for.
const RUN: [u32; 2] = [8, 2];
/// It follows the picture at most this often.
const INTERVAL: Duration = Duration::from_millis(150);

/// Brightness of the pixels of one layer.
#[derive(Default)]
pub struct Histogram {
    /// The largest channel of each pixel looked at; finite and not negative.
    values: Vec<f32>,
    of: Option<(u64, u32, Layer)>,
    made: Option<Instant>,
    /// The file looked at instead.
    file: Option<(Weak<Foreign>, Layer)>,
}

impl Histogram {
    /// Stops below white at the left end.
    pub const LOW: f32 = -10.0;
    /// Stops above white at the right end.
    pub const HIGH: f32 = 4.0;

    /// Brings it up to date with a layer of what is on screen.
    pub fn update(&mut self, ctx: &Context, content: &Content, layer: Layer) {
        match content {
            Content::Frame(frame) => self.follow(ctx, frame, layer),
            Content::File(file) => self.take(file, layer),
        }
    }

    /// A file stays as it is.
    fn take(&mut self, file: &Arc<Foreign>, layer: Layer) {
        let same = self.file.as_ref().is_some_and(|(held, of)| Weak::as_ptr(held) == Arc::as_ptr(file) && *of == layer);
        if same {
            return;
        }
        (self.file, self.of) = (Some((Arc::downgrade(file), layer)), None);
        let [width, height] = file.size();
        let middles = |length: u32| (0..SIDE.min(length)).map(move |i| (2 * i + 1) * length / (2 * SIDE.min(length)));
        let pixels = middles(height).flat_map(|y| middles(width).map(move |x| [x, y]));
        let largest = |at: [u32; 2]| layer.channels().iter().filter_map(|c| file.value(at, *c)).reduce(f32::max);
        self.values = pixels.filter_map(largest).map(|v| v.max(0.0)).filter(|v| v.is_finite()).collect();
    }

    fn follow(&mut self, ctx: &Context, frame: &Frame, layer: Layer) {
        self.file = None;
        let of = (frame.generation(), frame.spp(), layer);
        if self.of == Some(of) {
            return;
        }
        let same_layer = self.of.is_some_and(|(_, _, shown)| shown == layer);
        if let Some(made) = self.made.filter(|made| same_layer && made.elapsed() < INTERVAL) {
            // The last frame of a picture must arrive, too.
            passes::for_news_in(ctx, INTERVAL.saturating_sub(made.elapsed()));
            return;
        }
        (self.of, self.made) = (Some(of), Some(Instant::now()));
        let (bounds, channels) = (frame.bounds(), layer.channels());
        let place = |axis: usize| {
            let (from, length) = (bounds.min[axis], bounds.max[axis] - bounds.min[axis]);
            places(length, RUN[axis]).map(move |at| from + at)
        };
        let pixels: Vec<[u32; 2]> = place(1).flat_map(|y| place(0).map(move |x| [x, y])).collect();
        let mut planes = vec![0.0; channels.len() * pixels.len()];
        frame.resolve_pixels(channels, &pixels, &mut planes);
        let largest = |i: usize| (0..channels.len()).map(|c| planes[c * pixels.len() + i]).fold(0.0, f32::max);
        self.values = (0..pixels.len()).map(largest).filter(|v| v.is_finite()).collect();
    }

    /// Heights of `n` bars between [`Self::LOW`] and [`Self::HIGH`], the highest 1. What is darker stands in the first,
    /// what is brighter in the last; black is left out.
    pub fn bars(&self, view: &ViewState, n: usize) -> Vec<f32> {
        let mut counts = vec![0_u32; n];
        for exposed in self.exposed(view).filter(|v| *v > 0.0) {
            let at = (exposed.log2() - Self::LOW) / (Self::HIGH - Self::LOW) * n as f32;
            counts[(at.max(0.0) as usize).min(n - 1)] += 1;
        }
        let highest = counts.iter().copied().max().unwrap_or(0).max(1);
        // The root shows the few bright pixels that exposure is about.
        counts.into_iter().map(|count| (count as f32 / highest as f32).sqrt()).collect()
    }

    /// Share of the pixels that are shown as white whatever their number.
    pub fn clipped(&self, view: &ViewState) -> f32 {
        let white = clipped_from(view.tone_map);
        let count = self.exposed(view).filter(|v| *v > white).count();
        count as f32 / self.values.len().max(1) as f32
    }

    fn exposed<'a>(&'a self, view: &ViewState) -> impl Iterator<Item = f32> + 'a {
        let (gain, offset) = (view.exposure_ev.exp2(), view.offset);
        self.values.iter().map(move |v| v * gain + offset)
    }
}

/// Where along an axis of that length the pixels are, in runs.
fn places(length: u32, run: u32) -> impl Iterator<Item = u32> {
    let count = SIDE.min(length);
    (0..count).map(move |i| {
        if length == count {
            return i;
        }
        let middle = (2 * (i / run) + 1) * length / (2 * (SIDE / run));
        (middle / run * run).min(length - run) + i % run
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_different_and_everywhere() {
        for length in [1, 7, 95, 96, 97, 100, 800, 4001] {
            for run in RUN {
                let places: Vec<u32> = places(length, run).collect();
                assert_eq!(places.len() as u32, length.min(SIDE));
                assert!(
                    places.is_sorted_by(|a, b| a < b) && *places.last().unwrap_or(&0) < length,
                    "{length}: {places:?}"
                );
                let widest = places.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or(1);
                assert!(widest <= (run * length).div_ceil(SIDE) + run, "{length}: {places:?}");
            }
        }
    }

    #[test]
    fn bars_follow_the_exposure() {
        let histogram = Histogram { values: vec![0.25, 0.25, 0.25, 0.5, 2.0, 0.0], ..Histogram::default() };
        let view = ViewState::default();
        let n = (Histogram::HIGH - Histogram::LOW) as usize;
        let bars = histogram.bars(&view, n);
        assert_eq!(bars[8], 1.0, "two stops below white");
        assert!(bars[9] > 0.0 && bars[11] > 0.0 && bars[0] == 0.0, "{bars:?}");
        assert!((histogram.clipped(&view) - 1.0 / 6.0).abs() < 1e-6);
        let brighter = ViewState { exposure_ev: 2.5, ..view };
        assert!((histogram.clipped(&brighter) - 5.0 / 6.0).abs() < 1e-6);
        assert_eq!(histogram.bars(&brighter, n)[10], 1.0, "all of them have moved");
    }
}
