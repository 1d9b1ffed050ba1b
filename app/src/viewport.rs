//! The picture on screen.

use std::sync::Arc;

use eframe::egui::{self, Color32, Rect};
use eframe::egui_wgpu;
use mislab_renderer::Frame;

pub use crate::view_state::Geometry;
use crate::view_state::ViewState;

/// One picture on screen.
pub struct Viewport {}

/// What a pass over the viewport found.
pub struct ViewportResponse {
    /// Of the whole viewport, surround included.
    pub response: egui::Response,
    /// The pixel under the pointer, in coordinates of the full image; inside the frame's bounds only.
    pub hovered_pixel: Option<[u32; 2]>,
    /// Where the picture lies; `None` without a frame.
    pub geometry: Option<Geometry>,
}

impl Viewport {
    /// A viewport on that device, or on the CPU.
    pub fn new(render_state: Option<&egui_wgpu::RenderState>) -> Self {
        let _ = render_state;
        unimplemented!()
    }

    /// Draws the picture over all that is left of `ui`.
    pub fn ui(
        &mut self,
        ui: &mut egui::Ui,
        view: &mut ViewState,
        frame: Option<&Arc<Frame>>,
        stale: bool,
        dark: bool,
    ) -> ViewportResponse {
        let _ = (ui, view, frame, stale, dark);
        unimplemented!()
    }
}

/// The neutral grey round the picture.
pub fn surround(dark: bool) -> Color32 {
    Color32::from_gray(if dark { 38 } else { 208 })
}

/// Colour bar.
pub fn legend_ui(ui: &mut egui::Ui, view: &ViewState, dark: bool) -> egui::Response {
    let _ = (ui, view, dark);
    unimplemented!()
}

/// The legend in the corner of the viewport.
pub fn legend_overlay(ui: &mut egui::Ui, viewport: Rect, view: &ViewState, dark: bool) {
    let _ = (ui, viewport, view, dark);
    unimplemented!()
}

/// The picture as it is shown, at one pixel per pixel.
pub fn render_to_rgba8(frame: &Frame, view: &ViewState, dark: bool) -> (u32, u32, Vec<u8>) {
    let _ = (frame, view, dark);
    unimplemented!()
}
