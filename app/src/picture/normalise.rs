//! Exposure and range set from the picture, once, in plain sight (N).

use crate::look::layer::{Colouring, LayerLook, Quantity};
use crate::look::versus::Versus;
use crate::picture::planes::{Planes, UNLIT};
use crate::state::view::ViewState;

/// Sets the range of what is shown by the data. Colour layers: 99 % of the pixels come out below white, without offset.
/// Variance: whole decades that hold 98 % of the pixels. Shares keep their range of 0 to 1. Without a usable number
/// nothing changes.
pub fn normalise(view: &mut ViewState, planes: &Planes) {
    if planes.quantity() == Quantity::Versus(Versus::Difference) {
        if let Some(size) = quantity_size(planes) {
            // One digit: what stands under the bar is what is used.
            let decade = 10_f32.powf(size.log10().floor());
            view.difference_range = (size / decade).ceil() * decade;
        }
        return;
    }
    let channels: Vec<&[f32]> = planes.channels().collect();
    let pixels = 0..channels.first().map_or(0, |plane| plane.len());
    let mut largest: Vec<f32> = pixels
        .map(|i| channels.iter().map(|plane| plane[i]).fold(0.0, f32::max))
        .filter(|v| v.is_finite() && *v > 0.0)
        .collect();
    largest.sort_unstable_by(f32::total_cmp);
    let Some(last) = largest.len().checked_sub(1) else { return };
    let quantile = |q: f64| largest[(q * last as f64).round() as usize];
    match LayerLook::of(planes.quantity()).colouring {
        Colouring::Radiance => {
            // Tenths of a stop, downwards: what the status shows is what is used.
            let stops = (-quantile(0.99).log2() * 10.0).floor() / 10.0;
            view.exposure_ev = stops.clamp(-ViewState::MAX_EV, ViewState::MAX_EV);
            view.offset = 0.0;
        }
        Colouring::Magnitude => {
            let low = quantile(0.01).log10().floor();
            view.variance_range = [low, quantile(0.99).log10().ceil().max(low + 1.0)];
        }
        Colouring::Share { .. } | Colouring::Signed => {}
    }
}

/// What 98 % of the sizes of signed numbers stay below; at least a millionth.
fn quantity_size(planes: &Planes) -> Option<f32> {
    let sizes = planes.channels().flatten().map(|v| v.abs()).filter(|v| v.is_finite() && *v < -UNLIT);
    let mut sizes: Vec<f32> = sizes.collect();
    sizes.sort_unstable_by(f32::total_cmp);
    let last = sizes.len().saturating_sub(1);
    sizes.get((0.98 * last as f64) as usize).map(|size| size.max(1e-6))
}
