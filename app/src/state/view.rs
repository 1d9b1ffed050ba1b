//! How pictures are looked at: exposure, tone map, false-colour range, zoom.
//!
//! Nothing here ever reaches the renderer: every change is a shader uniform, not a new picture.

use mislab_renderer::Layer;
use serde::{Deserialize, Serialize};

use super::placement::Placement;
use crate::look::layer::by_key;
use crate::look::versus::Versus;

/// From scene-linear light to the screen, after exposure and offset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ToneMap {
    /// Clipped to [0, 1] and sent to the display as it is, without encoding.
    Linear,
    /// Clipped to [0, 1], then the sRGB transfer function: light on screen proportional to radiance.
    #[default]
    SrgbClip,
    /// Narkowicz's fit of the ACES curve, then the sRGB transfer function.
    Filmic,
}

impl ToneMap {
    /// All tone maps, in the order shown to users.
    pub const ALL: [Self; 3] = [Self::Linear, Self::SrgbClip, Self::Filmic];

    /// The name on screen.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "Linear",
            Self::SrgbClip => "sRGB",
            Self::Filmic => "Filmic",
        }
    }

    /// What it does, in one line.
    pub fn description(self) -> &'static str {
        match self {
            Self::Linear => "values straight to the display, clipped at 1, not encoded",
            Self::SrgbClip => "clipped at 1, sRGB encoding: true proportions up to white",
            Self::Filmic => "film-like shoulder (ACES fit by Narkowicz), sRGB encoding",
        }
    }

    /// The next one, the first after the last.
    pub fn next(self) -> Self {
        match self {
            Self::Linear => Self::SrgbClip,
            Self::SrgbClip => Self::Filmic,
            Self::Filmic => Self::Linear,
        }
    }
}

/// In what unit the variance of a pixel is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum VarianceUnit {
    /// Of the luminance of one sample: radiance squared.
    OneSample,
    /// The same over the square of the mean: 1 is noise as large as the picture.
    Relative,
    /// Relative, times the rays that a sample costs.
    #[default]
    PerRay,
    /// Relative, times the seconds of processor time that a sample of every pixel costs.
    PerSecond,
}

impl VarianceUnit {
    /// All of them, in the order shown to users.
    pub const ALL: [Self; 4] = [Self::OneSample, Self::Relative, Self::PerRay, Self::PerSecond];

    /// The name on a button.
    pub fn name(self) -> &'static str {
        match self {
            Self::OneSample => "sample",
            Self::Relative => "relative",
            Self::PerRay => "per ray",
            Self::PerSecond => "per s",
        }
    }

    /// What the numbers are, over their legend.
    pub fn title(self) -> &'static str {
        match self {
            Self::OneSample => "Variance of one sample",
            Self::Relative => "Variance over mean\u{b2}",
            Self::PerRay => "Variance over mean\u{b2}, per ray",
            Self::PerSecond => "Variance over mean\u{b2}, per second",
        }
    }

    /// What they tell, in one sentence.
    pub fn description(self) -> &'static str {
        match self {
            Self::OneSample => "Variance of the luminance of one sample, in radiance squared.",
            Self::Relative => {
                "The same over the square of the mean: comparable between dark and bright. At 1 one sample has as much noise as light."
            }
            Self::PerRay => {
                "Relative, times the rays of a sample: what is left after one ray. \u{201c}MIS, both\u{201d} pays for two."
            }
            Self::PerSecond => {
                "Relative, times the processor time of a pass: what is left after one second over the whole picture."
            }
        }
    }

    /// Ends of the colour bar, as log10, for pictures of usual scenes.
    pub fn default_range(self) -> [f32; 2] {
        match self {
            Self::OneSample => ViewState::DEFAULT_VARIANCE_RANGE,
            Self::Relative | Self::PerRay => [-2.0, 4.0],
            Self::PerSecond => [-4.0, 2.0],
        }
    }
}

/// How all pictures of the window are looked at.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ViewState {
    /// Exposure of the colour layers in stops: radiance is multiplied by 2^EV.
    pub exposure_ev: f32,
    /// Added to the colour layers after exposure.
    pub offset: f32,
    /// For the colour layers.
    pub tone_map: ToneMap,
    /// Pixels that the tone map shows as white whatever their number are striped.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub mark_clipped: bool,
    /// log10 of the variance at the two ends of the colour bar, the lower first.
    pub variance_range: [f32; 2],
    /// What it is counted in.
    pub variance_unit: VarianceUnit,
    /// What of two pictures is shown.
    pub versus: Versus,
    /// Radiance at the upper end of the colour bar of a difference.
    pub difference_range: f32,
    /// Zoom and pan.
    pub placement: Placement,
}

impl Default for ViewState {
    fn default() -> Self {
        Self {
            exposure_ev: 0.0,
            offset: 0.0,
            tone_map: ToneMap::default(),
            mark_clipped: false,
            variance_range: VarianceUnit::default().default_range(),
            variance_unit: VarianceUnit::default(),
            versus: Versus::default(),
            difference_range: Self::DEFAULT_DIFFERENCE_RANGE,
            placement: Placement::Fit,
        }
    }
}

impl ViewState {
    /// Six decades about a variance of 0.1 of one sample.
    pub const DEFAULT_VARIANCE_RANGE: [f32; 2] = [-4.0, 2.0];
    /// Bright plates of usual scenes have a radiance about 1.
    pub const DEFAULT_DIFFERENCE_RANGE: f32 = 0.5;
    /// Exposure beyond this many stops either way is taken as this.
    pub const MAX_EV: f32 = 20.0;

    /// Exposure, offset, tone map, unit and range of the variance as they were at the start (R). Zoom stays.
    pub fn reset_display(&mut self) {
        let Self {
            placement: _,
            versus: _,
            exposure_ev,
            offset,
            tone_map,
            mark_clipped,
            variance_range,
            variance_unit,
            difference_range,
        } = self;
        let default = Self::default();
        *exposure_ev = default.exposure_ev;
        *offset = default.offset;
        *tone_map = default.tone_map;
        *mark_clipped = default.mark_clipped;
        *variance_range = default.variance_range;
        *variance_unit = default.variance_unit;
        *difference_range = default.difference_range;
    }
}

/// How one picture was looked at, as it is stored beside it: one flat object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct StoredView {
    /// The layer shown.
    #[serde(with = "by_key")]
    pub layer: Layer,
    /// What all pictures had in common.
    #[serde(flatten)]
    pub view: ViewState,
}

impl Default for StoredView {
    fn default() -> Self {
        Self { layer: Layer::Picture, view: ViewState::default() }
    }
}
