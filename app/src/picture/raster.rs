//! Shapes and text of the window's toolkit as pixels, without a window and without a graphics device: for files.

use std::collections::HashMap;
use std::sync::Arc;

use eframe::egui::epaint::{ClippedPrimitive, ClippedShape, Mesh, Primitive, Vertex};
use eframe::egui::{
    Color32, ColorImage, Context, ImageData, Pos2, RawInput, Rect, TextureId, Theme, Ui, ViewportId, vec2,
};

use crate::look::theme::{self, TypeScale};
use crate::picture::sheet::patch;

/// What `add` paints on the ground of a panel: rows of RGBA8 from the top left, `scale` pixels to a point.
pub fn paint(size: [u32; 2], scale: f32, dark: bool, add: impl FnMut(&mut Ui)) -> Vec<u8> {
    Offscreen::new(size, scale, dark, TypeScale::Desk, add).pixels()
}

/// A pass of the toolkit without a window: what it would have drawn.
pub struct Offscreen {
    /// In pixels.
    pub size: [u32; 2],
    /// Pixels to a point.
    pub scale: f32,
    /// Of a panel.
    pub ground: Color32,
    /// In the order of drawing, in points.
    pub shapes: Vec<ClippedShape>,
    ctx: Context,
    textures: HashMap<TextureId, ColorImage>,
}

impl Offscreen {
    /// The largest side of a texture, in pixels: that of no device.
    const TEXTURE_SIDE: usize = 1 << 15;

    /// Runs `add`, with type of that size.
    pub fn new(size: [u32; 2], scale: f32, dark: bool, type_scale: TypeScale, mut add: impl FnMut(&mut Ui)) -> Self {
        let ctx = Context::default();
        theme::install_fonts(&ctx);
        theme::install(&ctx, type_scale, true);
        ctx.set_theme(if dark { Theme::Dark } else { Theme::Light });
        let points = vec2(size[0] as f32, size[1] as f32) / scale;
        let mut input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, points)),
            max_texture_side: Some(Self::TEXTURE_SIDE),
            ..RawInput::default()
        };
        input.viewports.entry(ViewportId::ROOT).or_default().native_pixels_per_point = Some(scale);
        let mut ground = Color32::BLACK;
        let mut output = ctx.run_ui(input, |ui| {
            ground = ui.visuals().panel_fill;
            add(ui);
        });
        let mut textures: HashMap<TextureId, ColorImage> = HashMap::new();
        let deltas =
            output.textures_delta.set.iter().flat_map(|(id, deltas)| deltas.iter().map(move |delta| (id, delta)));
        for (id, delta) in deltas {
            let ImageData::Color(image) = &delta.image;
            match (delta.pos, textures.get_mut(id)) {
                (Some(at), Some(texture)) => patch(texture, image, at),
                (Some(_), None) | (None, _) => drop(textures.insert(*id, Arc::unwrap_or_clone(image.clone()))),
            }
        }
        // Handled: the toolkit asks.
        output.textures_delta.clear();
        Self { size, scale, ground, shapes: output.shapes, ctx, textures }
    }

    /// All of it on its ground: rows of RGBA8 from the top left.
    pub fn pixels(&self) -> Vec<u8> {
        let canvas = self.drawn(self.shapes.clone(), self.ground);
        canvas.pixels.iter().flat_map(Color32::to_array).collect()
    }

    /// One of its shapes on nothing: the pixels it touches, their left and top, and how many there are of them.
    pub fn alone(&self, shape: &ClippedShape) -> ([u32; 4], Vec<u8>) {
        let canvas = self.drawn(vec![shape.clone()], Color32::TRANSPARENT);
        let [width, height] = canvas.size;
        let all = Rect::from_min_size(Pos2::ZERO, vec2(width as f32, height as f32));
        let touched = (shape.shape.visual_bounding_rect().intersect(shape.clip_rect) * self.scale).expand(1.0);
        let part = touched.intersect(all);
        let [left, top] = [part.left(), part.top()].map(|v| v.floor() as usize);
        let [right, bottom] = [part.right(), part.bottom()].map(|v| v.ceil() as usize);
        let (right, bottom) = (right.clamp(left, width.max(left)), bottom.clamp(top, height.max(top)));
        let rows = (top..bottom).flat_map(|y| &canvas.pixels[y * width + left..y * width + right]);
        let bytes = rows.flat_map(Color32::to_srgba_unmultiplied).collect();
        ([left, top, right - left, bottom - top].map(|v| v as u32), bytes)
    }

    fn drawn(&self, shapes: Vec<ClippedShape>, ground: Color32) -> Canvas {
        let size = self.size.map(|n| n as usize);
        let mut canvas = Canvas { size, pixels: vec![ground; size[0] * size[1]] };
        for ClippedPrimitive { clip_rect, primitive } in self.ctx.tessellate(shapes, self.scale) {
            if let Primitive::Mesh(mesh) = primitive
                && let Some(texture) = self.textures.get(&mesh.texture_id)
            {
                canvas.mesh(&mesh, texture, clip_rect * self.scale, self.scale);
            }
        }
        canvas
    }
}

struct Canvas {
    size: [usize; 2],
    /// Premultiplied, sRGB-encoded: the toolkit blends encoded values too.
    pixels: Vec<Color32>,
}

impl Canvas {
    fn mesh(&mut self, mesh: &Mesh, texture: &ColorImage, clip: Rect, scale: f32) {
        for corners in mesh.indices.chunks_exact(3) {
            let corners = [0, 1, 2].map(|i| mesh.vertices[corners[i] as usize]);
            self.triangle(corners.map(|v| Vertex { pos: v.pos * scale, ..v }), texture, clip);
        }
    }

    /// Each pixel whose centre is inside; of an edge between two triangles it belongs to one of them.
    fn triangle(&mut self, corners: [Vertex; 3], texture: &ColorImage, clip: Rect) {
        let [a, b, c] = corners.map(|v| v.pos);
        let area = cross(a, b, c);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let bounds = Rect::from_points(&[a, b, c]).intersect(clip);
        let range = |low: f32, high: f32, size: usize| {
            let end = (high.ceil().max(0.0) as usize).min(size);
            (low.floor().max(0.0) as usize).min(end)..end
        };
        for y in range(bounds.top(), bounds.bottom(), self.size[1]) {
            for x in range(bounds.left(), bounds.right(), self.size[0]) {
                let at = Pos2::new(x as f32 + 0.5, y as f32 + 0.5);
                let weights = [cross(b, c, at) / area, cross(c, a, at) / area, cross(a, b, at) / area];
                let edges = [(b, c), (c, a), (a, b)];
                let inside =
                    weights.iter().zip(edges).all(|(w, (from, to))| *w > 0.0 || (*w == 0.0 && owns(from, to, area)));
                if inside && clip.contains(at) {
                    let mix = |of: fn(&Vertex) -> f32| (0..3).map(|i| weights[i] * of(&corners[i])).sum::<f32>();
                    let uv = [mix(|v| v.uv.x), mix(|v| v.uv.y)];
                    let texel = texel(texture, uv);
                    let channels: [fn(&Vertex) -> f32; 4] = [
                        |v| f32::from(v.color.r()),
                        |v| f32::from(v.color.g()),
                        |v| f32::from(v.color.b()),
                        |v| f32::from(v.color.a()),
                    ];
                    let [r, g, b, alpha] = [0, 1, 2, 3].map(|i| mix(channels[i]) * f32::from(texel[i]) / 255.0);
                    let pixel = &mut self.pixels[y * self.size[0] + x];
                    let under = pixel.to_array().map(f32::from);
                    let over = |new: f32, old: f32| (new + old * (1.0 - alpha / 255.0)).round().clamp(0.0, 255.0) as u8;
                    *pixel = Color32::from_rgba_premultiplied(
                        over(r, under[0]),
                        over(g, under[1]),
                        over(b, under[2]),
                        over(alpha, under[3]),
                    );
                }
            }
        }
    }
}

/// Twice the signed area of a triangle.
fn cross(a: Pos2, b: Pos2, c: Pos2) -> f32 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

/// Of the two triangles at an edge, which run along it in opposite directions, one owns the pixels on it.
fn owns(from: Pos2, to: Pos2, area: f32) -> bool {
    let edge = if area > 0.0 { to - from } else { from - to };
    edge.y > 0.0 || (edge.y == 0.0 && edge.x < 0.0)
}

/// The nearest value of a texture: glyphs lie on whole pixels.
fn texel(texture: &ColorImage, uv: [f32; 2]) -> [u8; 4] {
    let [w, h] = texture.size;
    let at = |t: f32, n: usize| ((t * n as f32).floor().max(0.0) as usize).min(n.saturating_sub(1));
    texture.pixels.get(at(uv[1], h) * w + at(uv[0], w)).map_or([0; 4], Color32::to_array)
}

#[cfg(test)]
mod tests {
    use eframe::egui::{self, Stroke, pos2};

    use super::*;

    #[test]
    fn shapes_and_text_become_pixels() {
        let pixels = paint([80, 40], 2.0, true, |ui| {
            let painter = ui.painter();
            painter.rect_filled(
                Rect::from_min_max(pos2(2.0, 2.0), pos2(12.0, 12.0)),
                0.0,
                Color32::from_rgb(200, 10, 20),
            );
            painter.rect_filled(
                Rect::from_min_max(pos2(20.0, 2.0), pos2(30.0, 12.0)),
                0.0,
                Color32::from_rgba_unmultiplied(255, 255, 255, 128),
            );
            painter.hline(0.0..=40.0, 15.0, Stroke::new(1.0, Color32::GREEN));
        });
        assert_eq!(pixels.len(), 80 * 40 * 4);
        let at = |x: usize, y: usize| [0, 1, 2, 3].map(|i| pixels[4 * (y * 80 + x) + i]);
        assert_eq!(at(12, 12), [200, 10, 20, 255], "inside");
        let ground = at(36, 12);
        assert_eq!(ground[3], 255);
        let half = at(50, 12);
        assert!((i32::from(half[0]) - (255 + i32::from(ground[0])) / 2).abs() <= 2, "half over the ground: {half:?}");
        assert_eq!(at(40, 30), [0, 255, 0, 255], "a line of two pixels");
        let text = paint([200, 40], 1.0, false, |ui| {
            ui.painter().text(
                pos2(4.0, 4.0),
                egui::Align2::LEFT_TOP,
                "HHHH",
                egui::FontId::proportional(20.0),
                Color32::BLACK,
            );
        });
        let dark = text.chunks_exact(4).filter(|p| p[0] < 60).count();
        assert!((100..2000).contains(&dark), "{dark} dark pixels of text");
    }
}
