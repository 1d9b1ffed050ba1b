//! Where the picture lies in the viewport: zoom and pan.

use eframe::egui::{Pos2, Rect, Vec2, pos2};
use serde::{Deserialize, Serialize};

/// Where the picture lies in the viewport.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Placement {
    /// As large as it fits, centred.
    #[default]
    Fit,
    /// A part of the image as large as it fits, centred: its corners, in pixels.
    Part([[f32; 2]; 2]),
    /// At a scale of the user's own.
    Free {
        /// Physical screen pixels per image pixel.
        scale: f32,
        /// The point of the full image, in pixels, at the centre of the viewport.
        centre: [f32; 2],
    },
}

impl Placement {
    /// The smallest scale, physical pixels per image pixel.
    pub const MIN_SCALE: f32 = 1.0 / 512.0;
    /// The largest scale.
    pub const MAX_SCALE: f32 = 256.0;

    /// Width over height of what fills the viewport as far as it can, of an image of that size.
    pub fn aspect(&self, image: [u32; 2]) -> f32 {
        let [w, h] = match *self {
            Self::Part([min, max]) => [0, 1].map(|i| (max[i] - min[i]).max(1.0)),
            Self::Fit | Self::Free { .. } => image.map(|n| n.max(1) as f32),
        };
        w / h
    }

    /// The same part of the same picture in another resolution, `to` instead of `from` pixels: what is seen stays.
    pub fn scaled(self, from: [u32; 2], to: [u32; 2]) -> Self {
        let [kx, ky] = [0, 1].map(|i| to[i].max(1) as f32 / from[i].max(1) as f32);
        let point = |[x, y]: [f32; 2]| [x * kx, y * ky];
        match self {
            _ if from == to => self,
            Self::Fit => Self::Fit,
            Self::Part(corners) => Self::Part(corners.map(point)),
            Self::Free { scale, centre } => Self::Free { scale: scale / kx, centre: point(centre) },
        }
    }

    /// Fit the picture into the viewport (F).
    pub fn fit(&mut self) {
        *self = Self::Fit;
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
        *self = Self::Free { scale, centre };
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
            Placement::Part([min, max]) => {
                let part = [0, 1].map(|i| (max[i] - min[i]).max(1.0));
                let scale = (size.x / part[0]).min(size.y / part[1]);
                (scale, [0, 1].map(|i| (0.5 * (min[i] + max[i])).clamp(0.0, [w, h][i])))
            }
            Placement::Free { scale, centre } => (scale, [0, 1].map(|i| centre[i].clamp(0.0, [w, h][i]))),
        };
        // Stored state may hold anything, and `clamp` keeps a NaN.
        let scale = if scale.is_finite() { scale.clamp(Placement::MIN_SCALE, Placement::MAX_SCALE) } else { 1.0 };
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
