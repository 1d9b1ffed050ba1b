//! The shader and its twin on the CPU draw the same.

use std::sync::Arc;

use eframe::egui::pos2;
use egui_kittest::Harness;
use mislab::look::colormap::LIGHT_TECHNIQUE;
use mislab::look::versus::Versus;
use mislab::picture::planes::{BLIND, Planes, UNHIT};
use mislab::picture::still::planes_to_rgba8;
use mislab::picture::tone::surround;
use mislab::state::placement::Placement;
use mislab::state::view::{ToneMap, ViewState};
use mislab_renderer::{Layer, PixelRect};

use crate::window::{App, drawn, synthetic};

/// The window's picture by both ways, width and RGBA8.
fn both(harness: &mut Harness<'static, App>) -> [(u32, Vec<u8>); 2] {
    [true, false].map(|on_gpu| {
        harness.state_mut().on_gpu = on_gpu;
        // Two passes: a texture made in the first is drawn in the same, sizes settle.
        harness.run();
        let image = harness.render().expect("the window can be drawn");
        (image.width(), image.into_raw())
    })
}

/// Fails where the two pictures differ by more than one step of 8 bits.
fn assert_agree(harness: &mut Harness<'static, App>, what: &str) {
    let [(width, gpu), (_, cpu)] = both(harness);
    assert_eq!(gpu.len(), cpu.len(), "{what}: pictures of different sizes");
    let worst = gpu.iter().zip(&cpu).enumerate().max_by_key(|(_, (a, b))| a.abs_diff(**b));
    let (at, (a, b)) = worst.expect("the picture is not empty");
    let pixel = at as u32 / 4;
    let place = (pixel % width, pixel / width, at % 4);
    assert!(a.abs_diff(*b) <= 1, "{what}: shader {a}, CPU {b} at x, y, channel {place:?}");
    let distinct: std::collections::BTreeSet<&[u8]> = gpu.chunks_exact(4).collect();
    assert!(distinct.len() > 3, "{what}: only {} colours, is anything drawn?", distinct.len());
}

#[test]
fn shader_and_cpu_show_the_same_of_every_layer_and_tone_map() {
    let mut harness = drawn([210.0, 150.0], 1.0);
    for dark in [true, false] {
        harness.state_mut().dark = dark;
        for versus in Versus::ALL {
            harness.state_mut().show(versus);
            assert_agree(&mut harness, &format!("{versus:?}, dark {dark}"));
        }
        for layer in Layer::ALL {
            harness.state_mut().show(layer);
            for map in ToneMap::ALL {
                harness.state_mut().view.tone_map = map;
                assert_agree(&mut harness, &format!("{layer:?}, {map:?}, dark {dark}"));
                if !mislab::look::layer::LayerLook::of(layer).is_colour() {
                    break;
                }
            }
        }
    }
}

#[test]
fn shader_and_cpu_agree_on_exposure_range_zoom_crop_and_stale() {
    let mut harness = drawn([200.0, 120.0], 2.0);
    let view = |ev: f32, offset: f32| ViewState { exposure_ev: ev, offset, ..ViewState::default() };
    harness.state_mut().view = view(-2.5, 0.1);
    assert_agree(&mut harness, "exposure -2.5, offset 0.1");
    harness.state_mut().view = view(6.0, -0.25);
    assert_agree(&mut harness, "exposure 6, offset -0.25");
    harness.state_mut().view = view(1e30, f32::NAN);
    assert_agree(&mut harness, "absurd exposure and offset");

    for map in ToneMap::ALL {
        harness.state_mut().view = ViewState { tone_map: map, mark_clipped: true, ..view(1.0, 0.0) };
        assert_agree(&mut harness, &format!("clipped pixels marked, {map:?}"));
    }
    harness.state_mut().view = view(0.0, 0.0);

    harness.state_mut().show(Layer::Variance);
    harness.state_mut().view.variance_range = [-2.5, 0.5];
    assert_agree(&mut harness, "variance range");
    harness.state_mut().view.variance_range = [1.0, 1.0];
    assert_agree(&mut harness, "empty variance range");

    for scale in [0.31, 1.0, 3.0, 7.77, 130.0] {
        harness.state_mut().view.placement = Placement::Free { scale, centre: [40.3, 58.8] };
        assert_agree(&mut harness, &format!("scale {scale}"));
    }
    harness.state_mut().stale = true;
    assert_agree(&mut harness, "stale");

    let bounds = PixelRect { min: [100, 20], max: [196, 84] };
    let whole = synthetic(Layer::ShareLight);
    let data = whole.channels().flatten().copied().collect();
    harness.state_mut().planes = Some(Arc::new(Planes::new(Layer::ShareLight, bounds, [300, 200], data)));
    harness.state_mut().layer = Layer::ShareLight.into();
    harness.state_mut().view = ViewState::default();
    assert_agree(&mut harness, "crop window");
}

/// At 100 % every pixel of the screen is one of the picture, at any density of the screen.
#[test]
fn at_100_percent_the_screen_holds_the_picture_pixel_by_pixel() {
    for pixels_per_point in [1.0, 1.5, 2.0] {
        let mut harness = drawn([121.0, 90.0], pixels_per_point);
        let geometry = harness.state().geometry();
        harness.state_mut().view.placement.actual_size(&geometry);
        harness.run();
        let geometry = harness.state().geometry();
        assert_eq!(geometry.zoom_percent(), 100.0);
        let screen = harness.render().expect("the window can be drawn");
        let state = harness.state();
        let planes = state.planes.as_ref().expect("a picture is shown");
        let (w, h, expected) = planes_to_rgba8(planes, &state.view, true);
        let [left, top] = geometry.origin.map(|v| v as i64);
        let mut compared = 0;
        for y in 0..i64::from(h) {
            for x in 0..i64::from(w) {
                let (sx, sy) = (x + left, y + top);
                if sx < 0 || sy < 0 || sx >= i64::from(screen.width()) || sy >= i64::from(screen.height()) {
                    continue;
                }
                // Hatchings begin at the corner of the window.
                if [BLIND, UNHIT].contains(&planes.value(x as u32, y as u32)[0]) {
                    continue;
                }
                let shown = screen.get_pixel(sx as u32, sy as u32).0;
                let from = (4 * (y * i64::from(w) + x)) as usize;
                let close = shown.iter().zip(&expected[from..from + 4]).all(|(a, b)| a.abs_diff(*b) <= 1);
                assert!(close, "pixel {x}, {y}: {shown:?}, expected {:?}", &expected[from..from + 4]);
                compared += 1;
            }
        }
        assert!(compared > 4000, "only {compared} pixels of the picture are on screen");
    }
}

#[test]
fn a_picture_beyond_the_largest_texture_is_shown_all_the_same() {
    let mut harness = drawn([210.0, 60.0], 1.0);
    let bounds = PixelRect { min: [0, 0], max: [20_000, 2] };
    let data = (0..bounds.area()).map(|i| (i % 20_000) as f32 / 20_000.0).collect();
    let state = harness.state_mut();
    state.layer = Layer::ShareLight.into();
    state.view.placement = Placement::Free { scale: 32.0, centre: [19_999.0, 1.0] };
    state.planes = Some(Arc::new(Planes::new(Layer::ShareLight, bounds, bounds.max, data)));
    harness.run();
    let image = harness.render().expect("the window can be drawn");
    let shown = image.get_pixel(105, 30).0;
    let close = shown.iter().zip(LIGHT_TECHNIQUE).all(|(a, b)| a.abs_diff(b) <= 1);
    assert!(close, "{shown:?} at the right end of the picture, expected {LIGHT_TECHNIQUE:?}");
}

#[test]
fn outside_the_crop_window_is_surround_and_no_pixel() {
    let mut harness = drawn([200.0, 100.0], 1.0);
    let bounds = PixelRect { min: [50, 0], max: [100, 100] };
    let planes = Planes::new(Layer::ShareLight, bounds, [200, 100], vec![1.0; bounds.area()]);
    harness.state_mut().planes = Some(Arc::new(planes));
    harness.state_mut().layer = Layer::ShareLight.into();
    for (at, inside) in [(pos2(20.5, 50.5), false), (pos2(70.5, 50.5), true), (pos2(120.5, 50.5), false)] {
        harness.hover_at(at);
        harness.run();
        let expected = inside.then_some([at.x as u32, at.y as u32]);
        assert_eq!(harness.state().hovered(), expected);
        let image = harness.render().expect("the window can be drawn");
        let shown = image.get_pixel(at.x as u32, at.y as u32).0;
        let [r, g, b] = LIGHT_TECHNIQUE;
        let expected = if inside { [r, g, b, 255] } else { surround(true).to_array() };
        assert!(
            shown.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 1),
            "{shown:?} at {at:?}, expected {expected:?}"
        );
    }
}

#[test]
fn a_stale_picture_looks_different() {
    let mut harness = drawn([192.0, 128.0], 1.0);
    let fresh = harness.render().expect("the window can be drawn");
    harness.state_mut().stale = true;
    harness.run();
    let stale = harness.render().expect("the window can be drawn");
    let contrast = |image: &dyn Fn(u32) -> u8| (0..192).map(image).max().zip((0..192).map(image).min());
    let (high, low) = contrast(&|x| stale.get_pixel(x, 64).0[1]).expect("the row is not empty");
    let (fresh_high, fresh_low) = contrast(&|x| fresh.get_pixel(x, 64).0[1]).expect("the row is not empty");
    assert!(
        u32::from(high - low) * 10 < u32::from(fresh_high - fresh_low) * 6,
        "contrast {low} to {high}, fresh {fresh_low} to {fresh_high}"
    );
}

#[test]
fn nothing_to_show_is_no_error() {
    let mut harness = drawn([200.0, 100.0], 1.0);
    let empty = PixelRect { min: [3, 3], max: [3, 3] };
    for planes in [None, Some(Arc::new(Planes::new(Layer::Picture, empty, [8, 8], Vec::new())))] {
        harness.state_mut().planes = planes;
        harness.run();
        let image = harness.render().expect("the window can be drawn");
        assert_eq!(image.get_pixel(100, 50).0, surround(true).to_array());
    }
}
