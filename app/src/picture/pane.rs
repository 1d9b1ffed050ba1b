//! A picture in the window, with all that is drawn on it: legend, outlines, the pixel under the mouse.

use eframe::egui::{self, Align2, Color32, Rect, Ui};
use eframe::egui_wgpu::RenderState;

use mislab_renderer::{Layer, PixelRect};

use crate::look::layer::not_drawn;
use crate::look::theme::GRID;
use crate::picture::against::{self, Against};
use crate::picture::black::Black;
use crate::picture::content::Content;
use crate::picture::dark::{DarkSpots, Darks, SharedDarkSpots};
use crate::picture::film_texture::FilmPipeline;
use crate::picture::incoming::Look;
use crate::picture::interaction::{Interaction, Place};
use crate::picture::legend::{Key, legend_overlay};
use crate::picture::live::LivePicture;
use crate::picture::picking::Target;
use crate::picture::pixel::Pixel;
use crate::picture::planes::Asked;
use crate::picture::selection::Selection;
use crate::picture::viewport::{Shown, Viewport};
use crate::state::command::Command;
use crate::state::document::Document;
use crate::state::placement::Geometry;
use crate::state::view::{VarianceUnit, ViewState};

/// What a pane is to show.
pub struct Subject<'a> {
    /// Which slot of the document.
    pub slot: usize,
    /// Its frames.
    pub live: &'a LivePicture,
    /// What the mouse is on in a panel.
    pub pointed_at: Option<Target>,
    /// The file has changed and cannot be read: the picture is of the file as it was.
    pub outdated: bool,
    /// A file is being read.
    pub reading: bool,
    /// Its legend stands on or beside it, not in a column.
    pub legend: bool,
    /// The pixel under the mouse in any picture.
    pub cursor: Option<[u32; 2]>,
    /// What the mouse is on in any picture.
    pub hovered: Option<Target>,
    /// A click pins the pixel under the mouse.
    pub pinning: bool,
    /// The pixel that is explained, in coordinates of the full image.
    pub marked: Option<[u32; 2]>,
    /// Pixels that are listed beside the pictures, in their order and the same coordinates. A click beside one pins it.
    pub listed: &'a [[u32; 2]],
    /// The mouse selects a part with Shift.
    pub selects: bool,
}

/// What all pictures have in common.
#[derive(Default)]
struct Common {
    /// The part of them that numbers are about.
    selection: Selection,
    /// What their pixels are, but for what was kept.
    dark: SharedDarkSpots,
}

/// One picture on screen.
pub struct Pane {
    viewport: Viewport,
    geometry: Option<Geometry>,
    /// Under the mouse, in this picture or in another.
    pixel: Option<[u32; 2]>,
    /// In this one.
    own_pixel: Option<[u32; 2]>,
    /// The same as the first, in the pixels of what is shown: a file may have others.
    read: Option<[u32; 2]>,
    interaction: Interaction,
    black: Black,
    dark: DarkSpots,
    /// What the pixels are of what was on screen in the last pass.
    shown_dark: Darks,
}

impl Pane {
    fn new(pipeline: Option<FilmPipeline>) -> Self {
        Self {
            viewport: Viewport::new(pipeline),
            geometry: None,
            pixel: None,
            own_pixel: None,
            read: None,
            interaction: Interaction::default(),
            black: Black::default(),
            dark: DarkSpots::default(),
            shown_dark: None,
        }
    }

    /// Where the picture lay in the last pass; `None` without a frame.
    pub fn geometry(&self) -> Option<Geometry> {
        self.geometry
    }

    /// The same as [`Self::pixel`], in the pixels of what is shown.
    pub fn read(&self) -> Option<[u32; 2]> {
        self.read
    }

    /// The pixel that was under the mouse in this or another picture, in coordinates of the full image.
    pub fn pixel(&self) -> Option<[u32; 2]> {
        self.pixel
    }

    /// What the pixels are, where they are black, of what was on screen.
    pub fn dark(&self) -> &Darks {
        &self.shown_dark
    }

    /// What the mouse was on.
    pub fn hovered(&self) -> Option<Target> {
        self.interaction.hovered()
    }

    /// Not on screen in this pass.
    fn rest(&mut self) {
        self.geometry = None;
        self.pixel = None;
        self.own_pixel = None;
        self.read = None;
        self.interaction = Interaction::default();
    }

    /// Draws it over all that is left of `ui` and of its clip rectangle, and lets the mouse zoom, pan, drag lights and select. A
    /// click makes it the picture that controls are about.
    fn ui(
        &mut self,
        ui: &mut Ui,
        document: &mut Document,
        on: &Subject<'_>,
        common: &mut Common,
        out: &mut Vec<Command>,
    ) {
        let layer = document.slots()[on.slot].layer;
        let content = on.live.content();
        let unit = document.view.variance_unit;
        let dark = match &content {
            // Of a technique that is never drawn nothing will be hit: the pane says that.
            Some(Content::Frame(frame)) if not_drawn(layer, &frame.request().settings.estimator).is_some() => None,
            // What was kept may be of another scene.
            Some(Content::Frame(frame)) if on.live.held().is_some() => self.dark.of(ui.ctx(), frame, layer),
            Some(Content::Frame(frame)) => common.dark.of(ui.ctx(), frame, layer),
            Some(Content::File(_)) | None => None,
        };
        if let Some(arrived) = on.live.arrived()
            && let Some(content) = &content
        {
            self.viewport.take(content, arrived);
        }
        let numbers = self.viewport.asks_for_numbers(ui.ctx(), self.geometry.as_ref());
        let asked = Asked { layer, unit, numbers };
        let frame = content.as_ref().and_then(Content::frame).filter(|_| on.live.held().is_none());
        let coming = frame.is_some_and(|frame| {
            let (dark, request) = (dark.clone(), frame.request().clone());
            on.live.look(Look { asked, dark, request, pipeline: self.viewport.pipeline().cloned() })
        });
        let planes = content.as_ref().map(|content| {
            let before = self.viewport.outdated_planes(content, &asked).filter(|_| coming);
            before.map_or_else(|| self.viewport.planes_of(content, &asked, &dark), Ok)
        });
        let missing = planes.as_ref().and_then(|planes| planes.as_ref().err()).cloned();
        let planes = planes.and_then(Result::ok);
        let behind = on.live.marked_in().is_some_and(|wait| wait.is_zero());
        let stale = if on.outdated {
            Some("the file as it was before the error")
        } else {
            behind.then_some("previous settings")
        };
        let shown = Shown { quantity: layer.into(), planes: planes.as_ref(), stale };
        // A file may have another resolution: pictures are aligned by their edges.
        let image = document.image.resolution;
        let size = content.as_ref().map_or(image, Content::size);
        let shown = aligned(&mut document.view, [image, size], |view| self.viewport.ui(ui, view, shown));
        self.geometry = shown.geometry;
        self.own_pixel = shown.hovered_pixel.map(|at| same_place(at, [size, image]));
        self.pixel = self.own_pixel.or(on.cursor);
        self.read = shown.hovered_pixel.or(on.cursor.map(|at| same_place(at, [image, size])));
        if shown.response.clicked() && document.active_index() != on.slot {
            out.push(Command::Activate(on.slot));
        }
        if shown.response.clicked()
            && on.pinning
            && let Some(pixel) = self.own_pixel
        {
            let at = shown.response.interact_pointer_pos().zip(self.geometry);
            let listed = at.and_then(|(at, geometry)| {
                let distance = |pixel: &[u32; 2]| {
                    geometry.to_screen(same_place(*pixel, [image, size]).map(|i| i as f32 + 0.5)).distance(at)
                };
                let nearest = on.listed.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
                nearest.filter(|pixel| distance(pixel) <= LISTED).copied()
            });
            out.push(Command::Pin(Some(listed.unwrap_or(pixel))));
        }
        let rect = shown.response.rect.intersect(ui.clip_rect());
        let Some(content) = content else {
            let text = if on.reading { "Reading the scene \u{2026}" } else { "Rendering the first picture \u{2026}" };
            let heading = egui::TextStyle::Heading.resolve(ui.style());
            let wide = ui.painter().layout_no_wrap(text.to_owned(), heading.clone(), Color32::WHITE).size().x;
            let body = egui::TextStyle::Body.resolve(ui.style());
            let font = if wide < rect.width() { heading } else { body };
            ui.painter().text(rect.center(), Align2::CENTER_CENTER, text, font, ui.visuals().weak_text_color());
            return;
        };
        if let Some(geometry) = self.geometry {
            let place = Place { document, geometry, pixel: self.own_pixel };
            let selecting = on.selects && ui.input(|input| input.modifiers.shift);
            if let Some(bounds) = planes.as_ref().map(|planes| planes.bounds()).filter(|_| on.selects && size == image)
            {
                common.selection.ui(ui, &shown.response, &geometry, bounds);
            }
            if on.live.held().is_none() && !selecting {
                self.interaction.ui(ui, &place, on.pointed_at.or(on.hovered), out);
            } else {
                // The scene may be another one by now, or the mouse is about a part of the picture.
                self.interaction = Interaction::default();
            }
            if let Some(at) = self.read.filter(|_| self.own_pixel.is_none()) {
                cursor(ui, rect, geometry.to_screen(at.map(|i| i as f32 + 0.5)));
            }
            if let Some(at) = on.marked.map(|at| same_place(at, [image, size])) {
                mark(ui, rect, &geometry, at);
            }
            let listed: Vec<_> = on.listed.iter().map(|pixel| same_place(*pixel, [image, size])).collect();
            list(ui, rect, &geometry, &listed);
        }
        if let Content::Frame(frame) = &content {
            if let Some(words) = not_drawn(layer, &frame.request().settings.estimator) {
                remark(ui, rect, words);
            }
            if layer == Layer::Picture {
                self.black.overlay(ui, rect, frame);
            }
        }
        if let Some(words) = missing {
            remark(ui, rect, words);
            return;
        }
        let pixel = self.read.map(|at| Pixel { content: &content, at, unit, dark: dark.as_ref() });
        if on.legend {
            let here = pixel.as_ref().and_then(|pixel| pixel.single(layer));
            let picture = self.geometry.map_or(rect, |geometry| geometry.picture_rect());
            legend_overlay(ui, rect, picture, Key { quantity: layer.into(), view: &document.view, here });
        }
        if let Some(pixel) = pixel {
            pixel.overlay(ui, rect, layer);
        }
        self.shown_dark = dark;
    }

    /// The number under the mouse of a layer that has one for each pixel of what is shown, as it is shown.
    pub fn here(&self, content: &Content, layer: Layer, unit: VarianceUnit) -> Option<f32> {
        Pixel { content, at: self.read?, unit, dark: self.shown_dark.as_ref() }.single(layer)
    }
}

/// Looks at a picture of `to` pixels as the view looks at one of `from`; how that changes, changes the view.
fn aligned<R>(view: &mut ViewState, [from, to]: [[u32; 2]; 2], look: impl FnOnce(&mut ViewState) -> R) -> R {
    if from == to {
        return look(view);
    }
    let placement = view.placement.scaled(from, to);
    let mut own = ViewState { placement, ..view.clone() };
    let result = look(&mut own);
    if own.placement != placement {
        view.placement = own.placement.scaled(to, from);
    }
    result
}

/// The pixel at the same place of a picture of `to` pixels instead of `from`.
fn same_place(at: [u32; 2], [from, to]: [[u32; 2]; 2]) -> [u32; 2] {
    [0, 1].map(|i| {
        let [at, from, to] = [at[i], from[i], to[i]].map(u64::from);
        ((2 * at + 1) * to / (2 * from).max(1)) as u32
    })
}

/// Where the mouse is in another picture.
fn cursor(ui: &Ui, rect: Rect, at: egui::Pos2) {
    let painter = ui.painter_at(rect);
    for (width, ink) in [(3.0, egui::Color32::from_black_alpha(160)), (1.5, egui::Color32::WHITE)] {
        for along in [egui::vec2(2.0 * GRID, 0.0), egui::vec2(0.0, 2.0 * GRID)] {
            // Open in the middle: the pixel itself stays in sight.
            painter.line_segment([at - along, at - 0.35 * along], (width, ink));
            painter.line_segment([at + 0.35 * along, at + along], (width, ink));
        }
    }
}

/// A ring around the pixel that is explained, and around its square once that is larger.
fn mark(ui: &Ui, rect: Rect, geometry: &Geometry, at: [u32; 2]) {
    let painter = ui.painter_at(rect);
    let centre = geometry.to_screen(at.map(|i| i as f32 + 0.5));
    let radius = (0.75 * geometry.scale / geometry.pixels_per_point).max(2.0 * GRID);
    painter.circle_stroke(centre, radius, (4.0, egui::Color32::from_black_alpha(170)));
    painter.circle_stroke(centre, radius, (2.0, egui::Color32::WHITE));
    let response = ui.interact(
        Rect::from_center_size(centre, egui::Vec2::splat(2.0 * radius)).intersect(rect),
        ui.scope_id().with("explained pixel"),
        egui::Sense::empty(),
    );
    let [x, y] = at;
    response
        .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, format!("Explained pixel: x {x}, y {y}")));
}

/// Half the side of the mark of a pixel that is listed, and how far from its middle a click is still about it. In points.
const LISTED: f32 = 1.5 * GRID;

/// A square around each of the pixels, with its number in the list where no other's is in the way.
fn list(ui: &Ui, rect: Rect, geometry: &Geometry, pixels: &[[u32; 2]]) {
    let painter = ui.painter_at(rect);
    let half = (0.75 * geometry.scale / geometry.pixels_per_point).max(LISTED);
    let font = egui::TextStyle::Small.resolve(ui.style());
    let mut numbered: Vec<Rect> = Vec::new();
    for (index, pixel) in pixels.iter().enumerate() {
        let centre = geometry.to_screen(pixel.map(|i| i as f32 + 0.5));
        let square = Rect::from_center_size(centre, egui::Vec2::splat(2.0 * half));
        for (width, ink) in [(3.5, egui::Color32::from_black_alpha(190)), (1.5, egui::Color32::WHITE)] {
            painter.rect_stroke(square, 0.0, (width, ink), egui::StrokeKind::Middle);
        }
        let number = painter.layout_no_wrap((index + 1).to_string(), font.clone(), egui::Color32::WHITE);
        let plate = Align2::LEFT_BOTTOM.anchor_size(square.right_top(), number.size()).expand2(egui::vec2(2.0, 0.0));
        if numbered.iter().all(|other| !other.intersects(plate)) {
            painter.rect_filled(plate, 2.0, egui::Color32::from_black_alpha(190));
            painter.galley(plate.min + egui::vec2(2.0, 0.0), number, egui::Color32::WHITE);
            numbered.push(plate);
        }
    }
}

/// A sentence over the middle of the picture, where there is nothing to see.
fn remark(ui: &Ui, rect: Rect, words: String) {
    let font = egui::TextStyle::Body.resolve(ui.style());
    let width = rect.width() - 16.0 * GRID;
    let galley = ui.painter().layout(words.clone(), font, ui.visuals().text_color(), width);
    let size = galley.size() + egui::vec2(6.0 * GRID, 4.0 * GRID);
    let plate = Align2::CENTER_CENTER.align_size_within_rect(size, rect);
    let painter = ui.painter_at(rect);
    painter.rect_filled(plate, 6.0, ui.visuals().panel_fill);
    painter.galley(plate.min + egui::vec2(3.0 * GRID, 2.0 * GRID), galley, ui.visuals().text_color());
    let response = ui.interact(plate, ui.scope_id().with("remark"), egui::Sense::empty());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, &words));
}

/// The pictures of the window, one for each slot of the document, and what they are all drawn with.
pub struct Panes {
    pipeline: Option<FilmPipeline>,
    panes: Vec<Pane>,
    /// Where the divider between two pictures is, as a share of their width.
    divider: f32,
    /// Two pictures as one.
    against: Against,
    common: Common,
}

impl Panes {
    /// Drawn on that device, or on the CPU if there is none or it refuses the shader. None yet: see
    /// [`Self::set_count`].
    pub fn new(render_state: Option<&RenderState>) -> Self {
        let pipeline = render_state.and_then(FilmPipeline::new);
        let (against, common) = (Against::new(pipeline.clone()), Common::default());
        Self { against, pipeline, panes: Vec::new(), divider: 0.5, common }
    }

    /// As many as the document has slots: the last ones go, or new ones come.
    pub fn set_count(&mut self, count: usize) {
        self.panes.resize_with(count, || Pane::new(self.pipeline.clone()));
    }

    /// What they are drawn with; `None`: on the CPU.
    pub fn pipeline(&self) -> Option<&FilmPipeline> {
        self.pipeline.as_ref()
    }

    /// The panes, in the order of the slots.
    pub fn all(&self) -> &[Pane] {
        &self.panes
    }

    /// Draws the pane of that slot over all that is left of `ui` and of its clip rectangle.
    pub fn pane_ui(&mut self, ui: &mut Ui, document: &mut Document, subject: &Subject<'_>, out: &mut Vec<Command>) {
        self.panes[subject.slot].ui(ui, document, subject, &mut self.common, out);
    }

    /// The pane of that slot is not on screen in this pass.
    pub fn rest(&mut self, slot: usize) {
        self.panes[slot].rest();
    }

    /// Where the divider between two pictures is, as a share of their width.
    pub fn divider_mut(&mut self) -> &mut f32 {
        &mut self.divider
    }

    /// Draws two pictures as one over all that is left of `ui`; the panes of both rest.
    pub fn against_ui(&mut self, ui: &mut Ui, document: &mut Document, subject: &against::Subject) {
        self.panes.iter_mut().for_each(Pane::rest);
        self.against.ui(ui, document, subject, &mut self.common.selection);
    }

    /// Two pictures as one.
    pub fn against(&self) -> &Against {
        &self.against
    }

    /// The part of a picture of `bounds` that numbers are about, in pixels of the full image; `None`: all of it.
    pub fn selected(&mut self, bounds: PixelRect) -> Option<PixelRect> {
        self.common.selection.keep_within(bounds);
        self.common.selection.part()
    }

    /// The pixel that was under the mouse in any of them.
    pub fn cursor(&self) -> Option<[u32; 2]> {
        self.panes.iter().find_map(|pane| pane.own_pixel)
    }

    /// What the mouse was on in any of them.
    pub fn hovered(&self) -> Option<Target> {
        self.panes.iter().find_map(Pane::hovered)
    }

    /// Without the graphics device from here on.
    pub fn draw_on_cpu(&mut self) {
        self.pipeline = None;
        self.against = Against::new(None);
        for pane in &mut self.panes {
            pane.viewport = Viewport::new(None);
        }
    }
}
