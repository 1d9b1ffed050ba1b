//! The window's own drawing of the toolkit's meshes against the toolkit's.

use std::collections::HashSet;

use eframe::egui::{self, Color32, ColorImage, TextureHandle, TextureOptions};
use egui_kittest::Harness;
use mislab::picture::meshes::Meshes;
use mislab_renderer::Layer;

use crate::window::App;

/// Letters, shapes with soft and with clipped edges, textures of both filters, and a picture between what is under and over it.
struct Window {
    picture: App,
    textures: [TextureHandle; 2],
    changed: bool,
}

impl Window {
    fn new(cc: &eframe::CreationContext<'_>, own: bool) -> Self {
        let state = cc.wgpu_render_state.as_ref().expect("a device");
        if own {
            cc.egui_ctx.add_plugin(Meshes::new(state).expect("the device takes the shader"));
        }
        let image =
            ColorImage::new([2, 2], vec![Color32::RED, Color32::GREEN, Color32::BLUE, Color32::from_white_alpha(90)]);
        let textures = [TextureOptions::NEAREST, TextureOptions::LINEAR]
            .map(|options| cc.egui_ctx.load_texture("four", image.clone(), options));
        Self { picture: App::new(Some(state), Layer::Picture), textures, changed: false }
    }
}

impl eframe::App for Window {
    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        ui.heading("Light, BSDF, MIS");
        let mut c = 0.3;
        ui.add(egui::Slider::new(&mut c, 0.0..=1.0).text("c"));
        ui.horizontal(|ui| {
            let _ = ui.button("One pass");
            for texture in &self.textures {
                ui.add(egui::Image::new(texture).fit_to_exact_size(egui::vec2(33.0, 21.5)));
            }
        });
        egui::ScrollArea::vertical().max_height(33.3).show(ui, |ui| {
            for line in 0..9 {
                ui.colored_label(Color32::from_rgb(200, 90, 20 * line), format!("line {line} of many"));
            }
        });
        if !self.changed {
            self.changed = true;
            let patch = ColorImage::filled([1, 1], Color32::YELLOW);
            self.textures[0].set_partial([1, 0], patch, TextureOptions::NEAREST);
        }
        self.picture.ui(ui, frame);
        let painter = ui.ctx().layer_painter(egui::LayerId::new(egui::Order::Foreground, egui::Id::unique("over")));
        painter.circle_filled(egui::pos2(120.0, 170.0), 30.0, Color32::from_black_alpha(120));
        painter.text(
            egui::pos2(120.0, 170.0),
            egui::Align2::CENTER_CENTER,
            "over",
            egui::FontId::proportional(17.0),
            Color32::WHITE,
        );
    }
}

/// Rows of RGBA8.
fn image(own: bool, pixels_per_point: f32) -> Vec<u8> {
    let mut harness = Harness::builder()
        .with_size(egui::vec2(240.0, 220.0))
        .with_pixels_per_point(pixels_per_point)
        .wgpu()
        .build_eframe(|cc| Window::new(cc, own));
    harness.run();
    harness.render().expect("it is drawn").into_raw()
}

#[test]
fn meshes_are_drawn_as_the_toolkit_draws_them() {
    for pixels_per_point in [1.0, 1.25, 2.0] {
        let [own, theirs] = [true, false].map(|own| image(own, pixels_per_point));
        assert_eq!(own.len(), theirs.len());
        let apart = own.iter().zip(&theirs).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(apart <= Some(2), "{apart:?} of 255 levels at {pixels_per_point} pixels a point");
        let colours: HashSet<_> = own.chunks_exact(4).collect();
        assert!(colours.len() > 500, "{} colours: there is something to see", colours.len());
    }
}
