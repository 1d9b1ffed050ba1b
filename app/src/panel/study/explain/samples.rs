//! The samples of a pixel once more, to the bit.

use std::sync::Arc;

use eframe::egui::Context;
use mislab_renderer::inspect::{Direction, Ray, Replayed, Weighted, replay};
use mislab_renderer::kernel::lanes::Lanewise;
use mislab_renderer::{Estimator, Settings};

use super::place::Place;
use crate::picture::background::{Background, Effort};

/// Of more samples only so many are replayed.
pub const MOST: u32 = 256;

/// The first samples of a pixel.
pub struct Samples {
    /// Which pixel, and how it was sampled.
    pub place: Place,
    /// The samples, in their order.
    pub list: Vec<Replayed>,
}

impl Samples {
    /// Replays `count` samples; `None` once nobody wants them.
    fn new(place: &Place, count: u32, goes_on: &mut dyn FnMut() -> bool) -> Option<Self> {
        let mut list = Vec::with_capacity(count as usize);
        for index in 0..count {
            if !goes_on() {
                return None;
            }
            list.push(replay(Lanewise::best(), &place.built, &place.settings, place.pixel, index));
        }
        Some(Self { place: place.clone(), list })
    }

    /// Variance of the luminances and the standard error of that, which the fourth moment gives; `None` of fewer than 8.
    pub fn variance(&self) -> Option<[f64; 2]> {
        let n = self.list.len() as f64;
        let values = || self.list.iter().map(|sample| f64::from(sample.luminance));
        let mean = values().sum::<f64>() / n;
        let central = |power: i32| values().map(|v| (v - mean).powi(power)).sum::<f64>() / n;
        let (second, fourth) = (central(2), central(4));
        (n >= 8.0).then(|| [second * n / (n - 1.0), ((fourth - second * second) / n).max(0.0).sqrt()])
    }
}

/// What either technique's sample in the direction of a ray is weighted with and worth, light and BSDF.
pub fn both(ray: &Ray, estimator: &Estimator) -> [Weighted; 2] {
    let Ray { wi, dirac, f, p_light, p_bsdf, lit, .. } = *ray;
    let seen = Direction { wi, f, radiance: glam::Vec3::ZERO, visible: lit, p_light, p_bsdf, dirac, hit: None };
    seen.weighted(estimator)
}

/// Replays them beside the pictures.
pub struct SamplesJob(Background<About, Arc<Samples>>);

#[derive(Clone)]
struct About {
    place: Place,
    count: u32,
}

/// Settings as far as samples depend on them.
fn sampled(settings: &Settings) -> Settings {
    let mut settings = settings.clone();
    settings.sampling.spp = None;
    settings
}

impl PartialEq for About {
    fn eq(&self, other: &Self) -> bool {
        self.count == other.count
            && self.place.is_same(&other.place)
            && sampled(&self.place.settings) == sampled(&other.place.settings)
    }
}

impl Default for SamplesJob {
    fn default() -> Self {
        Self(Background::new("samples"))
    }
}

impl SamplesJob {
    /// The samples that the picture has so far; until they are replayed, those that were before.
    pub fn of(&mut self, ctx: &Context, place: &Place, spp: u32) -> Option<Arc<Samples>> {
        let about = About { place: place.clone(), count: spp.min(MOST) };
        let work = |about: &About, goes_on: &mut (dyn FnMut() -> bool + Send)| {
            Samples::new(&about.place, about.count, goes_on).map(Arc::new)
        };
        let found = self.0.of(ctx, about, Effort::Aside, work);
        found.or_else(|| self.0.known().filter(|samples| samples.place.is_same(place)).cloned())
    }

    /// Gives up what is being replayed.
    pub fn rest(&mut self) {
        self.0.rest();
    }
}

#[cfg(test)]
mod tests {
    use super::super::tables::tests::place;
    use super::*;
    use mislab_renderer::inspect::Technique;
    use mislab_renderer::{Channel, Request, Strategy};

    #[test]
    fn replayed_samples_are_those_of_the_picture() {
        let mut place = place();
        place.settings.sampling.spp = std::num::NonZeroU32::new(16);
        for strategy in Strategy::ALL {
            place.settings.estimator.strategy = strategy;
            let request = Request { scene: place.scene.clone(), settings: place.settings.clone() };
            let frame = mislab_renderer::render(&request, 1, &mut |_| true).expect("the shipped scene renders");
            let samples = Samples::new(&place, 16, &mut || true).expect("wanted");
            let sum =
                |k: usize| samples.list.iter().flat_map(|s| &s.rays).map(|ray| f64::from(ray.value[k])).sum::<f64>();
            for (k, channel) in [Channel::R, Channel::G, Channel::B].into_iter().enumerate() {
                let film = f64::from(frame.pixel(place.pixel[0], place.pixel[1], channel).expect("inside"));
                assert!((sum(k) / 16.0 - film).abs() <= 1e-6 * film, "{strategy:?}: {}, film {film}", sum(k) / 16.0);
            }
            for ray in samples.list.iter().flat_map(|sample| &sample.rays).filter(|ray| ray.lit) {
                let [light, bsdf] = both(ray, &place.settings.estimator);
                let own = match ray.technique {
                    Technique::Light => light,
                    Technique::Bsdf => bsdf,
                };
                assert!(
                    (own.value - ray.value).length() <= 1e-5 * ray.value.length(),
                    "{strategy:?}: {own:?}, {ray:?}"
                );
                if strategy == Strategy::MisAll || strategy == Strategy::Mis {
                    assert!((light.weight + bsdf.weight - 1.0).abs() < 1e-6, "weights of a direction sum to one");
                }
            }
        }
    }
}
