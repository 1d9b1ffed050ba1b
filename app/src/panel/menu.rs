//! The menu at the right end of the strategy bar.

use eframe::egui::{Button, Ui};

use super::open::choices_ui;
use crate::look::theme::GRID;
use crate::look::zoom::ZoomStep;
use crate::state::command::{Command, Figure};
use crate::state::document::Document;
use crate::state::history::{EditKey, History};
use crate::state::keys::{THEMES, bindings};
use crate::state::prefs::Prefs;

/// The menu button. `study`: one is open.
pub fn menu_ui(
    ui: &mut Ui,
    prefs: &Prefs,
    document: &Document,
    history: &History,
    study: bool,
    out: &mut Vec<Command>,
) {
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
        ui.menu_button("Export what is seen", |ui| {
            entry(ui, "As PNG", Command::Export(Figure::Png), true, out);
            entry(ui, "To the clipboard", Command::Export(Figure::Clipboard), true, out);
            entry(ui, "A study as SVG", Command::Export(Figure::Svg), study, out);
        });
        ui.separator();
        let named = |verb: &str, key: Option<EditKey>| {
            key.map_or_else(|| verb.to_owned(), |key| format!("{verb}: {}", key.words(document)))
        };
        entry(ui, &named("Undo", history.next_undo()), Command::Undo, history.next_undo().is_some(), out);
        entry(ui, &named("Redo", history.next_redo()), Command::Redo, history.next_redo().is_some(), out);
        ui.separator();
        entry(ui, "The tutorial's table \u{2026}", Command::ToggleTable, true, out);
        ui.separator();
        entry(ui, "Fit the picture", Command::Fit, true, out);
        entry(ui, "Fit plates and lights", Command::FitThings, true, out);
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
            ui.label("Interface");
            for (name, step) in [("\u{2212}", ZoomStep::Smaller), ("+", ZoomStep::Larger)] {
                if ui.button(name).accessible_name(format!("Interface {step:?}")).clicked() {
                    out.push(Command::ZoomInterface(step));
                }
            }
            let percent = format!("{:.0} %", 100.0 * prefs.zoom);
            if ui.button(percent).accessible_name("Interface at 100 %").clicked() {
                out.push(Command::ZoomInterface(ZoomStep::Reset));
            }
        });
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = GRID;
            ui.label("Theme");
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
