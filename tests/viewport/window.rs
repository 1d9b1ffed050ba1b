//! A window with nothing but the viewport.

use std::sync::Arc;

use eframe::egui;
use egui_kittest::Harness;
use mislab::look::layer::{Colouring, LayerLook, Quantity};
use mislab::picture::film_texture::FilmPipeline;
use mislab::picture::legend::{Key, legend_overlay};
use mislab::picture::planes::{BLIND, Planes, UNHIT, UNLIT};
use mislab::picture::viewport::{Shown, Viewport, ViewportResponse};
use mislab::state::placement::Geometry;
use mislab::state::view::ViewState;
use mislab_renderer::{Layer, PixelRect};

pub const SIZE: [u32; 2] = [96, 64];

/// A window with nothing but the viewport; `on_gpu` says which of the two ways draws.
pub struct App {
    pub gpu: Viewport,
    pub cpu: Viewport,
    pub on_gpu: bool,
    pub layer: Quantity,
    pub view: ViewState,
    pub planes: Option<Arc<Planes>>,
    pub stale: bool,
    pub dark: bool,
    pub legend: bool,
    pub here: Option<f32>,
    last: Option<ViewportResponse>,
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        let Self { gpu, cpu, on_gpu, layer, view, planes, stale, dark, legend, here, last } = self;
        ui.ctx().set_theme(if *dark { egui::Theme::Dark } else { egui::Theme::Light });
        let viewport = if *on_gpu { gpu } else { cpu };
        let shown = viewport.ui(
            ui,
            view,
            Shown { quantity: *layer, planes: planes.as_ref(), stale: stale.then_some("previous settings") },
        );
        if *legend {
            let rect = shown.response.rect;
            legend_overlay(ui, rect, rect, Key { quantity: *layer, view, here: *here });
        }
        *last = Some(shown);
    }
}

impl App {
    pub fn new(render_state: Option<&eframe::egui_wgpu::RenderState>, layer: Layer) -> Self {
        Self {
            gpu: Viewport::new(render_state.and_then(FilmPipeline::new)),
            cpu: Viewport::new(None),
            on_gpu: render_state.is_some(),
            layer: layer.into(),
            view: ViewState::default(),
            planes: Some(Arc::new(synthetic(layer))),
            stale: false,
            dark: true,
            legend: false,
            here: None,
            last: None,
        }
    }

    pub fn show(&mut self, quantity: impl Into<Quantity>) {
        self.layer = quantity.into();
        self.planes = Some(Arc::new(synthetic(self.layer)));
    }

    pub fn geometry(&self) -> Geometry {
        self.last.as_ref().and_then(|last| last.geometry).expect("a picture is shown")
    }

    pub fn hovered(&self) -> Option<[u32; 2]> {
        self.last.as_ref().and_then(|last| last.hovered_pixel)
    }
}

/// A window that is really drawn.
pub fn drawn(size: [f32; 2], pixels_per_point: f32) -> Harness<'static, App> {
    let mut harness = Harness::builder()
        .with_size(egui::Vec2::from(size))
        .with_pixels_per_point(pixels_per_point)
        .with_render_cursor(false)
        .wgpu()
        .build_eframe(|cc| App::new(cc.wgpu_render_state.as_ref(), Layer::Picture));
    assert!(harness.state().gpu.on_gpu(), "the device refuses the shader");
    harness.run();
    harness
}

/// A window of which only the logic runs.
pub fn undrawn(size: [f32; 2]) -> Harness<'static, App> {
    let mut harness = Harness::builder()
        .with_size(egui::Vec2::from(size))
        // Two clicks of two steps each within the time of a double click.
        .with_step_dt(1.0 / 60.0)
        .with_max_steps(64)
        .build_eframe(|cc| App::new(cc.wgpu_render_state.as_ref(), Layer::Picture));
    harness.run();
    harness
}

/// Numbers over the whole range of a layer and beyond: exponential or linear from left to right, a blotch of
/// every kind of number that needs care in the lowest rows.
pub fn synthetic(quantity: impl Into<Quantity>) -> Planes {
    let quantity = quantity.into();
    let [w, h] = SIZE;
    let special =
        [0.0, -0.0, 1.0, 1.0005, -0.0005, 1.1, -0.2, f32::NAN, f32::INFINITY, BLIND, UNHIT, UNLIT, 1e-40, 3e38];
    let mut data = Vec::new();
    for channel in 0..quantity.channels() {
        for y in 0..h {
            for x in 0..w {
                let t = (x as f32 + 0.37 * y as f32 / h as f32) / w as f32;
                data.push(if y >= h - 8 {
                    special[x as usize * special.len() / w as usize]
                } else {
                    match LayerLook::of(quantity).colouring {
                        Colouring::Radiance => {
                            let tint = 1.0 - 0.3 * channel as f32 * y as f32 / h as f32;
                            (20.0 * t - 12.0).exp2() * tint
                        }
                        Colouring::Magnitude => 10_f32.powf(8.0 * t - 5.0),
                        // Beyond the range of ratios on either side, and through that of differences in the middle.
                        Colouring::Signed => 8.0 * t - 4.0,
                        Colouring::Share { .. } => t,
                    }
                });
            }
        }
    }
    Planes::new(quantity, PixelRect { min: [0, 0], max: SIZE }, SIZE, data)
}
