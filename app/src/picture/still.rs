//! A picture as it is shown, pixel by pixel, apart from any window: for files and the clipboard.

use eframe::egui::{Pos2, Rect, vec2};
use mislab_renderer::blind::dark_pixels;
use mislab_renderer::{Frame, Layer};

use crate::look::layer::LayerLook;
use crate::picture::planes::Planes;
use crate::picture::tone::{self, Uniforms};
use crate::state::placement::Geometry;
use crate::state::view::ViewState;

/// The pixels of a layer of the frame as `view` shows them at 100 %, zoom and pan left out: width, height, RGBA8 rows
/// from the top left.
pub fn render_to_rgba8(frame: &Frame, layer: Layer, view: &ViewState, dark: bool) -> (u32, u32, Vec<u8>) {
    // Programs that compare colours want no hatching in them.
    let dark_pixels = (!LayerLook::of(layer).is_colour()).then(|| dark_pixels(frame.request()));
    planes_to_rgba8(&Planes::shown(frame, layer, view.variance_unit, dark_pixels.as_deref()), view, dark)
}

/// [`render_to_rgba8`] for numbers that come from elsewhere than a frame.
pub fn planes_to_rgba8(planes: &Planes, view: &ViewState, dark: bool) -> (u32, u32, Vec<u8>) {
    let bounds = planes.bounds();
    let (width, height) = (bounds.width(), bounds.height());
    let corner = bounds.min.map(|v| v as f32);
    let geometry = Geometry {
        viewport: Rect::from_min_size(Pos2::ZERO, vec2(width as f32, height as f32)),
        image: planes.image(),
        scale: 1.0,
        centre: [corner[0] + width as f32 / 2.0, corner[1] + height as f32 / 2.0],
        origin: corner.map(|v| -v),
        pixels_per_point: 1.0,
    };
    let uniforms = Uniforms::new(planes, view, &geometry, dark);
    (width, height, tone::render(planes, &uniforms, [width as usize, height as usize]))
}
