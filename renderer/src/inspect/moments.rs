//! How one sample of an estimator is distributed, exactly.

use glam::DVec3;
use mislab_kernel::request::{Estimator, Strategy};

use super::table::Table;

/// Mean and variance of the luminance of one sample, or of one technique's part of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// E Y per channel.
    pub radiance: DVec3,
    /// E Y.
    pub mean: f64,
    /// E Y^2.
    pub second: f64,
    /// E Y^2 - (E Y)^2, worked out without that difference.
    pub variance: f64,
    /// Probability that light is carried. Of the sum of two samples it means nothing and is NaN.
    pub lit: f64,
    /// Mean weight of those that carry light; NaN where there are none, and of the sum of two samples.
    pub weight: f64,
}

/// One sample of an estimator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampled {
    /// The sample itself: for [`Strategy::MisAll`] the sum of two independent ones, else one of either technique.
    pub total: Moments,
    /// What it adds by the light technique; 0 when that is not drawn.
    pub light: Moments,
    /// What it adds by the BSDF technique; 0 when that is not drawn.
    pub bsdf: Moments,
}

/// Values of one technique with their probabilities.
#[derive(Default)]
struct Values {
    list: Vec<(f64, f64)>,
    radiance: DVec3,
    lit: f64,
    weight: f64,
}

impl Values {
    fn mean(&self) -> f64 {
        // The sum of nothing is -0.
        0.0 + self.list.iter().map(|(probability, value)| probability * value).sum::<f64>()
    }

    fn second(&self) -> f64 {
        0.0 + self.list.iter().map(|(probability, value)| probability * value * value).sum::<f64>()
    }

    /// `E (Y - m)^2` where light is carried.
    fn around(&self, m: f64) -> f64 {
        self.list.iter().map(|(probability, value)| probability * (value - m).powi(2)).sum()
    }

    fn moments(&self) -> Moments {
        let mean = self.mean();
        let dark = 1.0 - self.lit;
        Moments {
            radiance: self.radiance,
            mean,
            second: self.second(),
            variance: (self.around(mean) + dark * mean * mean).max(0.0),
            lit: self.lit,
            weight: self.weight / self.lit,
        }
    }
}

impl Table {
    /// Mean and variance of one sample of the estimator at this point. Its bias shows: the mean is then not
    /// [`Self::radiance`] (the tutorial's weights at c = 0 or 1, or a mirror that only light samples are drawn for).
    pub fn moments(&self, estimator: &Estimator) -> Sampled {
        let mut values = [Values::default(), Values::default()];
        self.visit(estimator, |node, dw, techniques| {
            for (t, technique) in techniques.into_iter().enumerate() {
                let probability = technique.c * f64::from(node.p[t]) * dw;
                if probability != 0.0 {
                    let values = &mut values[t];
                    values.list.push((probability, node.y * technique.per_f));
                    values.radiance += node.f.as_dvec3() * (technique.per_f * probability);
                    values.lit += probability;
                    values.weight += probability * technique.weight;
                }
            }
        });
        let [light, bsdf] = [values[0].moments(), values[1].moments()];
        let (radiance, mean) = (light.radiance + bsdf.radiance, light.mean + bsdf.mean);
        let total = if estimator.strategy == Strategy::MisAll {
            let variance = light.variance + bsdf.variance;
            let second = variance + mean * mean;
            Moments { radiance, mean, second, variance, lit: f64::NAN, weight: f64::NAN }
        } else {
            let lit = light.lit + bsdf.lit;
            let around = values[0].around(mean) + values[1].around(mean);
            Moments {
                radiance,
                mean,
                second: light.second + bsdf.second,
                variance: (around + (1.0 - lit) * mean * mean).max(0.0),
                lit,
                weight: (values[0].weight + values[1].weight) / lit,
            }
        };
        Sampled { total, light, bsdf }
    }

    /// What the techniques, light and BSDF, add to E Y and to E Y^2 of the one-sample model.
    pub(super) fn first_and_second(&self, estimator: &Estimator) -> [[f64; 2]; 2] {
        let mut parts = [[0.0; 2]; 2];
        self.visit(estimator, |node, dw, techniques| {
            for (part, (technique, p)) in parts.iter_mut().zip(techniques.into_iter().zip(node.p)) {
                let (probability, value) = (technique.c * f64::from(p) * dw, node.y * technique.per_f);
                part[0] += probability * value;
                part[1] += probability * value * value;
            }
        });
        parts
    }

    /// Luminance of the reflected radiance.
    pub(super) fn true_mean(&self) -> f64 {
        self.nodes().map(|node| node.y * node.dw).sum()
    }
}
