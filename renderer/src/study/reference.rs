//! A reference that grows: what errors are measured against, better and better while one waits.

use std::num::NonZeroU32;
use std::sync::Arc;
use std::time::Duration;

use mislab_kernel::request::scene::Scene;
use mislab_kernel::request::{ImageSettings, Request, Settings};

use super::blocks::Blocks;
use super::cells::{Cells, Part};
use super::means::Mean;
use crate::engine::{Pace, Picture, Renderer, State};
use crate::error::Error;
use crate::frame::Frame;
use crate::metrics::Errors;
use crate::snapshot::{Image, Window};
use crate::table::quality::Reference;
use crate::table::reference::{LUMINANCE, Plan, rgb};

/// A converged picture in two halves that share no sample, and the squares of its pixels.
#[derive(Clone, Debug)]
pub struct Against {
    halves: Reference,
    /// Camera rays per pixel so far; `None` if a file does not say.
    pub spp: Option<u32>,
    /// It came from a file and is taken as exact.
    pub exact: bool,
    /// The parts that get numbers of their own.
    pub cells: Arc<Cells>,
}

impl Against {
    /// Two halves of `spp` camera rays per pixel together.
    pub(crate) fn of_halves(halves: Reference, spp: u32, cells: Arc<Cells>) -> Self {
        Self { halves, spp: Some(spp), exact: false, cells }
    }

    /// The pixels of a file, taken as exact: its own noise counts as error of what is measured.
    ///
    /// # Errors
    /// [`Error::Invalid`] unless it holds the pixels of `settings` as numbers.
    pub fn of_image(image: &Image, settings: &Settings, cells: Arc<Cells>) -> Result<Self, Error> {
        let planes = exact(image, settings)?.map(|plane| plane.into_iter().map(f64::from).collect::<Vec<_>>());
        Ok(Self {
            halves: Reference { halves: [planes.clone(), planes] },
            spp: samples_per_pixel(image),
            exact: true,
            cells,
        })
    }

    /// Its pixels, red, green and blue: the mean of both halves.
    pub fn planes(&self) -> [Vec<f32>; 3] {
        let [first, second] = &self.halves.halves;
        std::array::from_fn(|c| first[c].iter().zip(&second[c]).map(|(a, b)| (0.5 * (a + b)) as f32).collect())
    }

    /// Pixels in a plane.
    pub fn len(&self) -> usize {
        self.halves.halves[0][0].len()
    }

    /// Whether it has no pixel.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Errors of a picture's planes in a part.
    ///
    /// # Panics
    /// If they are not of [`Self::len`].
    pub fn errors(&self, picture: [&[f32]; 3], part: Part) -> Errors {
        self.halves.errors(picture, &self.cells.region(part))
    }

    /// Errors of a picture's planes by blocks of pixels.
    ///
    /// # Panics
    /// If they are not of [`Self::len`].
    pub fn block_errors(&self, picture: [&[f32]; 3]) -> Blocks {
        Blocks::new(self.cells.bounds, |region| self.halves.errors(picture, region))
    }

    /// Squared errors of each pixel of a picture's planes, whose mean over a part is the relMSE of [`Self::errors`].
    ///
    /// # Panics
    /// If they are not of [`Self::len`].
    pub fn pixel_errors(&self, picture: [&[f32]; 3]) -> Vec<f64> {
        self.halves.pixel_errors(picture)
    }

    /// Its own noise, as errors of the mean of its halves; `None` for a file, which is taken as exact.
    pub fn noise(&self, part: Part) -> Option<Errors> {
        let [first, second] = self.halves.halves.each_ref().map(|half| half.each_ref().map(Vec::as_slice));
        (!self.exact).then(|| Errors::of_halves([&first, &second], &self.cells.region(part)))
    }

    /// Its mean luminance in a part, and the standard error of that by half the difference of the halves, pixel by pixel.
    pub fn mean(&self, part: Part) -> Mean {
        let y = |half: usize, pixel: usize| -> f64 {
            self.halves.halves[half].iter().zip(LUMINANCE).map(|(plane, weight)| weight * plane[pixel]).sum()
        };
        let (mut sum, mut squared, mut count) = (0.0, 0.0, 0.0);
        self.cells.region(part).each(self.len(), |pixel| {
            let [a, b] = [y(0, pixel), y(1, pixel)];
            sum += 0.5 * (a + b);
            squared += (0.5 * (a - b)).powi(2);
            count += 1.0;
        });
        Mean {
            value: sum / count,
            standard_error: squared.sqrt() / count,
            pixels: count as usize,
            bright: f64::INFINITY,
        }
    }
}

/// The planes of a reference file.
///
/// # Errors
/// [`Error::Invalid`] unless it holds the pixels of `settings` as numbers.
fn exact(image: &Image, settings: &Settings) -> Result<[Vec<f32>; 3], Error> {
    let bounds = settings.pixel_bounds();
    let expected = Window { min: bounds.min.map(|v| v as i32), size: [bounds.width(), bounds.height()] };
    if image.window != expected {
        return Err(Error::Invalid(format!(
            "the reference holds {}, the pictures {expected}: expected the same",
            image.window
        )));
    }
    let mut planes = [const { Vec::new() }; 3];
    for (plane, name) in planes.iter_mut().zip(["R", "G", "B"]) {
        let values = image.channel(name);
        let values = values.ok_or_else(|| Error::Invalid(format!("the reference has no channel {name}")))?;
        if let Some(at) = values.iter().position(|value| !value.is_finite()) {
            let (x, y) = (at as u32 % bounds.width(), at as u32 / bounds.width());
            return Err(Error::Invalid(format!(
                "the reference's channel {name} is {} at pixel {}, {}: expected numbers",
                values[at],
                bounds.min[0] + x,
                bounds.min[1] + y
            )));
        }
        *plane = values.to_vec();
    }
    Ok(planes)
}

/// What an EXR file says of its samples: an attribute of pbrt-v4 and of this program.
fn samples_per_pixel(image: &Image) -> Option<u32> {
    image.attributes.iter().find(|(name, _)| name == "samplesPerPixel").and_then(|(_, text)| text.parse().ok())
}

/// What [`grow`] reports.
pub enum News {
    /// Camera rays per pixel so far, of how many.
    Growing {
        /// Done.
        spp: u32,
        /// Asked for.
        of: u32,
    },
    /// A better one than the last.
    Better(Arc<Against>),
}

/// What whoever waits wants next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// Go on.
    GoOn,
    /// Hold, and ask again.
    Hold,
    /// Give up.
    Stop,
}

/// The first one that is reported has so many samples; each later one twice those of the one before.
const FIRST_SPP: u32 = 64;
/// How often whoever waits is asked.
const ASK: Duration = Duration::from_millis(40);

/// Renders a reference of `spp` (a power of two from 64) with both techniques, at low priority on `threads`; blocks. `on` is told
/// several times a second and says how to go on.
///
/// # Errors
/// [`Error::Invalid`] if the scene cannot be rendered.
pub fn grow(
    scene: &Arc<Scene>,
    image: ImageSettings,
    [seed, spp]: [u32; 2],
    threads: usize,
    on: &mut dyn FnMut(News) -> Wish,
) -> Result<(), Error> {
    let renderer = Renderer::in_background(threads);
    let growing = |spp: u32, of: u32| News::Growing { spp, of };
    let Some(cells) = Cells::of(&renderer, scene, image, &mut || on(growing(0, spp)) != Wish::Stop)? else {
        return Ok(());
    };
    let cells = Arc::new(cells);
    let halves = [renderer.add_picture(), renderer.add_picture()];
    let mut target = FIRST_SPP.min(spp);
    loop {
        let plan = Plan { image, spp: target, seed };
        for (number, picture) in halves.iter().enumerate() {
            let mut settings = plan.half(number as u32);
            settings.sampling.spp = NonZeroU32::new(target / 2);
            picture.submit(Request { scene: Arc::clone(scene), settings });
        }
        let Some(frames) = finished(&halves, &mut |done| on(growing(done, spp)))? else { return Ok(()) };
        let planes = frames.map(|frame| rgb(&frame).map(|plane| plane.into_iter().map(f64::from).collect()));
        let better = Against::of_halves(Reference { halves: planes }, target, cells.clone());
        if on(News::Better(Arc::new(better))) == Wish::Stop || target >= spp {
            return Ok(());
        }
        target = target.saturating_mul(2).min(spp);
    }
}

/// Both pictures at their target; `None` if they are not wanted any more.
fn finished(halves: &[Picture; 2], on: &mut dyn FnMut(u32) -> Wish) -> Result<Option<[Arc<Frame>; 2]>, Error> {
    loop {
        let states = halves.each_ref().map(Picture::status);
        if let Some(failed) = states.iter().find(|status| status.state == State::Failed) {
            return Err(Error::Invalid(failed.error.clone().unwrap_or_default()));
        }
        if states.iter().all(|status| status.state == State::Finished)
            && let [Some(a), Some(b)] = halves.each_ref().map(Picture::latest)
        {
            return Ok(Some([a, b]));
        }
        let pace = match on(states.iter().map(|status| status.spp).sum()) {
            Wish::GoOn => Pace::Full,
            Wish::Hold => Pace::Paused,
            Wish::Stop => return Ok(None),
        };
        halves.iter().for_each(|picture| picture.set_pace(pace));
        std::thread::sleep(ASK);
    }
}
