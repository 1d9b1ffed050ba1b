//! A part of the window as it was drawn in one pass, kept to be drawn again elsewhere: on paper.

use std::collections::HashMap;
use std::sync::Arc;

use eframe::egui::epaint::{ClippedShape, TextShape};
use eframe::egui::layers::ShapeIdx;
use eframe::egui::plugin::Plugin;
use eframe::egui::{
    self, Color32, ColorImage, Context, Event, FullOutput, ImageData, LayerId, Painter, Pos2, RawInput, Rect, Shape,
    TextureId, TextureOptions, Ui, Vec2, pos2,
};

use crate::picture::cut::Cut;
use crate::picture::planes::Planes;
use crate::picture::tone::{self, Uniforms};

/// What a picture of the window was drawn from.
struct Drawn {
    layer: LayerId,
    at: ShapeIdx,
    rect: Rect,
    planes: Arc<Planes>,
    uniforms: Uniforms,
}

/// What is noted while a sheet is being recorded.
#[derive(Default)]
struct Notes {
    drawn: Vec<Drawn>,
    cuts: Vec<Cut>,
}

/// The window as if there were no mouse.
struct Away {
    /// Where the mouse is by now.
    mouse: Option<Pos2>,
    /// Passes of the window since it was hidden.
    passes: u32,
}

/// What was under the mouse is forgotten in one pass, and in the second nothing depends on it.
const PASSES_AWAY: u32 = 2;

/// Looks over the toolkit's shoulder: the textures of the window and, while a sheet is being recorded, its pictures and what
/// is for the screen alone. Hides the mouse from the window.
#[derive(Default)]
pub struct Recorder {
    notes: Option<Notes>,
    away: Option<Away>,
    /// Where the mouse comes back.
    back: Option<Pos2>,
    /// Shared with the toolkit, not copied. That of the letters is not among them: text is set anew.
    textures: HashMap<TextureId, Arc<ColorImage>>,
}

impl Plugin for Recorder {
    fn debug_name(&self) -> &'static str {
        "recorder"
    }

    fn input_hook(&mut self, _ctx: &Context, input: &mut RawInput) {
        if let Some(back) = self.back.take() {
            input.events.insert(0, Event::PointerMoved(back));
        }
        let Some(away) = &mut self.away else { return };
        for event in &input.events {
            match event {
                Event::PointerMoved(to) => away.mouse = Some(*to),
                Event::PointerGone => away.mouse = None,
                _ => {}
            }
        }
        input.events.retain(|event| !matches!(event, Event::PointerMoved(_)));
        input.events.push(Event::PointerGone);
        away.passes += 1;
    }

    fn output_hook(&mut self, _ctx: &Context, output: &mut FullOutput) {
        let delta = &output.textures_delta;
        for (id, changes) in delta.set.iter().filter(|(id, _)| **id != TextureId::default()) {
            for change in changes {
                let ImageData::Color(image) = &change.image;
                match (change.pos, self.textures.get_mut(id)) {
                    (Some(at), Some(texture)) => patch(Arc::make_mut(texture), image, at),
                    (Some(_), None) | (None, _) => drop(self.textures.insert(*id, image.clone())),
                }
            }
        }
        for id in &delta.free {
            self.textures.remove(id);
        }
    }
}

impl Recorder {
    /// Says that `at` is a picture, whatever has drawn it.
    pub fn note(painter: &Painter, at: ShapeIdx, rect: Rect, planes: &Arc<Planes>, uniforms: Uniforms) {
        painter.ctx().with_plugin(|recorder: &mut Self| {
            if let Some(notes) = &mut recorder.notes {
                notes.drawn.push(Drawn { layer: painter.layer_id(), at, rect, planes: planes.clone(), uniforms });
            }
        });
    }

    /// Whether a sheet is being recorded.
    pub fn is_recording(ctx: &Context) -> bool {
        ctx.with_plugin(|recorder: &mut Self| recorder.notes.is_some()).unwrap_or_default()
    }

    /// Draws what is for the screen alone: on paper it is left out with the room that it takes, and what follows in its row,
    /// or below it, moves up.
    pub fn on_screen_only<R>(ui: &mut Ui, add: impl FnOnce(&mut Ui) -> R) -> R {
        let (first, from) = (count(ui), ui.cursor().min);
        let result = add(ui);
        let cut = Cut::new(ui, first..count(ui), from);
        ui.ctx().with_plugin(|recorder: &mut Self| recorder.notes.as_mut().map(|notes| notes.cuts.push(cut)));
        result
    }

    /// From here on the window is drawn as if there were no mouse.
    pub fn hide_mouse(ctx: &Context) {
        let mouse = ctx.input(|input| input.pointer.latest_pos());
        ctx.with_plugin(|recorder: &mut Self| {
            recorder.away.get_or_insert(Away { mouse, passes: 0 });
        });
    }

    /// Nothing on screen depends on the mouse any more.
    pub fn is_mouse_forgotten(ctx: &Context) -> bool {
        let forgotten = |recorder: &mut Self| recorder.away.as_ref().is_some_and(|away| away.passes >= PASSES_AWAY);
        ctx.with_plugin(forgotten).unwrap_or_default()
    }

    /// The mouse is where it is again.
    pub fn show_mouse(ctx: &Context) {
        ctx.with_plugin(|recorder: &mut Self| recorder.back = recorder.away.take().and_then(|away| away.mouse));
        ctx.request_repaint();
    }
}

/// Shapes of the layer of `ui` so far.
fn count(ui: &Ui) -> usize {
    ui.ctx().graphics(|graphics| graphics.get(ui.layer_id()).map_or(0, |list| list.next_idx().0))
}

/// Replaces a part of a texture.
pub fn patch(texture: &mut ColorImage, part: &ColorImage, [left, top]: [usize; 2]) {
    for (y, row) in part.pixels.chunks_exact(part.width().max(1)).enumerate() {
        let start = (top + y) * texture.width() + left;
        if let Some(place) = texture.pixels.get_mut(start..start + row.len()) {
            place.copy_from_slice(row);
        }
    }
}

/// What stays free under the lowest thing drawn, in points.
const MARGIN: f32 = 12.0;

/// A part of the window.
pub struct Sheet {
    rect: Rect,
    items: Vec<Item>,
    textures: HashMap<TextureId, Arc<ColorImage>>,
    pixels_per_point: f32,
}

enum Item {
    Shape(ClippedShape),
    Picture { clip: Rect, rect: Rect, planes: Arc<Planes>, uniforms: Uniforms },
}

impl Item {
    /// Where it is seen.
    fn bounds(&self) -> Rect {
        match self {
            Self::Shape(ClippedShape { clip_rect, shape, .. }) => clip_rect.intersect(shape.visual_bounding_rect()),
            Self::Picture { clip, rect, .. } => clip.intersect(*rect),
        }
    }
}

impl Sheet {
    /// Draws `add` into `ui` as usual, and keeps what it has drawn within `rect`.
    pub fn record(ui: &mut Ui, rect: Rect, add: impl FnOnce(&mut Ui)) -> Self {
        let (ctx, layer) = (ui.ctx().clone(), ui.layer_id());
        ctx.with_plugin(|recorder: &mut Recorder| recorder.notes = Some(Notes::default()));
        let start = count(ui);
        add(ui);
        let (notes, textures) = ctx
            .with_plugin(|recorder: &mut Recorder| (recorder.notes.take(), recorder.textures.clone()))
            .unwrap_or_default();
        let Notes { drawn, cuts } = notes.unwrap_or_default();
        let pictures: HashMap<usize, Drawn> =
            drawn.into_iter().filter(|d| d.layer == layer).map(|d| (d.at.0, d)).collect();
        let shapes: Vec<ClippedShape> = ctx
            .graphics(|g| g.get(layer).map_or_else(Vec::new, |list| list.all_entries().skip(start).cloned().collect()));
        let mut items = Vec::new();
        for (index, mut shape) in (start..).zip(shapes).filter(|(index, _)| !cuts.iter().any(|cut| cut.holds(*index))) {
            let centre = shape.shape.visual_bounding_rect().center();
            let move_by = cuts.iter().fold(Vec2::ZERO, |sum, cut| sum + cut.moves(centre));
            let clip = shape.clip_rect.translate(move_by);
            items.push(match pictures.get(&index) {
                Some(Drawn { rect, planes, uniforms, .. }) => {
                    Item::Picture { clip, rect: rect.translate(move_by), planes: planes.clone(), uniforms: *uniforms }
                }
                None => {
                    shape.clip_rect = clip;
                    shape.shape.translate(move_by);
                    Item::Shape(shape)
                }
            });
        }
        let shorter = cuts.iter().map(Cut::height).sum::<f32>();
        // Room that was kept free below, for longer words or a larger window, is none of it.
        let drawn = items.iter().map(|item| item.bounds().bottom()).fold(rect.top(), f32::max);
        let rect = rect.with_max_y((rect.bottom() - shorter).min(drawn + MARGIN));
        Self { rect, items, textures, pixels_per_point: ctx.pixels_per_point() }
    }

    /// Its size in points.
    pub fn size(&self) -> Vec2 {
        self.rect.size()
    }

    /// Whether a picture has hatched pixels among its colours.
    pub fn has_hatched_colours(&self) -> bool {
        self.items.iter().any(|item| match item {
            Item::Picture { planes, .. } => planes.has_hatched_colours(),
            Item::Shape(_) => false,
        })
    }

    /// Draws it again, its upper left corner at the origin: pictures pixel by pixel from their numbers, text set in the
    /// resolution of `ui`.
    pub fn ui(&self, ui: &Ui) {
        let move_by = -self.rect.min.to_vec2();
        let textures = self.textures.iter().map(|(id, image)| (*id, load(ui, image.clone()))).collect();
        for item in &self.items {
            match item {
                Item::Picture { clip, rect, planes, uniforms } => {
                    let painter = ui.painter_at(clip.intersect(self.rect).translate(move_by));
                    picture(ui, &painter, rect.translate(move_by), planes, *uniforms, self.pixels_per_point);
                }
                Item::Shape(ClippedShape { clip_rect, shape, .. }) => {
                    let mut shape = shape.clone();
                    renew(ui, &mut shape, &textures);
                    shape.translate(move_by);
                    ui.painter_at(clip_rect.intersect(self.rect).translate(move_by)).add(shape);
                }
            }
        }
    }
}

/// Image by image: the toolkit frees a texture with its last handle, which the context keeps until it is gone.
fn load(ui: &Ui, image: Arc<ColorImage>) -> TextureId {
    let texture = ui.ctx().load_texture("sheet", ImageData::Color(image), TextureOptions::NEAREST);
    let id = texture.id();
    ui.data_mut(|data| data.insert_temp(egui::Id::unique(("sheet", id)), texture));
    id
}

fn picture(ui: &Ui, painter: &Painter, rect: Rect, planes: &Planes, uniforms: Uniforms, was: f32) {
    let now = ui.pixels_per_point();
    let size = (rect.size() * now).round();
    let size = [size.x.max(0.0) as usize, size.y.max(0.0) as usize];
    if size.contains(&0) {
        return;
    }
    let pixels = tone::render(planes, &uniforms.coarser(was / now), size);
    let image = ColorImage::from_rgba_premultiplied(size, &pixels);
    let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
    painter.image(load(ui, Arc::new(image)), rect, whole, Color32::WHITE);
}

/// Text and images of another context, in this one.
fn renew(ui: &Ui, shape: &mut Shape, textures: &HashMap<TextureId, TextureId>) {
    match shape {
        Shape::Vec(shapes) => shapes.iter_mut().for_each(|shape| renew(ui, shape, textures)),
        Shape::Text(TextShape { galley, .. }) => {
            *galley = ui.fonts_mut(|fonts| fonts.layout_job((*galley.job).clone()));
        }
        Shape::Mesh(mesh) => {
            if let Some(id) = textures.get(&mesh.texture_id) {
                Arc::make_mut(mesh).texture_id = *id;
            }
        }
        Shape::Rect(rect) => {
            if let Some(brush) = &mut rect.brush
                && let Some(id) = textures.get(&brush.fill_texture_id)
            {
                Arc::make_mut(brush).fill_texture_id = *id;
            }
        }
        // Drawn by a device, by something that is no picture.
        Shape::Callback(_) => *shape = Shape::Noop,
        Shape::Noop
        | Shape::Circle(_)
        | Shape::Ellipse(_)
        | Shape::LineSegment { .. }
        | Shape::Path(_)
        | Shape::Band(_)
        | Shape::QuadraticBezier(_)
        | Shape::CubicBezier(_) => {}
    }
}
