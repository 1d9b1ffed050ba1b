//! In the projector view what is drawn has the room first, and words what is left of it.

use eframe::egui::{Key, Modifiers, Rect};
use egui_kittest::kittest::Queryable as _;
use mislab::state::arrangement::Arrangement;
use mislab::state::command::Command;
use mislab::state::edit::Edit;
use mislab_renderer::Layer;

use crate::lab::Lab;

fn hall(size: [f32; 2]) -> Lab {
    let mut lab = Lab::with_size(size);
    lab.apply(Command::TogglePanels);
    lab.settle();
    lab.fit();
    lab
}

impl Lab {
    fn place(&self, label: &str) -> Rect {
        let found = self.harness.query_all_by_label_contains(label).map(|node| node.rect()).next();
        found.unwrap_or_else(|| panic!("{label} is nowhere"))
    }
}

#[test]
fn a_plot_is_most_of_its_study() {
    let mut lab = hall([1280.0, 720.0]);
    lab.key(Modifiers::NONE, Key::G);
    const SLOPES: [&str; 4] = ["Light \u{2212}", "BSDF \u{2212}", "MIS, both \u{2212}", "MIS, one \u{2212}"];
    lab.until("all slopes", |lab| SLOPES.iter().all(|slope| lab.has(slope)));
    let plot = lab.place("Plot of errors");
    let window = lab.harness.ctx.content_rect();
    assert!(plot.height() > 0.45 * window.height(), "{plot:?} in {window:?}");
    for label in SLOPES {
        let slope = lab.place(label);
        assert!(plot.contains_rect(slope), "{label} stands in the plot: {slope:?} in {plot:?}");
    }
    let below = lab.place("Reference from elsewhere");
    assert!(below.top() >= plot.bottom(), "{below:?} lies over {plot:?}");
}

#[test]
fn a_legend_with_a_bar_has_its_room_under_a_study() {
    for size in [[1280.0, 720.0], [1920.0, 1080.0]] {
        let mut lab = hall(size);
        lab.apply(Edit::SetLayer(Layer::WeightBsdf));
        lab.key(Modifiers::NONE, Key::I);
        lab.settle();
        let window = lab.harness.ctx.content_rect();
        let [legend, picture, caption] = ["Legend: ", "Picture", "Caption: "].map(|label| lab.place(label));
        assert!(window.expand(0.5).contains_rect(legend), "{legend:?} in {window:?}");
        assert!(picture.bottom() <= caption.top() + 0.5, "{picture:?} covers {caption:?}");
        assert!(picture.bottom() <= legend.top() + 0.5, "{picture:?} covers {legend:?}");
    }
}

#[test]
fn another_layer_moves_no_picture() {
    let mut lab = hall([1280.0, 720.0]);
    lab.key(Modifiers::NONE, Key::I);
    let mut places = Vec::new();
    for layer in Layer::ALL {
        lab.apply(Edit::SetLayer(layer));
        lab.harness.run_steps(3);
        // Its legend is at the right.
        let all = lab.harness.query_all_by_label_contains("Picture").map(|node| node.rect());
        places.extend(all.filter(|rect| rect.left() == 0.0));
    }
    assert_eq!(places.len(), Layer::ALL.len(), "{places:?}");
    assert!(places.iter().all(|place| *place == places[0]), "{places:?}");
}

#[test]
fn the_columns_menus_are_whole() {
    for arrangement in [Arrangement::One, Arrangement::Four, Arrangement::Difference] {
        let mut lab = hall([1280.0, 720.0]);
        lab.apply(Command::FitThings);
        lab.apply(Edit::Arrange(arrangement));
        for layer in Layer::ALL {
            lab.apply(Edit::SetLayer(layer));
            lab.harness.run_steps(3);
            let [strategies, layers, layouts] = ["4 MIS, one", "Layer menu", "Layout"].map(|label| lab.place(label));
            for menu in [layers, layouts] {
                assert!(menu.right() <= strategies.right() + 1.0, "{layer:?}, {arrangement:?}: {menu:?}");
                assert!(menu.width() > 100.0, "{layer:?}, {arrangement:?}: {menu:?} has no room for a word");
            }
        }
    }
}

#[test]
fn the_sheet_has_all_keys_without_scrolling() {
    for projector in [false, true] {
        let mut lab = Lab::with_size([1280.0, 720.0]);
        if projector {
            lab.apply(Command::TogglePanels);
            lab.fit();
        }
        lab.apply(Command::ToggleHelp);
        lab.harness.run_steps(3);
        let close = lab.place("Close");
        for action in mislab::state::keys::bindings() {
            let all = lab.harness.query_all_by_label(action.name.as_str()).map(|node| node.rect());
            let lowest = all.map(|rect| rect.bottom()).fold(0.0, f32::max);
            assert!(lowest > 0.0 && lowest < close.top(), "{}: {lowest}, {close:?}", action.name);
        }
    }
}
