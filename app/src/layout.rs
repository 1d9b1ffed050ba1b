//! Where everything is: strategy bar, columns, picture, caption, status.

use eframe::egui::{
    self, Align, Align2, CentralPanel, Color32, Frame, Id, Layout, Margin, Panel, ScrollArea, Sense, Stroke, Ui, vec2,
};
use mislab_renderer::State;

use crate::app::MisLabApp;
use crate::look::theme::{GRID, TypeScale};
use crate::panel::{
    caption, display, formula, help, menu, messages, open, palette, sampling, save, scene, status, strategy, table,
};
use crate::picture::picking::{Projector, Target};
use crate::picture::viewport::legend_overlay;
use crate::state::command::Command;
use crate::state::document::Document;

/// Width in points at which both columns stand beside the picture.
pub const FULL_WIDTH: f32 = 1100.0;

/// Draws the window and collects what the user wants.
pub fn window_ui(app: &mut MisLabApp, ui: &mut Ui, out: &mut Vec<Command>) {
    let hall = app.scale() == TypeScale::Hall;
    strategy_bar(app, ui, out);
    if !hall {
        status_bar(app, ui, out);
        // At a large interface scale the picture is worth more than the panels.
        if ui.available_width() > 620.0 {
            left_column(app, ui, out);
        }
        if app.prefs.inspector && ui.available_width() > 760.0 {
            right_column(app, ui, out);
        }
    } else if ui.available_width() > 1.6 * ui.available_height() {
        // Beside a picture as high as the screen there is room for the blackboard.
        let panel = Panel::right("blackboard").resizable(false).exact_size(500.0).show_separator_line(false);
        panel.frame(column_frame(ui)).show(ui, |ui| {
            formula::formula_ui(ui, &app.document.settings, TypeScale::Hall);
        });
    }
    caption_strip(app, ui);
    CentralPanel::no_frame().show(ui, |ui| picture(app, ui, out));
    sheets(app, ui, out);
}

fn bar_frame(ui: &Ui) -> Frame {
    Frame::new().fill(ui.visuals().panel_fill).inner_margin(Margin::symmetric(12, 0))
}

fn column_frame(ui: &Ui) -> Frame {
    Frame::new().fill(ui.visuals().panel_fill).inner_margin(Margin { left: 12, right: 8, top: 4, bottom: 4 })
}

fn strategy_bar(app: &MisLabApp, ui: &mut Ui, out: &mut Vec<Command>) {
    let scale = app.scale();
    let height = if scale == TypeScale::Hall { 88.0 } else { 52.0 };
    Panel::top("strategy bar").exact_size(height).frame(bar_frame(ui)).show(ui, |ui| {
        ui.horizontal_centered(|ui| {
            let default_c = app.document.opened.settings.estimator.light_prob;
            strategy::bar_ui(ui, &app.document.settings, default_c, scale, out);
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                menu::menu_ui(ui, &app.prefs, app.history.can_undo(), app.history.can_redo(), out);
                let width = if scale == TypeScale::Hall { 400.0 } else { 236.0 };
                if ui.available_width() > width {
                    display::layer_menu(ui, &app.document.view, width, out);
                }
            });
        });
    });
}

fn status_bar(app: &MisLabApp, ui: &mut Ui, out: &mut Vec<Command>) {
    let Some(status) = app.engine.status() else { return };
    Panel::bottom("status bar").exact_size(36.0).frame(bar_frame(ui)).show(ui, |ui| {
        ui.horizontal_centered(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0 * GRID;
            let frame = app.engine.current_frame();
            let document = &app.document;
            status::status_ui(
                ui,
                frame.as_deref(),
                &document.settings,
                &document.view,
                &status,
                app.engine.threads(),
                out,
            );
        });
    });
}

fn left_column(app: &mut MisLabApp, ui: &mut Ui, out: &mut Vec<Command>) {
    let panel = Panel::left("left column").default_size(320.0).size_range(296.0..=520.0);
    panel.frame(column_frame(ui)).show(ui, |ui| {
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            let document = &app.document;
            sampling::sampling_ui(ui, &document.settings, &document.opened.settings, &app.pacing, out);
            ui.add_space(GRID);
            let in_picture = app.hovered_in_picture;
            app.hovered_in_panel = scene::scene_ui(ui, document, &app.swatches, in_picture, out);
        });
    });
}

fn right_column(app: &mut MisLabApp, ui: &mut Ui, out: &mut Vec<Command>) {
    let panel = Panel::right("right column").default_size(340.0).size_range(280.0..=560.0);
    panel.frame(column_frame(ui)).show(ui, |ui| {
        formula::formula_ui(ui, &app.document.settings, TypeScale::Desk);
        ui.separator();
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            messages::warnings_ui(ui, &app.document.opened.warnings);
            display::display_ui(ui, &app.document.view, &app.document.opened.view, out);
            ui.add_space(GRID);
            save::save_ui(ui, &mut app.prefs.save, app.save_error.as_deref(), out);
        });
    });
}

fn caption_strip(app: &MisLabApp, ui: &mut Ui) {
    let scale = app.scale();
    let height = if scale == TypeScale::Hall { 52.0 } else { 30.0 };
    Panel::bottom("caption").exact_size(height).frame(bar_frame(ui)).show_separator_line(false).show(ui, |ui| {
        ui.horizontal_centered(|ui| {
            let frame = app.engine.frame();
            caption::caption_ui(ui, frame.as_deref(), app.engine.is_behind(), scale);
        });
    });
}

fn picture(app: &mut MisLabApp, ui: &mut Ui, out: &mut Vec<Command>) {
    let dark = ui.visuals().dark_mode;
    let frame = app.engine.frame();
    if let Some(frame) = &frame
        && app.prefs.panels
    {
        app.swatches.update(ui.ctx(), frame, &app.document.view);
    }
    let stale = app.engine.marked_in().is_some_and(|wait| wait.is_zero());
    let shown = app.viewport.ui(ui, &mut app.document.view, frame.as_ref(), stale, dark);
    app.geometry = shown.geometry;
    app.pixel = shown.hovered_pixel;
    let rect = shown.response.rect;
    if let Some(frame) = &frame {
        let on_rim = light_rim(app, ui, rect, out);
        hovered_things(app, ui, rect, on_rim);
        legend_overlay(ui, rect, &app.document.view, dark);
        if let Some(pixel) = app.pixel {
            caption::pixel_overlay(ui, rect, frame, &app.document.view, pixel);
        }
    } else {
        let text = "Rendering the first picture \u{2026}";
        let font = egui::TextStyle::Heading.resolve(ui.style());
        ui.painter().text(rect.center(), Align2::CENTER_CENTER, text, font, ui.visuals().weak_text_color());
    }
    if ui.input(|i| !i.raw.hovered_files.is_empty()) {
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 0.0, Color32::from_black_alpha(160));
        let font = egui::TextStyle::Heading.resolve(ui.style());
        painter.text(rect.center(), Align2::CENTER_CENTER, "Drop a .pbrt or .exr to open it", font, Color32::WHITE);
    }
    errors(app, ui, rect, out);
}

/// Finds what the mouse is on in the picture and outlines it, and what it is on in the panel.
fn hovered_things(app: &mut MisLabApp, ui: &Ui, rect: egui::Rect, on_rim: Option<Target>) {
    let (Some(geometry), Some(frame)) = (app.geometry, app.engine.frame()) else { return };
    let scene = &app.document.scene;
    let projector = Projector::new(scene, frame.request().settings.image.resolution);
    let under_mouse = || {
        let at = app.pixel?.map(|i| i as f32 + 0.5);
        Target::of_shape(scene, projector.pick(scene, at)?)
    };
    app.hovered_in_picture = on_rim.or_else(under_mouse);
    let Some(target) = app.hovered_in_panel.or(app.hovered_in_picture) else { return };
    let painter = ui.painter_at(rect);
    for shape in target.shapes(scene) {
        for [a, b] in projector.outline(shape) {
            let line = [geometry.to_screen(a), geometry.to_screen(b)];
            painter.line_segment(line, Stroke::new(4.0, Color32::from_black_alpha(150)));
            painter.line_segment(line, Stroke::new(1.5, Color32::WHITE));
        }
    }
}

/// Within this distance, in points, the rim of a light is under the mouse.
const RIM: f32 = 7.0;

/// Drags the rim of a light: its radius follows the mouse. A double click goes back to the file's.
/// Returns the light whose rim the mouse is on.
fn light_rim(app: &mut MisLabApp, ui: &Ui, rect: egui::Rect, out: &mut Vec<Command>) -> Option<Target> {
    let (Some(geometry), Some(pointer)) = (app.geometry, ui.input(|i| i.pointer.latest_pos())) else { return None };
    let scene = &app.document.scene;
    let id = ui.scope_id().with("light rim");
    let dragged = app.dragged_light.filter(|_| ui.ctx().is_being_dragged(id));
    let projector = Projector::new(scene, app.document.settings.image.resolution);
    // The middle of a light's outline on screen, and its radius there.
    let outline = |shape: usize| {
        let [min, max] = projector.bounds(scene, Target::Light(shape))?;
        let (min, max) = (geometry.to_screen(min), geometry.to_screen(max));
        Document::radius(scene, shape)?;
        Some((min + 0.5 * (max - min), 0.25 * (max.x - min.x + max.y - min.y)))
    };
    let near =
        |shape: &usize| outline(*shape).is_some_and(|(middle, radius)| (middle.distance(pointer) - radius).abs() < RIM);
    let shape = dragged.or_else(|| scene.light_shapes().find(near))?;
    if dragged.is_none() && !rect.contains(pointer) {
        return None;
    }
    app.dragged_light = Some(shape);
    let handle = egui::Rect::from_center_size(pointer, egui::Vec2::splat(2.0 * RIM)).intersect(rect);
    let response = ui.interact(handle, id, Sense::click_and_drag());
    let response = response.on_hover_and_drag_cursor(egui::CursorIcon::ResizeHorizontal);
    let original = Document::radius(&app.document.opened.scene, shape);
    if response.double_clicked()
        && let Some(original) = original
    {
        out.push(Command::SetLightRadius(shape, original));
    } else if response.dragged()
        && response.drag_delta() != egui::Vec2::ZERO
        && let (Some((middle, on_screen)), Some(radius)) = (outline(shape), Document::radius(scene, shape))
        && on_screen > 0.0
    {
        // The outline grows in proportion to the radius as long as a light is small against its distance.
        let wanted = radius * middle.distance(pointer) / on_screen;
        let original = original.unwrap_or(radius);
        out.push(Command::SetLightRadius(shape, wanted.clamp(0.1 * original, 10.0 * original)));
    }
    (response.hovered() || response.dragged()).then_some(Target::Light(shape))
}

/// Over the picture: what could not be opened, rendered or drawn.
fn errors(app: &mut MisLabApp, ui: &mut Ui, rect: egui::Rect, _out: &mut Vec<Command>) {
    let failed = app.engine.status().filter(|s| s.state == State::Failed);
    let failed = failed.map(|s| s.error.unwrap_or_else(|| "this scene cannot be rendered".into()));
    if app.open_error.is_none() && failed.is_none() && app.gpu_error.is_none() {
        return;
    }
    let width = (rect.width() - 6.0 * GRID).min(760.0);
    let at = rect.center_top() + vec2(-0.5 * width, 3.0 * GRID);
    egui::Area::new(Id::unique("errors")).order(egui::Order::Middle).fixed_pos(at).show(ui.ctx(), |ui| {
        ui.set_width(width);
        if let Some(message) = failed {
            let remark = "Undo (Ctrl+Z) brings the last picture back.";
            messages::error_strip(ui, "This cannot be rendered", &message, remark);
        }
        if let Some(error) = &app.open_error {
            let name = error.path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
            let remark = "The picture on screen stays.";
            if messages::error_strip(ui, &format!("{name} was not opened"), &error.message, remark) {
                app.open_error = None;
            }
        }
        if let Some(message) = &app.gpu_error {
            let remark = "The picture is drawn by the processor from here on. Restarting the program tries again.";
            if messages::error_strip(ui, "Drawing without the graphics device", message, remark) {
                app.gpu_error = None;
            }
        }
    });
}

fn sheets(app: &mut MisLabApp, ui: &mut Ui, out: &mut Vec<Command>) {
    let ctx = ui.ctx().clone();
    let on_top = app.help || app.palette.is_some() || app.open_sheet.is_some();
    if !on_top && ctx.input(|i| i.key_pressed(egui::Key::Escape)) {
        app.table.open = false;
        app.open_error = None;
    }
    if app.table.open {
        table::table_ui(&ctx, &mut app.table, &app.document.scene, &app.prefs.save, &app.files);
    }
    if app.help {
        app.help = help::help_ui(&ctx);
    }
    if let Some(sheet) = &mut app.open_sheet
        && !open::open_ui(&ctx, sheet, &app.prefs.recent, out)
    {
        app.open_sheet = None;
    }
    if let Some(palette) = &mut app.palette
        && !palette::palette_ui(&ctx, palette, out)
    {
        app.palette = None;
    }
    let corner = ctx.content_rect().with_max_y(ctx.content_rect().bottom() - 36.0);
    messages::notices_ui(&ctx, &mut app.notices, corner);
}
