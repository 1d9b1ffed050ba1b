//! The stage: one, two or four pictures, each with its caption.

use std::sync::Arc;

use eframe::egui::{
    self, Align, Align2, Color32, CursorIcon, Layout, Rect, Role, Sense, Stroke, StrokeKind, Ui, UiBuilder, pos2, vec2,
};
use mislab_renderer::Frame;

use crate::lab::Lab;
use crate::look::layer::LayerLook;
use crate::look::names::strategy_name;
use crate::look::theme::{GRID, Inks};
use crate::look::versus::Versus;
use crate::panel::caption::{self, Alike, Caption, waiting_ui};
use crate::panel::compare;
use crate::panel::file_caption::FileCaption;
use crate::picture::against;
use crate::picture::content::Content;
use crate::picture::live::LivePicture;
use crate::picture::pane::Subject;
use crate::picture::sheet::Recorder;
use crate::state::arrangement::Arrangement;
use crate::state::command::Command;
use crate::state::paths::shortened;
use crate::state::study::Study;

/// Space between pictures, in points.
const BETWEEN: f32 = 2.0 * GRID;
/// Width of the frame around the active one.
const FRAME: f32 = 2.0;

/// Draws the pictures over all that is left of `ui`. `legend`: on or beside each.
pub(super) fn stage_ui(ui: &mut Ui, lab: &mut Lab, legend: bool, out: &mut Vec<Command>) {
    let place = ui.available_rect_before_wrap();
    let cursor = lab.panes.cursor();
    match lab.document.arrangement() {
        Arrangement::One => pane_ui(ui, lab, 0, [place, place], legend, out),
        arrangement @ (Arrangement::Beside | Arrangement::Four) => {
            grid_ui(ui, lab, place, arrangement.grid(), legend, out);
        }
        Arrangement::Wipe => wipe_ui(ui, lab, place, legend, out),
        Arrangement::Flip => flip_ui(ui, lab, place, legend, out),
        Arrangement::Difference => difference_ui(ui, lab, place, out),
    }
    if lab.panes.cursor() != cursor {
        // The other pictures were drawn with the place where the mouse was before.
        ui.ctx().request_repaint_after(std::time::Duration::from_millis(1));
    }
}

/// One picture over `viewport`, as far as it lies in `clip`.
fn pane_ui(ui: &mut Ui, lab: &mut Lab, slot: usize, [viewport, clip]: [Rect; 2], legend: bool, out: &mut Vec<Command>) {
    let Lab { document, engine, panes, files, pointed_at, studies, .. } = lab;
    let layer = document.slots()[slot].layer;
    // A column has the legend of the active picture only.
    let other_colours = layer != document.active().layer && !LayerLook::of(layer).is_colour();
    let subject = Subject {
        slot,
        live: &engine.pictures()[slot],
        pointed_at: *pointed_at,
        legend: legend || other_colours,
        outdated: files.is_outdated(document.opened.path.as_deref()),
        reading: files.is_reading(),
        cursor: panes.cursor(),
        hovered: panes.hovered(),
        pinning: studies.open == Some(Study::Explain),
        marked: studies.explain.marked().filter(|_| studies.open == Some(Study::Explain)),
        listed: if studies.open == Some(Study::Explain) { studies.explain.listed() } else { &[] },
        selects: studies.open.is_some_and(Study::is_beside_pictures),
    };
    ui.scope_builder(UiBuilder::new().id_salt(("picture", slot)).max_rect(viewport), |ui| {
        ui.set_clip_rect(clip.intersect(ui.clip_rect()));
        panes.pane_ui(ui, document, &subject, out);
    });
}

/// Pictures in columns and rows, each over its caption.
fn grid_ui(ui: &mut Ui, lab: &mut Lab, place: Rect, [columns, rows]: [usize; 2], legend: bool, out: &mut Vec<Command>) {
    let gaps = vec2((columns - 1) as f32, (rows - 1) as f32) * BETWEEN;
    let size = ((place.size() - gaps) / vec2(columns as f32, rows as f32)).max(vec2(1.0, 1.0));
    for slot in 0..lab.document.slots().len() {
        let at = vec2((slot % columns) as f32, (slot / columns) as f32);
        let cell = Rect::from_min_size(place.min + at * (size + egui::Vec2::splat(BETWEEN)), size);
        let (picture, caption) = cell.split_top_bottom_at_y(cell.bottom() - caption_height(ui));
        pane_ui(ui, lab, slot, [picture, picture], legend, out);
        caption_ui(ui, lab, slot, caption, Align::Min, out);
        if slot == lab.document.active_index() {
            Recorder::on_screen_only(ui, |ui| frame_ui(ui, cell));
        }
    }
}

/// Two pictures in one place, with a divider to drag.
fn wipe_ui(ui: &mut Ui, lab: &mut Lab, place: Rect, legend: bool, out: &mut Vec<Command>) {
    let (picture, captions) = place.split_top_bottom_at_y(place.bottom() - caption_height(ui));
    let x = picture.left() + *lab.panes.divider_mut() * picture.width();
    let (left, right) = picture.split_left_right_at_x(x.round());
    for (slot, clip) in [left, right].into_iter().enumerate() {
        pane_ui(ui, lab, slot, [picture, clip], legend, out);
    }
    let (first, second) = captions.split_left_right_at_fraction(0.5);
    for (slot, (caption, align)) in [(first, Align::Min), (second, Align::Max)].into_iter().enumerate() {
        caption_ui(ui, lab, slot, caption, align, out);
    }
    divider_ui(ui, lab, picture);
    for (slot, clip) in [left, right].into_iter().enumerate() {
        name_ui(ui, lab, slot, clip);
    }
}

/// The name of a picture beside the divider.
fn name_ui(ui: &Ui, lab: &Lab, slot: usize, clip: Rect) {
    let strategy = lab.document.slots()[slot].estimator.strategy;
    let font = egui::TextStyle::Body.resolve(ui.style());
    let ink = slot_ink(ui, lab, slot);
    let file = lab.engine.pictures()[slot].file().map(|file| shortened(file.name(), 24));
    let name = file.unwrap_or_else(|| strategy_name(strategy).to_owned());
    let galley = ui.painter().layout_no_wrap(name, font, ink);
    let size = galley.size() + vec2(4.0 * GRID, 2.0 * GRID);
    let corner = if slot == 0 { Align2::RIGHT_BOTTOM } else { Align2::LEFT_BOTTOM };
    let plate = corner.align_size_within_rect(size, clip.shrink(2.0 * GRID));
    let painter = ui.painter_at(clip);
    painter.rect_filled(plate, GRID, ui.visuals().panel_fill);
    painter.galley(plate.min + vec2(2.0 * GRID, GRID), galley, ink);
}

/// The divider. It stays within the picture, and a double click brings it back to the middle.
fn divider_ui(ui: &mut Ui, lab: &mut Lab, place: Rect) {
    let share = lab.panes.divider_mut();
    let x = place.left() + *share * place.width();
    let grip = Rect::from_x_y_ranges(x - 1.5 * GRID..=x + 1.5 * GRID, place.y_range());
    let response = ui.interact(grip, ui.scope_id().with("divider"), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(Role::Splitter, true, "Divider between the pictures"));
    if response.double_clicked() {
        *share = 0.5;
    } else if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.dragged()) {
        *share = ((pointer.x - place.left()) / place.width().max(1.0)).clamp(0.0, 1.0);
    }
    let painter = ui.painter_at(place);
    painter.vline(x, place.y_range(), Stroke::new(3.0, egui::Color32::from_black_alpha(160)));
    painter.vline(x, place.y_range(), Stroke::new(1.5, egui::Color32::WHITE));
    let handle = Rect::from_center_size(pos2(x, place.center().y), vec2(2.0 * GRID, 10.0 * GRID));
    let stroke = Stroke::new(1.0, egui::Color32::BLACK);
    Recorder::on_screen_only(ui, |_| painter.rect(handle, GRID, egui::Color32::WHITE, stroke, StrokeKind::Outside));
    response.on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
}

/// The active picture, or the other one while Shift is held.
fn flip_ui(ui: &mut Ui, lab: &mut Lab, place: Rect, legend: bool, out: &mut Vec<Command>) {
    let active = lab.document.active_index();
    let flipped = ui.input(|i| i.modifiers.shift_only()) && !ui.ctx().text_edit_focused();
    let shown = if flipped { 1 - active } else { active };
    let (picture, captions) = place.split_top_bottom_at_y(place.bottom() - caption_height(ui));
    pane_ui(ui, lab, shown, [picture, picture], legend, out);
    lab.panes.rest(1 - shown);
    let (first, second) = captions.split_left_right_at_fraction(0.5);
    for (slot, caption) in [first, second].into_iter().enumerate() {
        if slot == shown {
            caption_ui(ui, lab, slot, caption, Align::Min, out);
        } else {
            // What is not on screen is said faintly.
            ui.scope(|ui| {
                ui.multiply_opacity(0.4);
                caption_ui(ui, lab, slot, caption, Align::Min, out);
            });
        }
    }
}

/// Two pictures as one, over what can be said of them and both captions.
fn difference_ui(ui: &mut Ui, lab: &mut Lab, place: Rect, out: &mut Vec<Command>) {
    let (above, captions) = place.split_top_bottom_at_y(place.bottom() - caption_height(ui));
    let strip = ui.spacing().interact_size.y + compare::found_height(ui, place.width()) + 3.0 * GRID;
    let (picture, strip) = above.split_top_bottom_at_y(above.bottom() - strip);
    let Lab { document, engine, panes, references, .. } = lab;
    let contents = [0, 1].map(|slot| engine.pictures()[slot].content());
    let subject = against::Subject { contents, reference: references.latest(), words: references.words() };
    ui.scope_builder(UiBuilder::new().id_salt("against").max_rect(picture), |ui| {
        ui.set_clip_rect(picture.intersect(ui.clip_rect()));
        panes.against_ui(ui, document, &subject);
    });
    let against = panes.against();
    ui.scope_builder(UiBuilder::new().id_salt("versus").max_rect(strip.shrink2(vec2(2.0 * GRID, 0.0))), |ui| {
        let found = match document.view.versus {
            Versus::Errors if against.planes().is_some() => format!("{}; {}", against.found(), subject.words),
            Versus::Errors | Versus::Variances | Versus::Difference => against.found().to_owned(),
        };
        compare::versus_ui(ui, document, &found, out);
    });
    let (first, second) = captions.split_left_right_at_fraction(0.5);
    for (slot, (caption, align)) in [(first, Align::Min), (second, Align::Max)].into_iter().enumerate() {
        caption_ui(ui, lab, slot, caption, align, out);
    }
}

/// The colour of a picture's strategy; none for a file.
fn slot_ink(ui: &Ui, lab: &Lab, slot: usize) -> Color32 {
    let slot = &lab.document.slots()[slot];
    if slot.is_file() {
        return ui.visuals().strong_text_color();
    }
    Inks::of(ui.visuals()).strategy(slot.estimator.strategy)
}

/// What stands under a picture.
enum Words {
    Frame(Caption),
    File(FileCaption),
}

fn caption_height(ui: &Ui) -> f32 {
    ui.text_style_height(&egui::TextStyle::Body) + 2.0 * GRID
}

/// What made a picture, in one line; a click makes it the active one.
fn caption_ui(ui: &mut Ui, lab: &Lab, slot: usize, place: Rect, align: Align, out: &mut Vec<Command>) {
    let live = &lab.engine.pictures()[slot];
    let error = || lab.measuring.rel_mse(slot, live);
    let caption = live.content().map(|content| match content {
        Content::Frame(frame) if live.kept().is_some() => Words::Frame(Caption::of_kept(&frame).with_error(error())),
        Content::Frame(frame) => Words::Frame(Caption::new(&frame, live.is_behind()).with_error(error())),
        Content::File(file) => Words::File(FileCaption::new(&file, lab.document.image.resolution)),
    });
    let active = slot == lab.document.active_index();
    let response = ui.interact(place, ui.scope_id().with(("caption", slot)), Sense::click());
    let spoken = match &caption {
        Some(Words::Frame(caption)) => caption.spoken_line(),
        Some(Words::File(caption)) => caption.spoken_line(),
        None => "waiting".to_owned(),
    };
    response.widget_info(|| {
        egui::WidgetInfo::selected(Role::RadioButton, true, active, format!("Picture {}: {spoken}", slot + 1))
    });
    if response.clicked() {
        out.push(Command::Activate(slot));
    }
    let visuals = ui.visuals();
    let fill = if active { visuals.widgets.inactive.weak_bg_fill } else { visuals.panel_fill };
    ui.painter().rect_filled(place, 0.0, fill);
    let ink = slot_ink(ui, lab, slot);
    // The strategy's colour also where its name has no room.
    let edge = match align {
        Align::Max => place.with_min_x(place.right() - GRID),
        Align::Min | Align::Center => place.with_max_x(place.left() + GRID),
    };
    ui.painter().rect_filled(edge, 0.0, ink);
    let inner = place.shrink2(vec2(2.5 * GRID, 0.0));
    // Where all show the same the menu and the legend name it.
    let slots = lab.document.slots();
    let layer = slots.iter().any(|other| other.layer != slots[0].layer).then_some(slots[slot].layer);
    let layout = match align {
        Align::Max => Layout::right_to_left(Align::Center),
        Align::Min | Align::Center => Layout::left_to_right(Align::Center),
    };
    ui.scope_builder(UiBuilder::new().max_rect(inner).layout(layout), |ui| {
        ui.set_clip_rect(place.intersect(ui.clip_rect()));
        ui.spacing_mut().interact_size.y = 0.0;
        match &caption {
            Some(Words::Frame(caption)) => caption.line_ui(ui, alike(lab), layer),
            Some(Words::File(caption)) => caption.line_ui(ui, layer),
            None => waiting_ui(ui),
        }
    });
}

/// What the pictures are to have alike, and whether those on screen have it by now.
fn alike(lab: &Lab) -> Alike {
    let live = lab.engine.pictures().iter().filter(|live| live.kept().is_none());
    let number = |frame: Arc<Frame>| caption::number(lab.document.equal, &frame);
    let mut numbers = live.filter_map(LivePicture::frame).map(number);
    let first = numbers.next();
    Alike { what: lab.document.equal, exactly: numbers.all(|number| Some(&number) == first.as_ref()) }
}

/// Around the picture that controls are about.
fn frame_ui(ui: &Ui, cell: Rect) {
    let stroke = Stroke::new(FRAME, ui.visuals().text_color());
    ui.painter().rect_stroke(cell, 0.0, stroke, StrokeKind::Inside);
}
