//! Errors and means of the pictures on screen against the reference, a few times a second, off the UI thread.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

use eframe::egui;
use mislab_renderer::blind::blind_materials;
use mislab_renderer::study::points::errors;
use mislab_renderer::study::{Against, Cells, Mean, Part};
use mislab_renderer::{Channel, Estimator, Frame, PixelRect};

use super::live::LivePicture;
use crate::state::passes;

/// A reference with fewer samples per pixel says nothing yet: single pixels that it misses altogether outweigh the picture.
const ROUGH: u32 = 256;

/// What is known of a picture.
#[derive(Clone, Debug)]
pub struct SlotErrors {
    /// Of the frame with that generation ...
    pub generation: u64,
    /// ... and so many samples per pixel.
    pub spp: u32,
    /// What it was made with.
    pub estimator: Estimator,
    /// Processor seconds of the frame.
    pub cpu_seconds: f64,
    /// relMSE and MSE in each of [`Round::parts`].
    pub errors: Vec<[f64; 2]>,
    /// Means in each of them; `None` with one sample per pixel.
    pub means: Option<Vec<Mean>>,
    /// Of each of them whether it is a mirror that the strategy cannot sample.
    pub blind: Vec<bool>,
}

/// What all slots were measured with, and what came of it.
#[derive(Clone)]
pub struct Round {
    /// The reference.
    pub against: Arc<Against>,
    /// The whole picture, its squares and, if one was selected, the rectangle.
    pub parts: Vec<Part>,
    /// Means of the reference in each part.
    pub reference: Arc<Vec<Mean>>,
    /// Its own relMSE and MSE in each part; `None` of a file.
    pub noise: Option<Vec<[f64; 2]>>,
    /// In the order of the slots; `None` without a frame of these pixels.
    pub slots: Vec<Option<SlotErrors>>,
}

impl Round {
    /// The place of a part among [`Self::parts`]; `None` of a rectangle that was selected since.
    pub fn index(&self, part: Part) -> Option<usize> {
        self.parts.iter().position(|known| *known == part)
    }
}

/// Measures one round after the other.
#[derive(Default)]
pub struct Measuring {
    running: Option<Receiver<Round>>,
    last: Option<Instant>,
    round: Option<Round>,
    /// Generation and samples of the frames of the last round.
    seen: Vec<Option<(u64, u32)>>,
}

/// Time between two rounds: numbers that change faster cannot be read.
const EVERY: Duration = Duration::from_millis(300);

impl Measuring {
    /// Takes over what is finished, and begins the next round where there is something new; `selected` is a part of its own. Without a
    /// reference nothing is known.
    pub fn update(
        &mut self,
        ctx: &egui::Context,
        against: Option<Arc<Against>>,
        pictures: &[LivePicture],
        selected: Option<PixelRect>,
    ) {
        match self.running.as_ref().map(Receiver::try_recv) {
            Some(Ok(round)) => (self.round, self.running) = (Some(round), None),
            Some(Err(TryRecvError::Disconnected)) => self.running = None,
            Some(Err(TryRecvError::Empty)) | None => {}
        }
        let Some(against) = against else {
            self.round = None;
            return;
        };
        let frames: Vec<Option<Arc<Frame>>> = pictures.iter().map(LivePicture::current_frame).collect();
        let parts: Vec<Part> = against.cells.parts().chain(selected.map(Part::Rect)).collect();
        if self.running.is_some() || !self.is_news(&against, &parts, &frames) {
            return;
        }
        let wait = EVERY.saturating_sub(self.last.map_or(EVERY, |last| last.elapsed()));
        if !wait.is_zero() {
            passes::for_news_in(ctx, wait);
            return;
        }
        self.last = Some(Instant::now());
        self.seen = frames.iter().map(key).collect();
        let (sender, receiver) = channel();
        let known = self.round.as_ref().filter(|round| Arc::ptr_eq(&round.against, &against) && round.parts == parts);
        let (known, ctx) = (known.map(|round| round.reference.clone()), ctx.clone());
        let work = move || {
            let means = || Arc::new(parts.iter().map(|part| against.mean(*part)).collect());
            let reference = known.unwrap_or_else(means);
            let slots = frames.into_iter().map(|frame| measured(&*frame?, &against, &parts)).collect();
            let noise = parts.iter().map(|part| {
                let errors = against.noise(*part)?;
                Some([errors.rel_mse()?, errors.mse()?])
            });
            let noise = noise.collect();
            // The window may have closed meanwhile.
            let _ = sender.send(Round { against, parts, reference, noise, slots });
            passes::for_news(&ctx);
        };
        self.running = std::thread::Builder::new().name("errors".into()).spawn(work).ok().map(|_| receiver);
    }

    fn is_news(&self, against: &Arc<Against>, parts: &[Part], frames: &[Option<Arc<Frame>>]) -> bool {
        let Some(round) = &self.round else { return true };
        !Arc::ptr_eq(&round.against, against)
            || round.parts != parts
            || !frames.iter().map(key).eq(self.seen.iter().copied())
    }

    /// The last round.
    pub fn round(&self) -> Option<&Round> {
        self.round.as_ref()
    }

    /// relMSE of the whole picture in a slot: `None` without a reference, `Some(None)` where it is not known yet, of this
    /// picture or by a reference that is not [`ROUGH`].
    pub fn rel_mse(&self, slot: usize, live: &LivePicture) -> Option<Option<f64>> {
        let found = self.round.as_ref()?.slots.get(slot).and_then(Option::as_ref);
        let found = found.filter(|found| live.shown().is_none_or(|shown| shown == found.generation));
        // A picture that is soon complete runs ahead of what is measured of it.
        let spp = live.frame().map_or(0, |frame| frame.spp());
        let found = found.filter(|found| found.spp >= spp / 2);
        let rough = self.round.as_ref()?.against.spp.is_some_and(|spp| spp < ROUGH);
        Some(found.filter(|_| !rough).and_then(|found| found.errors.first()).map(|errors| errors[0]))
    }
}

fn key(frame: &Option<Arc<Frame>>) -> Option<(u64, u32)> {
    frame.as_ref().map(|frame| (frame.generation(), frame.spp()))
}

fn measured(frame: &Frame, against: &Against, parts: &[Part]) -> Option<SlotErrors> {
    if frame.bounds().area() != against.len() {
        return None;
    }
    let planes = [Channel::R, Channel::G, Channel::B].map(|channel| frame.channel(channel));
    let picture = planes.each_ref().map(Vec::as_slice);
    Some(SlotErrors {
        generation: frame.generation(),
        spp: frame.spp(),
        estimator: frame.request().settings.estimator,
        cpu_seconds: frame.stats().cpu_seconds,
        errors: parts.iter().map(|part| errors(picture, against, *part)).collect(),
        means: Mean::of_frame(frame, &against.cells, parts),
        blind: blind_parts(frame, &against.cells, parts),
    })
}

/// Of each part whether it shows a mirror whose one direction the frame's strategy never draws.
fn blind_parts(frame: &Frame, cells: &Cells, parts: &[Part]) -> Vec<bool> {
    let request = frame.request();
    let blind = blind_materials(&request.scene, &request.settings.estimator);
    let is_blind = |plate: &String| blind.iter().any(|&index| request.scene.materials[index].name == *plate);
    let of = |part: &Part| match part {
        Part::Whole | Part::Rect(_) => false,
        Part::Square(index) => is_blind(&cells.squares[*index].plate),
    };
    parts.iter().map(of).collect()
}
