//! How a picture is looked at: layer, exposure, tone map, false-colour range, zoom.
//!
//! Nothing here ever reaches the renderer: every change is a shader uniform, not a new picture.

use eframe::egui::{Pos2, Rect, Vec2, pos2};
use mislab_renderer::{Frame, Layer};
use serde::{Deserialize, Serialize};

use crate::look::layer::{Colouring, LayerLook, by_key};
use crate::picture::film_texture::Planes;

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

/// Where the picture lies in the viewport.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Placement {
    /// As large as it fits, centred.
    #[default]
    Fit,
    /// At a scale of the user's own.
    Free {
        /// Physical screen pixels per image pixel.
        scale: f32,
        /// The point of the full image, in pixels, at the centre of the viewport.
        centre: [f32; 2],
    },
}

/// How one picture is looked at.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ViewState {
    /// What is shown.
    #[serde(with = "by_key")]
    pub layer: Layer,
    /// Exposure of the colour layers in stops: radiance is multiplied by 2^EV.
    pub exposure_ev: f32,
    /// Added to the colour layers after exposure.
    pub offset: f32,
    /// For the colour layers.
    pub tone_map: ToneMap,
    /// log10 of the variance at the two ends of the colour bar, the lower first.
    pub variance_range: [f32; 2],
    /// Zoom and pan.
    pub placement: Placement,
}

impl Default for ViewState {
    fn default() -> Self {
        Self {
            layer: Layer::Picture,
            exposure_ev: 0.0,
            offset: 0.0,
            tone_map: ToneMap::default(),
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
    /// The smallest scale, physical pixels per image pixel.
    pub const MIN_SCALE: f32 = 1.0 / 512.0;
    /// The largest scale.
    pub const MAX_SCALE: f32 = 256.0;

    /// Fit the picture into the viewport (F).
    pub fn fit(&mut self) {
        self.placement = Placement::Fit;
    }

    /// One image pixel to one physical screen pixel (Ctrl+0); what is at the centre stays there.
    pub fn actual_size(&mut self, geometry: &Geometry) {
        self.place(geometry, 1.0, geometry.centre, Vec2::ZERO);
    }

    /// Magnifies by `factor`; what lies under `screen` stays there.
    pub fn zoom_about(&mut self, geometry: &Geometry, screen: Pos2, factor: f32) {
        if !(factor.is_finite() && factor > 0.0) {
            return;
        }
        let scale = (geometry.scale * factor).clamp(Self::MIN_SCALE, Self::MAX_SCALE);
        // From the exact centre, not from the rounded origin: many small steps must not drift.
        let from_centre = (screen - geometry.viewport.center()) * geometry.pixels_per_point;
        let fixed = [0, 1].map(|i| geometry.centre[i] + from_centre[i] / geometry.scale);
        self.place(geometry, scale, fixed, from_centre);
    }

    /// Moves the picture by `delta` points.
    pub fn pan_by(&mut self, geometry: &Geometry, delta: Vec2) {
        self.place(geometry, geometry.scale, geometry.centre, delta * geometry.pixels_per_point);
    }

    /// Puts the image point `fixed` at `from_centre` physical pixels from the centre of the viewport.
    fn place(&mut self, geometry: &Geometry, scale: f32, fixed: [f32; 2], from_centre: Vec2) {
        let centre = [0, 1].map(|i| (fixed[i] - from_centre[i] / scale).clamp(0.0, geometry.image[i] as f32));
        self.placement = Placement::Free { scale, centre };
    }

    /// Sets the range of what is shown by the data (N). Colour layers: 99 % of the pixels come out below white,
    /// without offset. Variance: whole decades that hold 98 % of the pixels. Weights keep their range of 0 to 1.
    pub fn normalise(&mut self, frame: &Frame) {
        self.normalise_to(&Planes::from_frame(frame, self.layer));
    }

    /// [`Self::normalise`] by numbers that come from elsewhere than a frame. Without a usable number nothing changes.
    pub fn normalise_to(&mut self, planes: &Planes) {
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
                self.exposure_ev = ((-quantile(0.99).log2() * 10.0).floor() / 10.0).clamp(-Self::MAX_EV, Self::MAX_EV);
                self.offset = 0.0;
            }
            Colouring::Magnitude => {
                let low = quantile(0.01).log10().floor();
                self.variance_range = [low, quantile(0.99).log10().ceil().max(low + 1.0)];
            }
            Colouring::Share { .. } => {}
        }
    }

    /// Exposure, offset, tone map and variance range as they were at the start (R). Layer and zoom stay.
    pub fn reset_display(&mut self) {
        let Self { layer: _, placement: _, exposure_ev, offset, tone_map, variance_range } = self;
        let default = Self::default();
        *exposure_ev = default.exposure_ev;
        *offset = default.offset;
        *tone_map = default.tone_map;
        *variance_range = default.variance_range;
    }
}

/// Where the picture lies on screen in one pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    /// The viewport, in points.
    pub viewport: Rect,
    /// Size of the full image in pixels.
    pub image: [u32; 2],
    /// Physical screen pixels per image pixel.
    pub scale: f32,
    /// The point of the full image, in pixels, asked to be at the centre of the viewport.
    pub centre: [f32; 2],
    /// Top left corner of the full image, in physical screen pixels: whole numbers, so that at 100 %
    /// every screen pixel is one image pixel.
    pub origin: [f32; 2],
    /// Physical screen pixels per point.
    pub pixels_per_point: f32,
}

impl Geometry {
    /// The geometry that `placement` asks for.
    pub fn new(viewport: Rect, image: [u32; 2], placement: Placement, pixels_per_point: f32) -> Self {
        let size = viewport.size() * pixels_per_point;
        let [w, h] = image.map(|n| n.max(1) as f32);
        let middle = viewport.center().to_vec2() * pixels_per_point;
        let (scale, centre) = match placement {
            Placement::Fit => ((size.x / w).min(size.y / h), [w / 2.0, h / 2.0]),
            Placement::Free { scale, centre } => (scale, [0, 1].map(|i| centre[i].clamp(0.0, [w, h][i]))),
        };
        // Stored state may hold anything, and `clamp` keeps a NaN.
        let scale = if scale.is_finite() { scale.clamp(ViewState::MIN_SCALE, ViewState::MAX_SCALE) } else { 1.0 };
        let centre = centre.map(|c| if c.is_finite() { c } else { 0.0 });
        let origin = [(middle.x - centre[0] * scale).round(), (middle.y - centre[1] * scale).round()];
        Self { viewport, image, scale, centre, origin, pixels_per_point }
    }

    /// The full image on screen, in points; it may exceed the viewport.
    pub fn picture_rect(&self) -> Rect {
        let [w, h] = self.image.map(|n| n as f32);
        Rect::from_min_max(self.to_screen([0.0, 0.0]), self.to_screen([w, h]))
    }

    /// From a point of the full image, in pixels, to the screen, in points.
    pub fn to_screen(&self, image: [f32; 2]) -> Pos2 {
        let at = |i: usize| (self.origin[i] + image[i] * self.scale) / self.pixels_per_point;
        pos2(at(0), at(1))
    }

    /// From the screen, in points, to a point of the full image, in pixels.
    pub fn to_image(&self, screen: Pos2) -> [f32; 2] {
        [0, 1].map(|i| (screen[i] * self.pixels_per_point - self.origin[i]) / self.scale)
    }

    /// 100 when one image pixel is one physical screen pixel.
    pub fn zoom_percent(&self) -> f32 {
        100.0 * self.scale
    }
}
