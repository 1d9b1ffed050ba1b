//! The command palette: every command by name.

use eframe::egui::{self, Align2, Id, Key, Modal, Modifiers, ScrollArea, TextEdit, TextStyle, vec2};

use crate::look::theme::GRID;
use crate::panel::widgets::sheet_type;
use crate::state::command::Command;
use crate::state::keys::{Action, actions};

/// What has been typed, and which line is marked.
#[derive(Default)]
pub struct Palette {
    text: String,
    marked: usize,
}

/// The palette. Returns false when it is done with.
pub fn palette_ui(ctx: &egui::Context, palette: &mut Palette, out: &mut Vec<Command>) -> bool {
    let mut chosen: Option<Command> = None;
    let area = Modal::default_area(Id::unique("palette")).anchor(Align2::CENTER_TOP, vec2(0.0, 80.0));
    let modal = Modal::new(Id::unique("palette")).area(area).show(ctx, |ui| {
        sheet_type(ui);
        ui.set_width(520.0_f32.min(ctx.content_rect().width() - 40.0));
        let (down, up, enter) = ui.input_mut(|i| {
            (
                i.count_and_consume_key(Modifiers::NONE, Key::ArrowDown),
                i.count_and_consume_key(Modifiers::NONE, Key::ArrowUp),
                i.key_pressed(Key::Enter),
            )
        });
        let edit = TextEdit::singleline(&mut palette.text).hint_text("What to do").desired_width(f32::INFINITY);
        let edit = ui.add(edit).accessible_name("Command");
        edit.request_focus();
        let found: Vec<Action> = actions().into_iter().filter(|a| matches(&a.name, a.group, &palette.text)).collect();
        if edit.changed() {
            palette.marked = 0;
        }
        palette.marked = (palette.marked + down).saturating_sub(up).min(found.len().saturating_sub(1));
        ui.add_space(GRID);
        let height = (ctx.content_rect().height() - 200.0).clamp(80.0, 420.0);
        ScrollArea::vertical().max_height(height).auto_shrink([false, true]).show(ui, |ui| {
            for (index, action) in found.iter().enumerate() {
                let on = index == palette.marked;
                let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 30.0), egui::Sense::click());
                response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, on, &action.name));
                if on || response.hovered() {
                    let fill =
                        if on { ui.visuals().selection.bg_fill } else { ui.visuals().widgets.hovered.weak_bg_fill };
                    ui.painter().rect_filled(rect, 4.0, fill);
                }
                if on && (down > 0 || up > 0) {
                    response.scroll_to_me(None);
                }
                let font = TextStyle::Body.resolve(ui.style());
                let small = TextStyle::Small.resolve(ui.style());
                let inner = rect.shrink2(vec2(2.0 * GRID, 0.0));
                let (text, weak) = (ui.visuals().text_color(), ui.visuals().weak_text_color());
                ui.painter().text(inner.left_center(), Align2::LEFT_CENTER, &action.name, font, text);
                let right = if action.keys.is_empty() { action.group } else { action.keys };
                ui.painter().text(inner.right_center(), Align2::RIGHT_CENTER, right, small, weak);
                if response.clicked() || (on && enter) {
                    chosen = Some(action.command.clone());
                }
            }
            if found.is_empty() {
                ui.weak("No command of that name.");
            }
        });
    });
    let done = chosen.is_some() || modal.should_close();
    out.extend(chosen);
    !done
}

/// Every word typed is somewhere in the name.
fn matches(name: &str, group: &str, typed: &str) -> bool {
    let text = format!("{group} {name}").to_lowercase();
    typed.to_lowercase().split_whitespace().all(|word| text.contains(word))
}
