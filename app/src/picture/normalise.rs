//! Exposure and range set from the picture, once, in plain sight (N).

use crate::look::layer::{Colouring, LayerLook};
use crate::picture::planes::Planes;
use crate::state::view::ViewState;

/// Sets the range of what is shown by the data. Colour layers: 99 % of the pixels come out below white, without offset.
/// Variance: whole decades that hold 98 % of the pixels. Shares keep their range of 0 to 1. Without a usable number
/// nothing changes.
pub fn normalise(view: &mut ViewState, planes: &Planes) {
    let channels: Vec<&[f32]> = planes.channels().collect();
    let pixels = 0..channels.first().map_or(0, |plane| plane.len());
    let mut largest: Vec<f32> = pixels
        .map(|i| channels.iter().map(|plane| plane[i]).fold(0.0, f32::max))
        .filter(|v| v.is_finite() && *v > 0.0)
        .collect();
    largest.sort_unstable_by(f32::total_cmp);
    let Some(last) = largest.len().checked_sub(1) else { return };
    let quantile = |q: f64| largest[(q * last as f64).round() as usize];
    match LayerLook::of(planes.layer()).colouring {
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
        Colouring::Share { .. } => {}
    }
}
