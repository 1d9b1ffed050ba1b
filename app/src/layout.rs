//! Where everything is: strategy bar, columns, picture, caption, status.

use eframe::egui::{self, Align, Align2, CentralPanel, Color32, Frame, Layout, Margin, Panel, Rect, ScrollArea, Ui};
use mislab_renderer::State;

use crate::lab::Lab;
use crate::look::theme::{GRID, TypeScale};
use crate::panel::{
    caption, display, formula, help, menu, messages, open, palette, sampling, save, scene, status, strategy, table,
};
use crate::picture::pane::Subject;
use crate::state::command::Command;

/// Width in points at which both columns stand beside the picture.
pub const FULL_WIDTH: f32 = 1100.0;

/// Draws the window and collects what the user wants.
pub fn window_ui(ui: &mut Ui, lab: &mut Lab, out: &mut Vec<Command>) {
    let hall = lab.scale() == TypeScale::Hall;
    strategy_bar(ui, lab, out);
    if !hall {
        status_bar(ui, lab, out);
        // At a large interface scale the picture is worth more than the panels.
        if ui.available_width() > 620.0 {
            let width = width_taken(ui, |ui| left_column(ui, lab, out));
            lab.prefs.window.columns[0] = width;
        }
        if lab.prefs.inspector && ui.available_width() > 760.0 {
            let width = width_taken(ui, |ui| right_column(ui, lab, out));
            lab.prefs.window.columns[1] = width;
        }
    } else if ui.available_width() > 1.6 * ui.available_height() {
        // Beside a picture as high as the screen there is room for the blackboard.
        let panel = Panel::right("blackboard").resizable(false).exact_size(500.0).show_separator_line(false);
        panel.frame(column_frame(ui)).show(ui, |ui| {
            formula::formula_ui(ui, &lab.document.active().estimator, TypeScale::Hall);
        });
    }
    caption_strip(ui, lab);
    let place = CentralPanel::no_frame().show(ui, |ui| pictures(ui, lab, out)).inner;
    sheets(ui.ctx(), lab, place, out);
}

/// Draws a column and returns its width in whole points.
fn width_taken(ui: &mut Ui, draw: impl FnOnce(&mut Ui)) -> f32 {
    let before = ui.available_width();
    draw(ui);
    (before - ui.available_width()).round()
}

fn bar_frame(ui: &Ui) -> Frame {
    Frame::new().fill(ui.visuals().panel_fill).inner_margin(Margin::symmetric(12, 0))
}

fn column_frame(ui: &Ui) -> Frame {
    Frame::new().fill(ui.visuals().panel_fill).inner_margin(Margin { left: 12, right: 8, top: 4, bottom: 4 })
}

fn strategy_bar(ui: &mut Ui, lab: &Lab, out: &mut Vec<Command>) {
    let scale = lab.scale();
    let height = if scale == TypeScale::Hall { 88.0 } else { 52.0 };
    Panel::top("strategy bar").exact_size(height).frame(bar_frame(ui)).show(ui, |ui| {
        ui.horizontal_centered(|ui| {
            let slot = lab.document.active();
            let default_c = lab.document.opened.settings.estimator.light_prob;
            strategy::bar_ui(ui, &slot.estimator, default_c, scale, out);
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                menu::menu_ui(ui, &lab.prefs, &lab.history, out);
                let width = if scale == TypeScale::Hall { 400.0 } else { 236.0 };
                if ui.available_width() > width {
                    display::layer_menu(ui, slot.layer, width, out);
                }
            });
        });
    });
}

fn status_bar(ui: &mut Ui, lab: &Lab, out: &mut Vec<Command>) {
    let Some(status) = lab.live().status() else { return };
    Panel::bottom("status bar").exact_size(36.0).frame(bar_frame(ui)).show(ui, |ui| {
        ui.horizontal_centered(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0 * GRID;
            let frame = lab.live().current_frame();
            let work = status::Work { frame: frame.as_deref(), status: &status, threads: lab.engine.threads() };
            status::status_ui(ui, &work, &lab.document, out);
        });
    });
}

fn left_column(ui: &mut Ui, lab: &mut Lab, out: &mut Vec<Command>) {
    let panel = Panel::left("left column").default_size(lab.prefs.window.columns[0]).size_range(296.0..=520.0);
    panel.frame(column_frame(ui)).show(ui, |ui| {
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            let document = &lab.document;
            sampling::weights_ui(ui, &document.active().estimator, out);
            sampling::samples_ui(ui, &document.sampling, &document.opened.settings.sampling, out);
            sampling::pace_ui(ui, &lab.pacing, out);
            ui.add_space(GRID);
            lab.pointed_at = scene::scene_ui(ui, document, &lab.swatches, lab.panes.hovered(), out);
        });
    });
}

fn right_column(ui: &mut Ui, lab: &mut Lab, out: &mut Vec<Command>) {
    let panel = Panel::right("right column").default_size(lab.prefs.window.columns[1]).size_range(280.0..=560.0);
    panel.frame(column_frame(ui)).show(ui, |ui| {
        formula::formula_ui(ui, &lab.document.active().estimator, TypeScale::Desk);
        ui.separator();
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            messages::warnings_ui(ui, &lab.document.opened.warnings);
            display::display_ui(ui, &lab.document, out);
            ui.add_space(GRID);
            let spp = lab.snapshot_spp();
            save::save_ui(ui, &mut lab.destination, &mut lab.prefs.png, &lab.document, spp, out);
        });
    });
}

fn caption_strip(ui: &mut Ui, lab: &Lab) {
    let scale = lab.scale();
    let height = if scale == TypeScale::Hall { 52.0 } else { 30.0 };
    Panel::bottom("caption").exact_size(height).frame(bar_frame(ui)).show_separator_line(false).show(ui, |ui| {
        ui.horizontal_centered(|ui| {
            let frame = lab.live().frame();
            caption::caption_ui(ui, frame.as_deref(), lab.live().is_behind(), scale);
        });
    });
}

/// The pictures of all slots: for now there is one, over the whole place. Returns where it is.
fn pictures(ui: &mut Ui, lab: &mut Lab, out: &mut Vec<Command>) -> Rect {
    if let Some(frame) = lab.live().frame()
        && lab.prefs.panels
    {
        lab.swatches.update(ui.ctx(), &frame, &lab.document.view);
    }
    let mut place = ui.available_rect_before_wrap();
    for (slot, (pane, live)) in lab.panes.all_mut().iter_mut().zip(lab.engine.pictures()).enumerate() {
        let outdated = lab.files.is_outdated(lab.document.opened.path.as_deref());
        let subject = Subject { slot, live, pointed_at: lab.pointed_at, outdated, reading: lab.files.is_reading() };
        place = pane.ui(ui, &mut lab.document, &subject, out);
    }
    drop_target(ui, place);
    let failed = lab.live().status().filter(|s| s.state == State::Failed);
    let failed = failed.map(|s| s.error.unwrap_or_else(|| "this scene cannot be rendered".into()));
    messages::errors_ui(ui, place, &mut lab.messages, failed.as_deref(), out);
    place
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

/// What lies over the window.
fn sheets(ctx: &egui::Context, lab: &mut Lab, picture: Rect, out: &mut Vec<Command>) {
    let sheets = &mut lab.sheets;
    let on_top = sheets.help || sheets.palette.is_some() || sheets.open.is_some();
    if !on_top && ctx.input(|i| i.key_pressed(egui::Key::Escape)) {
        sheets.table.open = false;
        out.push(Command::DismissOpenError);
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
