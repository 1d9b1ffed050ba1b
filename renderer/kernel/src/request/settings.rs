//! What to compute: strategy, weights, samples and image, apart from the scene.
//!
//! Everything here changes the bits of the picture. How it is computed (threads, SIMD level, pace)
//! and how it is shown (exposure, tone map, zoom) live elsewhere and never do.

use std::num::NonZeroU32;

use serde::{Deserialize, Serialize};

use super::PerTechnique;

/// How the direction of the secondary ray is chosen and weighted.
///
/// A *technique* is one way to draw a direction (from the lights, from the BSDF); a *strategy* is a
/// combination of techniques.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Strategy {
    /// One light sample, weight 1.
    Light,
    /// One BSDF sample, weight 1.
    Bsdf,
    /// One sample of each technique, combined by the heuristic (Veach 1997, eq. 9.4).
    MisAll,
    /// One sample of either technique, light with probability c (Veach 1997, eq. 9.15).
    Mis,
}

impl Strategy {
    /// All strategies in the order of the tutorial, of the keys 1 to 4 and of the table.
    pub const ALL: [Self; 4] = [Self::Light, Self::Bsdf, Self::MisAll, Self::Mis];

    /// The name in scene files, on the command line and in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Light => "light",
            Self::Bsdf => "bsdf",
            Self::MisAll => "mis_all",
            Self::Mis => "mis",
        }
    }

    /// The strategy of that name, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|s| s.name() == name)
    }

    /// Which techniques draw directions.
    pub fn draws(self) -> PerTechnique<bool> {
        PerTechnique { light: self != Self::Bsdf, bsdf: self != Self::Light }
    }

    /// Secondary rays per camera ray.
    pub fn rays_per_sample(self) -> u32 {
        match self {
            Self::MisAll => 2,
            Self::Light | Self::Bsdf | Self::Mis => 1,
        }
    }
}

/// How the weights of two techniques follow from their densities (Veach 1997, section 9.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Heuristic {
    /// `w_i = q_i / sum q` (eq. 9.8).
    Balance,
    /// `w_i = q_i^2 / sum q^2` (eq. 9.11 with beta = 2).
    Power,
    /// Densities below a tenth of the largest are dropped, the rest is balanced (eq. 9.10).
    Cutoff,
    /// The technique with the largest density takes all; light wins ties (eq. 9.12).
    Maximum,
}

impl Heuristic {
    /// All heuristics, in the order shown to users.
    pub const ALL: [Self; 4] = [Self::Balance, Self::Power, Self::Cutoff, Self::Maximum];

    /// The name in scene files, on the command line and in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Balance => "balance",
            Self::Power => "power",
            Self::Cutoff => "cutoff",
            Self::Maximum => "maximum",
        }
    }

    /// The heuristic of that name, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|h| h.name() == name)
    }
}

/// Whether the selection probability c takes part in the weights of the one-sample model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OneSampleWeights {
    /// The heuristic sees `c_i p_i`: the optimal choice (Veach 1997, theorem 9.4).
    Veach,
    /// The heuristic sees `p_i`, as in the tutorial: unbiased for 0 < c < 1, noisier unless c = 1/2.
    Tutorial,
}

impl OneSampleWeights {
    /// Both, in the order shown to users.
    pub const ALL: [Self; 2] = [Self::Veach, Self::Tutorial];

    /// The name in scene files, on the command line and in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Veach => "veach",
            Self::Tutorial => "tutorial",
        }
    }

    /// The variant of that name, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|w| w.name() == name)
    }
}

/// The pattern that the samples of one pixel follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SamplerKind {
    /// A lattice with one sample in each of n x m strata, and one in each of n m slots of either axis; of directions in
    /// other strata, as many, where the lights then share out their columns evenly.
    Stratified,
    /// A lattice that grows: any number of samples is spread evenly.
    Lattice,
    /// Owen-scrambled Sobol points (Burley 2020).
    Sobol,
    /// Independent uniform samples.
    Independent,
    /// As pbrt-v3's: one sample in each of n x m strata, visited in a random order of the pixel's own, and every choice
    /// in a dimension of its own.
    PaddedStratified,
    /// Owen-scrambled Sobol points, with every choice in a dimension of its own.
    PaddedSobol,
}

impl SamplerKind {
    /// All samplers, in the order shown to users.
    pub const ALL: [Self; 6] =
        [Self::Stratified, Self::Lattice, Self::Sobol, Self::Independent, Self::PaddedStratified, Self::PaddedSobol];

    /// The name on the command line and in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stratified => "stratified",
            Self::Lattice => "lattice",
            Self::Sobol => "sobol",
            Self::Independent => "independent",
            Self::PaddedStratified => "padded_stratified",
            Self::PaddedSobol => "padded_sobol",
        }
    }

    /// The sampler of that name, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|s| s.name() == name)
    }

    /// True if `strata` and `jitter` matter: the pattern is one of n x m samples, repeated.
    pub fn has_strata(self) -> bool {
        match self {
            Self::Stratified | Self::PaddedStratified => true,
            Self::Lattice | Self::Sobol | Self::Independent | Self::PaddedSobol => false,
        }
    }

    /// True if one number chooses technique, light or lobe and, with what they leave of it, the direction. The
    /// others have a number of its own for every choice (*padding*), as pbrt has.
    pub fn is_nested(self) -> bool {
        match self {
            Self::Stratified | Self::Lattice | Self::Sobol => true,
            Self::Independent | Self::PaddedStratified | Self::PaddedSobol => false,
        }
    }
}

/// Sampler and its parameters. `strata` and `jitter` matter where [`SamplerKind::has_strata`] says so.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct SamplerSettings {
    /// The pattern.
    pub kind: SamplerKind,
    /// Strata along x and y (pbrt's `xsamples` and `ysamples`), each at least 1.
    pub strata: [u32; 2],
    /// Random position in each stratum, or its centre.
    pub jitter: bool,
}

impl SamplerSettings {
    /// The most strata of one pattern (65536 = 256 x 256).
    pub const MAX_STRATA: u32 = 1 << 16;

    /// The pair of factors of `spp` closest to a square, the smaller first, e.g. 64 -> 8 x 8, 12 -> 3 x 4.
    /// Above [`Self::MAX_STRATA`] the pattern of that many strata, repeated.
    pub fn strata_for(spp: u32) -> [u32; 2] {
        let spp = spp.clamp(1, Self::MAX_STRATA);
        let mut x = spp.isqrt();
        while !spp.is_multiple_of(x) {
            x -= 1;
        }
        [x, spp / x]
    }
}

/// A rectangle of pixels, `min` included, `max` excluded, in the coordinates of the full image
/// (origin at the top left).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct PixelRect {
    /// Left and top.
    pub min: [u32; 2],
    /// One past right and bottom.
    pub max: [u32; 2],
}

impl PixelRect {
    /// Width in pixels.
    pub fn width(self) -> u32 {
        self.max[0].saturating_sub(self.min[0])
    }

    /// Height in pixels.
    pub fn height(self) -> u32 {
        self.max[1].saturating_sub(self.min[1])
    }

    /// Number of pixels.
    pub fn area(self) -> usize {
        self.width() as usize * self.height() as usize
    }
}

/// Which estimator of the reflected radiance: strategy, weights, c. Pictures that are compared differ in this alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimator {
    /// How directions are drawn.
    pub strategy: Strategy,
    /// c, the probability of the light technique in the one-sample model, in [0, 1].
    pub light_prob: f32,
    /// How the two techniques are weighted.
    pub heuristic: Heuristic,
    /// Whether c takes part in the one-sample weights.
    pub weights: OneSampleWeights,
}

impl Default for Estimator {
    fn default() -> Self {
        Self {
            strategy: Strategy::MisAll,
            light_prob: 0.5,
            heuristic: Heuristic::Balance,
            weights: OneSampleWeights::Veach,
        }
    }
}

impl Estimator {
    /// Why the expected picture is not the true one, if so: with weights that leave out c, a technique that is never
    /// drawn takes its share of the light with it. (Mirrors are another matter: no light sample hits one's direction.)
    pub fn bias(&self) -> Option<&'static str> {
        let one_sample = self.strategy == Strategy::Mis && self.weights == OneSampleWeights::Tutorial;
        match self.light_prob {
            _ if !one_sample => None,
            0.0 => Some("biased, too dark: at c = 0 the tutorial's weights lose what they leave to light samples"),
            1.0 => Some("biased, too dark: at c = 1 the tutorial's weights lose what they leave to BSDF samples"),
            _ => None,
        }
    }

    /// Into how many equal parts a uniform number falls that chooses the technique and one of so many lights; as many as there are
    /// lights, where those of the light technique are not whole parts of it.
    pub fn parts(&self, lights: usize) -> usize {
        let all = if self.strategy == Strategy::Mis { lights as f32 / self.light_prob } else { lights as f32 };
        if all.fract() == 0.0 && all <= u16::MAX.into() { all as usize } else { lights }
    }
}

/// Where the random numbers come from, and how many samples are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sampling {
    /// Pattern of the samples of one pixel.
    pub sampler: SamplerSettings,
    /// Samples per pixel to stop at; `None` goes on until stopped.
    pub spp: Option<NonZeroU32>,
    /// Seed of every random number.
    pub seed: u32,
}

impl Default for Sampling {
    fn default() -> Self {
        Self {
            sampler: SamplerSettings { kind: SamplerKind::Stratified, strata: [8, 8], jitter: true },
            spp: NonZeroU32::new(64),
            seed: 1,
        }
    }
}

impl Sampling {
    /// [`Self::spp`] as a plain number.
    pub fn target(&self) -> Option<u32> {
        self.spp.map(NonZeroU32::get)
    }
}

/// Size of the image and the part of it that is rendered.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImageSettings {
    /// Full image, width and height in pixels.
    pub resolution: [u32; 2],
    /// Crop window x0, x1, y0, y1 as fractions of the image in [0, 1] (pbrt's `cropwindow`).
    pub crop: [f32; 4],
}

impl Default for ImageSettings {
    fn default() -> Self {
        Self { resolution: [800, 800], crop: [0.0, 1.0, 0.0, 1.0] }
    }
}

/// Everything but the scene that decides the bits of a picture. Stored flat: the keys in files are those of the fields
/// of its parts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// How the radiance is estimated.
    #[serde(flatten)]
    pub estimator: Estimator,
    /// Samples and their random numbers.
    #[serde(flatten)]
    pub sampling: Sampling,
    /// Image size and crop.
    #[serde(flatten)]
    pub image: ImageSettings,
}

impl Settings {
    /// Most pixels of one picture: the accumulators take about 100 bytes each.
    pub const MAX_PIXELS: u64 = 1 << 25;

    /// The pixels to render: pbrt's rule, `ceil(resolution * crop)` on either side, in f32 as there.
    pub fn pixel_bounds(&self) -> PixelRect {
        let edge = |axis: usize, fraction: f32| {
            let n = self.image.resolution[axis];
            ((n as f32 * fraction).ceil() as u32).min(n)
        };
        PixelRect {
            min: [edge(0, self.image.crop[0]), edge(1, self.image.crop[2])],
            max: [edge(0, self.image.crop[1]), edge(1, self.image.crop[3])],
        }
    }

    /// The first setting that is out of its range, in words: the value and what was expected.
    pub fn check(&self) -> Result<(), String> {
        if !(0.0..=1.0).contains(&self.estimator.light_prob) {
            return Err(format!("light probability {}, expected a number in [0, 1]", self.estimator.light_prob));
        }
        let [w, h] = self.image.resolution;
        if w == 0 || h == 0 || u64::from(w) * u64::from(h) > Self::MAX_PIXELS || w > 65536 || h > 65536 {
            return Err(format!(
                "image of {w} x {h} pixels, expected 1 to 65536 on each side and at most {} in all",
                Self::MAX_PIXELS
            ));
        }
        let [nx, ny] = self.sampling.sampler.strata;
        if nx == 0 || ny == 0 || u64::from(nx) * u64::from(ny) > u64::from(SamplerSettings::MAX_STRATA) {
            return Err(format!(
                "{nx} x {ny} strata, expected at least 1 x 1 and at most {} in all",
                SamplerSettings::MAX_STRATA
            ));
        }
        let [x0, x1, y0, y1] = self.image.crop;
        let in_unit = self.image.crop.iter().all(|v| (0.0..=1.0).contains(v));
        if !in_unit || x0 >= x1 || y0 >= y1 || self.pixel_bounds().area() == 0 {
            return Err(format!(
                "crop window {x0} {x1} {y0} {y1}, expected x0 < x1 and y0 < y1 in [0, 1] with at least one pixel inside"
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_fall_into_whole_parts() {
        let of = |strategy, light_prob| Estimator { strategy, light_prob, ..Estimator::default() }.parts(4);
        assert_eq!([Strategy::Light, Strategy::Bsdf, Strategy::MisAll].map(|strategy| of(strategy, 0.5)), [4; 3]);
        assert_eq!([0.5, 0.25, 1.0, 0.3, 0.0, 1e-30].map(|c| of(Strategy::Mis, c)), [8, 16, 4, 4, 4, 4]);
    }
}
