//! The oracle's moments of one sample, from the directions of its table:
//!
//! ```text
//! light, bsdf    E Y^k = int p_t (f / p_t)^k
//! mis_all        Y = X_L + X_B independent,  E X_t^k = int p_t (w_t f / p_t)^k
//! mis            E Y^k = sum over t of  int c_t p_t (w_t f / (c_t p_t))^k
//! ```

use mislab_renderer::Strategy;

/// Highest moment that is kept.
const ORDER: usize = 6;

/// Raw moments E Y^k, k = 0 to 6.
#[derive(Clone, Copy, Debug)]
pub struct Moments([f64; ORDER + 1]);

impl Moments {
    /// E Y.
    pub fn mean(&self) -> f64 {
        self.0[1]
    }

    /// E (Y - E Y)^k.
    fn central(&self, k: usize) -> f64 {
        (0..=k).map(|j| binomial(k, j) * self.0[j] * (-self.mean()).powi((k - j) as i32)).sum()
    }

    /// Variance of one sample.
    pub fn variance(&self) -> f64 {
        self.central(2).max(0.0)
    }

    /// Skewness of the mean of `n` samples: how far it is from a normal distribution.
    pub fn skewness_of_mean(&self, n: f64) -> f64 {
        self.central(3) / self.central(2).powf(1.5) / n.sqrt()
    }

    /// Standard error of the variance as estimated from `n` samples.
    pub fn standard_error_of_variance(&self, n: f64) -> f64 {
        let (m2, m4) = (self.central(2), self.central(4));
        ((m4 - m2 * m2 * (n - 3.0) / (n - 1.0)) / n).max(0.0).sqrt()
    }

    /// Skewness of the variance as estimated from many (`n`) samples: that of the mean of (Y - E Y)^2.
    pub fn skewness_of_variance(&self, n: f64) -> f64 {
        let (m2, m4, m6) = (self.central(2), self.central(4), self.central(6));
        let third = m6 - 3.0 * m4 * m2 + 2.0 * m2.powi(3);
        third / (m4 - m2 * m2).powf(1.5) / n.sqrt()
    }
}

/// One technique's part of a sample.
#[derive(Clone, Copy, Debug)]
pub struct Contribution {
    /// Moments of its contribution.
    pub moments: Moments,
    /// Probability that it is drawn and meets a light.
    pub carries: f64,
    weight: f64,
    weight2: f64,
}

impl Default for Contribution {
    fn default() -> Self {
        let mut moments = Moments([0.0; ORDER + 1]);
        moments.0[0] = 1.0;
        Self { moments, carries: 0.0, weight: 0.0, weight2: 0.0 }
    }
}

impl Contribution {
    /// Adds draws of probability `prob` and density `p`, made with probability c.
    pub fn add(&mut self, c: f64, prob: f64, p: f64, weight: f64, y: f64) {
        if c == 0.0 || prob == 0.0 {
            return;
        }
        let value = weight * y / (c * p);
        let mut power = c * prob;
        self.carries += power;
        self.weight += power * weight;
        self.weight2 += power * weight * weight;
        for moment in &mut self.moments.0[1..] {
            power *= value;
            *moment += power;
        }
    }

    /// Mean weight of the samples that carry light, and the standard deviation of one such weight.
    pub fn weight(&self) -> (f64, f64) {
        let mean = self.weight / self.carries;
        (mean, (self.weight2 / self.carries - mean * mean).max(0.0).sqrt())
    }
}

/// How one sample is distributed.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// The sample itself.
    pub total: Moments,
    /// Its part by the light technique.
    pub light: Contribution,
    /// Its part by the BSDF technique.
    pub bsdf: Contribution,
}

impl Sample {
    /// Of a strategy, from what its techniques contribute.
    pub fn new(strategy: Strategy, light: Contribution, bsdf: Contribution) -> Self {
        let mut total = Moments([0.0; ORDER + 1]);
        for k in 0..=ORDER {
            total.0[k] = match strategy {
                // Two independent samples, added.
                Strategy::MisAll => (0..=k).map(|j| binomial(k, j) * light.moments.0[j] * bsdf.moments.0[k - j]).sum(),
                // One sample of either kind.
                _ if k == 0 => 1.0,
                Strategy::Light | Strategy::Bsdf | Strategy::Mis => light.moments.0[k] + bsdf.moments.0[k],
            };
        }
        Self { total, light, bsdf }
    }
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).map(|i| (n - i) as f64 / (i + 1) as f64).product()
}
