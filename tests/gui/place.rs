//! Where everything is at every size of the window.

use eframe::egui::accesskit::Role;
use eframe::egui::{self, Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use mislab::look::zoom::ZoomStep;
use mislab::state::command::Command;
use mislab::state::edit::{Edit, SppTarget};
use mislab::state::prefs::Prefs;
use mislab_renderer::{Layer, OneSampleWeights, Strategy};

use crate::lab::{Lab, small_scene};

#[test]
fn themes() {
    let mut lab = Lab::new();
    for (name, theme) in [("Light", egui::Theme::Light), ("Dark", egui::Theme::Dark)] {
        lab.click("Menu");
        lab.harness.get_by_role_and_label(Role::Button, name).click_accesskit();
        lab.harness.run_steps(3);
        assert_eq!(lab.harness.ctx.theme(), theme);
        lab.harness.key_press(Key::Escape);
        lab.harness.run_steps(2);
    }
}

#[test]
fn the_projector_view_has_large_type() {
    let mut lab = Lab::with_size([1920.0, 1080.0]);
    assert!(lab.has("Save EXR") && lab.has("Exposure"));
    lab.key(Modifiers::COMMAND, Key::B);
    assert!(!lab.has("Exposure") && !lab.has("Sampler: Sobol"), "the panels are gone");
    assert!(lab.has("4 MIS, one") && lab.has("Caption: MIS, both"), "bar and caption stay");
    let style = lab.harness.ctx.global_style();
    assert!(style.text_styles.values().all(|font| font.size >= 24.0), "legible from the last row");
    lab.key(Modifiers::COMMAND, Key::B);
    assert!(lab.has("Exposure"));
}

#[test]
fn the_picture_is_large_even_in_a_small_window() {
    let lab = Lab::with_size([1280.0, 720.0]);
    let rect = lab.harness.get_by_role_and_label(Role::Image, "Picture").rect();
    assert!(rect.width() >= 600.0 && rect.height() >= 600.0, "{rect:?}");
}

#[test]
fn at_a_large_interface_scale_the_picture_stays() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    for _ in 0..5 {
        lab.apply(Command::ZoomInterface(ZoomStep::Larger));
        lab.fit();
    }
    let rect = lab.harness.get_by_role_and_label(Role::Image, "Picture").rect();
    assert!(rect.width() > 300.0 && rect.height() > 150.0, "{rect:?}");
}

#[test]
fn a_scale_kept_from_a_larger_screen_leaves_the_panels() {
    let lab = Lab::with_prefs([1280.0, 720.0], Prefs { zoom: 3.0, ..Prefs::default() });
    assert!(lab.harness.ctx.zoom_factor() <= 1280.0 / 1100.0 + 1e-3, "{}", lab.harness.ctx.zoom_factor());
    assert!(lab.has("Normalise"), "the right column is there");
}

#[test]
fn type_grows_with_the_window() {
    let lab = Lab::with_size([2560.0, 1440.0]);
    assert_eq!(lab.harness.ctx.zoom_factor(), 1.4);
    let rect = lab.harness.get_by_role_and_label(Role::Image, "Picture").rect();
    assert!(1.4 * rect.height() > 1200.0, "the picture still has most of it: {rect:?}");
}

#[test]
fn steps_of_the_interface_meet_again() {
    let mut lab = Lab::with_size([2560.0, 1440.0]);
    let start = lab.harness.ctx.zoom_factor();
    for key in [Key::Plus, Key::Plus, Key::Minus, Key::Minus] {
        lab.key(Modifiers::COMMAND, key);
        lab.fit();
    }
    assert_eq!(lab.harness.ctx.zoom_factor(), start);
    assert!(lab.has("Interface 100 %"), "it says where it is");
    lab.key(Modifiers::COMMAND, Key::Plus);
    lab.fit();
    lab.click("Menu");
    assert!(lab.has("110 %") || lab.has("Interface at 100 %"));
    lab.click("Interface at 100 %");
    lab.fit();
    assert_eq!(lab.harness.ctx.zoom_factor(), start);
}

#[test]
fn one_escape_closes_one_thing() {
    let mut lab = Lab::new();
    let bad = lab.file("bad.pbrt");
    std::fs::write(&bad, "Film \"image\" \"integer xresolution\" [60\nWorldBegin\n").expect("write");
    lab.apply(Command::OpenPath(bad));
    lab.until("the error", |lab| lab.has("bad.pbrt was not opened"));
    lab.key(Modifiers::NONE, Key::T);
    lab.click("Image size of the table");
    assert!(lab.has("100 \u{d7} 100"), "the menu is open");
    lab.key(Modifiers::NONE, Key::Escape);
    assert!(!lab.has("100 \u{d7} 100") && lab.has("Fill in the table"), "first the menu");
    lab.harness.get_by_role_and_label(Role::SpinButton, "Seed").focus();
    lab.harness.run_steps(2);
    lab.key(Modifiers::NONE, Key::Escape);
    assert!(lab.has("Fill in the table"), "then the field");
    lab.key(Modifiers::NONE, Key::Escape);
    assert!(!lab.has("Fill in the table") && lab.has("was not opened"), "then the table");
    lab.key(Modifiers::NONE, Key::Escape);
    assert!(!lab.has("was not opened"), "then the message");
}

#[test]
fn nothing_jumps_when_weights_get_biased_or_warnings_come() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.apply(Edit::SetStrategy(Strategy::Mis));
    lab.apply(Edit::SetWeights(OneSampleWeights::Tutorial));
    lab.settle();
    let places = |lab: &Lab| {
        let spp = lab.harness.query_all_by_label_contains("4 spp").map(|node| node.rect()).next_back();
        let picture = lab.harness.get_by_role_and_label(Role::Image, "Picture").rect();
        assert!(spp.is_some(), "the caption counts");
        (lab.rect("Layer: Picture"), lab.rect("Normalise"), picture, spp)
    };
    let before = places(&lab);
    let scene = lab.document().scene.name.clone();
    let named = lab.rect(&scene);
    lab.slide("c", 1.0);
    lab.settle();
    assert!(lab.has("biased, too dark"), "it is said");
    assert_eq!(places(&lab), before);
    assert_eq!(lab.rect(&scene), named);

    let good = lab.file("good.pbrt");
    std::fs::write(&good, small_scene().replace("WorldBegin", "WorldBegin\nTwiddle 1\n")).expect("write");
    lab.apply(Command::OpenPath(good.clone()));
    lab.until("the file", |lab| lab.document().opened.path.as_deref() == Some(good.as_path()));
    lab.apply(Edit::SetStrategy(Strategy::Mis));
    lab.settle();
    assert!(lab.has("good.pbrt:"), "the warning is there");
    assert_eq!(places(&lab), before);
    lab.key(Modifiers::NONE, Key::Escape);
    assert!(!lab.has("good.pbrt:"), "put away");
    lab.click("Warnings about the scene file");
    assert!(lab.has("good.pbrt:"), "and called back");
}

#[test]
fn the_caption_stands_still_while_it_counts() {
    let mut lab = Lab::new();
    let places = |lab: &mut Lab, spp: u32| {
        lab.apply(Edit::SetSpp(SppTarget::passes(spp)));
        lab.settle();
        let mut rects: Vec<egui::Rect> = [" spp", " paths"]
            .into_iter()
            .flat_map(|what| lab.harness.query_all_by_label_contains(what).map(|node| node.rect()).collect::<Vec<_>>())
            .filter(|rect| rect.bottom() < 990.0 && rect.top() > 900.0)
            .collect();
        rects.sort_by(|a, b| (a.top(), a.left()).partial_cmp(&(b.top(), b.left())).expect("numbers"));
        rects
    };
    let nine = places(&mut lab, 9);
    assert!(nine.len() >= 3, "caption and status bar: {nine:?}");
    let caption =
        |rects: &[egui::Rect]| rects.iter().filter(|r| r.center().y < 968.0).map(|r| r.left()).collect::<Vec<_>>();
    for spp in [10, 400] {
        let other = places(&mut lab, spp);
        assert_eq!(caption(&other), caption(&nine), "at {spp} spp");
    }
}

#[test]
fn the_caption_names_the_scene() {
    let lab = Lab::new();
    let name = lab.document().scene.name.clone();
    assert!(!name.is_empty() && lab.has(&name), "{name}");
}

#[test]
fn the_projector_view_gives_the_picture_the_whole_height() {
    for size in [[1280.0, 720.0], [1920.0, 1080.0], [2560.0, 1440.0]] {
        let mut lab = Lab::with_size(size);
        lab.key(Modifiers::COMMAND, Key::B);
        lab.fit();
        lab.settle();
        let zoom = lab.harness.ctx.zoom_factor();
        let rect = lab.harness.get_by_role_and_label(Role::Image, "Picture").rect() * zoom;
        assert!(rect.height() > size[1] - 1.0 && rect.width() > size[1] - 1.0, "{size:?}: {rect:?}");
        let body = lab.harness.ctx.global_style().text_styles[&egui::TextStyle::Body].size * zoom;
        assert!((26.0..30.0).contains(&(size[1] / body)), "{size:?}: type of {body}");
        assert!(lab.has("Formula: ") && lab.has("Caption: ") && lab.has("Layer menu"));
        lab.click("Layer menu");
        lab.click("Share of the light technique");
        assert_eq!(lab.document().active().layer, Layer::ShareLight);
        assert!(lab.has("Legend: Share of the light technique"));
    }
}

#[test]
fn nothing_is_larger_than_the_window_of_a_projector() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.key(Modifiers::COMMAND, Key::B);
    lab.fit();
    let window =
        egui::Rect::from_min_size(egui::Pos2::ZERO, egui::Vec2::from(lab.size) / lab.harness.ctx.zoom_factor());
    lab.key(Modifiers::SHIFT, Key::Questionmark);
    lab.harness.run_steps(3);
    assert!(window.contains_rect(lab.rect("Close")), "the keys can be put away");
    lab.click("Close");
    lab.key(Modifiers::NONE, Key::T);
    lab.click("Image size of the table");
    lab.click("100 \u{d7} 100");
    lab.click("Fill in the table");
    lab.until("the table", |lab| lab.has("small light"));
    lab.harness.run_steps(5);
    for head in ["broad BSDF", "sharp BSDF", "Strategy, file", "veachMIS_MIS.exr"] {
        assert!(window.contains_rect(lab.rect(head)), "{head} at {:?}", lab.rect(head));
    }
}

#[test]
fn the_status_bar_never_runs_under_its_button() {
    for width in [480.0, 640.0, 960.0, 1280.0, 2000.0] {
        let lab = Lab::with_size([width, 400.0]);
        let save = lab.rect("Save EXR");
        let nodes = lab.harness.query_all_by_role(Role::Label);
        let row: Vec<egui::Rect> =
            nodes.map(|node| node.rect()).filter(|rect| (rect.center().y - save.center().y).abs() < 4.0).collect();
        assert!(!row.is_empty(), "{width}: there is something in the bar");
        for rect in row {
            assert!(!rect.intersects(save), "{width}: {rect:?} under {save:?}");
        }
    }
}

#[test]
fn the_interface_can_be_enlarged() {
    let mut lab = Lab::new();
    lab.key(Modifiers::COMMAND, Key::Plus);
    assert!(lab.harness.ctx.zoom_factor() > 1.05);
    lab.key(Modifiers::COMMAND, Key::Minus);
    assert_eq!(lab.harness.ctx.zoom_factor(), 1.0);
}
