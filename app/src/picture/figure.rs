//! A picture for paper and slides: false colours with their legend, and a line that says what is shown.

use eframe::egui::{Align2, FontId, TextStyle, pos2, vec2};
use mislab_renderer::blind::blind_materials;
use mislab_renderer::{Frame, Layer, Strategy};

use crate::look::layer::LayerLook;
use crate::look::names::{heuristic_name, strategy_name};
use crate::picture::legend::legend_on_paper;
use crate::picture::raster;
use crate::picture::still::render_to_rgba8;
use crate::picture::tone::surround;
use crate::state::view::ViewState;

/// Sizes of the strip under the picture at a type size of 16, in points.
const MARGIN: f32 = 12.0;
const LEGEND_HEIGHT: f32 = 80.0;
const LINE_HEIGHT: f32 = 24.0;
/// The narrowest strip that legend and caption fit into.
const NARROWEST: f32 = 460.0;
/// Pixels of the picture's width for which type of 16 pixels is right.
const USUAL_WIDTH: f32 = 800.0;

/// As [`render_to_rgba8`]; under a picture in false colours stand its legend and what made it, in as much room as that takes.
pub fn figure(frame: &Frame, layer: Layer, view: &ViewState, dark: bool) -> (u32, u32, Vec<u8>) {
    let (width, height, rgba) = render_to_rgba8(frame, layer, view, dark);
    if LayerLook::of(layer).is_colour() {
        // What is on screen is all there is to say, and programs that compare pictures want nothing else.
        return (width, height, rgba);
    }
    let scale = (width as f32 / USUAL_WIDTH).max(1.0);
    let full_width = width.max((NARROWEST * scale).ceil() as u32);
    let lines = caption(frame);
    let strip = scale * (2.0 * MARGIN + LEGEND_HEIGHT + LINE_HEIGHT * lines.len() as f32);
    let strip_size = [full_width, strip.ceil() as u32];
    let strip = raster::paint(strip_size, scale, dark, |ui| {
        let at = pos2(MARGIN, MARGIN);
        legend_on_paper(ui, at, layer, view, full_width as f32 / scale - 2.0 * MARGIN);
        let font = FontId { size: 15.0, ..TextStyle::Body.resolve(ui.style()) };
        for (index, line) in lines.iter().enumerate() {
            let at = at + vec2(0.0, LEGEND_HEIGHT + LINE_HEIGHT * index as f32 + 6.0);
            ui.painter().text(at, Align2::LEFT_TOP, line, font.clone(), ui.visuals().strong_text_color());
        }
    });
    let rows = height as usize * full_width as usize * 4;
    let mut all = Vec::with_capacity(rows + strip.len());
    // The picture in the middle of what may be wider than it is.
    let left = ((full_width - width) / 2) as usize;
    let ground = surround(dark).to_array();
    for row in rgba.chunks_exact(4 * width as usize) {
        all.extend(std::iter::repeat_n(ground, left).flatten());
        all.extend_from_slice(row);
        all.extend(std::iter::repeat_n(ground, full_width as usize - width as usize - left).flatten());
    }
    all.extend(strip);
    (full_width, height + strip_size[1], all)
}

/// What the picture is, and what made it: true of the frame, whatever the window shows by now.
pub fn caption(frame: &Frame) -> [String; 2] {
    let request = frame.request();
    let settings = &request.settings;
    let estimator = &settings.estimator;
    let mut how = strategy_name(estimator.strategy).to_owned();
    if matches!(estimator.strategy, Strategy::MisAll | Strategy::Mis) {
        how += &format!(", {} heuristic", heuristic_name(estimator.heuristic).to_lowercase());
    }
    if estimator.strategy == Strategy::Mis {
        how += &format!(", c = {:.2}", estimator.light_prob);
    }
    if estimator.bias().is_some() || !blind_materials(&request.scene, estimator).is_empty() {
        how += ", biased";
    }
    let name = crate::state::paths::shortened(&request.scene.name, 40);
    [format!("{name}: {how}"), format!("{} spp, seed {}", frame.spp(), settings.sampling.seed)]
}

#[cfg(test)]
mod tests {
    use mislab_renderer::{Request, Settings, pbrt};

    use super::*;

    fn frame() -> std::sync::Arc<Frame> {
        let file = pbrt::embedded_scene();
        let mut settings: Settings = file.settings;
        settings.image.resolution = [40, 30];
        settings.sampling.spp = std::num::NonZeroU32::new(2);
        let request = Request { scene: std::sync::Arc::new(file.scene), settings };
        mislab_renderer::render(&request, 1, &mut |_| true).expect("renders")
    }

    #[test]
    fn false_colours_have_legend_and_caption_and_colours_have_neither() {
        let frame = frame();
        let (view, dark) = (ViewState::default(), true);
        let plain = figure(&frame, Layer::Picture, &view, dark);
        assert_eq!((plain.0, plain.1), (40, 30));
        let (width, height, rgba) = figure(&frame, Layer::ShareLight, &view, dark);
        assert!(width >= 460 && height > 100, "{width} x {height}");
        assert_eq!(rgba.len(), 4 * (width * height) as usize);
        // The picture itself, bit by bit.
        let (_, _, picture) = render_to_rgba8(&frame, Layer::ShareLight, &view, dark);
        let left = (width as usize - 40) / 2;
        for (y, row) in picture.chunks_exact(160).enumerate() {
            let at = 4 * (y * width as usize + left);
            assert_eq!(&rgba[at..at + 160], row, "row {y}");
        }
        // Under it the colours of the bar, from blue to amber, and text.
        let strip: Vec<[u8; 4]> =
            rgba[4 * (30 * width as usize)..].chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect();
        assert!(strip.iter().all(|p| p[3] == 255), "nothing shows through");
        assert!(strip.iter().any(|p| p[2] > p[0].saturating_add(60)), "blue");
        assert!(strip.iter().any(|p| p[0] > p[2].saturating_add(100)), "amber");
        let bright = strip.iter().filter(|p| p[..3].iter().all(|c| *c > 180)).count();
        assert!(bright > 300, "text: {bright} pixels");
        assert_eq!(caption(&frame), ["veach_mis: MIS, both, balance heuristic", "2 spp, seed 1"]);
    }
}
