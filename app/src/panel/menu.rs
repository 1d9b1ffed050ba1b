//! The menu at the right end of the strategy bar.

use eframe::egui::{Button, Ui};

use super::open::choices_ui;
use crate::look::theme::GRID;
use crate::state::command::Command;
use crate::state::history::History;
use crate::state::keys::{THEMES, bindings};
use crate::state::prefs::Prefs;

/// The menu button.
pub fn menu_ui(ui: &mut Ui, prefs: &Prefs, history: &History, out: &mut Vec<Command>) {
    ui.menu_button("Menu", |ui| {
        ui.set_min_width(300.0);
        let entry = |ui: &mut Ui, name: &str, command: Command, enabled: bool, out: &mut Vec<Command>| {
            let all = bindings();
            let keys = all.iter().find(|a| a.command == command).map_or("", |a| a.keys);
            if ui.add_enabled(enabled, Button::new(name).shortcut_text(keys)).clicked() {
                out.push(command);
                ui.close();
            }
        };
        entry(ui, "Open \u{2026}", Command::Open, true, out);
        entry(ui, "Open a typed path \u{2026}", Command::OpenTyped, true, out);
        ui.menu_button("Scenes and recent files", |ui| {
            if choices_ui(ui, &prefs.recent, out) {
                ui.close();
            }
        });
        entry(ui, "Read the open file again", Command::Reload, true, out);
        entry(ui, "Save a snapshot", Command::Save, true, out);
        entry(ui, "Copy the picture", Command::CopyPicture, true, out);
        ui.separator();
        entry(ui, "Undo", Command::Undo, history.can_undo(), out);
        entry(ui, "Redo", Command::Redo, history.can_redo(), out);
        ui.separator();
        entry(ui, "The tutorial's table \u{2026}", Command::ToggleTable, true, out);
        ui.separator();
        entry(ui, "Fit the picture", Command::Fit, true, out);
        entry(ui, "100 %: one pixel to one", Command::ActualSize, true, out);
        let name = if prefs.panels { "Projector view" } else { "Leave the projector view" };
        entry(ui, name, Command::TogglePanels, true, out);
        let name = if prefs.inspector { "Hide the right panel" } else { "Show the right panel" };
        entry(ui, name, Command::ToggleInspector, true, out);
        let name = if prefs.reduce_motion { "Motion as usual" } else { "Reduce motion" };
        entry(ui, name, Command::ToggleMotion, true, out);
        entry(ui, "Full screen", Command::ToggleFullScreen, true, out);
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = GRID;
            for (name, theme) in THEMES {
                if ui.add(Button::selectable(prefs.theme == theme, name)).clicked() {
                    out.push(Command::SetTheme(theme));
                }
            }
        });
        ui.separator();
        entry(ui, "All commands \u{2026}", Command::TogglePalette, true, out);
        entry(ui, "Keys \u{2026}", Command::ToggleHelp, true, out);
    });
}
