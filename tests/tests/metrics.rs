//! Metrics against examples computed by hand.

use mislab_renderer::PixelRect;
use mislab_renderer::metrics::{Errors, Reference, Region, compare};
use mislab_renderer::snapshot::{Image, Window};

/// Two by two pixels, at (10, -20).
fn image(channels: &[(&str, [f32; 4])]) -> Image {
    let window = Window { min: [10, -20], size: [2, 2] };
    let channels = channels.iter().map(|(name, values)| ((*name).to_owned(), values.to_vec())).collect();
    Image { window, display: window, channels, attributes: Vec::new() }
}

fn close(found: Option<f64>, expected: f64) {
    let found = found.expect("there are finite values");
    assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{found}, expected {expected}");
}

#[test]
fn numbers_by_hand() {
    let a = image(&[("R", [1.0, 2.0, 3.0, 4.0])]);
    let b = image(&[("R", [1.0, 0.0, 2.0, 4.5])]);
    let c = compare(&a, &b).expect("same pixels");
    let r = &c.channels[0];
    close(r.mean_a, 2.5);
    close(r.mean_b, 1.875);
    close(r.mse, (4.0 + 1.0 + 0.25) / 4.0);
    close(r.rel_mse, (4.0 / 0.01 + 1.0 / 4.01 + 0.25 / 20.26) / 4.0);
    let maximum = r.maximum.expect("finite values");
    assert_eq!((maximum.value, maximum.x, maximum.y), (2.0, 11, -20));
    assert_eq!((r.compared, r.both_undefined, r.undefined_mismatch()), (4, 0, 0));
    assert!(!c.is_identical());
    assert!(compare(&a, &a).expect("same pixels").is_identical());
}

#[test]
fn a_layer_is_the_average_of_its_channels() {
    let a = image(&[("light.G", [1.0; 4]), ("light.R", [0.0; 4]), ("R", [0.0; 4]), ("a.b.Y", [2.0; 4])]);
    let b = image(&[("light.G", [0.0; 4]), ("light.R", [0.0, 0.0, 0.0, 3.0]), ("R", [0.0; 4]), ("a.b.Y", [2.0; 4])]);
    let c = compare(&a, &b).expect("same pixels");
    let names: Vec<_> = c.layers.iter().map(|l| l.name.as_str()).collect();
    assert_eq!(names, ["RGB", "a.b", "light"]);
    let light = &c.layers[2];
    close(light.mean_a, 0.5);
    close(light.mse, (4.0 + 9.0) / 8.0);
    let maximum = light.maximum.expect("finite values");
    assert_eq!((maximum.value, maximum.x, maximum.y), (3.0, 11, -19));
    assert_eq!(light.compared, 8);
}

#[test]
fn undefined_values_are_counted_by_picture_and_left_out_of_all_averages_alike() {
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let a = image(&[("w.Y", [nan, nan, 2.0, inf])]);
    let b = image(&[("w.Y", [nan, 1.0, 5.0, inf])]);
    let w = &compare(&a, &b).expect("same pixels").channels[0];
    assert_eq!((w.compared, w.both_undefined, w.undefined_in_a, w.undefined_in_b), (1, 2, 1, 0));
    close(w.mean_a, 2.0);
    close(w.mean_b, 5.0);
    close(w.mse, 9.0);
    let w = &compare(&b, &a).expect("same pixels").channels[0];
    assert_eq!((w.undefined_in_a, w.undefined_in_b, w.undefined_mismatch()), (0, 1, 1));
    let opposite = image(&[("w.Y", [nan, nan, 2.0, -inf])]);
    let w = &compare(&a, &opposite).expect("same pixels").channels[0];
    assert_eq!((w.undefined_differently, w.undefined_mismatch()), (1, 1), "inf is not -inf");
    let same = compare(&a, &a).expect("same pixels");
    assert!(same.is_identical(), "NaN equals NaN");

    let nothing = image(&[("w.Y", [nan; 4])]);
    let json = serde_json::to_value(compare(&nothing, &nothing).expect("same pixels")).expect("is JSON");
    assert!(json["channels"][0]["mse"].is_null() && json["channels"][0]["maximum"].is_null(), "{json}");
}

#[test]
fn a_hole_in_one_picture_is_no_error_of_zero() {
    let b = image(&[("R", [1.0, 2.0, 3.0, 4.0])]);
    let a = image(&[("R", [1.0, f32::NAN, 3.0, 4.0])]);
    for (a, b) in [(&a, &b), (&b, &a)] {
        let c = compare(a, b).expect("same pixels");
        for d in c.layers.iter().chain(&c.channels) {
            assert_eq!((d.mse, d.rel_mse, d.maximum), (None, None, None), "{}", d.name);
            assert_eq!(d.compared, 3);
            close(d.mean_a, 8.0 / 3.0);
        }
        assert!(!c.is_identical());
    }
    // With a difference elsewhere there is one to tell, over the other pixels.
    let a = image(&[("R", [1.0, f32::NAN, 3.0, 5.0])]);
    close(compare(&a, &b).expect("same pixels").layers[0].mse, 1.0 / 3.0);
}

#[test]
fn a_layer_counts_the_pixels_that_are_defined_in_all_of_its_channels() {
    let a = image(&[("G", [0.0, 1.0, 2.0, 3.0]), ("R", [f32::NAN, 1.0, 1.0, 1.0])]);
    let b = image(&[("G", [9.0, 1.0, 2.0, 5.0]), ("R", [1.0, 1.0, 2.0, 1.0])]);
    let c = compare(&a, &b).expect("same pixels");
    let rgb = &c.layers[0];
    assert_eq!((rgb.compared, rgb.undefined_in_a, rgb.undefined_in_b), (6, 1, 0));
    close(rgb.mse, (4.0 + 1.0) / 6.0);
    close(rgb.mean_a, (1.0 + 2.0 + 3.0 + 3.0) / 6.0);
    close(rgb.mean_b, (1.0 + 2.0 + 5.0 + 1.0 + 2.0 + 1.0) / 6.0);
    let green = &c.channels[0];
    assert_eq!((green.name.as_str(), green.compared), ("G", 4));
    close(green.mse, (81.0 + 4.0) / 4.0);
}

#[test]
fn a_crop_is_compared_with_the_pixels_it_was_cut_from() {
    let full = Window { min: [0, 0], size: [4, 3] };
    let values: Vec<f32> = (0..12).map(|i| i as f32).collect();
    let b = Image { window: full, display: full, channels: vec![("R".into(), values)], attributes: Vec::new() };
    // Two by two pixels at (1, 1), one of them another.
    let crop = Window { min: [1, 1], size: [2, 2] };
    let a = Image {
        window: crop,
        display: full,
        channels: vec![("R".into(), vec![5.0, 6.0, 9.0, 13.0])],
        attributes: Vec::new(),
    };
    for (first, second) in [(&a, &b), (&b, &a)] {
        let c = compare(first, second).expect("pixels in common");
        assert_eq!((c.window, c.window_a, c.window_b), (crop, first.window, second.window));
        let r = &c.channels[0];
        assert_eq!((r.compared, r.maximum.map(|m| (m.value, m.x, m.y))), (4, Some((3.0, 2, 2))));
        close(r.mse, 9.0 / 4.0);
    }
    // Two crops: the pixels of both.
    let other =
        Image { window: Window { min: [2, 0], size: [2, 3] }, channels: vec![("R".into(), vec![6.0; 6])], ..b.clone() };
    let c = compare(&a, &other).expect("pixels in common");
    assert_eq!(c.window, Window { min: [2, 1], size: [1, 2] });
    close(c.channels[0].mse, 49.0 / 2.0);
    let apart =
        Image { window: Window { min: [3, 0], size: [1, 3] }, channels: vec![("R".into(), vec![0.0; 3])], ..b.clone() };
    let error = compare(&a, &apart).expect_err("no pixel").to_string();
    assert!(error.contains("2 x 2 at (1 1)") && error.contains("1 x 3 at (3 0)"), "{error}");
    let smaller = Image { display: crop, ..a.clone() };
    let error = compare(&smaller, &b).expect_err("another image").to_string();
    assert!(error.contains("display window"), "{error}");
}

#[test]
fn names_that_begin_with_a_dot_are_of_the_default_layer() {
    let a = image(&[(".B", [1.0; 4]), (".G", [1.0; 4]), (".R", [1.0; 4])]);
    let b = image(&[("B", [1.0; 4]), ("G", [1.0; 4]), ("R", [3.0; 4])]);
    let c = compare(&a, &b).expect("same pixels");
    assert_eq!(c.layers.iter().map(|l| l.name.as_str()).collect::<Vec<_>>(), ["RGB"]);
    assert_eq!((c.channels.len(), c.only_in_a.len(), c.only_in_b.len()), (3, 0, 0));
    close(c.layers[0].mse, 4.0 / 3.0);
    assert_eq!(compare(&a, &a).expect("same pixels").layers[0].name, "RGB");
}

#[test]
fn what_cannot_be_compared_says_why() {
    let a = image(&[("R", [0.0; 4])]);
    let mut moved = a.clone();
    moved.window.min[0] = 12;
    let error = compare(&a, &moved).expect_err("other pixels").to_string();
    assert!(error.contains("2 x 2 at (10 -20)") && error.contains("2 x 2 at (12 -20)"), "{error}");
    let error = compare(&a, &image(&[("Z", [0.0; 4])])).expect_err("nothing in common").to_string();
    assert!(error.contains('R') && error.contains('Z'), "{error}");
    let c = compare(&image(&[("R", [0.0; 4]), ("A", [0.0; 4])]), &image(&[("R", [0.0; 4]), ("Z", [0.0; 4])]));
    let c = c.expect("R is common");
    assert_eq!((c.only_in_a.as_slice(), c.only_in_b.as_slice()), (&["A".to_owned()][..], &["Z".to_owned()][..]));
    assert!(!c.is_identical(), "missing channels are a difference");
}

#[test]
fn a_region_counts_its_own_pixels_only() {
    // Three by two pixels, two channels.
    let x: [&[f32]; 2] = [&[1.0, 2.0, 3.0, 4.0, f32::NAN, 6.0], &[0.0; 6]];
    let r: [&[f32]; 2] = [&[1.0, 1.0, 1.0, 1.0, 1.0, f32::NAN], &[0.0, 1.0, 0.0, 2.0, 0.0, 0.0]];
    let of = |region: Region<'_>| Errors::of(&x, &Reference::Exact(&r), &region);
    let all = of(Region::All);
    close(all.mse(), (1.0 + 4.0 + 9.0 + 1.0 + 4.0) / 8.0);
    assert_eq!((all.compared, all.undefined_mismatch(), all.maximum), (8, 2, Some((3.0, 3))));
    let right = of(Region::Rect { width: 3, rect: PixelRect { min: [1, 0], max: [3, 2] } });
    close(right.mse(), (1.0 + 4.0 + 1.0) / 4.0);
    close(right.rel_mse(), (1.0 / 1.01 + 4.0 / 1.01 + 1.0 / 1.01) / 4.0);
    close(right.mean(), (2.0 + 3.0) / 4.0);
    close(right.reference_mean(), (1.0 + 1.0 + 1.0) / 4.0);
    assert_eq!(of(Region::Mask(&[false, true, true, false, true, true])), right);
    assert_eq!(of(Region::Mask(&[false; 6])).mse(), None);
    assert_eq!(of(Region::Mask(&[true; 6])), all);
    let mut parts = of(Region::Mask(&[true, false, false, true, false, false]));
    parts.merge(&right);
    assert_eq!(
        (parts.mse(), parts.rel_mse(), parts.compared, parts.maximum),
        (all.mse(), all.rel_mse(), 8, all.maximum)
    );
}

#[test]
fn halves_take_the_references_noise_out() {
    let (x, halves): ([f32; 2], [[f64; 2]; 2]) = ([1.5, 3.0], [[1.1, 3.5], [0.9, 2.5]]);
    let reference = Reference::Halves([&[&halves[0]], &[&halves[1]]]);
    let errors = Errors::of(&[&x], &reference, &Region::All);
    close(errors.mse(), (0.4 * 0.6 - 0.25) / 2.0);
    close(errors.rel_mse(), (0.4 * 0.6 / 1.01 - 0.25 / 9.01) / 2.0);
    let own = Errors::of_halves([&[&halves[0]], &[&halves[1]]], &Region::Mask(&[false, true]));
    close(own.mse(), 0.25);
    close(own.rel_mse(), 0.25 / 9.01);
}
