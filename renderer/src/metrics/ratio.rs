//! How much noisier one picture is than another of the same pixels, with an interval.
//!
//! 1. *Ratio.* With V the variance of one sample of a pixel and k what a sample costs, R = sum of w V_A k_A over sum of
//!    w V_B k_B over the pixels of a region. The weight w = 1 / m^2 makes variances relative; m is the mean luminance of both
//!    pictures over the block of 32 x 32 pixels: where it is of few pixels, a bright sample lowers its own weight.
//! 2. *Its error.* By the delta method log R has the variance of the sum of u = w V_A k_A / S_A - w V_B k_B / S_B (S: the sums). The
//!    pixels are independent of each other, but no two have the same V. What varies by chance is told from what varies over the
//!    picture by successive differences (von Neumann et al. 1941): E (u_i - u_j)^2 = var u_i + var u_j for neighbours, and a
//!    little more where V changes from one to the next. Common random numbers of A and B are in u already.
//! 3. *Its distribution.* Student's, with the degrees of freedom of a sum of squares (Satterthwaite 1946):
//!    3 (sum d^2)^2 / sum d^4. A few bright samples among many pixels leave few, and below [`Ratio::LEAST_FREEDOM`] nothing is claimed.
//! 4. *What was missed.* Samples that are bright and so rare that a region has none are missing from its sum and from its error,
//!    and no error can tell. As many as were seen once may be missing once: by the rule of succession either sum may be larger by
//!    its largest pixel, and the band reaches as much further on that side.

use statrs::distribution::{ContinuousCDF as _, StudentsT};

use super::Region;

/// Side of the blocks that means are taken over, in pixels.
const BLOCK: usize = 32;

/// What is known about the noise of a picture.
#[derive(Clone, Copy, Debug)]
pub struct Noise<'a> {
    /// Mean luminance of each pixel, row by row.
    pub mean: &'a [f32],
    /// Variance of the luminance of one sample of each pixel. What is not finite is left out.
    pub variance: &'a [f32],
    /// What a sample costs, in whatever the pictures are compared by.
    pub cost: f64,
}

/// What the numbers are that a ratio is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Compared {
    Noise,
    Errors,
}

/// What is compared of two pictures A and B: a number of each pixel, that of all being their sum.
#[derive(Clone, Debug)]
pub struct Pixels {
    compared: Compared,
    /// Row by row; what is not finite in both is left out.
    values: Vec<[f64; 2]>,
}

impl Pixels {
    /// The noise of pictures of that `width`: the weighted variances.
    ///
    /// # Panics
    /// If the planes differ in length.
    pub fn noise(a: &Noise<'_>, b: &Noise<'_>, width: usize) -> Self {
        let weights = block_weights(a.mean, b.mean, width);
        let across = width.div_ceil(BLOCK);
        let value = |pixel: usize| {
            let weight = weights[pixel / width / BLOCK * across + pixel % width / BLOCK];
            [a, b].map(|noise| weight * f64::from(noise.variance[pixel]) * noise.cost)
        };
        Self { compared: Compared::Noise, values: (0..a.mean.len()).map(value).collect() }
    }

    /// Squared errors of each pixel of both pictures: by [`super::pixel_errors`], so that R is the ratio of the relMSE. They
    /// are of the pictures as they are, whatever those cost.
    ///
    /// # Panics
    /// If there are not as many of both.
    pub fn errors(a: &[f64], b: &[f64]) -> Self {
        assert_eq!(a.len(), b.len(), "errors of the same pixels");
        Self { compared: Compared::Errors, values: a.iter().zip(b).map(|(a, b)| [*a, *b]).collect() }
    }

    /// The numbers of A and B at a pixel.
    ///
    /// # Panics
    /// If there is no such pixel.
    pub fn at(&self, pixel: usize) -> [f64; 2] {
        self.values[pixel]
    }

    /// The sums over a region.
    ///
    /// # Panics
    /// If it reaches beyond the pixels.
    pub fn sums(&self, region: &Region<'_>) -> [f64; 2] {
        self.of(region).iter().fold([0.0; 2], |sum, value| [sum[0] + value[0], sum[1] + value[1]])
    }

    fn of(&self, region: &Region<'_>) -> Vec<[f64; 2]> {
        let mut found = Vec::new();
        region.each(self.values.len(), |pixel| {
            let value = self.values[pixel];
            if value.iter().all(|v| v.is_finite()) {
                found.push(value);
            }
        });
        found
    }
}

/// The noise, or the squared error, of a picture A over that of a picture B.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ratio {
    compared: Compared,
    log: f64,
    standard_error: f64,
    freedom: f64,
    /// Logarithm of what the sums of A and B may be larger by.
    missed: [f64; 2],
}

impl Ratio {
    /// With fewer degrees of freedom the tails are too heavy to say anything: with 40, bands of 95 % were measured to hold
    /// the truth in 89 of 100 cases, since the rarest samples are missing from the error, too.
    pub const LEAST_FREEDOM: f64 = 100.0;
    /// One looks many times while pictures converge: what is called distinguishable is so at 99 %.
    const CONFIDENCE: f64 = 0.99;

    /// Over a region. `None` if either has nothing there, or there are too few pixels.
    ///
    /// # Panics
    /// If the region reaches beyond the pixels.
    pub fn of(pixels: &Pixels, region: &Region<'_>) -> Option<Self> {
        let noises = pixels.of(region);
        let [sum_a, sum_b] = pixels.sums(region);
        if sum_a <= 0.0 || sum_b <= 0.0 {
            return None;
        }
        let (mut pairs, mut second, mut fourth) = (0.0, 0.0, 0.0);
        for pair in noises.chunks_exact(2) {
            let [u, v] = [pair[0], pair[1]].map(|[of_a, of_b]| of_a / sum_a - of_b / sum_b);
            let squared = (u - v) * (u - v);
            pairs += 1.0;
            second += squared;
            fourth += squared * squared;
        }
        // A last pixel without a neighbour counts as the others.
        let standard_error = (second * noises.len() as f64 / (2.0 * pairs)).sqrt();
        let freedom = if fourth > 0.0 { 3.0 * second * second / fourth } else { 0.0 };
        let most = noises.iter().fold([0.0_f64; 2], |most, noise| [most[0].max(noise[0]), most[1].max(noise[1])]);
        let missed = [(most[0] / sum_a).ln_1p(), (most[1] / sum_b).ln_1p()];
        (pairs > 0.0).then_some(Self {
            compared: pixels.compared,
            log: (sum_a / sum_b).ln(),
            standard_error,
            freedom,
            missed,
        })
    }

    /// The ratio: above 1, A is the worse one.
    pub fn value(&self) -> f64 {
        self.log.exp()
    }

    /// Where the true ratio is with that probability (bands of 95 % were measured to hold 93 to 97 of 100); all numbers where the tails are too heavy.
    pub fn interval(&self, confidence: f64) -> [f64; 2] {
        let student = StudentsT::new(0.0, 1.0, self.freedom).ok().filter(|_| self.freedom >= Self::LEAST_FREEDOM);
        let Some(student) = student else { return [0.0, f64::INFINITY] };
        let half = student.inverse_cdf(0.5 + confidence / 2.0) * self.standard_error;
        let [a, b] = self.missed;
        [self.log - half - b, self.log + half + a].map(f64::exp)
    }

    /// Whether the data say which of the two is the worse one.
    pub fn is_distinguishable(&self) -> bool {
        let [low, high] = self.interval(Self::CONFIDENCE);
        low > 1.0 || high < 1.0
    }

    /// What is sure of it, for people, to follow a colon: "A is 2.3 × less noisy here (1.9 to 2.7)" or "A has 2.3 × less squared error here (1.9 to
    /// 2.7)", the band being that of 95 %.
    pub fn sentence(&self) -> String {
        let [low, high] = self.interval(0.95);
        if !self.is_distinguishable() {
            return if self.freedom < Self::LEAST_FREEDOM {
                "not distinguishable yet: a few bright samples decide".to_owned()
            } else {
                format!("not distinguishable yet (A over B: {} to {})", short(low), short(high))
            };
        }
        let (name, ratio, [low, high]) = if self.log < 0.0 {
            ("A", 1.0 / self.value(), [1.0 / high, 1.0 / low])
        } else {
            ("B", self.value(), [low, high])
        };
        let (ratio, low, high) = (short(ratio), short(low), short(high));
        match self.compared {
            Compared::Noise => format!("{name} is {ratio} \u{d7} less noisy here ({low} to {high})"),
            Compared::Errors => format!("{name} has {ratio} \u{d7} less squared error here ({low} to {high})"),
        }
    }
}

/// Two digits, or all before the point.
fn short(value: f64) -> String {
    if value < 10.0 { format!("{value:.1}") } else { format!("{value:.0}") }
}

/// 1 over the squared mean of both pictures, of each block of the plane; infinite where nothing has been hit.
fn block_weights(a: &[f32], b: &[f32], width: usize) -> Vec<f64> {
    let across = width.div_ceil(BLOCK);
    let rows = a.len().div_ceil(width.max(1));
    let mut sums = vec![[0.0, 0.0]; across * rows.div_ceil(BLOCK)];
    for (pixel, (a, b)) in a.iter().zip(b).enumerate() {
        let both = f64::from(*a) + f64::from(*b);
        let [sum, count] = &mut sums[pixel / width / BLOCK * across + pixel % width / BLOCK];
        if both.is_finite() {
            *sum += both;
            *count += 2.0;
        }
    }
    sums.iter().map(|[sum, count]| (count / sum).powi(2)).collect()
}
