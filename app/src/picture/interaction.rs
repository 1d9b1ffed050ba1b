//! The mouse on the picture: what it is on, outlined, and the rim of a light, which can be dragged.

use eframe::egui::{self, Color32, Pos2, Rect, Sense, Stroke, Ui, Vec2};

use crate::picture::picking::{Finder, Target};
use crate::state::command::Command;
use crate::state::document::Document;
use crate::state::edit::Edit;
use crate::state::placement::Geometry;

/// Within this distance, in points, the rim of a light is under the mouse.
const RIM: f32 = 7.0;

/// What is where in one pass.
pub struct Place<'a> {
    /// The scene that is pointed at and edited.
    pub document: &'a Document,
    /// Where its picture is on screen.
    pub geometry: Geometry,
    /// The pixel under the mouse.
    pub pixel: Option<[u32; 2]>,
}

impl Place<'_> {
    fn finder(&self) -> Finder<'_> {
        Finder::new(&self.document.scene, self.geometry.image)
    }
}

/// What the mouse does on one picture.
#[derive(Debug, Default)]
pub struct Interaction {
    hovered: Option<Target>,
    dragged_light: Option<usize>,
}

impl Interaction {
    /// What the mouse was on in the last pass.
    pub fn hovered(&self) -> Option<Target> {
        self.hovered
    }

    /// Finds what the mouse is on, drags it, and outlines it; or else `pointed_at`, what it is on in a panel.
    pub fn ui(&mut self, ui: &Ui, place: &Place<'_>, pointed_at: Option<Target>, out: &mut Vec<Command>) {
        let on_rim = self.drag_rim(ui, place, out);
        let under_mouse = || {
            let at = place.pixel?.map(|i| i as f32 + 0.5);
            Target::of_shape(&place.document.scene, place.finder().pick(at)?)
        };
        self.hovered = on_rim.or_else(under_mouse);
        if let Some(target) = pointed_at.or(self.hovered) {
            outline(ui, place, target);
        }
    }

    /// Drags the rim of a light: its radius follows the mouse. A double click goes back to the file's.
    /// Returns the light whose rim the mouse is on.
    fn drag_rim(&mut self, ui: &Ui, place: &Place<'_>, out: &mut Vec<Command>) -> Option<Target> {
        let pointer = ui.input(|i| i.pointer.latest_pos())?;
        let (scene, viewport) = (&place.document.scene, place.geometry.viewport);
        let id = ui.scope_id().with("light rim");
        let dragged = self.dragged_light.filter(|_| ui.ctx().is_being_dragged(id));
        let finder = place.finder();
        let near = |shape: &usize| {
            rim(&finder, place, *shape).is_some_and(|rim| (rim.middle.distance(pointer) - rim.on_screen).abs() < RIM)
        };
        let shape = dragged.or_else(|| scene.light_shapes().find(near))?;
        if dragged.is_none() && !viewport.contains(pointer) {
            return None;
        }
        self.dragged_light = Some(shape);
        let handle = Rect::from_center_size(pointer, Vec2::splat(2.0 * RIM)).intersect(viewport);
        let response = ui.interact(handle, id, Sense::click_and_drag());
        let across = rim(&finder, place, shape).map_or(Vec2::X, |rim| pointer - rim.middle);
        let response = response.on_hover_and_drag_cursor(resize_cursor(across));
        let original = Document::radius(&place.document.opened.scene, shape);
        if response.double_clicked()
            && let Some(original) = original
        {
            out.push(Edit::SetLightRadius(shape, original).into());
        } else if response.dragged()
            && response.drag_delta() != Vec2::ZERO
            && let Some(rim) = rim(&finder, place, shape)
            && rim.on_screen > 0.0
        {
            // The outline grows in proportion to the radius as long as a light is small against its distance.
            let wanted = rim.radius * rim.middle.distance(pointer) / rim.on_screen;
            let original = original.unwrap_or(rim.radius);
            out.push(Edit::SetLightRadius(shape, wanted.clamp(0.1 * original, 10.0 * original)).into());
        }
        (response.hovered() || response.dragged()).then_some(Target::Light(shape))
    }
}

/// The outline of a light, taken for a circle.
struct Rim {
    /// Its middle on screen.
    middle: Pos2,
    /// Its radius there, in points.
    on_screen: f32,
    /// Its radius in the scene.
    radius: f32,
}

fn rim(finder: &Finder<'_>, place: &Place<'_>, shape: usize) -> Option<Rim> {
    let [min, max] = finder.bounds(Target::Light(shape))?.map(|at| place.geometry.to_screen(at));
    let radius = Document::radius(&place.document.scene, shape)?;
    Some(Rim { middle: min + 0.5 * (max - min), on_screen: 0.25 * (max.x - min.x + max.y - min.y), radius })
}

/// The arrows along `direction` on screen.
fn resize_cursor(direction: Vec2) -> egui::CursorIcon {
    // Eighths of a turn, those opposite to each other alike.
    match (direction.angle() / std::f32::consts::FRAC_PI_4).round().rem_euclid(4.0) as u32 {
        0 => egui::CursorIcon::ResizeHorizontal,
        1 => egui::CursorIcon::ResizeNwSe,
        2 => egui::CursorIcon::ResizeVertical,
        _ => egui::CursorIcon::ResizeNeSw,
    }
}

fn outline(ui: &Ui, place: &Place<'_>, target: Target) {
    let painter = ui.painter_at(place.geometry.viewport);
    let finder = place.finder();
    for shape in target.shapes(&place.document.scene) {
        for line in finder.outline(shape) {
            let line = line.map(|at| place.geometry.to_screen(at));
            painter.line_segment(line, Stroke::new(4.0, Color32::from_black_alpha(150)));
            painter.line_segment(line, Stroke::new(1.5, Color32::WHITE));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::{CursorIcon, vec2};

    #[test]
    fn arrows_point_where_a_drag_goes() {
        assert_eq!(resize_cursor(vec2(1.0, 0.1)), CursorIcon::ResizeHorizontal);
        assert_eq!(resize_cursor(vec2(-1.0, 0.1)), CursorIcon::ResizeHorizontal);
        assert_eq!(resize_cursor(vec2(0.0, -1.0)), CursorIcon::ResizeVertical);
        assert_eq!(resize_cursor(vec2(1.0, 1.0)), CursorIcon::ResizeNwSe, "down to the right");
        assert_eq!(resize_cursor(vec2(1.0, -1.0)), CursorIcon::ResizeNeSw);
    }
}
