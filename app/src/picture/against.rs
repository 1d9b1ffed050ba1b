//! Two pictures as one: the first against the second, pixel by pixel, and what is sure of them in a sentence.

use std::borrow::Cow;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

use eframe::egui::{self, Ui};
use mislab_renderer::study::Against as Reference;
use mislab_renderer::{Layer, Lockstep, PixelRect};

use crate::look::versus::Versus;
use crate::picture::comparing::{Answer, Question};
use crate::picture::content::Content;
use crate::picture::dark::DarkSpots;
use crate::picture::film_texture::FilmPipeline;
use crate::picture::legend::{Key, legend_overlay};
use crate::picture::planes::Planes;
use crate::picture::selection::Selection;
use crate::picture::squares::Squares;
use crate::picture::viewport::{Shown, Viewport};
use crate::state::document::Document;
use crate::state::passes;

/// It follows the pictures at most this often: both are gone through for it.
const INTERVAL: Duration = Duration::from_millis(250);

/// What two pictures are shown from.
pub struct Subject {
    /// A and B.
    pub contents: [Option<Content>; 2],
    /// What errors are measured against, of the scene as it is edited.
    pub reference: Option<Arc<Reference>>,
    /// How far that is, in words.
    pub words: String,
}

/// Two pictures on screen as one.
pub struct Against {
    viewport: Viewport,
    dark: [DarkSpots; 2],
    squares: Squares,
    /// The square that the mouse was on in the last pass: an index into those of the answer.
    on: Option<usize>,
    /// What planes and sentence were worked out from.
    of: Option<Of>,
    answer: Option<Answer>,
    /// What is being worked out.
    running: Option<(Of, Receiver<Option<Answer>>)>,
    begun: Option<Instant>,
    /// Why there is nothing.
    why: Cow<'static, str>,
}

#[derive(Clone, PartialEq)]
struct Of {
    contents: [(u64, u32, usize); 2],
    dark: [Option<usize>; 2],
    versus: Versus,
    equal: Lockstep,
    reference: Option<usize>,
    cells: Option<usize>,
    part: Option<PixelRect>,
}

impl Against {
    /// Drawn by the shader, or on the CPU without one.
    pub fn new(pipeline: Option<FilmPipeline>) -> Self {
        Self {
            viewport: Viewport::new(pipeline),
            dark: Default::default(),
            squares: Squares::default(),
            on: None,
            of: None,
            answer: None,
            running: None,
            begun: None,
            why: Cow::default(),
        }
    }

    /// What was on screen in the last pass.
    pub fn planes(&self) -> Option<&Arc<Planes>> {
        self.answer.as_ref().map(|answer| &answer.planes)
    }

    /// What is sure of the two pictures.
    pub fn found(&self) -> &str {
        match &self.answer {
            Some(Answer { part: Some(part), .. }) => part,
            Some(Answer { whole, squares, part: None, .. }) => {
                self.on.and_then(|square| squares.get(square)).unwrap_or(whole)
            }
            None => &self.why,
        }
    }

    /// Draws them over all that is left of `ui`, and lets the mouse select the part that the sentence is about.
    pub fn ui(&mut self, ui: &mut Ui, document: &mut Document, subject: &Subject, selection: &mut Selection) {
        match &subject.contents {
            [Some(a), Some(b)] if same_pixels(a, b) => match fitting(subject.reference.as_ref(), document, [a, b]) {
                Err(why) => self.nothing(why),
                Ok(None) if document.view.versus == Versus::Errors => self.nothing(subject.words.clone()),
                Ok(reference) => {
                    selection.keep_within(a.bounds());
                    self.update(ui.ctx(), document, [a, b], reference, selection.part());
                }
            },
            [Some(_), Some(_)] => self.nothing("The pictures have different sizes: nothing to compare."),
            [None, _] | [_, None] => self.nothing("Rendering the first pictures \u{2026}"),
        }
        // Until the number asked for is worked out, the one before is shown, under its own name.
        let planes = self.planes().cloned();
        let quantity = planes.as_ref().map_or(document.view.versus.into(), |planes| planes.quantity());
        let shown = Shown { quantity, planes: planes.as_ref(), stale: None };
        let response = self.viewport.ui(ui, &mut document.view, shown);
        let rect = response.response.rect.intersect(ui.clip_rect());
        let (Some(geometry), Some(planes)) = (response.geometry, &planes) else { return };
        let bounds = planes.bounds();
        self.on = response.hovered_pixel.and_then(|at| self.squares.at(at, bounds));
        let here = response.hovered_pixel.map(|[x, y]| planes.value(x - bounds.min[0], y - bounds.min[1])[0]);
        selection.ui(ui, &response.response, &geometry, bounds);
        let key = Key { quantity, view: &document.view, here };
        legend_overlay(ui, rect, geometry.picture_rect(), key);
    }

    fn nothing(&mut self, why: impl Into<Cow<'static, str>>) {
        self.on = None;
        self.of = None;
        self.answer = None;
        self.running = None;
        self.why = why.into();
    }

    /// Takes over what is worked out, and asks again where there is something new.
    fn update(
        &mut self,
        ctx: &egui::Context,
        document: &Document,
        [a, b]: [&Content; 2],
        reference: Option<Arc<Reference>>,
        part: Option<PixelRect>,
    ) {
        match self.running.as_ref().map(|(_, answer)| answer.try_recv()) {
            Some(Ok(answer)) => {
                self.of = self.running.take().map(|(of, _)| of);
                self.answer = answer;
                if self.answer.is_none() {
                    self.why = "A file has no red, green and blue: nothing to compare.".into();
                }
            }
            Some(Err(TryRecvError::Disconnected)) => self.running = None,
            Some(Err(TryRecvError::Empty)) | None => {}
        }
        let [first, second] = &mut self.dark;
        let dark_of = |spots: &mut DarkSpots, content: &Content| spots.of(ctx, content.frame()?, Layer::Picture);
        let dark = [dark_of(first, a), dark_of(second, b)];
        // A file has the same pixels, as far as anybody knows.
        let requests = [a, b].map(|content| content.frame().map(|frame| frame.request()));
        let differ = requests[0].zip(requests[1]).is_some_and(|(a, b)| a.settings.image != b.settings.image);
        let request = requests[0].or(requests[1]).filter(|_| !differ);
        let cells = request.and_then(|request| self.squares.of(ctx, request));
        let of = Of {
            contents: [a, b].map(|content| match content {
                Content::Frame(frame) => (frame.generation(), frame.spp(), Arc::as_ptr(frame) as usize),
                Content::File(file) => (0, 0, Arc::as_ptr(file) as usize),
            }),
            dark: dark.each_ref().map(|dark| dark.as_ref().map(|dark| Arc::as_ptr(dark) as usize)),
            versus: document.view.versus,
            equal: document.equal,
            reference: reference.as_ref().map(|reference| Arc::as_ptr(reference) as usize),
            cells: cells.as_ref().map(|cells| Arc::as_ptr(cells) as usize),
            part,
        };
        if self.running.is_some() || self.of.as_ref() == Some(&of) {
            return;
        }
        let asked = |of: &Of| (of.versus, of.equal, of.reference, of.cells, of.part);
        let asked = self.of.as_ref().is_some_and(|old| asked(old) != asked(&of));
        if let Some(begun) = self.begun.filter(|begun| self.answer.is_some() && !asked && begun.elapsed() < INTERVAL) {
            passes::for_news_in(ctx, INTERVAL.saturating_sub(begun.elapsed()));
            return;
        }
        let (contents, pixels) = ([a, b].map(Content::clone), (a.bounds(), a.size()));
        let question =
            Question { contents, pixels, dark, versus: of.versus, equal: of.equal, reference, cells, part: of.part };
        let (sender, receiver) = channel();
        let ctx = ctx.clone();
        let work = move || {
            // The two may have gone from the screen meanwhile.
            let _ = sender.send(question.answer());
            passes::for_news(&ctx);
        };
        self.begun = Some(Instant::now());
        // Without a thread it is asked again.
        let thread = std::thread::Builder::new().name("A against B".into()).spawn(work);
        self.running = thread.ok().map(|_| (of, receiver));
    }
}

fn same_pixels(a: &Content, b: &Content) -> bool {
    a.bounds() == b.bounds() && a.size() == b.size()
}

/// The reference, where errors are asked for: nothing else must begin anew when there is a better one. An error if the pictures have
/// not what is asked for: a file has no variance, and the reference may be of another picture than one of the two.
fn fitting(
    reference: Option<&Arc<Reference>>,
    document: &Document,
    contents: [&Content; 2],
) -> Result<Option<Arc<Reference>>, &'static str> {
    match document.view.versus {
        Versus::Variances if contents.iter().any(|content| content.frame().is_none()) => {
            return Err("A file has no variance to compare: choose A \u{2212} B or the errors.");
        }
        Versus::Variances | Versus::Difference => return Ok(None),
        Versus::Errors => {}
    }
    // What a file is of is the user's word.
    for frame in contents.iter().filter_map(|content| content.frame()) {
        let request = frame.request();
        let same_scene = Arc::ptr_eq(&request.scene, &document.scene) || request.scene == document.scene;
        if !same_scene || request.settings.image != document.image {
            return Err("A picture is of another scene than the reference: no errors to compare.");
        }
    }
    let of_pixels = |reference: &&Arc<Reference>| reference.len() == contents[0].bounds().area();
    Ok(reference.filter(of_pixels).cloned())
}
