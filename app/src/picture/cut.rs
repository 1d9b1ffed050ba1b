//! What is on screen and not on paper, such as buttons: left out with the room that it takes.

use std::ops::Range;

use eframe::egui::{Pos2, Rect, Ui, Vec2, vec2};

/// A place that is cut out.
pub struct Cut {
    /// Which shapes of the layer were drawn in it.
    shapes: Range<usize>,
    place: Rect,
    /// How what follows moves.
    move_by: Vec2,
}

impl Cut {
    /// What `ui` has drawn since its cursor was at `from`. In a row, what is to the right follows; else what is below.
    pub fn new(ui: &Ui, shapes: Range<usize>, from: Pos2) -> Self {
        let to = ui.cursor().min;
        let drawn = ui.min_rect();
        if ui.layout().is_horizontal() {
            let place = Rect::from_x_y_ranges(from.x..=to.x, drawn.y_range());
            Self { shapes, place, move_by: vec2(from.x - to.x, 0.0) }
        } else {
            let place = Rect::from_x_y_ranges(drawn.x_range(), from.y..=to.y);
            Self { shapes, place, move_by: vec2(0.0, from.y - to.y) }
        }
    }

    /// Whether the shape of that number is in it.
    pub fn holds(&self, shape: usize) -> bool {
        self.shapes.contains(&shape)
    }

    /// How a shape with that centre moves.
    pub fn moves(&self, centre: Pos2) -> Vec2 {
        let right = self.move_by.x != 0.0 && centre.x >= self.place.right() && self.place.y_range().contains(centre.y);
        let below = self.move_by.y != 0.0 && centre.y >= self.place.bottom();
        if right || below { self.move_by } else { Vec2::ZERO }
    }

    /// By how much the whole is shorter without it.
    pub fn height(&self) -> f32 {
        -self.move_by.y
    }
}
