//! The small pictures of a study: layers of frames, brought up to date a few at a time, enlarged by a click.

use std::sync::{Arc, Weak};

use eframe::egui::{self, Align2, Color32, Context, Rect, Response, Role, Sense, TextStyle, Ui, UiBuilder};
use mislab_renderer::{Frame, Layer};

use crate::panel::widgets::{caption, focus_ring};
use crate::picture::dark::Darks;
use crate::picture::film_texture::FilmPipeline;
use crate::picture::planes::Planes;
use crate::picture::viewport::{Shown, Viewport};
use crate::state::passes;
use crate::state::placement::Placement;
use crate::state::view::{VarianceUnit, ViewState};

/// What a tile is to show.
pub struct Wanted {
    /// Of which frame.
    pub frame: Arc<Frame>,
    /// Which of its layers.
    pub layer: Layer,
    /// What is hatched in it.
    pub dark: Darks,
    /// It is of older settings.
    pub behind: bool,
}

/// One picture.
struct Tile {
    viewport: Viewport,
    layer: Layer,
    /// The frame that the numbers are from, which may be gone.
    from: Weak<Frame>,
    /// What is hatched in them.
    dark: Darks,
    planes: Option<Arc<Planes>>,
    /// They are of older settings.
    behind: bool,
}

/// All of a study. They share zoom and pan.
pub struct Tiles {
    tiles: Vec<Tile>,
    /// Whose turn it is to be brought up to date.
    next: usize,
    /// The one that has the whole place.
    pub enlarged: Option<usize>,
    placement: Placement,
}

impl Tiles {
    /// So many, empty, drawn by the shader or, without one, on the CPU.
    pub fn new(count: usize, pipeline: Option<&FilmPipeline>, placement: Placement) -> Self {
        let tile = || Tile {
            viewport: Viewport::new(pipeline.cloned()),
            layer: Layer::Picture,
            from: Weak::new(),
            dark: None,
            planes: None,
            behind: false,
        };
        Self { tiles: std::iter::repeat_with(tile).take(count).collect(), next: 0, enlarged: None, placement }
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.tiles.len()
    }

    /// Without the graphics device, if it has gone.
    pub fn match_device(&mut self, pipeline: Option<&FilmPipeline>) {
        for tile in self.tiles.iter_mut().filter(|tile| pipeline.is_none() && tile.viewport.on_gpu()) {
            tile.viewport = Viewport::new(None);
        }
    }

    /// Brings at most `most` tiles up to date, in turns, so that no pass of the window is held up; asks for another pass
    /// if some are left. Where passes are rare, all of them. Returns which have new numbers.
    pub fn refresh(&mut self, ctx: &Context, wanted: &[Option<Wanted>], most: usize) -> Vec<usize> {
        let count = self.tiles.len();
        let most = if passes::are_rare(ctx) { count } else { most };
        for (tile, wanted) in self.tiles.iter_mut().zip(wanted) {
            tile.behind = wanted.as_ref().is_none_or(|wanted| wanted.behind);
        }
        let mut fresh = Vec::new();
        for index in (0..count).map(|i| (self.next + i) % count) {
            let Some(wanted) = wanted.get(index).and_then(Option::as_ref) else { continue };
            let Wanted { frame, layer, dark, behind: _ } = wanted;
            let tile = &mut self.tiles[index];
            let same = tile.dark.as_ref().map(Arc::as_ptr) == dark.as_ref().map(Arc::as_ptr) && tile.layer == *layer;
            if same && tile.planes.is_some() && Weak::as_ptr(&tile.from) == Arc::as_ptr(frame) {
                continue;
            }
            if fresh.len() == most {
                passes::for_news(ctx);
                self.next = index;
                break;
            }
            // The old ones go first: no need for both at a time.
            tile.planes = None;
            let hatched = dark.as_ref().map(|dark| dark.as_slice());
            tile.planes = Some(Arc::new(Planes::shown(frame, *layer, VarianceUnit::OneSample, hatched)));
            (tile.from, tile.layer, tile.dark) = (Arc::downgrade(frame), *layer, dark.clone());
            fresh.push(index);
        }
        fresh
    }

    /// All tiles count as not up to date, whatever they show.
    pub fn retake(&mut self) {
        for tile in &mut self.tiles {
            tile.from = Weak::new();
        }
    }

    /// Draws one over `place`. A click makes it large, or small again.
    pub fn tile_ui(&mut self, ui: &mut Ui, index: usize, place: Rect, view: &ViewState, name: &str) -> Response {
        let tile = &mut self.tiles[index];
        let mut view = ViewState { placement: self.placement, ..view.clone() };
        let shown = ui.scope_builder(UiBuilder::new().id_salt(("tile", index)).max_rect(place), |ui| {
            ui.set_clip_rect(place.intersect(ui.clip_rect()));
            let shown =
                Shown { quantity: tile.layer.into(), planes: tile.planes.as_ref(), stale: tile.behind.then_some("") };
            let response = tile.viewport.ui(ui, &mut view, shown).response;
            if tile.planes.is_none() {
                words(ui, place, Align2::CENTER_CENTER, WAITING, TextStyle::Small, ui.visuals().weak_text_color());
            }
            response
        });
        self.placement = view.placement;
        let response = shown.inner;
        response.widget_info(|| egui::WidgetInfo::labeled(Role::Button, true, name));
        focus_ring(ui, &response, place);
        if response.hovered() && !response.dragged() {
            let icon = if self.enlarged.is_some() { egui::CursorIcon::ZoomOut } else { egui::CursorIcon::ZoomIn };
            ui.ctx().set_cursor_icon(icon);
        }
        if response.clicked() {
            self.enlarged = if self.enlarged.is_some() { None } else { Some(index) };
        }
        response
    }
}

/// In a tile that has no picture yet.
const WAITING: &str = "waiting \u{2026}";

/// A line of words in a place of its own, which it does not leave.
pub fn words(ui: &mut Ui, place: Rect, align: Align2, text: &str, style: TextStyle, color: Color32) -> Response {
    let font = style.resolve(ui.style());
    ui.painter_at(place).text(align.pos_in_rect(&place), align, text, font, color);
    let response =
        ui.interact(place, ui.scope_id().with((text, place.min.x as i32, place.min.y as i32)), Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(Role::Label, true, text));
    response
}

/// Lines of a caption that room is kept for: fewer in large type, where what is drawn needs it more.
pub fn caption_lines(ui: &Ui, [few, all]: [f32; 2]) -> f32 {
    ui.text_style_height(&TextStyle::Small) * if is_large(ui) { few } else { all }
}

/// Whether type is that of a hall.
pub fn is_large(ui: &Ui) -> bool {
    TextStyle::Small.resolve(ui.style()).size > 20.0
}

/// A quiet caption in all words or, where those have no room (in a hall), in few.
pub fn caption_that_fits(ui: &mut Ui, all: &str, few: &str) {
    let font = TextStyle::Small.resolve(ui.style());
    let height = ui.painter().layout(all.to_owned(), font, Color32::WHITE, ui.available_width()).size().y;
    caption(ui, if height <= ui.available_height() { all } else { few });
}
