//! Zoom and pan.

use eframe::egui::{self, Pos2, Rect, pos2, vec2};
use mislab::state::placement::{Geometry, Placement};
use mislab::state::view::ViewState;

use crate::window::undrawn;

fn geometry(placement: Placement, pixels_per_point: f32) -> Geometry {
    Geometry::new(Rect::from_min_size(pos2(13.0, 29.0), vec2(640.0, 480.0)), [800, 800], placement, pixels_per_point)
}

#[test]
fn fit_shows_the_whole_picture_in_the_middle() {
    let fitted = geometry(Placement::Fit, 1.25);
    let picture = fitted.picture_rect();
    assert!((picture.height() - 480.0).abs() < 1e-3 && (picture.width() - 480.0).abs() < 1e-3, "{picture:?}");
    assert!((picture.center() - fitted.viewport.center()).length() < 1.0, "{picture:?}");
    let back = fitted.to_image(fitted.to_screen([123.0, 456.0]));
    assert!((back[0] - 123.0).abs() < 1e-2 && (back[1] - 456.0).abs() < 1e-2, "{back:?}");
}

#[test]
fn a_part_fills_the_viewport_as_far_as_it_can() {
    let part = Placement::Part([[100.0, 200.0], [700.0, 500.0]]);
    let fitted = geometry(part, 1.25);
    let corners = [fitted.to_screen([100.0, 200.0]), fitted.to_screen([700.0, 500.0])];
    assert!((corners[1].x - corners[0].x - 640.0).abs() < 1e-2, "the whole width: {corners:?}");
    let middle = pos2(0.5 * (corners[0].x + corners[1].x), 0.5 * (corners[0].y + corners[1].y));
    assert!((middle - fitted.viewport.center()).length() < 1.0, "{corners:?}");
    assert_eq!(part.aspect([800, 800]), 2.0);
    assert_eq!(Placement::Fit.aspect([800, 400]), 2.0);
}

#[test]
fn zoom_keeps_what_is_under_the_pointer() {
    for pixels_per_point in [1.0, 2.0] {
        let pointer = pos2(300.0, 333.0);
        let mut view = ViewState::default();
        let start = geometry(view.placement, pixels_per_point);
        let under = start.to_image(pointer);
        // Many small steps in and out again, as a wheel makes them.
        for step in 0..200 {
            let now = geometry(view.placement, pixels_per_point);
            view.placement.zoom_about(&now, pointer, if step < 100 { 1.05 } else { 1.0 / 1.04 });
            let now = geometry(view.placement, pixels_per_point);
            let error = (now.to_screen(under) - pointer).length() * pixels_per_point;
            // The picture's corner is rounded to a whole pixel on either axis.
            assert!(error < 1.0, "step {step}: {error} pixels off");
        }
    }
}

#[test]
fn zoom_and_pan_stop_at_their_limits() {
    let mut view = ViewState::default();
    for (factor, limit) in [(1e9, Placement::MAX_SCALE), (1e-9, Placement::MIN_SCALE)] {
        let now = geometry(view.placement, 1.0);
        view.placement.zoom_about(&now, pos2(300.0, 300.0), factor);
        assert_eq!(geometry(view.placement, 1.0).scale, limit);
    }
    view.placement.pan_by(&geometry(view.placement, 1.0), vec2(1e7, -1e7));
    let now = geometry(view.placement, 1.0);
    assert!(now.viewport.expand(2.0).intersects(now.picture_rect()), "the picture is lost at {:?}", now.picture_rect());
    let before = view.clone();
    for factor in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        view.placement.zoom_about(&now, Pos2::ZERO, factor);
    }
    assert_eq!(view, before, "a factor that is none changes nothing");
}

#[test]
fn wheel_drag_and_double_click_move_the_picture() {
    let mut harness = undrawn([400.0, 300.0]);
    let fitted = harness.state().geometry();
    let pointer = fitted.to_screen([30.5, 20.5]);
    harness.hover_at(pointer);
    harness.run();
    assert_eq!(harness.state().hovered(), Some([30, 20]));

    harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: vec2(0.0, 4.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: egui::Modifiers::NONE,
    });
    harness.run();
    let zoomed = harness.state().geometry();
    assert!(zoomed.scale > 1.5 * fitted.scale, "scale {} after {}", zoomed.scale, fitted.scale);
    assert_eq!(harness.state().hovered(), Some([30, 20]), "the pixel under the pointer stays");

    harness.drag_at(pointer);
    harness.run();
    harness.hover_at(pointer + vec2(-40.0, 25.0));
    harness.run();
    assert_eq!(harness.state().hovered(), Some([30, 20]), "the picture follows the pointer");
    harness.drop_at(pointer + vec2(-40.0, 25.0));
    harness.run();
    assert_eq!(harness.state().geometry().scale, zoomed.scale);

    for pressed in [true, false, true, false] {
        harness.event(egui::Event::PointerButton {
            pos: pointer,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: egui::Modifiers::NONE,
        });
    }
    harness.run();
    assert_eq!(harness.state().view.placement, Placement::Fit);
    assert_eq!(harness.state().geometry(), fitted);
}

#[test]
fn absurd_stored_numbers_still_give_a_picture() {
    for scale in [f32::NAN, f32::INFINITY, -1.0, 0.0] {
        let placed = geometry(Placement::Free { scale, centre: [f32::NAN, 1e30] }, 1.0);
        assert!(placed.scale > 0.0 && placed.origin.iter().all(|v| v.is_finite()), "{placed:?}");
        assert!(placed.viewport.expand(2.0).intersects(placed.picture_rect()), "{placed:?}");
    }
}
