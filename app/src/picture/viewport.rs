//! The picture on screen: drawing, zoom, pan, values of pixels.

use std::sync::{Arc, Weak};

use eframe::egui::{self, Align2, Color32, FontId, Pos2, Rect, Role, Sense, emath::GuiRounding, pos2, vec2};
use eframe::egui_wgpu;
use mislab_renderer::{Frame, Layer, PixelRect};

use crate::look::layer::{LayerLook, Quantity};
use crate::picture::content::Content;
use crate::picture::dark::Darks;
use crate::picture::film_texture::{FilmPipeline, FilmTexture};
use crate::picture::foreign::Foreign;
use crate::picture::incoming::Arrived;
use crate::picture::planes::{Asked, BLIND, Planes, UNHIT, UNLIT};
use crate::picture::sheet::Recorder;
use crate::picture::tone::{self, Uniforms};
use crate::state::placement::{Geometry, Placement};
use crate::state::view::{VarianceUnit, ViewState};

/// From this size of an image pixel on screen, in points, its numbers are written into it.
const VALUES_FROM: f32 = 60.0;

/// Points of scrolling that double the scale.
const SCROLL_PER_DOUBLING: f32 = 120.0;

/// One picture on screen: what is on the GPU, or its stand-in on the CPU. All of it can be made anew at any time.
pub struct Viewport {
    gpu: Option<FilmTexture>,
    cpu: Option<CpuPicture>,
    /// The layer last taken from what is shown, which may be gone, and how.
    planes: Option<(Origin, VarianceUnit, Darks, Arc<Planes>)>,
}

/// What planes were taken from, which may be gone.
enum Origin {
    /// And its generation.
    Frame(Weak<Frame>, u64),
    File(Weak<Foreign>),
}

impl Origin {
    fn of(content: &Content) -> Self {
        match content {
            Content::Frame(frame) => Self::Frame(Arc::downgrade(frame), frame.generation()),
            Content::File(file) => Self::File(Arc::downgrade(file)),
        }
    }

    fn is(&self, content: &Content) -> bool {
        match (self, content) {
            (Self::Frame(held, _), Content::Frame(frame)) => Weak::as_ptr(held) == Arc::as_ptr(frame),
            (Self::File(held), Content::File(file)) => Weak::as_ptr(held) == Arc::as_ptr(file),
            (Self::Frame(..), Content::File(_)) | (Self::File(_), Content::Frame(_)) => false,
        }
    }

    /// An older frame of the same settings.
    fn is_before(&self, content: &Content) -> bool {
        match (self, content) {
            (Self::Frame(_, generation), Content::Frame(frame)) => {
                !self.is(content) && *generation == frame.generation()
            }
            (Self::Frame(..) | Self::File(_), Content::Frame(_) | Content::File(_)) => false,
        }
    }
}

/// A picture drawn without the shader, and what it was drawn from.
struct CpuPicture {
    planes: Arc<Planes>,
    uniforms: Uniforms,
    size: [usize; 2],
    texture: egui::TextureHandle,
}

/// What a viewport is to show.
#[derive(Clone, Copy)]
pub struct Shown<'a> {
    /// What the numbers are, also while there is no frame.
    pub quantity: Quantity,
    /// Its numbers.
    pub planes: Option<&'a Arc<Planes>>,
    /// They are not what was asked for: faded, and labelled with these words.
    pub stale: Option<&'a str>,
}

/// What a pass over the viewport found.
pub struct ViewportResponse {
    /// Of the whole viewport, surround included.
    pub response: egui::Response,
    /// The pixel under the pointer, in coordinates of the full image; only where the frame has numbers.
    pub hovered_pixel: Option<[u32; 2]>,
    /// Where the picture lies; `None` without a frame.
    pub geometry: Option<Geometry>,
}

impl Viewport {
    /// A viewport drawn by the shader, or on the CPU if there is none or the device refuses.
    pub fn new(pipeline: Option<FilmPipeline>) -> Self {
        Self { gpu: pipeline.and_then(FilmTexture::new), cpu: None, planes: None }
    }

    /// Whether pictures are drawn by the shader.
    pub fn on_gpu(&self) -> bool {
        self.gpu.is_some()
    }

    /// What it is drawn with; `None`: on the CPU.
    pub fn pipeline(&self) -> Option<&FilmPipeline> {
        self.gpu.as_ref().map(FilmTexture::pipeline)
    }

    /// Whether the numbers are asked for where the picture lay in the last pass, or it is enough that the graphics device has them.
    pub fn asks_for_numbers(&self, ctx: &egui::Context, geometry: Option<&Geometry>) -> bool {
        self.gpu.is_none()
            || Recorder::is_recording(ctx)
            || geometry.is_some_and(|geometry| cell(geometry) >= VALUES_FROM)
    }

    /// The layer of a frame as it was worked out for this viewport.
    pub fn take(&mut self, content: &Content, arrived: Arrived) {
        let Arrived { look, planes, staged } = arrived;
        if let (Some(gpu), Some(staged)) = (&mut self.gpu, staged) {
            gpu.stage(&planes, staged);
        }
        self.planes = Some((Origin::of(content), look.asked.unit, look.dark, planes));
    }

    /// Draws the picture over all that is left of `ui` and lets wheel, pinch, drag and double click change
    /// `view.placement`. Numbers are uploaded again only when the `Arc` is another one.
    pub fn ui(&mut self, ui: &mut egui::Ui, view: &mut ViewState, shown: Shown<'_>) -> ViewportResponse {
        let ppp = ui.pixels_per_point();
        let dark = ui.visuals().dark_mode;
        let rect = ui.available_rect_before_wrap().round_to_pixels(ppp);
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        let label = if shown.quantity == Layer::Picture.into() {
            "Picture".to_owned()
        } else {
            format!("Picture: {}", LayerLook::of(shown.quantity).name)
        };
        response.widget_info(|| egui::WidgetInfo::labeled(Role::Image, true, &label));
        let painter = ui.painter_at(rect);
        // Runs without a frame too, so that the first frame of a picture does not fade in or out.
        let fade_seconds = ui.style().animation_time;
        let faded = ui.ctx().animate_bool_with_time(response.id.with("stale"), shown.stale.is_some(), fade_seconds);

        let Some(planes) = shown.planes.filter(|planes| planes.bounds().area() > 0) else {
            painter.rect_filled(rect, 0.0, tone::surround(dark));
            return ViewportResponse { response, hovered_pixel: None, geometry: None };
        };
        let geometry = navigate(ui, &response, &mut view.placement, planes.image());
        let uniforms = Uniforms::new(planes, view, &geometry, dark).with_stale(faded);
        self.paint(&painter, rect, planes, uniforms);
        if planes.bounds() != full(planes.image()) {
            // The part of the image that a crop window leaves out.
            let stroke = egui::Stroke::new(1.0, tone::hatch(dark)[1]);
            painter.rect_stroke(geometry.picture_rect(), 0.0, stroke, egui::StrokeKind::Outside);
        }
        draw_values(&painter, planes, &geometry, &uniforms);
        if faded > 0.0 {
            draw_stale_tag(ui, &painter, rect, shown.stale.unwrap_or_default(), faded);
        }
        let hovered_pixel = response.hover_pos().and_then(|at| pixel_at(planes.bounds(), geometry.to_image(at)));
        ViewportResponse { response, hovered_pixel, geometry: Some(geometry) }
    }

    /// The layer as it was taken out last, if it was that one and there is a newer frame of the same settings by now.
    pub fn outdated_planes(&self, content: &Content, asked: &Asked) -> Option<Arc<Planes>> {
        let (from, unit, _, planes) = self.planes.as_ref()?;
        (from.is_before(content) && *unit == asked.unit && asked.is_met_by(planes)).then(|| planes.clone())
    }

    /// The layer, taken out only when content, layer or what is asked of it changed.
    ///
    /// # Errors
    /// If there are no numbers of that layer, why not.
    pub fn planes_of(&mut self, content: &Content, asked: &Asked, dark: &Darks) -> Result<Arc<Planes>, String> {
        let Asked { layer, unit, .. } = *asked;
        if let Some((from, as_unit, marked, planes)) = &self.planes {
            let same = from.is(content) && *as_unit == unit && asked.is_met_by(planes);
            if same && marked.as_ref().map(Arc::as_ptr) == dark.as_ref().map(Arc::as_ptr) {
                return Ok(planes.clone());
            }
        }
        // The old ones go first: no need for both at a time.
        self.planes = None;
        let planes = Arc::new(content.planes(layer, unit, dark)?);
        self.planes = Some((Origin::of(content), unit, dark.clone(), planes.clone()));
        Ok(planes)
    }

    fn paint(&mut self, painter: &egui::Painter, rect: Rect, planes: &Arc<Planes>, uniforms: Uniforms) {
        let size = (rect.size() * painter.ctx().pixels_per_point()).round();
        let size = [size.x, size.y].map(|side| side as u32);
        if size.contains(&0) {
            return;
        }
        if let Some(callback) = self.gpu.as_mut().and_then(|gpu| gpu.paint(planes, uniforms, size)) {
            self.cpu = None;
            let at = painter.add(egui_wgpu::Callback::new_paint_callback(rect, callback));
            Recorder::note(painter, at, rect, planes, uniforms);
        } else if planes.has_numbers() {
            self.paint_on_cpu(painter, rect, planes, uniforms);
        } else {
            // The device had them, and has refused to draw them: from here on without it.
            self.gpu = None;
            painter.ctx().request_repaint();
        }
    }

    /// The same picture without the shader, pixel of the screen by pixel of the screen: its cost depends on the size of
    /// the viewport and not on that of the picture.
    fn paint_on_cpu(&mut self, painter: &egui::Painter, rect: Rect, planes: &Arc<Planes>, uniforms: Uniforms) {
        let ctx = painter.ctx();
        let wanted = (rect.size() * ctx.pixels_per_point()).round();
        // A viewport beyond the largest texture is drawn in coarser pixels.
        let limit = ctx.input(|input| input.max_texture_side).max(1) as f32;
        let factor = (wanted.max_elem() / limit).ceil().max(1.0);
        let size = [wanted.x, wanted.y].map(|v| (v / factor) as usize);
        if size.contains(&0) {
            return;
        }
        let fine = uniforms;
        let uniforms = if factor > 1.0 { uniforms.coarser(factor) } else { uniforms };
        let current = self
            .cpu
            .as_ref()
            .is_some_and(|held| Arc::ptr_eq(&held.planes, planes) && held.uniforms == uniforms && held.size == size);
        if !current {
            let pixels = tone::render(planes, &uniforms, size);
            let image = egui::ColorImage::from_rgba_premultiplied(size, &pixels);
            let texture = match self.cpu.take() {
                Some(mut held) => {
                    held.texture.set(image, egui::TextureOptions::NEAREST);
                    held.texture
                }
                None => ctx.load_texture("picture", image, egui::TextureOptions::NEAREST),
            };
            self.cpu = Some(CpuPicture { planes: planes.clone(), uniforms, size, texture });
        }
        if let Some(picture) = &self.cpu {
            let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
            let at = painter.add(egui::Shape::image(picture.texture.id(), rect, whole, Color32::WHITE));
            Recorder::note(painter, at, rect, planes, fine);
        }
    }
}

/// Zoom and pan by wheel, pinch, drag and double click; the geometry that results.
fn navigate(ui: &egui::Ui, response: &egui::Response, placement: &mut Placement, image: [u32; 2]) -> Geometry {
    let geometry = |placement: &Placement| Geometry::new(response.rect, image, *placement, ui.pixels_per_point());
    if response.double_clicked() {
        placement.fit();
    }
    // With Shift a part is selected where that means something.
    let pans = response.dragged_by(egui::PointerButton::Primary) && !ui.input(|input| input.modifiers.shift);
    if pans || response.dragged_by(egui::PointerButton::Middle) {
        let delta = response.drag_delta();
        if delta != egui::Vec2::ZERO {
            placement.pan_by(&geometry(placement), delta);
        }
    }
    // A hand where there is something to move, a cross where there is only something to read.
    if response.dragged() {
        response.ctx.set_cursor_icon(egui::CursorIcon::Grabbing);
    } else if response.hovered() {
        let movable = matches!(placement, Placement::Free { .. });
        response.ctx.set_cursor_icon(if movable { egui::CursorIcon::Grab } else { egui::CursorIcon::Crosshair });
    }
    if let Some(pointer) = response.hover_pos() {
        let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
        let factor = pinch * (scroll / SCROLL_PER_DOUBLING).exp2();
        if factor != 1.0 {
            placement.zoom_about(&geometry(placement), pointer, factor);
        }
    }
    geometry(placement)
}

/// Size of an image pixel on screen, in points.
fn cell(geometry: &Geometry) -> f32 {
    geometry.scale / geometry.pixels_per_point
}

fn full(image: [u32; 2]) -> PixelRect {
    PixelRect { min: [0, 0], max: image }
}

/// The pixel of `bounds` that holds the point `at`.
fn pixel_at(bounds: PixelRect, at: [f32; 2]) -> Option<[u32; 2]> {
    let inside = |i: usize| at[i] >= bounds.min[i] as f32 && at[i] < bounds.max[i] as f32;
    (inside(0) && inside(1)).then(|| at.map(|v| v as u32))
}

/// Writes the numbers into the pixels when these are large enough on screen.
fn draw_values(painter: &egui::Painter, planes: &Planes, geometry: &Geometry, uniforms: &Uniforms) {
    let cell = cell(geometry);
    if cell < VALUES_FROM {
        return;
    }
    if !planes.has_numbers() {
        // They are asked for in the next pass.
        painter.ctx().request_repaint();
        return;
    }
    let bounds = planes.bounds();
    let (from, to) = (geometry.to_image(geometry.viewport.min), geometry.to_image(geometry.viewport.max));
    let range = |i: usize| {
        let from = from[i].floor().max(bounds.min[i] as f32) as u32;
        from..(to[i].ceil().max(0.0) as u32).min(bounds.max[i])
    };
    // Nine characters of a monospaced font fit a pixel.
    let font = FontId::monospace((cell / 6.5).clamp(9.0, 22.0));
    for y in range(1) {
        for x in range(0) {
            let value = planes.value(x - bounds.min[0], y - bounds.min[1]);
            let shown = tone::at_pixel(uniforms, value);
            let ink = if luma(shown) > 0.5 { Color32::BLACK } else { Color32::WHITE };
            let [r, g, b] = value.map(number);
            let marked = [BLIND, UNHIT, UNLIT].contains(&value[0]);
            let text = if marked || (r == g && g == b) { r } else { [r, g, b].join("\n") };
            let centre = geometry.to_screen([x as f32 + 0.5, y as f32 + 0.5]);
            painter.text(centre, Align2::CENTER_CENTER, text, font.clone(), ink);
        }
    }
}

/// A number of a pixel in at most nine characters.
fn number(value: f32) -> String {
    let size = value.abs();
    if value.is_nan() || value == UNHIT {
        "none yet".to_owned()
    } else if value == BLIND {
        "blind".to_owned()
    } else if value == UNLIT {
        "no light".to_owned()
    } else if size == 0.0 || (1e-3..1e4).contains(&size) {
        let decimals = if size >= 1e3 {
            1
        } else if size >= 1e2 {
            2
        } else if size >= 10.0 {
            3
        } else {
            4
        };
        format!("{value:.decimals$}")
    } else {
        format!("{value:.2e}")
    }
}

/// Perceived brightness of a display colour, roughly, in [0, 1].
fn luma([r, g, b]: [f32; 3]) -> f32 {
    0.299 * r + 0.587 * g + 0.114 * b
}

/// Says that the picture is not that of the present settings.
fn draw_stale_tag(ui: &egui::Ui, painter: &egui::Painter, rect: Rect, words: &str, opacity: f32) {
    if words.is_empty() {
        return;
    }
    let font = egui::TextStyle::Small.resolve(ui.style());
    let galley = painter.layout_no_wrap(words.to_owned(), font, Color32::WHITE);
    // Above the legend: what has gone wrong is said at the top.
    let size = galley.size() + vec2(16.0, 8.0);
    let plate = Rect::from_min_size(rect.left_bottom() + vec2(12.0, -100.0 - size.y), size);
    let tag = ui.interact(plate, ui.scope_id().with("stale tag"), Sense::hover());
    tag.widget_info(|| egui::WidgetInfo::labeled(Role::Label, true, words));
    let mut painter = painter.clone();
    painter.multiply_opacity(opacity);
    painter.rect_filled(plate, 4.0, Color32::from_black_alpha(200));
    painter.galley(plate.min + vec2(8.0, 4.0), galley, Color32::WHITE);
}
