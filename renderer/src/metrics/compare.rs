//! Two files compared, channel by channel and layer by layer.

use std::borrow::Cow;

use serde::Serialize;

use super::resample::on_one_grid;
use super::{Errors, Reference, Region};
use crate::error::Error;
use crate::snapshot::{Image, Window, layer_and_component, layers_of};

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

/// How two images of numbers differ. All averages are over the same pixels: those of the common window at which every channel
/// named is finite in both images; `None` (JSON `null`) where there are none.
///
/// Where nothing differs but that values are undefined in one image only, the errors are `None`, too: a 0 would say that the
/// images are alike.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Channel ("light.R") or layer ("light"; "RGB" for the unnamed one).
    pub name: String,
    /// Mean of A.
    pub mean_a: Option<f64>,
    /// Mean of B.
    pub mean_b: Option<f64>,
    /// Mean of `(a - b)^2`.
    pub mse: Option<f64>,
    /// Mean of [`super::rel_mse`], B being the reference.
    pub rel_mse: Option<f64>,
    /// Largest `|a - b|`.
    pub maximum: Option<Maximum>,
    /// Values compared.
    pub compared: u64,
    /// Values undefined alike in both: both NaN, or the same infinity.
    pub both_undefined: u64,
    /// Values undefined in A and not in B.
    pub undefined_in_a: u64,
    /// Values undefined in B and not in A.
    pub undefined_in_b: u64,
    /// Values undefined in both, in different ways.
    pub undefined_differently: u64,
}

/// Two pictures compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// The pixels compared: those that both hold.
    pub window: Window,
    /// Size of the grid that both were resampled to; `None` if they are as they were.
    pub resampled: Option<[u32; 2]>,
    /// The pixels of A, before that.
    pub window_a: Window,
    /// The pixels of B, before that.
    pub window_b: Window,
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
    /// There are the same channels with the same values in the pixels that both hold, undefined ones included.
    pub fn is_identical(&self) -> bool {
        let same = |d: &Difference| d.undefined_mismatch() == 0 && d.maximum.is_none_or(|m| m.value == 0.0);
        self.only_in_a.is_empty() && self.only_in_b.is_empty() && self.channels.iter().all(same)
    }
}

impl Difference {
    /// Values undefined in one image only, or in different ways.
    pub fn undefined_mismatch(&self) -> u64 {
        self.undefined_in_a + self.undefined_in_b + self.undefined_differently
    }
}

/// Compares A with the reference B, per channel and per layer, in the pixels that both hold: a crop with the full picture, too.
///
/// # Errors
/// [`Error::Invalid`] if they are not of the same image (display window), hold no pixel in common, or share no channel.
pub fn compare(a: &Image, b: &Image) -> Result<Comparison, Error> {
    if a.display != b.display {
        let message = "expected parts of the same image (the same display window); --resample compares other sizes";
        return Err(Error::Invalid(format!("A is of an image of {}, B of {}: {message}", a.display, b.display)));
    }
    let window = a.window.common(&b.window).ok_or_else(|| {
        let message = "expected pixels that both hold";
        Error::Invalid(format!("A holds {}, B holds {}: {message}", a.window, b.window))
    })?;
    let missing = |from: &Image, of: &Image| -> Vec<String> {
        of.channels.iter().filter(|(name, _)| values(from, name).is_none()).map(|(name, _)| name.clone()).collect()
    };
    let common: Vec<Common<'_>> = a
        .channels
        .iter()
        .filter_map(|(name, in_a)| Some((name.as_str(), a.part(in_a, window), b.part(values(b, name)?, window))))
        .collect();
    if common.is_empty() {
        return Err(Error::Invalid(format!("no common channel: A has {}, B has {}", names(a), names(b))));
    }
    let differ = |name: &str, channels: &[usize]| {
        let of_a: Vec<&[f32]> = channels.iter().map(|&c| &*common[c].1).collect();
        let of_b: Vec<&[f32]> = channels.iter().map(|&c| &*common[c].2).collect();
        difference(&Errors::of(&of_a, &Reference::Exact(&of_b), &Region::All), name.to_owned(), window)
    };
    let layers = layers_of(common.iter().map(|(name, ..)| *name));
    Ok(Comparison {
        window,
        resampled: None,
        window_a: a.window,
        window_b: b.window,
        layers: layers.iter().map(|layer| differ(&layer.name, &layer.channels)).collect(),
        channels: common.iter().enumerate().map(|(c, (name, ..))| differ(name, &[c])).collect(),
        only_in_a: missing(b, a),
        only_in_b: missing(a, b),
    })
}

/// The same for pictures of different sizes: both on the coarser grid, every pixel the mean over its area.
///
/// # Errors
/// [`Error::Invalid`] if the images differ in shape, hold no pixel in common, or share no channel.
pub fn compare_resampled(a: &Image, b: &Image) -> Result<Comparison, Error> {
    if a.display.size == b.display.size {
        return compare(a, b);
    }
    let [on_grid_a, on_grid_b] = on_one_grid(a, b)?;
    let comparison = compare(&on_grid_a, &on_grid_b)?;
    Ok(Comparison { resampled: Some(on_grid_a.display.size), window_a: a.window, window_b: b.window, ..comparison })
}

/// A channel that both have: its name in A, its values in A and in B.
type Common<'a> = (&'a str, Cow<'a, [f32]>, Cow<'a, [f32]>);

/// The values of a channel under this name, or under another that means the same: "R" and ".R".
fn values<'a>(image: &'a Image, name: &str) -> Option<&'a [f32]> {
    let means_the_same = |(other, _): &&(String, Vec<f32>)| layer_and_component(other) == layer_and_component(name);
    image.channel(name).or_else(|| image.channels.iter().find(means_the_same).map(|(_, values)| values.as_slice()))
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
    // A difference of 0 is said of pictures that are alike, not of those of which one has holes.
    let told = errors.undefined_mismatch() == 0 || errors.maximum.is_some_and(|(largest, _)| largest > 0.0);
    Difference {
        name,
        mean_a: errors.mean(),
        mean_b: errors.reference_mean(),
        mse: errors.mse().filter(|_| told),
        rel_mse: errors.rel_mse().filter(|_| told),
        maximum: errors.maximum.filter(|_| told).map(place),
        compared: errors.compared,
        both_undefined: errors.both_undefined,
        undefined_in_a: errors.undefined_in_picture,
        undefined_in_b: errors.undefined_in_reference,
        undefined_differently: errors.undefined_differently,
    }
}
