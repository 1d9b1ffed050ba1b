//! The picture viewport: the shader against its twin on the CPU, published values of curves and maps,
//! zoom and pan. Pictures are drawn by a software driver; no display is needed.

use std::num::NonZeroU32;
use std::sync::Arc;

use eframe::egui::{self, Pos2, Rect, pos2, vec2};
use egui_kittest::{Harness, kittest::Queryable};
use mislab::look::colormap::{BSDF_TECHNIQUE, ColourMap, LIGHT_TECHNIQUE};
use mislab::look::layer::{Colouring, LayerLook, Quantity};
use mislab::look::versus::Versus;
use mislab::picture::film_texture::FilmPipeline;
use mislab::picture::legend::{Key, legend_overlay};
use mislab::picture::normalise::normalise;
use mislab::picture::planes::{BLIND, Planes, UNHIT};
use mislab::picture::still::{planes_to_rgba8, render_to_rgba8};
use mislab::picture::tone::{filmic, srgb_encode, surround, tone_map};
use mislab::picture::viewport::{Shown, Viewport, ViewportResponse};
use mislab::state::placement::{Geometry, Placement};
use mislab::state::view::{StoredView, ToneMap, VarianceUnit, ViewState};
use mislab_renderer::{ImageSettings, Layer, PixelRect, Request, Sampling, Settings};

const SIZE: [u32; 2] = [96, 64];

/// A window with nothing but the viewport; `on_gpu` says which of the two ways draws.
struct App {
    gpu: Viewport,
    cpu: Viewport,
    on_gpu: bool,
    layer: Quantity,
    view: ViewState,
    planes: Option<Arc<Planes>>,
    stale: bool,
    dark: bool,
    legend: bool,
    here: Option<f32>,
    last: Option<ViewportResponse>,
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        let Self { gpu, cpu, on_gpu, layer, view, planes, stale, dark, legend, here, last } = self;
        ui.ctx().set_theme(if *dark { egui::Theme::Dark } else { egui::Theme::Light });
        let viewport = if *on_gpu { gpu } else { cpu };
        let shown = viewport.ui(
            ui,
            view,
            Shown { quantity: *layer, planes: planes.as_ref(), stale: stale.then_some("previous settings") },
        );
        if *legend {
            let rect = shown.response.rect;
            legend_overlay(ui, rect, rect, Key { quantity: *layer, view, here: *here });
        }
        *last = Some(shown);
    }
}

impl App {
    fn new(render_state: Option<&eframe::egui_wgpu::RenderState>, layer: Layer) -> Self {
        Self {
            gpu: Viewport::new(render_state.and_then(FilmPipeline::new)),
            cpu: Viewport::new(None),
            on_gpu: render_state.is_some(),
            layer: layer.into(),
            view: ViewState::default(),
            planes: Some(Arc::new(synthetic(layer))),
            stale: false,
            dark: true,
            legend: false,
            here: None,
            last: None,
        }
    }

    fn show(&mut self, quantity: impl Into<Quantity>) {
        self.layer = quantity.into();
        self.planes = Some(Arc::new(synthetic(self.layer)));
    }

    fn geometry(&self) -> Geometry {
        self.last.as_ref().and_then(|last| last.geometry).expect("a picture is shown")
    }

    fn hovered(&self) -> Option<[u32; 2]> {
        self.last.as_ref().and_then(|last| last.hovered_pixel)
    }
}

/// A window that is really drawn.
fn drawn(size: [f32; 2], pixels_per_point: f32) -> Harness<'static, App> {
    let mut harness = Harness::builder()
        .with_size(egui::Vec2::from(size))
        .with_pixels_per_point(pixels_per_point)
        .with_render_cursor(false)
        .wgpu()
        .build_eframe(|cc| App::new(cc.wgpu_render_state.as_ref(), Layer::Picture));
    assert!(harness.state().gpu.on_gpu(), "the device refuses the shader");
    harness.run();
    harness
}

/// A window of which only the logic runs.
fn undrawn(size: [f32; 2]) -> Harness<'static, App> {
    let mut harness = Harness::builder()
        .with_size(egui::Vec2::from(size))
        // Two clicks of two steps each within the time of a double click.
        .with_step_dt(1.0 / 60.0)
        .with_max_steps(64)
        .build_eframe(|cc| App::new(cc.wgpu_render_state.as_ref(), Layer::Picture));
    harness.run();
    harness
}

/// Numbers over the whole range of a layer and beyond: exponential or linear from left to right, a blotch of
/// every kind of number that needs care in the lowest rows.
fn synthetic(quantity: impl Into<Quantity>) -> Planes {
    let quantity = quantity.into();
    let [w, h] = SIZE;
    let special = [0.0, -0.0, 1.0, 1.0005, -0.0005, 1.1, -0.2, f32::NAN, f32::INFINITY, BLIND, UNHIT, 1e-40, 3e38];
    let mut data = Vec::new();
    for channel in 0..quantity.channels() {
        for y in 0..h {
            for x in 0..w {
                let t = (x as f32 + 0.37 * y as f32 / h as f32) / w as f32;
                data.push(if y >= h - 8 {
                    special[x as usize * special.len() / w as usize]
                } else {
                    match LayerLook::of(quantity).colouring {
                        Colouring::Radiance => {
                            let tint = 1.0 - 0.3 * channel as f32 * y as f32 / h as f32;
                            (20.0 * t - 12.0).exp2() * tint
                        }
                        Colouring::Magnitude => 10_f32.powf(8.0 * t - 5.0),
                        // Beyond the range of ratios on either side, and through that of differences in the middle.
                        Colouring::Signed => 8.0 * t - 4.0,
                        Colouring::Share { .. } => t,
                    }
                });
            }
        }
    }
    Planes::new(quantity, PixelRect { min: [0, 0], max: SIZE }, SIZE, data)
}

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
        !red(Layer::ShareLight, vec![BLIND]) && !red(Layer::Variance, vec![BLIND]),
        "what cannot be hit is hatched"
    );
    assert!(!red(Layer::ShareLight, vec![1.0001]) && !red(Layer::Variance, vec![0.0]));
}

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
fn the_viewport_speaks_to_screen_readers() {
    let mut harness = undrawn([400.0, 300.0]);
    harness.state_mut().legend = true;
    harness.run();
    harness.get_by_label("Picture");
    harness.state_mut().view.exposure_ev = -1.5;
    harness.run();
    let hatched = "hatched: nothing hit yet, cross-hatched: cannot be hit";
    harness.get_by_label(&format!("Legend: Picture, EV -1.5, sRGB, {hatched}"));
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

#[test]
fn absurd_stored_numbers_still_give_a_picture() {
    for scale in [f32::NAN, f32::INFINITY, -1.0, 0.0] {
        let placed = geometry(Placement::Free { scale, centre: [f32::NAN, 1e30] }, 1.0);
        assert!(placed.scale > 0.0 && placed.origin.iter().all(|v| v.is_finite()), "{placed:?}");
        assert!(placed.viewport.expand(2.0).intersects(placed.picture_rect()), "{placed:?}");
    }
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
