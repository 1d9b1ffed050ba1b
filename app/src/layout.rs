//! Where everything is: at a desk strategy bar, columns, picture, caption, status; in a hall the picture and one column.

mod hall;
mod stage;
mod study;

use std::sync::Arc;

use eframe::egui::{
    self, Align, Align2, CentralPanel, Color32, Frame, Key, Layout, Margin, Panel, Popup, Rect, ScrollArea, Ui,
    UiBuilder, vec2,
};
use mislab_renderer::{Layer, State};

use crate::lab::Lab;
use crate::look::theme::{GRID, TypeScale};
use crate::panel::caption::{Caption, aside_ui, waiting_ui};
use crate::panel::display::Measured;
use crate::panel::file_caption::{FROM_FILE, FileCaption};
use crate::panel::picture::PictureSheet;
use crate::panel::spread::spread_words;
use crate::panel::{
    compare, display, formula, help, hint, menu, messages, open, palette, picture, sampling, save, scene, status,
    strategy, table, warnings,
};
use crate::picture::content::Content;
use crate::picture::foreign::Foreign;
use crate::picture::legend::{self, legend_ui};
use crate::picture::sheet::{Recorder, Sheet};
use crate::state::arrangement::Arrangement;
use crate::state::command::Command;
use crate::state::edit::Edit;
use crate::state::study::Study;

/// Draws the window and collects what the user wants.
pub fn window_ui(ui: &mut Ui, lab: &mut Lab, out: &mut Vec<Command>) {
    escape(ui.ctx(), lab, out);
    let place = match lab.scale() {
        TypeScale::Desk => desk(ui, lab, out),
        TypeScale::Hall => hall::hall_ui(ui, lab, out),
    };
    sheets(ui.ctx(), lab, place, out);
    lab.sheets.typing = ui.ctx().text_edit_focused();
}

/// Returns where the pictures are.
fn desk(ui: &mut Ui, lab: &mut Lab, out: &mut Vec<Command>) -> Rect {
    strategy_bar(ui, lab, out);
    status_bar(ui, lab, out);
    // At a large interface scale the picture is worth more than the panels.
    let left = ui.available_width() > 620.0;
    let beside_it = ui.available_width() - if left { 320.0 } else { 0.0 };
    // A study beside the pictures takes the place of the column.
    let column = lab.prefs.inspector && !lab.studies.open.is_some_and(Study::is_beside_pictures);
    let right = column && beside_it > 760.0;
    if left {
        lab.prefs.window.columns[0] = width_taken(ui, |ui| left_column(ui, lab, !right, out));
    }
    if right {
        lab.prefs.window.columns[1] = width_taken(ui, |ui| right_column(ui, lab, out));
    }
    caption_strip(ui, lab, 40.0, out);
    CentralPanel::no_frame().show(ui, |ui| pictures(ui, lab, !left && !right, out)).inner
}

/// Draws a column and returns its width in whole points.
fn width_taken(ui: &mut Ui, draw: impl FnOnce(&mut Ui)) -> f32 {
    let before = ui.available_width();
    draw(ui);
    (before - ui.available_width()).round()
}

/// Without a ground: that is what the window is cleared with, and to fill it again costs a software driver as much as all that stands on it.
fn bar_frame() -> Frame {
    Frame::new().inner_margin(Margin::symmetric(12, 0))
}

fn column_frame() -> Frame {
    Frame::new().inner_margin(Margin { left: 12, right: 8, top: 4, bottom: 4 })
}

/// In a narrow window with a second row for what the first has no room for.
fn strategy_bar(ui: &mut Ui, lab: &Lab, out: &mut Vec<Command>) {
    // The menu needs its place at the right end.
    let room = ui.available_width() - strategy::row_width(ui) - 12.0 * GRID - 110.0 - LAYOUT_MENU - LAYER_MENU;
    let one_row = room > 140.0;
    let bar = Panel::top("strategy bar").exact_size(if one_row { BAR_ROW } else { 1.75 * BAR_ROW });
    bar.frame(bar_frame()).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        let row = |ui: &mut Ui, height: f32, add: &mut dyn FnMut(&mut Ui)| {
            let size = vec2(ui.available_width(), height);
            ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), add);
        };
        row(ui, BAR_ROW, &mut |ui| {
            let made = !lab.document.active().is_file();
            ui.add_enabled_ui(made, |ui| strategy::row_ui(ui, &lab.document.active().estimator, out));
            ui.add_space(2.0 * GRID);
            if one_row {
                bar_light_prob_ui(ui, lab, room, out);
            }
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                menu::menu_ui(ui, &lab.prefs, &lab.document, &lab.history, lab.studies.open.is_some(), out);
                if one_row {
                    bar_menus(ui, lab, out);
                }
            });
        });
        if !one_row {
            row(ui, 0.75 * BAR_ROW, &mut |ui| {
                let room = ui.available_width() - LAYOUT_MENU - LAYER_MENU - 4.0 * GRID;
                bar_light_prob_ui(ui, lab, room.max(140.0), out);
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| bar_menus(ui, lab, out));
            });
        }
    });
}

fn bar_light_prob_ui(ui: &mut Ui, lab: &Lab, room: f32, out: &mut Vec<Command>) {
    let default = lab.document.opened.settings.estimator.light_prob;
    strategy::light_prob_ui(ui, &lab.document.active().estimator, default, room.min(272.0), out);
}

fn bar_menus(ui: &mut Ui, lab: &Lab, out: &mut Vec<Command>) {
    compare::layout_menu(ui, &lab.document, lab.studies.open, LAYOUT_MENU - 3.0 * GRID, out);
    layer_menu(ui, lab, LAYER_MENU, out);
}

/// Height of the strategies in the bar.
const BAR_ROW: f32 = 48.0;
/// Width of the menu of layers in the bar.
const LAYER_MENU: f32 = 220.0;
/// Width of the menu of layouts in the bar, with the space before it.
const LAYOUT_MENU: f32 = 160.0;

fn layer_menu(ui: &mut Ui, lab: &Lab, width: f32, out: &mut Vec<Command>) {
    if ui.available_width() > width {
        display::layer_menu(ui, lab.document.active().layer, width, out);
    }
}

/// The caption of the picture that controls are about.
fn single_caption(lab: &Lab, frame: &mislab_renderer::Frame) -> Caption {
    let error = lab.measuring.rel_mse(lab.document.active_index(), lab.live());
    let spread = (lab.document.active().layer == Layer::Variance)
        .then(|| spread_words(frame, lab.document.view.variance_unit, lab.replicates.found()));
    Caption::new(frame, lab.live().is_behind()).with_error(error).with_spread(spread)
}

fn status_bar(ui: &mut Ui, lab: &Lab, out: &mut Vec<Command>) {
    let Some(status) = lab.live().status() else { return };
    Panel::bottom("status bar").exact_size(32.0).frame(bar_frame()).show(ui, |ui| {
        ui.horizontal_centered(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0 * GRID;
            let frame = lab.live().current_frame();
            let work = status::Work {
                frame: frame.as_deref(),
                status: &status,
                threads: lab.engine.threads(),
                table: lab.sheets.table.progress(),
            };
            status::status_ui(ui, &work, &lab.document, out);
        });
    });
}

/// With the legend at its lower end if there is no other column for it.
fn left_column(ui: &mut Ui, lab: &mut Lab, legend: bool, out: &mut Vec<Command>) {
    let panel = Panel::left("left column").default_size(lab.prefs.window.columns[0]).size_range(296.0..=520.0);
    panel.frame(column_frame()).show(ui, |ui| {
        let column = ui.max_rect().expand2(vec2(3.0 * GRID, 0.0));
        if legend {
            let strip =
                Panel::bottom("legend").resizable(false).frame(Frame::new().inner_margin(Margin::symmetric(0, 4)));
            strip.show(ui, |ui| active_legend_ui(ui, lab));
        }
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            hint::beside(ui, column, |ui| {
                let document = &lab.document;
                let made = !document.active().is_file();
                ui.add_enabled_ui(made, |ui| sampling::weights_ui(ui, &document.active().estimator, out));
                sampling::samples_ui(ui, document, out);
                sampling::pace_ui(ui, &lab.pacing, out);
                ui.add_space(GRID);
                lab.pointed_at = scene::scene_ui(ui, document, &lab.swatches, lab.panes.hovered(), out);
            });
        });
    });
}

fn right_column(ui: &mut Ui, lab: &mut Lab, out: &mut Vec<Command>) {
    let panel = Panel::right("right column").default_size(lab.prefs.window.columns[1]).size_range(280.0..=560.0);
    panel.frame(column_frame()).show(ui, |ui| {
        let column = ui.max_rect().expand2(vec2(3.0 * GRID, 0.0));
        let slot = *lab.document.active();
        let unit = lab.document.view.variance_unit;
        let here = lab.live().content().and_then(|content| lab.pane().here(&content, slot.layer, unit));
        formula::formula_ui(ui, (!slot.is_file()).then_some(&slot.estimator), TypeScale::Desk);
        ui.separator();
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            hint::beside(ui, column, |ui| {
                let measured = Measured { histogram: &lab.histogram, here };
                display::display_ui(ui, &lab.document, &measured, out);
                ui.add_space(GRID);
                let spp = lab.snapshot_spp();
                save::save_ui(ui, &mut lab.destination, &mut lab.prefs.png, &lab.document, spp, out);
            });
        });
    });
}

fn caption_strip(ui: &mut Ui, lab: &mut Lab, height: f32, out: &mut Vec<Command>) {
    let panel = Panel::bottom("caption").exact_size(height).frame(bar_frame()).show_separator_line(false);
    panel.show(ui, |ui| {
        ui.spacing_mut().interact_size.y = 0.0;
        ui.spacing_mut().item_spacing.y = 0.0;
        let hall = lab.scale() == TypeScale::Hall;
        let legend = if hall { LEGEND } else { 0.0 };
        let (place, right) = ui.max_rect().split_left_right_at_x(ui.max_rect().right() - legend);
        if hall {
            // A wide picture leaves no column for its legend.
            ui.scope_builder(UiBuilder::new().max_rect(right), |ui| active_legend_ui(ui, lab));
        }
        // Beside the second line of the caption.
        let lines = place.with_max_y(place.top() + height.min(hall::HALL_CAPTION));
        let (_, second) = lines.split_top_bottom_at_fraction(0.54);
        let opened = &lab.document.opened;
        let aside = second.with_min_x(second.right() - ASIDE.min(0.4 * second.width()));
        let warnings = opened.warnings.len();
        let add_aside = |ui: &mut Ui| (warnings > 0 || !hall) && aside_ui(ui, warnings);
        if ui.scope_builder(UiBuilder::new().max_rect(aside), add_aside).inner {
            let read = lab.sheets.warnings_read.as_ref().is_some_and(|read| Arc::ptr_eq(read, opened));
            lab.sheets.warnings_read = if read { None } else { Some(opened.clone()) };
        }
        if lab.document.slots().len() > 1 {
            // Each picture has its own caption.
            let place = place.shrink2(vec2(0.0, 2.0 * GRID)).with_max_x(aside.left() - 2.0 * GRID);
            ui.scope_builder(UiBuilder::new().max_rect(place), |ui| equal_ui(ui, lab, out));
            return;
        }
        ui.scope_builder(UiBuilder::new().max_rect(place), |ui| match lab.live().content() {
            Some(Content::Frame(frame)) => single_caption(lab, &frame).strip_ui(ui, ASIDE),
            Some(Content::File(file)) => file_caption_ui(ui, lab, &file),
            None => waiting_ui(ui),
        });
    });
}

/// The caption of the file that is shown alone.
fn file_caption_ui(ui: &mut Ui, lab: &Lab, file: &Foreign) {
    let caption = FileCaption::new(file, lab.document.image.resolution);
    ui.horizontal(|ui| caption.line_ui(ui, None));
}

/// What several pictures have alike, and of what scene they are.
fn equal_ui(ui: &mut Ui, lab: &Lab, out: &mut Vec<Command>) {
    ui.horizontal_centered(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0 * GRID;
        ui.spacing_mut().interact_size.y = lab.scale().row_height();
        ui.label("Equal");
        ui.allocate_ui(
            vec2(
                ui.available_width().min(14.0 * egui::TextStyle::Body.resolve(ui.style()).size),
                ui.available_height(),
            ),
            |ui| {
                compare::equal_ui(ui, &lab.document, out);
            },
        );
        let scene = egui::RichText::new(&lab.document.scene.name).text_style(egui::TextStyle::Small);
        ui.add(egui::Label::new(scene.color(ui.visuals().weak_text_color())).truncate());
    });
}

/// The legend of the picture that controls are about.
fn active_legend_ui(ui: &mut Ui, lab: &Lab) {
    let layer = lab.document.active().layer;
    let unit = lab.document.view.variance_unit;
    let here = lab.live().content().and_then(|content| lab.pane().here(&content, layer, unit));
    legend_ui(ui, legend::Key { quantity: layer.into(), view: &lab.document.view, here });
}

/// Width of the legend in the strip of the projector view.
const LEGEND: f32 = 440.0;

/// Width of what stands at the right end of the caption's second line.
const ASIDE: f32 = 180.0;

/// The pictures, and what lies over them. `legend`: on or beside each. Returns where they are.
fn pictures(ui: &mut Ui, lab: &mut Lab, legend: bool, out: &mut Vec<Command>) -> Rect {
    if let Some(content) = lab.live().content()
        && lab.prefs.panels
    {
        lab.histogram.update(ui.ctx(), &content, lab.document.active().layer);
        if let Content::Frame(frame) = &content {
            lab.swatches.update(ui.ctx(), frame, &lab.document.view);
        }
    }
    let place = ui.available_rect_before_wrap();
    lab.studies.rest();
    let open = lab.studies.open;
    let [stage, beside] = study::divide(place, open);
    if let Some(stage) = stage {
        recorded(ui, lab, open.is_none(), stage, |ui, lab| {
            ui.scope_builder(UiBuilder::new().max_rect(stage), |ui| stage::stage_ui(ui, lab, legend, out));
        });
    }
    if let (Some(open), Some(beside)) = (open, beside) {
        recorded(ui, lab, true, beside, |ui, lab| study::study_ui(ui, lab, open, beside, out));
    }
    ui.advance_cursor_after_rect(place);
    drop_target(ui, place);
    let failed = lab.live().status().filter(|s| s.state == State::Failed);
    let failed = failed.map(|s| s.error.unwrap_or_else(|| "this scene cannot be rendered".into()));
    let running = lab.document.opened.path.as_deref();
    messages::errors_ui(ui, place, &mut lab.messages, messages::Trouble { failed: failed.as_deref(), running }, out);
    if warnings_open(lab) && warnings::sheet_ui(ui.ctx(), place, &lab.document.opened.warnings) {
        lab.sheets.warnings_read = Some(lab.document.opened.clone());
    }
    place
}

/// Draws `add`; keeps what it has drawn where a figure of it is asked for.
fn recorded(ui: &mut Ui, lab: &mut Lab, wanted: bool, place: Rect, add: impl FnOnce(&mut Ui, &mut Lab)) {
    let wanted = wanted && !lab.figures.is_empty();
    if wanted && Recorder::is_mouse_forgotten(ui.ctx()) {
        lab.sheet = Some(Sheet::record(ui, place, |ui| add(ui, lab)));
        return;
    }
    add(ui, lab);
    if wanted {
        ui.ctx().request_repaint();
    }
}

fn warnings_open(lab: &Lab) -> bool {
    let opened = &lab.document.opened;
    let read = lab.sheets.warnings_read.as_ref().is_some_and(|read| Arc::ptr_eq(read, opened));
    !read && !opened.warnings.is_empty()
}

/// Says that a file over the window can be dropped.
fn drop_target(ui: &Ui, rect: Rect) {
    if ui.input(|i| !i.raw.hovered_files.is_empty()) {
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 0.0, Color32::from_black_alpha(160));
        let font = egui::TextStyle::Heading.resolve(ui.style());
        painter.text(rect.center(), Align2::CENTER_CENTER, "Drop a .pbrt or .exr to open it", font, Color32::WHITE);
    }
}

/// One press of Escape closes one thing, the foremost. Sheets, menus and fields being typed in take it for themselves.
fn escape(ctx: &egui::Context, lab: &mut Lab, out: &mut Vec<Command>) {
    let open = warnings_open(lab);
    let Lab { sheets, studies, messages, document, .. } = lab;
    let taken = sheets.help
        || sheets.palette.is_some()
        || sheets.open.is_some()
        || sheets.typing
        || Popup::is_any_open(ctx)
        || ctx.dragged_id().is_some();
    if taken || !ctx.input(|i| i.key_pressed(Key::Escape)) {
        return;
    }
    if sheets.picture.is_some() {
        sheets.picture = None;
    } else if sheets.table.open {
        sheets.table.open = false;
    } else if messages.open_error.is_some() {
        messages.open_error = None;
    } else if messages.save_error.is_some() {
        messages.save_error = None;
    } else if messages.gpu_error.is_some() {
        messages.gpu_error = None;
    } else if open {
        sheets.warnings_read = Some(document.opened.clone());
    } else if studies.step_back() {
        // One picture of a study is gone, all of them are there again; or a pixel is let go.
    } else if let Some(study) = studies.open {
        out.push(Command::ToggleStudy(study));
    } else if document.arrangement() != Arrangement::One {
        out.push(Edit::Arrange(Arrangement::One).into());
    }
}

/// What lies over the window.
fn sheets(ctx: &egui::Context, lab: &mut Lab, picture: Rect, out: &mut Vec<Command>) {
    let sheets = &mut lab.sheets;
    if let Some(sheet) = &mut sheets.picture
        && !picture::picture_ui(ctx, sheet)
    {
        sheets.compared = sheets.picture.take().and_then(PictureSheet::compared);
    }
    if sheets.table.open {
        let folder = lab.destination.folder(&lab.document);
        table::table_ui(ctx, &mut sheets.table, &lab.document.scene, &folder, &mut lab.files);
    }
    if sheets.help {
        sheets.help = help::help_ui(ctx);
    }
    if let Some(sheet) = &mut sheets.open
        && !open::open_ui(ctx, sheet, &lab.prefs.recent, out)
    {
        sheets.open = None;
    }
    if let Some(palette) = &mut sheets.palette
        && !palette::palette_ui(ctx, palette, out)
    {
        sheets.palette = None;
    }
    // Not over buttons, nor over the values of the pixel; in the hall beside the picture, where there is room.
    let corner = if lab.prefs.panels { picture } else { ctx.content_rect() };
    let corner = corner.with_max_y(picture.bottom() - 64.0);
    messages::notices_ui(ctx, &mut lab.messages, lab.files.work().as_deref(), corner, out);
}
