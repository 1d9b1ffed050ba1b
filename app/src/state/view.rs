//! How pictures are looked at: exposure, tone map, false-colour range, zoom.
//!
//! Nothing here ever reaches the renderer: every change is a shader uniform, not a new picture.

use mislab_renderer::Layer;
use serde::{Deserialize, Serialize};

use super::placement::Placement;
use crate::look::layer::by_key;

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
            variance_range: Self::DEFAULT_VARIANCE_RANGE,
            placement: Placement::Fit,
        }
    }
}

impl ViewState {
    /// Six decades about a variance of 0.1.
    pub const DEFAULT_VARIANCE_RANGE: [f32; 2] = [-4.0, 2.0];
    /// Exposure beyond this many stops either way is taken as this.
    pub const MAX_EV: f32 = 20.0;

    /// Exposure, offset, tone map and variance range as they were at the start (R). Zoom stays.
    pub fn reset_display(&mut self) {
        let Self { placement: _, exposure_ev, offset, tone_map, mark_clipped, variance_range } = self;
        let default = Self::default();
        *exposure_ev = default.exposure_ev;
        *offset = default.offset;
        *tone_map = default.tone_map;
        *mark_clipped = default.mark_clipped;
        *variance_range = default.variance_range;
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
