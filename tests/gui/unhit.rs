//! What no sample has hit yet is hatched in every layer, and never plain black.

use eframe::egui::{Key, Modifiers};
use mislab::picture::planes::{BLIND, Planes, UNHIT};
use mislab::state::edit::{Edit, SppTarget};
use mislab::state::view::VarianceUnit;
use mislab_renderer::Layer;
use mislab_renderer::blind::{Dark, dark_pixels};

use crate::lab::Lab;

#[test]
fn nothing_hit_yet_is_hatched_in_every_layer_and_read() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::Num2);
    lab.apply(Edit::SetSpp(SppTarget::passes(1)));
    lab.settle();
    let frame = lab.app().live().current_frame().expect("it is complete");
    let dark = dark_pixels(frame.request());
    for layer in Layer::ALL {
        let unmarked = Planes::from_frame(&frame, layer);
        let planes = Planes::shown(&frame, layer, VarianceUnit::OneSample, Some(&dark));
        let colour = layer.channels().len() == 3;
        let [mut unhit, mut empty] = [0; 2];
        for (pixel, dark) in dark.iter().enumerate() {
            let at = [pixel as u32 % 60, pixel as u32 / 60];
            let (was, is) = (unmarked.value(at[0], at[1]), planes.value(at[0], at[1])[0]);
            if colour && was == [0.0; 3] {
                assert_eq!(is == UNHIT, *dark == Dark::Unhit, "{layer:?} at {at:?}, {dark:?}");
                unhit += usize::from(is == UNHIT);
                empty += usize::from(*dark == Dark::Empty);
            } else if colour {
                assert_eq!(is, was[0], "{layer:?} at {at:?}: it has been hit");
            } else {
                unhit += usize::from(is.is_nan());
            }
        }
        assert!(unhit > 1000, "{layer:?}: one sample of the BSDF hardly ever meets a light: {unhit}");
        // Lights are black in the layers of techniques, and no sample could change it.
        assert!(!matches!(layer, Layer::Light | Layer::Bsdf) || empty > 0, "{layer:?}");
    }
    lab.apply(Edit::SetLayer(Layer::Picture));
    lab.until("the hatchings", |lab| lab.has("hatched: nothing hit yet, cross-hatched: cannot be hit"));
    // The lower right corner is floor.
    let picture = lab.rect("Picture");
    let side = picture.size().min_elem();
    let black = |pixel: [u32; 2]| Planes::from_frame(&frame, Layer::Picture).value(pixel[0], pixel[1]) == [0.0; 3];
    let at = (40..60).flat_map(|y| (0..60).map(move |x| [x, y])).find(|at| black(*at)).expect("a black pixel");
    let corner = picture.center() - eframe::egui::Vec2::splat(0.5 * side);
    lab.harness.hover_at(corner + side / 60.0 * eframe::egui::vec2(at[0] as f32 + 0.5, at[1] as f32 + 0.5));
    lab.until("the reading", |lab| lab.has(&format!("Pixel: x {}   y {}\nR = G = B  nothing hit yet", at[0], at[1])));
}

#[test]
fn what_cannot_be_hit_is_crossed_in_colours_too() {
    let mut lab = Lab::new();
    let plate = lab.document().scene.materials.iter().position(|m| m.name == "plate1").expect("the scene has plates");
    lab.apply(Edit::SetAlpha(plate, 0.0));
    lab.key(Modifiers::NONE, Key::Num1);
    lab.settle();
    let frame = lab.app().live().current_frame().expect("it is complete");
    let dark = dark_pixels(frame.request());
    let planes = Planes::shown(&frame, Layer::Picture, VarianceUnit::OneSample, Some(&dark));
    let blind = planes.channels().next().expect("red").iter().filter(|red| **red == BLIND).count();
    assert!(
        blind > 20 && blind <= dark.iter().filter(|dark| **dark == Dark::Blind).count(),
        "{blind} pixels of a mirror"
    );
}
