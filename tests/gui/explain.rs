//! The study of one pixel: pinning it, its numbers, and what can be dragged in its plots.

use eframe::egui::accesskit::Role;
use eframe::egui::{self, Key, Modifiers, Pos2, vec2};
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use mislab::state::document::Document;
use mislab_renderer::plane::Square;
use mislab_renderer::projection::Projector;
use mislab_renderer::{OneSampleWeights, Strategy};

use crate::lab::Lab;

impl Lab {
    /// The study is open, on the pixel where plate 3 shows light 2.
    fn explained() -> Self {
        let mut lab = Self::with_size([1280.0, 720.0]);
        lab.key(Modifiers::NONE, Key::I);
        let at = lab.highlight();
        let [x, y] = at;
        lab.pin(at);
        lab.until("the pixel", |lab| lab.has(&format!("Pixel x {x}, y {y}")));
        lab
    }

    fn highlight(&self) -> [u32; 2] {
        let document = self.document();
        let square = &Square::all(&document.scene)[9];
        let projector = Projector::new(&document.scene.camera, document.image.resolution);
        projector.project(square.point()).expect("in front of the camera").map(|v| v as u32)
    }

    fn pin(&mut self, pixel: [u32; 2]) {
        let geometry = self.app().panes()[0].geometry().expect("a picture");
        self.click_at(geometry.to_screen(pixel.map(|i| i as f32 + 0.5)));
        self.harness.remove_cursor();
        self.harness.step();
    }

    /// Opens a part of the study and waits for what it shows.
    #[track_caller]
    fn part(&mut self, name: &str, shows: &str) {
        self.click(&format!("Explain: {name}"));
        self.until(name, |lab| lab.has(shows));
    }

    /// Drags from one place to another, in two steps.
    fn drag(&mut self, from: Pos2, by: egui::Vec2) {
        let (button, modifiers) = (egui::PointerButton::Primary, Modifiers::NONE);
        self.harness.event(egui::Event::PointerMoved(from));
        self.harness.step();
        self.harness.event(egui::Event::PointerButton { pos: from, button, pressed: true, modifiers });
        self.harness.step();
        for share in [0.5, 1.0] {
            self.harness.event(egui::Event::PointerMoved(from + share * by));
            self.harness.step();
        }
        self.harness.event(egui::Event::PointerButton { pos: from + by, button, pressed: false, modifiers });
        self.harness.step();
        self.harness.remove_cursor();
        self.harness.step();
    }

    /// The pixel of a firefly, by its number in the list.
    fn firefly(&self, number: usize) -> [u32; 2] {
        let start = format!("Firefly {number}: pixel x ");
        let row = self.harness.get_by_label_contains(&start);
        let words = row.accesskit_node().label().expect("a label");
        let pixel = words.split("pixel x ").nth(1).and_then(|rest| rest.split_once(", y ")).expect("its pixel");
        [pixel.0, pixel.1].map(|digits| digits.parse().expect("a number"))
    }

    fn radius(&self, light: &str) -> f32 {
        let scene = &self.document().scene;
        let named = |shape: &usize| scene.shapes[*shape].light.as_ref().is_some_and(|l| l.name == light);
        let shape = scene.light_shapes().find(named).expect("such a light");
        Document::radius(scene, shape).expect("a sphere")
    }

    fn alpha(&self, plate: &str) -> f32 {
        self.document().scene.material(plate).and_then(|m| m.bsdf.alpha()).expect("a rough plate")
    }
}

#[test]
fn it_begins_with_a_highlight() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.key(Modifiers::NONE, Key::I);
    lab.until("a highlight", |lab| lab.has("Surface plate3") && lab.has("Explained pixel: "));
    assert!(lab.has("a click in the picture pins"));
}

#[test]
fn a_click_pins_arrows_move_and_escape_lets_go() {
    let mut lab = Lab::explained();
    let [x, y] = lab.highlight();
    assert!(lab.has("pinned: arrow keys move"));
    lab.until("the mark in the picture", |lab| lab.has(&format!("Explained pixel: x {x}, y {y}")));
    lab.key(Modifiers::NONE, Key::ArrowRight);
    lab.until("the next pixel", |lab| lab.has(&format!("Pixel x {}, y {y}", x + 1)));
    lab.key(Modifiers::SHIFT, Key::ArrowUp);
    lab.until("ten rows up", |lab| lab.has(&format!("Pixel x {}, y {}", x + 1, y - 10)));
    lab.key(Modifiers::NONE, Key::Escape);
    assert!(lab.has("a click in the picture pins") && !lab.has("pinned: arrow"), "one Escape lets the pixel go");
    lab.key(Modifiers::NONE, Key::Escape);
    assert!(!lab.has("Explain: Numbers"), "the next one closes the study");
}

#[test]
fn its_mark_is_in_every_picture() {
    let mut lab = Lab::explained();
    lab.key(Modifiers::NONE, Key::Q);
    lab.settle_all();
    assert_eq!(lab.harness.query_all_by_label_contains("Explained pixel: ").count(), 4);
}

#[test]
fn four_pictures_agree_with_the_exact_numbers() {
    let mut lab = Lab::explained();
    assert_eq!(lab.harness.query_all_by_label_contains("no picture").count(), 3, "one strategy is measured");
    lab.key(Modifiers::NONE, Key::Q);
    lab.settle_all();
    lab.until("exact numbers", |lab| {
        lab.has("Exact by quadrature over all directions at ") && !lab.has("coarse so far")
    });
    assert!(!lab.has("no picture") && lab.has("Exact luminance of the pixel: "));
    lab.until("verdicts", |lab| {
        let of = |words: &str| lab.harness.query_all_by_label_contains(words).count();
        of("agrees, ") + of("too few hits") == 4
    });
}

#[test]
fn edges_in_the_slice_are_the_scenes_sliders() {
    let mut lab = Lab::explained();
    lab.part("Slice", "Right edge of light2");
    let (radius, alpha) = (lab.radius("light2"), lab.alpha("plate3"));
    let [edge, of_light] = ["Right edge of the lobe", "Right edge of light2"].map(|label| lab.rect(label));
    lab.drag(of_light.center(), vec2(10.0, 0.0));
    assert!(lab.radius("light2") > 1.05 * radius, "{} after {radius}", lab.radius("light2"));
    lab.key(Modifiers::COMMAND, Key::Z);
    assert_eq!(lab.radius("light2"), radius, "one step of undo");
    lab.until("the plot as it was", |lab| {
        // It is not there while what it shows is worked out, and before that it is the one of the larger light.
        let place = |label| lab.harness.query_by_label(label).map(|found| found.rect());
        place("Right edge of the lobe") == Some(edge) && place("Right edge of light2") == Some(of_light)
    });
    lab.drag(edge.center(), vec2(-30.0, 0.0));
    assert!(lab.alpha("plate3") < 0.95 * alpha, "{} after {alpha}", lab.alpha("plate3"));
}

#[test]
fn the_slice_shows_what_is_asked_for() {
    let mut lab = Lab::explained();
    lab.part("Slice", "Right edge of light2");
    let plot = lab.rect("Slice through the directions");
    lab.rest_on(plot.lerp_inside(vec2(0.6, 0.3)));
    assert!(lab.has("p_L ") && lab.has(" /sr, w_L "), "the numbers under the mouse");
    lab.harness.remove_cursor();
    lab.click("Reach: \u{b1}90\u{b0}");
    lab.click("Height: linear");
    assert!(lab.has("Each curve over its own largest value."));
    lab.harness.get_by_role_and_label(Role::ComboBox, "Light of the slice").click_accesskit();
    lab.harness.run_steps(3);
    lab.harness.get_by_role_and_label(Role::Button, "light4").click_accesskit();
    lab.until("the other light", |lab| lab.has("Right edge of light4"));
    lab.slide("Turn", 45.0);
    lab.until("another circle", |lab| !lab.has("Right edge of light4"));
}

#[test]
fn the_sphere_reads_the_direction_under_the_mouse() {
    let mut lab = Lab::explained();
    lab.part("Sphere", "Directions of the pixel");
    lab.until("its rim", |lab| lab.has("Rim: 90.0\u{b0} from the normal"));
    lab.click("Part: The lobe and light2");
    lab.until("the lobe", |lab| lab.has("from the mirror direction; distances"));
    lab.click("Image: w_L");
    let disc = lab.rect("Directions of the pixel");
    lab.rest_on(disc.center());
    // The pixel was chosen so that the mirror direction hits the light.
    lab.until("the middle", |lab| lab.has("\u{b0}, light2: f "));
    lab.rest_on(disc.left_top() + vec2(2.0, 2.0));
    lab.until("no direction beside the disc", |lab| lab.has("from the mirror direction; distances"));
}

#[test]
fn the_marker_on_the_curve_is_c() {
    let mut lab = Lab::explained();
    lab.part("Best c", "Use c ");
    assert!(lab.has("least variance"));
    lab.click("Use MIS, one");
    assert_eq!(lab.strategies(), [Strategy::Mis]);
    let plot = lab.rect("Variance over c: this pixel");
    let at = lab.rect("c in the curve").center();
    lab.drag(at, vec2(0.2 * plot.width(), 0.0));
    let c = lab.document().active().estimator.light_prob;
    assert!(c > 0.6 && c < 0.9, "{c}");
    lab.apply(mislab::state::edit::Edit::SetLightProb(1.0));
    lab.apply(mislab::state::edit::Edit::SetWeights(OneSampleWeights::Tutorial));
    assert!(lab.has("c 1.00: biased"));
}

#[test]
fn samples_are_stepped_through_with_their_numbers() {
    let mut lab = Lab::explained();
    lab.key(Modifiers::NONE, Key::Num4);
    lab.settle();
    lab.part("Sample", "Mean of 1: ");
    assert!(lab.has("its number 0."), "why the technique drew");
    lab.click("Next sample");
    assert!(lab.has("Mean of 2: "));
    lab.click("Previous sample");
    assert!(lab.has("Mean of 1: "));
    lab.key(Modifiers::NONE, Key::Num3);
    lab.settle();
    lab.until("both samples", |lab| lab.has("Light sample") && lab.has("BSDF sample"));
    lab.click("Brightest");
    assert!(lab.has("(f) / (p_L + p_B)"), "the contribution expanded");
    lab.part("Sketch", "Sketch in the plane of incidence");
}

#[test]
fn the_curve_is_also_of_the_square_and_of_the_picture() {
    let mut lab = Lab::explained();
    lab.key(Modifiers::NONE, Key::Num4);
    lab.part("Best c", "Use c ");
    lab.click("Curve: Its square");
    lab.until("the square", |lab| lab.has("Variance over c: plate3 under light2"));
    assert!(!lab.has("worst square"));
    lab.click("Curve: Whole picture");
    lab.until("the picture", |lab| lab.has("Variance over c: whole picture"));
    lab.until("all of its pixels", |lab| lab.has("Dotted: the worst square at each c") && !lab.has("coarse so far"));
    let at = lab.rect("c in the curve").center();
    let before = lab.document().active().estimator.light_prob;
    lab.drag(at, vec2(60.0, 0.0));
    assert!(lab.document().active().estimator.light_prob > before, "the marker is c here, too");
    // A pixel of the wall.
    lab.click("Curve: Its square");
    lab.pin([30, 30]);
    lab.until("no square", |lab| lab.has("This pixel is in no square"));
}

#[test]
fn fireflies_are_listed_marked_and_drawn_again() {
    let mut lab = Lab::explained();
    lab.key(Modifiers::NONE, Key::Num2);
    lab.settle();
    // A pixel of the wall, whose brightest sample is none of the brightest.
    lab.pin([30, 30]);
    lab.part("Fireflies", "Firefly 1: pixel x ");
    lab.until("none of them is pinned", |lab| lab.has("Click one, here or in the picture"));
    lab.until("the finished picture's", |lab| !lab.has("there may be brighter ones"));
    lab.harness.get_by_label_contains("Firefly 2: pixel x ").click_accesskit();
    lab.until("its sample", |lab| lab.has("Mean of the pixel: with it ") && lab.has("Without it the mean falls from "));
    lab.until("the exact mean", |lab| !lab.has("exact \u{2026}"));
    assert!(lab.has("BSDF sample"), "the technique that drew it");
    assert!(lab.has("The same direction under MIS, both"), "what weights would have made of it");
    assert!(lab.has("pinned: arrow keys move"));
    // The mark in the picture pins the same one.
    let [x, y] = lab.firefly(1);
    lab.key(Modifiers::NONE, Key::Escape);
    lab.until("none is pinned", |lab| lab.has("Click one, here or in the picture"));
    let geometry = lab.app().panes()[0].geometry().expect("a picture");
    lab.click_at(geometry.to_screen([x, y].map(|i| i as f32 + 0.5)) + vec2(3.0, 0.0));
    lab.harness.remove_cursor();
    lab.until("the first", |lab| lab.has(&format!("Pixel x {x}, y {y}")) && lab.has("Without it the mean falls"));
}
