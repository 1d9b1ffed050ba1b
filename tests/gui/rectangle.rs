//! Curves and means over a rectangle that is dragged out in a picture.

use eframe::egui::{self, Key, Modifiers};
use mislab::state::edit::{Edit, SppTarget};

use crate::lab::Lab;

fn with_shift(lab: &mut Lab, at: egui::Pos2, pressed: Option<bool>) {
    lab.harness.event_modifiers(egui::Event::PointerMoved(at), Modifiers::SHIFT);
    if let Some(pressed) = pressed {
        let (button, modifiers) = (egui::PointerButton::Primary, Modifiers::SHIFT);
        lab.harness
            .event_modifiers(egui::Event::PointerButton { pos: at, button, pressed, modifiers }, Modifiers::SHIFT);
    }
    lab.harness.step();
}

/// Drags from and to those shares of the picture.
fn select(lab: &mut Lab, from: [f32; 2], to: [f32; 2]) {
    let picture = lab.rect("Picture");
    let side = picture.size().min_elem();
    let square = egui::Rect::from_center_size(picture.center(), egui::Vec2::splat(side));
    let [from, to] = [from, to].map(|share| square.lerp_inside(share));
    with_shift(lab, from, Some(true));
    with_shift(lab, from.lerp(to, 0.5), None);
    with_shift(lab, to, None);
    with_shift(lab, to, Some(false));
    lab.harness.remove_cursor();
    lab.harness.run_steps(3);
}

/// The slope of a strategy on screen.
fn slope(lab: &Lab) -> String {
    use egui_kittest::kittest::{NodeT as _, Queryable as _};
    let mut all = lab.harness.query_all_by_label_contains("MIS, both: slope ");
    all.next().and_then(|node| node.accesskit_node().value().or(node.accesskit_node().label())).unwrap_or_default()
}

#[test]
fn curves_and_means_are_over_the_rectangle_that_is_selected() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.apply(Edit::SetSpp(SppTarget::passes(16)));
    let placement = lab.document().view.placement;
    lab.key(Modifiers::NONE, Key::G);
    lab.until("curves", |lab| slope(lab).contains('\u{2212}'));
    select(&mut lab, [0.3, 0.62], [0.68, 0.95]);
    // 60 pixels: 18 to 40.8 across and 37.2 to 57 down, in blocks of 8.
    let name = "32 \u{d7} 28 pixels from x 16 y 32";
    assert!(lab.has(&format!("over the {name}")), "the caption says what it is about");
    assert!(slope(&lab).contains('\u{2212}'), "pictures need not be rendered again: {}", slope(&lab));
    assert_eq!(lab.document().view.placement, placement, "the picture stays where it is");
    lab.click("Save the curves as CSV");
    lab.until("the file", |lab| lab.file("convergence.csv").exists());
    let text = std::fs::read_to_string(lab.file("convergence.csv")).expect("text");
    let points = |part: &str| -> Vec<String> {
        let lines = text.lines().filter(|line| line.contains(&format!(",{part},")));
        lines.map(|line| line.replace(part, "")).collect()
    };
    let [whole, rectangle] = ["whole picture", name].map(points);
    assert!(rectangle.len() >= 4 * 2 && rectangle.len() == whole.len(), "as many points: {text}");
    assert!(rectangle.iter().all(|line| !whole.contains(line)), "other errors: {text}");
    lab.key(Modifiers::NONE, Key::M);
    lab.until("the row of the rectangle", |lab| lab.has(&format!("{name}: ")));
    assert!(lab.has(&format!("{name}: 896 pixels, reference ")), "its numbers are shown");
    let middle = lab.rect("Picture").center();
    with_shift(&mut lab, middle, Some(true));
    with_shift(&mut lab, middle, Some(false));
    lab.until("all of the picture", |lab| !lab.has(name));
}
