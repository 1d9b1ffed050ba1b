//! Several pictures: how they lie in the window, and what they have alike.

use eframe::egui::{Button, ComboBox, Label, TextStyle, Ui};
use mislab_renderer::Lockstep;

use crate::look::names::equal_name;
use crate::look::versus::Versus;
use crate::panel::hint::Hint as _;
use crate::panel::widgets::segmented;
use crate::picture::sheet::Recorder;
use crate::state::arrangement::Arrangement;
use crate::state::command::Command;
use crate::state::document::Document;
use crate::state::edit::Edit;
use crate::state::keys::{EQUAL, bindings};
use crate::state::study::Study;

/// The layouts in one menu.
pub fn layout_menu(ui: &mut Ui, document: &Document, study: Option<Study>, width: f32, out: &mut Vec<Command>) {
    let response = ComboBox::from_id_salt("layout menu")
        .width(width)
        .truncate()
        .selected_text(document.arrangement().name())
        .show_ui(ui, |ui| {
            ui.set_min_width(200.0);
            let keys = bindings();
            for arrangement in Arrangement::ALL {
                let command = Command::from(Edit::Arrange(arrangement));
                let key = keys.iter().find(|action| action.command == command).map_or("", |action| action.keys);
                let on = arrangement == document.arrangement();
                let row = ui.add(Button::selectable(on, arrangement.name()).shortcut_text(key));
                if row.accessible_name(format!("Layout: {}", arrangement.name())).clicked() {
                    out.push(command);
                    ui.close();
                }
            }
            ui.separator();
            for entry in Study::ALL {
                let command = Command::ToggleStudy(entry);
                let key = keys.iter().find(|action| action.command == command).map_or("", |action| action.keys);
                let row = ui.add(Button::selectable(study == Some(entry), entry.name()).shortcut_text(key));
                if row.accessible_name(format!("Study: {}", entry.name())).clicked() {
                    out.push(command);
                    ui.close();
                }
            }
            ui.separator();
            if ui.add(Button::selectable(false, "Keep, go on beside it").shortcut_text("K")).clicked() {
                out.push(Command::Keep);
                ui.close();
            }
            if ui.add(Button::selectable(false, "Compare with an EXR \u{2026}").shortcut_text("Shift+K")).clicked() {
                out.push(Command::Compare);
                ui.close();
            }
            if document.slots().len() > 1
                && ui.add(Button::selectable(false, "This layer in all").shortcut_text("L")).clicked()
            {
                out.push(Edit::ShareLayer.into());
                ui.close();
            }
        })
        .response;
    response.accessible_name("Layout").hint("One picture, two or four of them. (A, B, W, H, D, Q; Escape: one)");
}

/// Height of what is sure of two pictures over that width: one line, or two where type is large.
pub fn found_height(ui: &Ui, width: f32) -> f32 {
    let style = TextStyle::Body;
    let lines = if width < WIDE * style.resolve(ui.style()).size { 2.0 } else { 1.0 };
    lines * ui.text_style_height(&style)
}

/// So many times the size of its type has one line of that room for the longest sentence.
const WIDE: f32 = 60.0;

/// Which number of two pictures is shown, and under it what is sure of them.
pub fn versus_ui(ui: &mut Ui, document: &Document, found: &str, out: &mut Vec<Command>) {
    let choices = Versus::ALL.map(|versus| (versus, versus.name()));
    let hint = |ui: &mut Ui, versus: Versus| {
        ui.label(versus.description());
    };
    // The legend says which one it is.
    Recorder::on_screen_only(ui, |ui| {
        ui.scope(|ui| {
            ui.set_max_width(ui.available_width().min(18.0 * TextStyle::Body.resolve(ui.style()).size));
            let picked = segmented(ui, "A against B", document.view.versus, &choices, true, &hint);
            out.extend(picked.map(|versus| Edit::SetVersus(versus).into()));
        });
    });
    let response = ui.add(Label::new(found).wrap());
    response.hint("With its 95 % band: of the plate under the light that the mouse is on, or of all. Shift and drag in the picture: of that part, until Shift and click.");
}

/// What the pictures have alike, over the width given.
pub fn equal_ui(ui: &mut Ui, document: &Document, out: &mut Vec<Command>) {
    let choices = EQUAL.map(|equal| (equal, equal_name(equal)));
    let hint = |ui: &mut Ui, equal: Lockstep| {
        ui.label(match equal {
            Lockstep::Spp => "The same samples per pixel, whatever they cost.",
            Lockstep::Rays => {
                "The same rays per pixel: \u{201c}MIS, both\u{201d} traces two a sample and has half the samples."
            }
            Lockstep::CpuSeconds => "The same processor time: what one would get by waiting as long.",
        });
    };
    let picked = segmented(ui, "Equal", document.equal, &choices, true, &hint);
    out.extend(picked.map(|equal| Edit::SetEqual(equal).into()));
}
