//! Samples replayed one by one, against the film that they went into.

use std::num::NonZeroU32;
use std::sync::Arc;

use glam::Vec3;
use mislab_kernel::lanes::Lanewise;
use mislab_kernel::world::BuiltScene;
use mislab_renderer::inspect::{Ray, Replayed, Technique, replay};
use mislab_renderer::{
    Channel, Estimator, Heuristic, ImageSettings, Request, SamplerKind, SamplerSettings, Sampling, Settings, Strategy,
    engine,
};
use mislab_tests::experiment::veach;
use mislab_tests::oracle;

/// A running sum as the film keeps it: what rounding has kept from it goes in with the next sample.
#[derive(Clone, Copy, Default)]
struct Sum {
    sum: f32,
    carry: f32,
}

impl Sum {
    fn add(&mut self, x: f32) {
        let x = x + self.carry;
        let old = self.sum;
        self.sum = old + x;
        self.carry = x - (self.sum - old);
    }

    fn value(&self) -> f64 {
        f64::from(self.sum) + f64::from(self.carry)
    }
}

/// What a pixel's samples add up to, one after the other.
#[derive(Default)]
struct Film {
    /// Light and BSDF: colour and weight.
    sums: [[Sum; 4]; 2],
    counts: [u32; 2],
    emission: [Sum; 3],
    squares: Sum,
}

impl Film {
    fn add(&mut self, sample: &Replayed) {
        for ray in sample.rays.iter().filter(|ray| ray.lit) {
            let t = usize::from(ray.technique == Technique::Bsdf);
            self.counts[t] += 1;
            for (sum, x) in self.sums[t].iter_mut().zip([ray.value.x, ray.value.y, ray.value.z, ray.weight]) {
                sum.add(x);
            }
        }
        if sample.emits {
            for (sum, x) in self.emission.iter_mut().zip(sample.emitted.to_array()) {
                sum.add(x);
            }
        }
        self.squares.add(sample.luminance * sample.luminance);
    }

    fn channel(&self, channel: Channel, spp: u32) -> f32 {
        let per_sample = 1.0 / f64::from(spp);
        let of = |t: usize, channel: usize| self.sums[t][channel].value();
        let total = |channel: usize| of(0, channel) + of(1, channel) + self.emission[channel].value();
        let luminance = |rgb: [f64; 3]| {
            let [r, g, b] = [0.212_671f32, 0.715_160, 0.072_169].map(f64::from);
            r * rgb[0] + g * rgb[1] + b * rgb[2]
        };
        let value = match channel {
            Channel::R => total(0) * per_sample,
            Channel::G => total(1) * per_sample,
            Channel::B => total(2) * per_sample,
            Channel::LightR => of(0, 0) * per_sample,
            Channel::LightG => of(0, 1) * per_sample,
            Channel::LightB => of(0, 2) * per_sample,
            Channel::BsdfR => of(1, 0) * per_sample,
            Channel::BsdfG => of(1, 1) * per_sample,
            Channel::BsdfB => of(1, 2) * per_sample,
            Channel::WeightLightY => of(0, 3) / f64::from(self.counts[0]),
            Channel::WeightBsdfY => of(1, 3) / f64::from(self.counts[1]),
            Channel::ShareLightY => {
                let [light, bsdf] = [0, 1].map(|t| luminance([of(t, 0), of(t, 1), of(t, 2)]));
                light / (light + bsdf)
            }
            Channel::VarianceY => {
                let sum = luminance([total(0), total(1), total(2)]);
                let rest = self.squares.value() - sum * sum / f64::from(spp);
                rest.max(0.0) / (f64::from(spp) - 1.0)
            }
        };
        if value.is_nan() { f32::NAN } else { value as f32 }
    }
}

/// A ray's numbers agree with each other.
fn ray_is_consistent(ray: &Ray, sample: &Replayed, settings: &Settings) {
    let [p, q] = if ray.technique == Technique::Light { [0, 1] } else { [1, 0] };
    let densities = [ray.p_light, ray.p_bsdf].map(f64::from);
    if let Some(number) = sample.drawn.technique {
        assert_eq!(number < settings.estimator.light_prob, ray.technique == Technique::Light, "{sample:?}");
    }
    assert!((ray.wi.length() - 1.0).abs() < 1e-5, "{ray:?}");
    if !ray.lit {
        assert_eq!((ray.value, ray.weight), (Vec3::ZERO, 0.0), "{ray:?}");
        return;
    }
    let c = match settings.estimator.strategy {
        Strategy::Mis => [f64::from(settings.estimator.light_prob), 1.0 - f64::from(settings.estimator.light_prob)],
        Strategy::Light | Strategy::Bsdf | Strategy::MisAll => [1.0; 2],
    };
    let weight = match settings.estimator.strategy {
        Strategy::Light | Strategy::Bsdf => 1.0,
        Strategy::MisAll | Strategy::Mis => {
            let seen = [0, 1].map(|t| densities[t] * c[t]);
            oracle::heuristic(settings.estimator.heuristic, seen[p], seen[q]).0
        }
    };
    let value = ray.f.as_dvec3() * (weight / (c[p] * densities[p]));
    assert!((f64::from(ray.weight) - weight).abs() < 1e-5, "{ray:?}: weight {weight}");
    assert!((ray.value.as_dvec3() - value).length() <= 1e-5 * value.length(), "{ray:?}: value {value}");
}

#[test]
fn replayed_samples_add_up_to_the_film_bit_for_bit_at_every_level() {
    const SPP: u32 = 16;
    let scenes = [Arc::new(veach()), Arc::new(mislab_renderer::pbrt::embedded_plastic_scene().scene)];
    let (mut rays, mut carrying, mut emitting) = (0, 0, 0);
    for (i, strategy) in Strategy::ALL.into_iter().enumerate() {
        for (j, kind) in SamplerKind::ALL.into_iter().enumerate() {
            let scene = &scenes[(i + j) % 2];
            let sampler = SamplerSettings { kind, strata: [4, 4], jitter: true };
            let settings = Settings {
                estimator: Estimator {
                    strategy,
                    light_prob: 0.4,
                    heuristic: Heuristic::ALL[j % Heuristic::ALL.len()],
                    ..Estimator::default()
                },
                sampling: Sampling { sampler, spp: NonZeroU32::new(SPP), seed: 7 },
                image: ImageSettings { resolution: [24, 16], ..ImageSettings::default() },
            };
            let built = BuiltScene::new(scene, &settings).expect("the scene can be built");
            let request = Request { scene: scene.clone(), settings: settings.clone() };
            for how in Lanewise::all() {
                let frame = engine::render_with(&request, 1, how, &mut |_| true).expect("it can be rendered");
                let mut pixels: Vec<[u32; 2]> = (0..24 * 16).map(|k| [k % 24, k / 24]).collect();
                // Every fifth, and those that see lights.
                let sees_light = |[x, y]: [u32; 2]| {
                    let whole = frame.pixel(x, y, Channel::G).unwrap_or(0.0);
                    let parts = [Channel::LightG, Channel::BsdfG].map(|c| frame.pixel(x, y, c).unwrap_or(0.0));
                    whole > parts[0] + parts[1] + 1e-3
                };
                pixels.retain(|&[x, y]| (x + 24 * y) % 5 == 0 || sees_light([x, y]));
                for [x, y] in pixels {
                    let mut film = Film::default();
                    for index in 0..SPP {
                        let sample = replay(how, &built, &settings, [x, y], index);
                        for ray in &sample.rays {
                            ray_is_consistent(ray, &sample, &settings);
                        }
                        rays += sample.rays.len();
                        carrying += sample.rays.iter().filter(|ray| ray.lit).count();
                        emitting += usize::from(sample.emits);
                        film.add(&sample);
                    }
                    for channel in Channel::ALL {
                        let (found, expected) =
                            (film.channel(channel, SPP), frame.pixel(x, y, channel).expect("a pixel of the frame"));
                        let label = format!("{} {}, {} at ({x}, {y})", how.name(), strategy.name(), channel.exr_name());
                        // A technique that a strategy does not draw has no weight of its own.
                        assert_eq!(found.to_bits(), expected.to_bits(), "{label}: {found}, in the film {expected}");
                    }
                }
            }
        }
    }
    println!("{rays} rays, of which {carrying} carry light; {emitting} samples see a light");
    assert!(carrying > 3000 && rays > 2 * carrying && emitting > 30, "{rays} rays, {carrying}, {emitting}");
}
