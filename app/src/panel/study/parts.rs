//! Which part of the picture a study is about: all of it, a square, or the rectangle that is selected.

use eframe::egui::{ComboBox, Ui};
use mislab_renderer::PixelRect;
use mislab_renderer::study::{Cells, Part};

use crate::panel::hint::Hint as _;

/// The part chosen. A rectangle is chosen by being selected in a picture, and left when it is not any more.
#[derive(Default)]
pub struct Chosen {
    part: Part,
    selected: Option<PixelRect>,
}

impl Chosen {
    /// What was chosen.
    pub fn part(&self) -> Part {
        self.part
    }

    /// To be called in each pass with what is selected in the pictures and what there are of squares.
    pub fn follow(&mut self, selected: Option<PixelRect>, squares: usize) {
        if selected != self.selected {
            self.selected = selected;
            self.part = selected.map_or(Part::Whole, Part::Rect);
        }
        if matches!(self.part, Part::Square(index) if index >= squares) {
            self.part = Part::Whole;
        }
    }

    /// Chooses one.
    pub fn set(&mut self, part: Part) {
        self.part = part;
    }

    /// All that can be chosen from.
    pub fn all(&self, cells: Option<&Cells>) -> Vec<Part> {
        let known = cells.map_or_else(|| vec![Part::Whole], |cells| cells.parts().collect());
        known.into_iter().chain(self.selected.map(Part::Rect)).collect()
    }

    /// A menu of all parts, of that width.
    pub fn menu(&mut self, ui: &mut Ui, cells: Option<&Cells>, width: f32) {
        let combo = ComboBox::from_id_salt("part").width(width).truncate();
        let response = combo.selected_text(part_name(cells, self.part)).show_ui(ui, |ui| {
            for part in self.all(cells) {
                ui.selectable_value(&mut self.part, part, part_name(cells, part));
            }
        });
        response.response.accessible_name("Part of the picture").hint(
            "The whole picture, one plate under one light, or a rectangle: Shift and drag in a picture selects one, Shift \
             and click none.",
        );
    }
}

/// Names of the parts as chosen from a menu and as written in files, without a comma.
pub fn part_name(cells: Option<&Cells>, part: Part) -> String {
    let square = |index: usize| cells.and_then(|cells| cells.squares.get(index));
    match part {
        Part::Whole => "whole picture".to_owned(),
        Part::Square(index) => {
            square(index).map_or_else(String::new, |square| format!("{} under {}", square.plate, square.light))
        }
        Part::Rect(PixelRect { min: [left, top], max: [right, bottom] }) => {
            format!("{} \u{d7} {} pixels from x {left} y {top}", right - left, bottom - top)
        }
    }
}
