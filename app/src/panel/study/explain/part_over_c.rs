//! Relative variances over c, averaged over the pixels of a square or of the whole picture.

use std::sync::{Arc, Mutex, PoisonError};

use eframe::egui::Context;
use mislab_renderer::inspect::{PixelCurve, Pixels};
use mislab_renderer::kernel::world::BuiltScene;
use mislab_renderer::metrics::RELMSE_EPSILON;
use mislab_renderer::study::{Cells, Part};
use mislab_renderer::{Channel, Frame, PixelRect, Request};

use super::over_c::{Curves, places};
use crate::picture::background::{Background, Effort};
use crate::picture::squares::Squares;

/// Values of c.
const PLACES: usize = 41;
/// About so many pixels of the picture are asked about in each round, evenly spread.
const ROUNDS: [usize; 2] = [1500, 10_000];

/// What is known of a picture.
pub struct Parts {
    /// Plates by light.
    pub cells: Arc<Cells>,
    request: Arc<Request>,
    round: usize,
    /// The whole picture, then its squares in their order; `None` where none of the pixels lie in one.
    averages: Vec<Option<Average>>,
    /// By weights.
    worst: [Worst; 2],
}

/// At each c, the largest of the squares' variances, and which square has it.
pub type Worst = Vec<Option<(f64, usize)>>;

/// What holds for one part on average.
pub struct Average {
    /// Variance over the squared luminance plus [`RELMSE_EPSILON`], averaged: relMSE of one sample.
    pub curves: Curves,
    /// The pixels, with the luminance that they reflect.
    pub pixels: Vec<([u32; 2], f64)>,
}

/// A variance over the square of a luminance, as errors are relative to it.
fn relative(variance: f64, mean: f64) -> f64 {
    variance / (mean * mean + RELMSE_EPSILON)
}

impl Average {
    fn of(curves: &[&PixelCurve], c: &[f64]) -> Option<Self> {
        if curves.is_empty() {
            return None;
        }
        let mean = |i: usize, weights: usize| {
            let of = |curve: &&PixelCurve| {
                let second = [curve.at[i].veach, curve.at[i].tutorial][weights]?;
                Some(relative((second - curve.mean * curve.mean).max(0.0), curve.mean))
            };
            let sum = curves.iter().map(of).sum::<Option<f64>>()?;
            Some(sum / curves.len() as f64)
        };
        let variances = [0, 1].map(|weights| (0..c.len()).map(|i| mean(i, weights)).collect::<Vec<_>>());
        let best = [0, 1].map(|weights| lowest(c, &variances[weights]));
        let curves_of = Curves { c: c.to_vec(), variances, best };
        Some(Self { curves: curves_of, pixels: curves.iter().map(|curve| (curve.pixel, curve.mean)).collect() })
    }

    /// The same from the variances that a picture has measured in these pixels, and its standard error: from the differences to the
    /// pixel beside, which has the same variance but for other samples. `None` where a pixel lacks one.
    pub fn measured(&self, frame: &Frame) -> Option<[f64; 2]> {
        let bounds = frame.bounds();
        let (mut sum, mut squares) = (0.0, 0.0);
        for &([x, y], mean) in &self.pixels {
            let beside = if x + 1 < bounds.max[0] { x + 1 } else { x.saturating_sub(1) };
            let [here, there] = [x, beside].map(|x| frame.pixel(x, y, Channel::VarianceY));
            let [here, there] = [here?, there?].map(|variance| relative(f64::from(variance), mean));
            sum += here;
            squares += 0.5 * (here - there) * (here - there);
        }
        let count = self.pixels.len() as f64;
        let found = [sum / count, squares.sqrt() / count];
        found[0].is_finite().then_some(found)
    }
}

/// Where a curve is least, between its places by the parabola through three of them.
fn lowest(c: &[f64], curve: &[Option<f64>]) -> Option<[f64; 2]> {
    let known: Vec<[f64; 2]> = c.iter().zip(curve).filter_map(|(c, v)| Some([*c, (*v)?])).collect();
    let index = (0..known.len()).min_by(|a, b| known[*a][1].total_cmp(&known[*b][1]))?;
    let least = known[index];
    if index == 0 || index + 1 == known.len() {
        return Some(least);
    }
    let [before, after] = [known[index - 1], known[index + 1]].map(|[x, y]| [x - least[0], y - least[1]]);
    // y = a x + b x^2 through both.
    let b = (before[1] / before[0] - after[1] / after[0]) / (before[0] - after[0]);
    let a = before[1] / before[0] - b * before[0];
    if b <= 0.0 {
        return Some(least);
    }
    let x = -0.5 * a / b;
    Some([least[0] + x, least[1] - 0.25 * a * a / b])
}

impl Parts {
    fn new(about: &About, goes_on: &(dyn Fn() -> bool + Sync)) -> Option<Self> {
        let About { request, built, cells, round } = about;
        let settings = &request.settings;
        let bounds = settings.pixel_bounds();
        let step = ((bounds.area() as f64 / ROUNDS[*round] as f64).sqrt() as u32).max(1);
        let pixels = grid(bounds, step);
        let c = places(PLACES);
        let cs: Vec<f32> = c.iter().map(|c| *c as f32).collect();
        let ask = Pixels { scene: built, settings, threads: 0, goes_on };
        let found = ask.curves(&pixels, settings.estimator.heuristic, &cs)?;
        let all: Vec<&PixelCurve> = found.iter().collect();
        let mut averages = vec![Average::of(&all, &c)];
        for square in &cells.squares {
            let inside = |curve: &&&PixelCurve| square.pixels.binary_search(&index(bounds, curve.pixel)).is_ok();
            let own: Vec<&PixelCurve> = all.iter().filter(inside).copied().collect();
            averages.push(Average::of(&own, &c));
        }
        let worst = [0, 1].map(|weights| (0..PLACES).map(|i| worst(&averages[1..], weights, i)).collect());
        Some(Self { cells: cells.clone(), request: request.clone(), round: *round, averages, worst })
    }

    /// What is known of a part; `None` where light comes from none of its pixels.
    pub fn average(&self, part: Part) -> Option<&Average> {
        match part {
            Part::Whole => self.averages[0].as_ref(),
            Part::Square(index) => self.averages.get(index + 1)?.as_ref(),
            Part::Rect(_) => None,
        }
    }

    /// The square that a pixel is in.
    pub fn square_at(&self, pixel: [u32; 2]) -> Option<usize> {
        let at = index(self.cells.bounds, pixel);
        self.cells.squares.iter().position(|square| square.pixels.binary_search(&at).is_ok())
    }

    /// By weights, the largest variance that a square has at each c, and which one.
    pub fn worst(&self) -> &[Worst; 2] {
        &self.worst
    }

    /// Whether nothing finer will come.
    pub fn is_fine(&self) -> bool {
        self.round + 1 == ROUNDS.len()
    }

    /// Whether they are of such a frame, whatever its strategy, c, weights and samples.
    pub fn is_of(&self, frame: &Frame) -> bool {
        is_same(&self.request, frame.request())
    }
}

/// The largest of the squares' variances, if all are known.
fn worst(squares: &[Option<Average>], weights: usize, place: usize) -> Option<(f64, usize)> {
    let mut worst = None;
    for (index, average) in squares.iter().enumerate() {
        let Some(average) = average else { continue };
        let variance = average.curves.variances[weights][place]?;
        if worst.is_none_or(|(most, _)| variance > most) {
            worst = Some((variance, index));
        }
    }
    worst
}

/// Index into planes of a picture.
fn index(bounds: PixelRect, [x, y]: [u32; 2]) -> u32 {
    (y - bounds.min[1]) * bounds.width() + x - bounds.min[0]
}

fn grid(bounds: PixelRect, step: u32) -> Vec<[u32; 2]> {
    let along = |axis: usize| (bounds.min[axis] + step / 2..bounds.max[axis]).step_by(step as usize);
    along(1).flat_map(|y| along(0).map(move |x| [x, y])).collect()
}

fn is_same(a: &Arc<Request>, b: &Arc<Request>) -> bool {
    let of = |request: &Request| (request.settings.image, request.settings.estimator.heuristic);
    Arc::ptr_eq(&a.scene, &b.scene) && of(a) == of(b)
}

/// Works them out beside the pictures.
pub struct PartsJob {
    squares: Squares,
    job: Background<About, Arc<Parts>>,
}

#[derive(Clone)]
struct About {
    request: Arc<Request>,
    built: Arc<BuiltScene>,
    cells: Arc<Cells>,
    round: usize,
}

impl PartialEq for About {
    fn eq(&self, other: &Self) -> bool {
        is_same(&self.request, &other.request) && self.round == other.round
    }
}

impl Default for PartsJob {
    fn default() -> Self {
        Self { squares: Squares::default(), job: Background::new("curves over c") }
    }
}

impl PartsJob {
    /// Those of a frame, as far as they are known.
    pub fn of(&mut self, ctx: &Context, frame: &Frame) -> Option<Arc<Parts>> {
        let cells = self.squares.of(ctx, frame.request())?;
        let known = self.job.known().filter(|parts| parts.is_of(frame)).cloned();
        let round = known.as_ref().map_or(0, |parts| (parts.round + 1).min(ROUNDS.len() - 1));
        let about = About { request: frame.request().clone(), built: frame.scene().clone(), cells, round };
        let found = self.job.of(ctx, about, Effort::Aside, |about, goes_on| {
            let goes_on = Mutex::new(goes_on);
            let wanted = || goes_on.lock().unwrap_or_else(PoisonError::into_inner)();
            Parts::new(about, &wanted).map(Arc::new)
        });
        found.or(known)
    }

    /// Gives up what is being worked out.
    pub fn rest(&mut self) {
        self.job.rest();
    }
}

#[cfg(test)]
mod tests {
    use super::super::tables::tests::place;
    use super::*;
    use mislab_renderer::{Renderer, SamplerKind, Strategy};

    #[test]
    fn the_lowest_point_of_a_parabola_is_found_between_its_places() {
        let c = places(9);
        let curve: Vec<Option<f64>> = c.iter().map(|c| Some(3.0 + 2.0 * (c - 0.37) * (c - 0.37))).collect();
        let [at, value] = lowest(&c, &curve).expect("known");
        assert!((at - 0.37).abs() < 1e-9 && (value - 3.0).abs() < 1e-9, "{at}, {value}");
        assert_eq!(lowest(&c, &[None; 9]), None);
        let falling: Vec<Option<f64>> = c.iter().map(|c| Some(-c)).collect();
        assert_eq!(lowest(&c, &falling), Some([1.0, -1.0]));
    }

    /// The variances of independent samples are the exact ones, within five standard errors by the pixels beside and a twentieth
    /// for what varies within pixels.
    #[test]
    fn pictures_measure_the_averages() {
        let mut place = place();
        place.settings.sampling.spp = std::num::NonZeroU32::new(64);
        place.settings.sampling.sampler.kind = SamplerKind::Independent;
        place.settings.estimator.strategy = Strategy::Mis;
        place.settings.estimator.light_prob = 0.5;
        let request = Request { scene: place.scene.clone(), settings: place.settings.clone() };
        let frame = mislab_renderer::render(&request, 1, &mut |_| true).expect("the shipped scene renders");
        let renderer = Renderer::in_background(1);
        let cells = Cells::of(&renderer, &place.scene, place.settings.image, &mut || true);
        let cells = Arc::new(cells.expect("the scene renders").expect("wanted"));
        let about = About { request: frame.request().clone(), built: frame.scene().clone(), cells, round: 1 };
        let parts = Parts::new(&about, &|| true).expect("wanted");
        assert!(parts.is_of(&frame) && parts.is_fine());
        let half = PLACES / 2;
        let plate = parts.square_at(place.pixel).expect("plate 3 under light 2");
        for part in [Part::Whole, Part::Square(plate)] {
            let average = parts.average(part).expect("light arrives");
            assert!((average.curves.c[half] - 0.5).abs() < 1e-12);
            let exact = average.curves.variances[0][half].expect("unbiased");
            let [found, error] = average.measured(&frame).expect("a picture has variances");
            assert!((found - exact).abs() < 5.0 * error + 0.05 * exact, "{part:?}: {found} +- {error}, exact {exact}");
            let [_, least] = average.curves.best[0].expect("unbiased");
            assert!(least <= exact);
        }
        let (most, _) = parts.worst()[0][half].expect("squares");
        let square = parts.average(Part::Square(plate)).and_then(|average| average.curves.variances[0][half]);
        assert!(square.is_some_and(|variance| variance <= most));
        assert!(Parts::new(&about, &|| false).is_none());
    }
}
