//! The picture: the mouse on it, its layer, its colours, the device that draws it.

use eframe::egui::accesskit::Role;
use eframe::egui::{self, Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use mislab::state::command::Command;
use mislab::state::document::Document;
use mislab::state::edit::Edit;
use mislab::state::placement::Placement;
use mislab::{AppOptions, MisLabApp};
use mislab_renderer::Layer;

use crate::lab::Lab;

#[test]
fn the_mouse_on_the_picture() {
    let mut lab = Lab::new();
    let picture = lab.harness.get_by_role_and_label(Role::Image, "Picture").rect();
    let side = picture.width().min(picture.height());
    let on_screen = |u: f32, v: f32| picture.center() + egui::vec2((u - 0.5) * side, (v - 0.5) * side);
    lab.harness.hover_at(on_screen(0.5, 0.5));
    lab.harness.run_steps(2);
    assert!(lab.has("Pixel: x 30   y 30"), "the value under the cursor");

    // The large light is on the left; its rim can be dragged.
    let scene = lab.document().scene.clone();
    let large = scene
        .light_shapes()
        .max_by(|a, b| Document::radius(&scene, *a).partial_cmp(&Document::radius(&scene, *b)).expect("numbers"))
        .expect("the scene has lights");
    let finder = mislab::picture::picking::Finder::new(&scene, [60, 60]);
    let [min, max] = finder.bounds(mislab::picture::picking::Target::Light(large)).expect("in front of the camera");
    let rim = on_screen(max[0] / 60.0, 0.5 * (min[1] + max[1]) / 60.0);
    let button = |pos, pressed| egui::Event::PointerButton {
        pos,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    lab.harness.hover_at(rim);
    lab.harness.run_steps(2);
    lab.harness.event(button(rim, true));
    lab.harness.step();
    for i in 1..=6 {
        lab.harness.hover_at(rim - egui::vec2(4.0 * i as f32, 0.0));
        lab.harness.step();
    }
    lab.harness.event(button(rim - egui::vec2(24.0, 0.0), false));
    lab.harness.run_steps(2);
    let radius = |lab: &Lab| Document::radius(&lab.document().scene, large).expect("a sphere");
    let original = Document::radius(&scene, large).expect("a sphere");
    assert!(radius(&lab) < 0.9 * original, "{} from {original}", radius(&lab));
    assert_eq!(lab.document().view.placement, mislab::state::placement::Placement::Fit, "the picture has not moved");
    lab.key(Modifiers::COMMAND, Key::Z);
    assert_eq!(radius(&lab), original);
}

#[test]
fn trouble_with_the_graphics_device_is_said_and_survived() {
    let device = std::sync::Arc::new(std::sync::Mutex::new(None));
    let kept = device.clone();
    let options = AppOptions { threads: 1, ..AppOptions::default() };
    let mut harness = Harness::builder().with_size([1280.0, 800.0]).wgpu().build_eframe(move |cc| {
        let state = cc.wgpu_render_state.as_ref().expect("the harness has a device");
        *kept.lock().expect("not poisoned") = Some(state.device.clone());
        MisLabApp::new(cc, options)
    });
    harness.step();
    // A buffer that cannot be mapped for reading and drawn from: the driver's error has no taker but ours.
    let device = device.lock().expect("not poisoned").take().expect("set above");
    let _ = device.create_buffer(&eframe::wgpu::BufferDescriptor {
        label: None,
        size: 16,
        usage: eframe::wgpu::BufferUsages::MAP_READ | eframe::wgpu::BufferUsages::VERTEX,
        mapped_at_creation: false,
    });
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("Drawing without the graphics device").is_some());
    assert!(harness.query_by_role_and_label(Role::Image, "Picture").is_some(), "the picture goes on");
    harness.get_by_label("Close message").click_accesskit();
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("Drawing without the graphics device").is_none());
}

#[test]
fn plates_and_lights_can_fill_the_view() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.key(Modifiers::COMMAND, Key::B);
    lab.fit();
    lab.key(Modifiers::SHIFT, Key::F);
    lab.apply(Edit::SetLayer(Layer::ShareLight));
    lab.settle();
    let Placement::Part([min, max]) = lab.document().view.placement else { panic!("not a part") };
    assert!(max[1] - min[1] < 60.0, "the rest is cut off: {min:?} to {max:?}");
    let picture = lab.harness.get_by_role_and_label(Role::Image, "Picture: Share of the light technique").rect();
    for label in ["4 MIS, one", "Layer menu", "Menu", "c value"] {
        let rect = lab.rect(label);
        assert!(
            rect.left() >= 0.0 && rect.right() <= picture.left(),
            "{label} at {rect:?}, the picture at {picture:?}"
        );
    }
    lab.key(Modifiers::NONE, Key::F);
    assert_eq!(lab.document().view.placement, Placement::Fit);
}

#[test]
fn the_legend_marks_the_number_under_the_mouse() {
    let mut lab = Lab::new();
    lab.apply(Edit::SetLayer(Layer::Variance));
    lab.settle();
    let at = lab.harness.query_all_by_label_contains("Picture: Variance").next().expect("the picture").rect().center();
    lab.harness.hover_at(at);
    lab.harness.run_steps(3);
    assert!(lab.has("plain: no light, marked: "));
    // With the right column and without.
    for _ in 0..2 {
        let legend = lab.harness.query_all_by_label_contains("Legend: ").next().expect("a legend").rect();
        let picture = lab.harness.query_all_by_label_contains("Picture: Variance").next().expect("the picture").rect();
        assert!(!legend.intersects(picture), "off the picture: {legend:?}");
        lab.apply(Command::ToggleInspector);
        lab.harness.run_steps(2);
    }
}

#[test]
fn equal_channels_are_one_number() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::Num1);
    lab.apply(Edit::SetLayer(Layer::Bsdf));
    lab.settle();
    let at = lab.harness.query_all_by_label_contains("Picture: BSDF").next().expect("the picture").rect().center();
    lab.harness.hover_at(at);
    lab.harness.run_steps(2);
    assert!(lab.has("R = G = B  0.0000"));
}

#[test]
fn clipped_pixels_can_be_marked() {
    let mut lab = Lab::new();
    assert!(lab.has("% clipped") || lab.has("nothing clipped"), "the histogram says how many");
    let generation = lab.app().live().generation();
    lab.click("mark clipped pixels");
    assert!(lab.document().view.mark_clipped);
    assert_eq!(lab.app().live().generation(), generation, "only the view");
}
