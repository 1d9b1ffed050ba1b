//! Studies that take the place of the pictures: the pyramid, the grid, the plane.

use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use mislab::state::command::Command;
use mislab_renderer::{Heuristic, OneSampleWeights, Strategy};

use crate::lab::Lab;

impl Lab {
    fn shows(&self, label: &str) -> bool {
        self.harness.query_by_label(label).is_some()
    }
}

const PARTS: [&str; 7] =
    ["Light alone", "Weight of light", "Light, weighted", "BSDF alone", "Weight of BSDF", "BSDF, weighted", "Picture"];

#[test]
fn in_a_hall_the_picture_stays_beside_what_explains_it() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.apply(Command::TogglePanels);
    lab.key(Modifiers::NONE, Key::I);
    lab.settle();
    let picture = lab.rect("Picture");
    assert!(picture.width() > 560.0 && picture.height() > 560.0, "{picture:?}");
    lab.click_at(picture.center());
    lab.until("the pixel", |lab| lab.has("pinned: arrow keys move"));
}

#[test]
fn the_pyramid_shows_seven_pictures_each_of_which_can_be_enlarged() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.key(Modifiers::NONE, Key::P);
    let mut places = Vec::new();
    for part in PARTS {
        let rect = lab.rect(&format!("Enlarge: {part}"));
        assert!(rect.width() > 100.0, "{part}: {rect:?}");
        assert!(places.iter().all(|other: &eframe::egui::Rect| !other.intersects(rect)), "{part} lies over another");
        places.push(rect);
    }
    lab.click("Enlarge: Weight of light");
    assert!(!lab.shows("Enlarge: Light alone"), "it has the whole place");
    let large = lab.harness.get_by_role_and_label(Role::Button, "Weight of light").rect();
    assert!(large.width() > 2.0 * places[1].width(), "{large:?}");
    lab.key(Modifiers::NONE, Key::Escape);
    assert!(lab.shows("Enlarge: Light alone"), "one press of Escape: all pictures again");
    lab.click("Enlarge: Picture");
    lab.click("Back");
    assert!(lab.shows("Enlarge: Light alone"));
    lab.key(Modifiers::NONE, Key::Escape);
    assert!(!lab.shows("Enlarge: Light alone"), "the next press closes it");
}

#[test]
fn without_weights_the_pyramid_offers_a_strategy_that_has_some() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::Num1);
    lab.key(Modifiers::NONE, Key::P);
    assert!(!lab.shows("Enlarge: Picture"));
    lab.click("Use MIS, both");
    assert_eq!(lab.strategies(), [Strategy::MisAll]);
    lab.until("the pictures", |lab| lab.shows("Enlarge: Picture"));
}

#[test]
fn the_grid_measures_all_cells_at_equal_rays() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.key(Modifiers::SHIFT, Key::G);
    lab.until("all errors", |lab| !lab.has("relMSE \u{2026}"));
    assert_eq!(lab.harness.query_all_by_label_contains("Enlarge: ").count(), 2 + 4 + 4);
    assert!(lab.has("Each cell: 4 rays a pixel, seed 1"), "what is equal is said");
    let error = |lab: &Lab, name: &str| {
        let cell = lab.rect(&format!("Enlarge: {name}"));
        let all = lab.harness.query_all_by_label_contains("relMSE ");
        let under = all.filter(|node| (node.rect().left_top() - cell.left_bottom()).length() < 2.0);
        let mut found = under.filter_map(|node| node.accesskit_node().value().or(node.accesskit_node().label()));
        let text = found.next().expect("an error under the cell");
        text.trim_start_matches("relMSE ").parse::<f64>().expect("a number")
    };
    // Floor and wall, most of the picture, scatter everywhere: the BSDF hardly ever draws a light.
    assert!(error(&lab, "BSDF") > 3.0 * error(&lab, "MIS, both, balance"));
}

#[test]
fn a_cells_settings_become_the_active_pictures_in_one_step() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.key(Modifiers::SHIFT, Key::G);
    lab.click("Grid of: c \u{d7} one-sample weights");
    assert!(lab.has("biased"), "the tutorial's weights at both ends");
    lab.click("Enlarge: c 0.9, Tutorial");
    lab.click("Use these settings");
    let estimator = lab.document().active().estimator;
    assert_eq!((estimator.strategy, estimator.light_prob), (Strategy::Mis, 0.9));
    assert_eq!(estimator.weights, OneSampleWeights::Tutorial);
    assert!(!lab.has("Enlarge: "), "the picture is shown");
    lab.key(Modifiers::COMMAND, Key::Z);
    let before = lab.document().active().estimator;
    assert_eq!((before.strategy, before.weights), (Strategy::MisAll, OneSampleWeights::Veach), "one step of undo");
    assert_eq!(before.heuristic, Heuristic::Balance);
}

#[test]
fn the_plane_reads_four_variances() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.key(Modifiers::SHIFT, Key::P);
    let map = "Map: best strategy by roughness and light radius";
    lab.until("the map", |lab| lab.shows(map));
    assert!(lab.has("plate3 \u{d7} light2"), "the square in the middle gives the distances");
    let at = lab.rect(map).lerp_inside(eframe::egui::vec2(0.75, 0.25));
    lab.until("variances", |lab| lab.has("variance of one ray"));
    lab.rest_on(at);
    lab.until("the reading", |lab| lab.has("\u{3b1} 0.1"));
    lab.harness.get_by_role_and_label(Role::ComboBox, "Plate and light").click_accesskit();
    lab.harness.run_steps(3);
    lab.click("plate4 \u{d7} light4");
    lab.until("the other square", |lab| lab.has("plate4, as a plane mirror, shows the centre of light4"));
}

#[test]
fn a_scene_without_plates_has_no_plane() {
    let mut lab = Lab::new();
    for light in lab.document().scene.light_shapes().collect::<Vec<_>>() {
        lab.apply(mislab::state::edit::Edit::SetLightOn(light, false));
    }
    lab.key(Modifiers::SHIFT, Key::P);
    lab.until("the reason", |lab| lab.has("The scene has none."));
}

#[test]
fn the_map_of_the_best_c_reads_pixels_and_explains_them() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.key(Modifiers::NONE, Key::C);
    lab.until("the whole map", |lab| lab.has("a click explains a pixel"));
    let map = lab.rect("Map over the pixels");
    // The wall: light samples nearly always.
    lab.rest_on(map.lerp_inside(eframe::egui::vec2(0.5, 0.05)));
    lab.until("the reading", |lab| lab.has(": best c 0.9") || lab.has(": best c 1.00"));
    lab.click("Map: Loss at c = 1/2");
    assert!(lab.has("more light samples") && lab.has("Loss: variance of one sample at c = 1/2"));
    lab.harness.remove_cursor();
    lab.click_at(map.lerp_inside(eframe::egui::vec2(0.5, 0.05)));
    lab.until("the pixel", |lab| lab.has("pinned: arrow keys move") && lab.has("Explain: Numbers"));
}
