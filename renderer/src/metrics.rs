//! How far two pictures are apart.

use serde::Serialize;

use crate::error::Error;
use crate::snapshot::{Image, Window};

/// The constant in [`rel_mse`]'s denominator: keeps black pixels from counting without bound.
pub const RELMSE_EPSILON: f64 = 1e-2;

/// Relative squared error of one value: `(a - b)^2 / (b^2 + epsilon)`, `b` being the reference
/// (Rousselle et al. 2011; epsilon as in the image viewer tev).
pub fn rel_mse(a: f64, b: f64) -> f64 {
    (a - b) * (a - b) / (b * b + RELMSE_EPSILON)
}

/// The largest difference and where it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Maximum {
    /// `|a - b|`.
    pub value: f64,
    /// Pixel, in the coordinates of the full image.
    pub x: i32,
    /// Pixel, from the top.
    pub y: i32,
}

/// How two images of numbers differ. Averages are over the values that are finite in both images; `None` (JSON `null`)
/// where there are none.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Channel ("light.R") or layer ("light"; "RGB" for the unnamed one).
    pub name: String,
    /// Mean of A, over its finite values.
    pub mean_a: Option<f64>,
    /// Mean of B, over its finite values.
    pub mean_b: Option<f64>,
    /// Mean of `(a - b)^2`.
    pub mse: Option<f64>,
    /// Mean of [`rel_mse`], B being the reference.
    pub rel_mse: Option<f64>,
    /// Largest `|a - b|`.
    pub maximum: Option<Maximum>,
    /// Values finite in both.
    pub compared: u64,
    /// Values undefined alike in both: both NaN, or the same infinity.
    pub both_undefined: u64,
    /// Values undefined in one image only, or in different ways.
    pub undefined_mismatch: u64,
}

/// Two pictures compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// The pixels compared.
    pub window: Window,
    /// Layers, the unnamed one first.
    pub layers: Vec<Difference>,
    /// Channels both have.
    pub channels: Vec<Difference>,
    /// Channels that only A has.
    pub only_in_a: Vec<String>,
    /// Channels that only B has.
    pub only_in_b: Vec<String>,
}

impl Comparison {
    /// Every value is the same and there are the same channels.
    pub fn is_identical(&self) -> bool {
        unimplemented!()
    }
}

/// Compares A with the reference B, per channel and per layer.
///
/// # Errors
/// [`Error::Invalid`] if they do not hold the same pixels or share no channel.
pub fn compare(a: &Image, b: &Image) -> Result<Comparison, Error> {
    let _ = (a, b);
    unimplemented!()
}
