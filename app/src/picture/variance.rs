//! The variance of a pixel in the unit that is asked for.

use mislab_renderer::{Channel, Frame};

use crate::state::view::VarianceUnit;

/// What it takes to work it out: the means of the three colours, and the variance of the luminance of one sample.
pub const CHANNELS: [Channel; 4] = [Channel::R, Channel::G, Channel::B, Channel::VarianceY];

/// What a sample of `frame` costs in the unit: rays, or seconds of processor time for one of every pixel. Numbers without
/// a cost have 1.
pub fn cost(unit: VarianceUnit, frame: &Frame) -> f64 {
    match unit {
        VarianceUnit::OneSample | VarianceUnit::Relative => 1.0,
        VarianceUnit::PerRay => f64::from(frame.request().settings.estimator.strategy.rays_per_sample()),
        VarianceUnit::PerSecond => frame.stats().cpu_seconds / f64::from(frame.spp()),
    }
}

/// Variance of a pixel with these [`CHANNELS`]; `cost` is by [`cost`]. NaN where no sample has carried light yet: that is
/// not a variance of 0.
pub fn in_unit(unit: VarianceUnit, cost: f64, [r, g, b, variance]: [f32; 4]) -> f32 {
    let mean = luminance([r, g, b].map(f64::from));
    if mean == 0.0 {
        return f32::NAN;
    }
    match unit {
        VarianceUnit::OneSample => variance,
        VarianceUnit::Relative | VarianceUnit::PerRay | VarianceUnit::PerSecond => {
            (f64::from(variance) / (mean * mean) * cost) as f32
        }
    }
}

/// The luminance that the renderer's variance is about.
pub fn luminance(rgb: [f64; 3]) -> f64 {
    rgb.iter().zip(mislab_renderer::kernel::film::LUMINANCE).map(|(v, weight)| v * f64::from(weight)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_hit_is_not_no_noise() {
        for unit in VarianceUnit::ALL {
            assert!(in_unit(unit, 2.0, [0.0, 0.0, 0.0, 0.0]).is_nan(), "{unit:?}");
        }
        // A grey of 1/2: the square of its luminance is 1/4.
        let grey = |unit, cost| in_unit(unit, cost, [0.5, 0.5, 0.5, 0.1]);
        assert_eq!(grey(VarianceUnit::OneSample, 1.0), 0.1);
        assert!((grey(VarianceUnit::Relative, 1.0) - 0.4).abs() < 1e-6);
        assert!((grey(VarianceUnit::PerRay, 2.0) - 0.8).abs() < 1e-6, "two rays, twice the variance per ray");
        assert_eq!(in_unit(VarianceUnit::PerRay, 2.0, [0.5, 0.5, 0.5, 0.0]), 0.0, "a lamp that is seen has no noise");
    }
}
