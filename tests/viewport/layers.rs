//! Layers in colours: published values of curves and maps, what is marked, legends, and what is kept of a view.

use std::num::NonZeroU32;
use std::sync::Arc;

use egui_kittest::kittest::Queryable;
use mislab::look::colormap::{BSDF_TECHNIQUE, ColourMap, LIGHT_TECHNIQUE};
use mislab::look::versus::Versus;
use mislab::picture::normalise::normalise;
use mislab::picture::planes::{BLIND, Planes, UNLIT};
use mislab::picture::still::{planes_to_rgba8, render_to_rgba8};
use mislab::picture::tone::{filmic, srgb_encode, tone_map};
use mislab::state::placement::Placement;
use mislab::state::view::{StoredView, ToneMap, VarianceUnit, ViewState};
use mislab_renderer::{ImageSettings, Layer, PixelRect, Request, Sampling, Settings};

use crate::window::undrawn;

#[test]
fn srgb_is_that_of_the_standard() {
    // IEC 61966-2-1: the linear toe, its end, and values computed by hand.
    for (linear, encoded) in
        [(0.0, 0.0), (0.001, 0.01292), (0.0031308, 0.04045), (0.18, 0.46136), (0.5, 0.73536), (1.0, 1.0)]
    {
        let got = srgb_encode(linear);
        assert!((got - encoded).abs() < 2e-5, "sRGB code of {linear}: {got}, expected {encoded}");
    }
}

#[test]
fn filmic_is_the_published_curve() {
    // (2.51 + 0.03) / (2.43 + 0.59 + 0.14) and so on, by hand.
    for (linear, expected) in [(0.0, 0.0), (0.18, 0.266_90), (1.0, 0.803_80), (10.0, 1.0), (1e30, 1.0)] {
        let got = filmic(linear);
        assert!((got - expected).abs() < 1e-5, "filmic curve at {linear}: {got}, expected {expected}");
    }
    assert_eq!(filmic(-1.0), 0.0);
    let codes = ToneMap::ALL.map(|map| (tone_map(map, 0.5) * 255.0).round());
    assert_eq!(codes, [128.0, 188.0, 206.0], "code values of 0.5 by {:?}", ToneMap::ALL);
}

#[test]
fn colour_maps_have_the_published_ends() {
    let bytes = |map: ColourMap, t: f32| map.at(t).map(|v| (v * 255.0).round() as u8);
    for dark in [true, false] {
        let map = ColourMap::technique(dark);
        assert_eq!(bytes(map, 0.0), BSDF_TECHNIQUE);
        assert_eq!(bytes(map, 1.0), LIGHT_TECHNIQUE);
        let [r, g, b] = bytes(map, 0.5);
        let neutral = r.abs_diff(g) <= 2 && g.abs_diff(b) <= 2;
        assert!(neutral && (if dark { g < 40 } else { g > 230 }), "middle of the map is {:?}", [r, g, b]);
    }
    assert_eq!(bytes(ColourMap::Viridis, 0.0), [68, 1, 84]);
    assert_eq!(bytes(ColourMap::Viridis, 1.0), [253, 231, 37]);
    assert_eq!(bytes(ColourMap::Viridis, -3.0), [68, 1, 84], "below the range");
    assert_eq!(bytes(ColourMap::Viridis, 7.0), [253, 231, 37], "above the range");
}

/// Amber stands for the light technique in all three maps.
#[test]
fn full_weights_have_the_colour_of_their_technique() {
    let shown = |layer: Layer, value: f32| {
        let bounds = PixelRect { min: [0, 0], max: [1, 1] };
        let planes = Planes::new(layer, bounds, [1, 1], vec![value]);
        let (_, _, rgba) = planes_to_rgba8(&planes, &ViewState::default(), true);
        [rgba[0], rgba[1], rgba[2]]
    };
    assert_eq!(shown(Layer::WeightLight, 1.0), LIGHT_TECHNIQUE);
    assert_eq!(shown(Layer::WeightLight, 0.0), BSDF_TECHNIQUE);
    assert_eq!(shown(Layer::WeightBsdf, 1.0), BSDF_TECHNIQUE);
    assert_eq!(shown(Layer::WeightBsdf, 0.0), LIGHT_TECHNIQUE);
    assert_eq!(shown(Layer::ShareLight, 1.0), LIGHT_TECHNIQUE);
}

#[test]
fn what_cannot_be_is_red_and_nothing_else_is() {
    let red = |layer: Layer, values: Vec<f32>| {
        let bounds = PixelRect { min: [0, 0], max: [1, 1] };
        let planes = Planes::new(layer, bounds, [1, 1], values);
        let (_, _, rgba) = planes_to_rgba8(&planes, &ViewState::default(), false);
        rgba[..3] == [255, 0, 0]
    };
    for bad in [f32::NAN, f32::INFINITY, -0.1] {
        assert!(red(Layer::Picture, vec![0.5, bad, 0.5]), "{bad} in a colour");
    }
    assert!(red(Layer::ShareLight, vec![1.1]) && red(Layer::ShareLight, vec![-0.1]));
    assert!(red(Layer::Variance, vec![f32::INFINITY]) && red(Layer::Variance, vec![-1.0]));
    assert!(!red(Layer::ShareLight, vec![f32::NAN]) && !red(Layer::Variance, vec![f32::NAN]), "undefined is no error");
    assert!(
        [BLIND, UNLIT].iter().all(|v| !red(Layer::ShareLight, vec![*v]) && !red(Layer::Variance, vec![*v])),
        "what cannot be hit is hatched, what reflects no light is plain"
    );
    assert!(!red(Layer::ShareLight, vec![1.0001]) && !red(Layer::Variance, vec![0.0]));
}

/// Numbers that the tone map cannot tell from white are striped, all others look as before.
#[test]
fn marks_are_on_clipped_pixels_only() {
    let values = [0.5, 0.99, 1.01, 3.0];
    let bounds = PixelRect { min: [0, 0], max: [4 * 16, 16] };
    let row: Vec<f32> = (0..4 * 16).map(|x| values[x / 16]).collect();
    let plane: Vec<f32> = (0..16).flat_map(|_| row.clone()).collect();
    let planes = Planes::new(Layer::Picture, bounds, [64, 16], [plane.clone(), plane.clone(), plane].concat());
    let picture = |mark_clipped| {
        let view = ViewState { mark_clipped, ..ViewState::default() };
        planes_to_rgba8(&planes, &view, true).2
    };
    let (plain, marked) = (picture(false), picture(true));
    let differs = |column: usize| {
        (0..16 * 64).filter(|i| i % 64 / 16 == column).any(|i| plain[4 * i..4 * i + 4] != marked[4 * i..4 * i + 4])
    };
    assert_eq!([0, 1, 2, 3].map(differs), [false, false, true, true]);
}

#[test]
fn the_viewport_speaks_to_screen_readers() {
    let mut harness = undrawn([400.0, 300.0]);
    harness.state_mut().legend = true;
    harness.run();
    harness.get_by_label("Picture");
    harness.state_mut().view.exposure_ev = -1.5;
    harness.run();
    let hatched = "hatched: nothing hit yet, cross-hatched: cannot be hit";
    harness.get_by_label(&format!("Legend: Picture, EV -1.5, sRGB, {hatched}"));
    let hatched = format!("{hatched}, plain: no light");
    harness.state_mut().show(Layer::Variance);
    harness.run();
    harness.get_by_label("Picture: Variance");
    harness.get_by_label(&format!(
        "Legend: Variance over mean\u{b2}, per ray, ≤0.01, 0.1, 1, 10, 100, 1000, ≥10000, {hatched}"
    ));
    harness.state_mut().view.variance_unit = VarianceUnit::OneSample;
    harness.state_mut().view.variance_range = VarianceUnit::OneSample.default_range();
    harness.run();
    harness.get_by_label(&format!("Legend: Variance of one sample, ≤1e-4, 0.001, 0.01, 0.1, 1, 10, ≥100, {hatched}"));
    harness.state_mut().here = Some(0.5);
    harness.run();
    harness.get_by_label_contains(&format!("{hatched}, marked: 0.5000"));
}

#[test]
fn normalise_sets_the_range_by_the_data() {
    let bounds = PixelRect { min: [0, 0], max: [100, 1] };
    let mut view = ViewState { offset: 0.3, ..ViewState::default() };
    // One bright pixel in a hundred and one that is not a number do not decide.
    let mut data: Vec<f32> = (0..300).map(|i| if i % 100 < 98 { 4.0 } else { 900.0 }).collect();
    data[99] = f32::NAN;
    data[199] = f32::INFINITY;
    normalise(&mut view, &Planes::new(Layer::Picture, bounds, [100, 1], data));
    assert_eq!((view.exposure_ev, view.offset), (-2.0, 0.0));

    let data = (0..100).map(|i| 10_f32.powf(-3.5 + 5.0 * i as f32 / 99.0)).collect();
    normalise(&mut view, &Planes::new(Layer::Variance, bounds, [100, 1], data));
    assert_eq!(view.variance_range, [-4.0, 2.0]);
    normalise(&mut view, &Planes::new(Layer::Variance, bounds, [100, 1], vec![f32::NAN; 100]));
    assert_eq!(view.variance_range, [-4.0, 2.0], "nothing to go by");

    // B is brighter everywhere but where a picture is blind.
    let data = (0..100).map(|i| if i % 2 == 0 { -0.034 } else { BLIND }).collect();
    normalise(&mut view, &Planes::new(Versus::Difference, bounds, [100, 1], data));
    assert!((view.difference_range - 0.04).abs() < 1e-6, "{}", view.difference_range);
}

#[test]
fn view_state_survives_storage_and_refuses_what_it_does_not_know() {
    let view = ViewState {
        exposure_ev: -1.25,
        tone_map: ToneMap::Filmic,
        placement: Placement::Free { scale: 3.0, centre: [1.5, 2.5] },
        ..ViewState::default()
    };
    let view = StoredView { layer: Layer::WeightBsdf, view };
    let json = serde_json::to_string(&view).expect("it can be written");
    let flat = r#"{"layer":"w_bsdf","exposure_ev":-1.25,"offset":0.0,"tone_map":"filmic","variance_range":[-2.0,4.0],"#;
    assert!(json.starts_with(flat), "the keys of older snapshots: {json}");
    assert_eq!(serde_json::from_str::<StoredView>(&json).expect("it can be read"), view);
    assert_eq!(serde_json::from_str::<StoredView>("{}").expect("missing fields are defaults"), StoredView::default());
    let error = serde_json::from_str::<StoredView>(r#"{"layer":"depth"}"#).expect_err("there is no such layer");
    assert!(error.to_string().contains("layer \"depth\", expected one of picture, light"), "{error}");
}

/// A frame of the renderer: its layers on screen, and the picture for a PNG.
#[test]
fn a_frame_of_the_renderer_is_shown_layer_by_layer() {
    let file = mislab_renderer::pbrt::embedded_scene();
    let settings = Settings {
        sampling: Sampling { spp: NonZeroU32::new(4), ..Sampling::default() },
        image: ImageSettings { resolution: [60, 40], ..ImageSettings::default() },
        ..Settings::default()
    };
    let crop = Settings { image: ImageSettings { crop: [0.25, 0.75, 0.5, 1.0], ..settings.image }, ..settings.clone() };
    for settings in [settings, crop] {
        let bounds = settings.pixel_bounds();
        let request = Request { scene: Arc::new(file.scene.clone()), settings };
        let frame = mislab_renderer::render(&request, 1, &mut |_| true).expect("the scene can be rendered");
        for layer in Layer::ALL {
            let planes = Planes::from_frame(&frame, layer);
            assert_eq!((planes.bounds(), planes.image()), (bounds, [60, 40]));
            for (plane, channel) in planes.channels().zip(layer.channels()) {
                let same = plane.iter().zip(frame.channel(*channel)).all(|(a, b)| a.to_bits() == b.to_bits());
                assert!(same, "{channel:?} of the frame is not that on screen");
            }
            let (w, h, pixels) = render_to_rgba8(&frame, layer, &ViewState::default(), true);
            assert_eq!((w, h, pixels.len()), (bounds.width(), bounds.height(), 4 * bounds.area()));
            assert!(!pixels.chunks_exact(4).any(|p| p == [255, 0, 0, 255]), "{layer:?} has numbers that cannot be");
        }
    }
}
