//! Two files compared, channel by channel and layer by layer.

use serde::Serialize;

use super::{Errors, Reference, Region};
use crate::error::Error;
use crate::snapshot::{Image, Window};

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
    /// Mean of [`super::rel_mse`], B being the reference.
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
    /// There are the same channels with the same values, undefined ones included.
    pub fn is_identical(&self) -> bool {
        let same = |d: &Difference| d.undefined_mismatch == 0 && d.maximum.is_none_or(|m| m.value == 0.0);
        self.only_in_a.is_empty() && self.only_in_b.is_empty() && self.channels.iter().all(same)
    }
}

/// Compares A with the reference B, per channel and per layer.
///
/// # Errors
/// [`Error::Invalid`] if they do not hold the same pixels or share no channel.
pub fn compare(a: &Image, b: &Image) -> Result<Comparison, Error> {
    if a.window != b.window {
        return Err(Error::Invalid(format!("A holds {}, B holds {}: expected the same pixels", a.window, b.window)));
    }
    let missing = |from: &Image, of: &Image| -> Vec<String> {
        of.channels.iter().filter(|(name, _)| from.channel(name).is_none()).map(|(name, _)| name.clone()).collect()
    };
    let mut layers: Vec<(String, Errors)> = Vec::new();
    let mut channels = Vec::new();
    for (name, values_a) in &a.channels {
        let Some(values_b) = b.channel(name) else { continue };
        let errors = Errors::of(&[values_a], &Reference::Exact(&[values_b]), &Region::All);
        channels.push(difference(&errors, name.clone(), a.window));
        let layer = layer_of(name);
        match layers.iter_mut().find(|(name, _)| name == layer) {
            Some((_, total)) => total.merge(&errors),
            None => layers.push((layer.to_owned(), errors)),
        }
    }
    if channels.is_empty() {
        return Err(Error::Invalid(format!("no common channel: A has {}, B has {}", names(a), names(b))));
    }
    layers.sort_by(|x, y| (x.0 != DEFAULT_LAYER, &x.0).cmp(&(y.0 != DEFAULT_LAYER, &y.0)));
    Ok(Comparison {
        window: a.window,
        layers: layers.into_iter().map(|(name, errors)| difference(&errors, name, a.window)).collect(),
        channels,
        only_in_a: missing(b, a),
        only_in_b: missing(a, b),
    })
}

/// What the layer of the channels without a dot is called.
const DEFAULT_LAYER: &str = "RGB";

/// "light.R" is in "light", "a.b.R" in "a.b", "R" in the default layer.
fn layer_of(channel: &str) -> &str {
    channel.rsplit_once('.').map_or(DEFAULT_LAYER, |(layer, _)| layer)
}

fn names(image: &Image) -> String {
    image.channels.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(" ")
}

fn difference(errors: &Errors, name: String, window: Window) -> Difference {
    let width = window.size[0] as usize;
    let place = |(value, i): (f64, usize)| Maximum {
        value,
        x: window.min[0] + (i % width) as i32,
        y: window.min[1] + (i / width) as i32,
    };
    Difference {
        name,
        mean_a: errors.mean(),
        mean_b: errors.reference_mean(),
        mse: errors.mse(),
        rel_mse: errors.rel_mse(),
        maximum: errors.maximum.map(place),
        compared: errors.compared,
        both_undefined: errors.both_undefined,
        undefined_mismatch: errors.undefined_mismatch,
    }
}
