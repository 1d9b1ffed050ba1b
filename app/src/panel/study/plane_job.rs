//! The exact variances of the plane, worked out on a thread of their own, from coarse to fine.

use std::sync::Arc;

use eframe::egui::Context;
use mislab_renderer::plane::{Square, Variances};
use mislab_renderer::{Estimator, Scene};

use crate::picture::rounds::Rounds;

/// Places along each axis, ends included.
pub const PLACES: usize = 33;
/// Distances between the places of each round: the first gives a picture at once, the last fills it in.
const ROUNDS: [usize; 4] = [8, 4, 2, 1];
/// Roughness (GGX width) of the plate.
pub const ALPHA: [f32; 2] = [0.002, 0.5];

/// What the plane is about.
#[derive(Clone, PartialEq)]
pub struct Question {
    /// The scene.
    pub scene: Arc<Scene>,
    /// Heuristic, c and weights.
    pub estimator: Estimator,
    /// Which of the scene's squares gives the distances.
    pub chosen: usize,
}

/// A plate and a light of the scene.
#[derive(Clone, Debug)]
pub struct Dot {
    /// Plate and light.
    pub name: String,
    /// In the scene.
    pub alpha: f32,
    /// In the scene.
    pub radius: f32,
    /// At its own point, with its own distances.
    pub variances: Option<Variances>,
    /// From its point to the camera and to the centre of the light.
    pub distances: [f64; 2],
}

/// What has been found so far.
#[derive(Clone, Debug, Default)]
pub struct Found {
    /// The scene's own squares.
    pub dots: Vec<Dot>,
    /// Ends of the axis of radii.
    pub radius: [f32; 2],
    /// Distance between known places; 0 as long as there is nothing to draw.
    pub step: usize,
    /// Row by row from the smallest radius, in each from the smallest alpha.
    pub places: Vec<Option<Variances>>,
}

/// Works it out beside the pictures.
pub type PlaneJob = Rounds<Question, Found>;

/// Starts it; nothing is to be drawn before the first report.
pub fn start(ctx: &Context, question: Question) -> PlaneJob {
    Rounds::start(ctx, "plane", question, |question, goes_on, report| run(question, goes_on, report))
}

fn run(question: &Question, goes_on: &(dyn Fn() -> bool + Sync), report: &mut dyn FnMut(&Found)) {
    let own = &question.estimator;
    let squares = Square::all(&question.scene);
    let mut found = Found { places: vec![None; PLACES * PLACES], ..Found::default() };
    for square in squares.iter().take_while(|_| goes_on()) {
        let (alpha, radius) = (square.alpha().unwrap_or(0.0), square.radius().unwrap_or(0.0));
        found.dots.push(Dot {
            name: format!("{} \u{d7} {}", square.plate(), square.light()),
            alpha,
            radius,
            variances: square.variances(alpha, radius, own),
            distances: square.distances(),
        });
    }
    let Some(square) = squares.get(question.chosen).or(squares.first()) else { return report(&found) };
    found.radius = radii(&found.dots, square.distances()[1]);
    report(&found);
    for (round, step) in ROUNDS.into_iter().enumerate() {
        let known = if round > 0 { ROUNDS[round - 1] } else { PLACES };
        for index in 0..PLACES * PLACES {
            let [x, y] = [index % PLACES, index / PLACES];
            let due = x % step == 0 && y % step == 0;
            let old = x % known == 0 && y % known == 0 && round > 0;
            if due && !old {
                if !goes_on() {
                    return;
                }
                let share = |i: usize| i as f32 / (PLACES - 1) as f32;
                let (alpha, radius) = (along(ALPHA, share(x)), along(found.radius, share(y)));
                found.places[index] = square.variances(alpha, radius, own);
            }
        }
        found.step = step;
        report(&found);
    }
}

/// A third of the smallest to half as much again as the largest, as far as the largest stays off the plate.
fn radii(dots: &[Dot], distance: f64) -> [f32; 2] {
    let least = dots.iter().map(|dot| dot.radius).fold(f32::INFINITY, f32::min);
    let most = dots.iter().map(|dot| dot.radius).fold(0.0, f32::max);
    let high = (1.5 * most).min(0.8 * distance as f32);
    [(least / 3.0).min(high / 30.0), high]
}

/// A place on a logarithmic axis, from 0 to 1.
pub fn along([low, high]: [f32; 2], share: f32) -> f32 {
    low * (high / low).powf(share)
}

/// The inverse of [`along`].
pub fn share_of([low, high]: [f32; 2], value: f32) -> f32 {
    (value / low).ln() / (high / low).ln()
}

impl Found {
    /// Logarithms of the variances of one ray between known places, at shares of both axes in [0, 1]; those of a strategy
    /// that is biased around there are infinite. `None` where nothing is known.
    pub fn between(&self, share: [f32; 2]) -> Option<[f64; 4]> {
        let step = Some(self.step).filter(|step| *step > 0)?;
        let cells = (PLACES - 1) / step;
        let at = share.map(|s| s.clamp(0.0, 1.0) * cells as f32);
        let low = at.map(|v| (v as usize).min(cells - 1));
        let blend = [0, 1].map(|i| f64::from(at[i]) - low[i] as f64);
        let mut sum = [0.0; 4];
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let weight = [(dx, blend[0]), (dy, blend[1])].map(|(d, b)| if d == 1 { b } else { 1.0 - b });
            let corner = self.places[(low[1] + dy) * step * PLACES + (low[0] + dx) * step]?;
            for (sum, variance) in sum.iter_mut().zip(corner.per_ray) {
                *sum += variance.map_or(f64::INFINITY, |v| weight[0] * weight[1] * v.max(1e-12).ln());
            }
        }
        Some(sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_known_places_logarithms_are_linear() {
        let place = |index: usize| {
            let (x, y) = (index % PLACES, index / PLACES);
            let v = (0.1 * x as f64 - 0.2 * y as f64).exp();
            Some(Variances { mean: 1.0, per_ray: [Some(v), Some(2.0 * v), None, Some(1.0)] })
        };
        let places = (0..PLACES * PLACES).map(place).collect();
        let found = Found { places, step: 4, ..Found::default() };
        let [light, bsdf, both, one] = found.between([0.3, 0.7]).expect("all is known");
        let expected = 32.0 * (0.1 * 0.3 - 0.2 * 0.7);
        assert!((light - expected).abs() < 1e-4, "{light}, expected {expected}");
        assert!((bsdf - light - 2f64.ln()).abs() < 1e-9);
        assert!(both.is_infinite() && one == 0.0);
        assert_eq!(Found::default().between([0.5; 2]), None);
    }
}
