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
    assert_eq!((r.compared, r.both_undefined, r.undefined_mismatch), (4, 0, 0));
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
fn undefined_values_are_counted_and_left_out_of_the_averages() {
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let a = image(&[("w.Y", [nan, nan, 2.0, inf])]);
    let b = image(&[("w.Y", [nan, 1.0, 5.0, inf])]);
    let w = &compare(&a, &b).expect("same pixels").channels[0];
    assert_eq!((w.compared, w.both_undefined, w.undefined_mismatch), (1, 2, 1));
    close(w.mean_a, 2.0);
    close(w.mean_b, 3.0);
    close(w.mse, 9.0);
    let opposite = image(&[("w.Y", [nan, nan, 2.0, -inf])]);
    assert_eq!(compare(&a, &opposite).expect("same pixels").channels[0].undefined_mismatch, 1, "inf is not -inf");
    let same = compare(&a, &a).expect("same pixels");
    assert!(same.is_identical(), "NaN equals NaN");

    let nothing = image(&[("w.Y", [nan; 4])]);
    let json = serde_json::to_value(compare(&nothing, &nothing).expect("same pixels")).expect("is JSON");
    assert!(json["channels"][0]["mse"].is_null() && json["channels"][0]["maximum"].is_null(), "{json}");
}

#[test]
fn what_cannot_be_compared_says_why() {
    let a = image(&[("R", [0.0; 4])]);
    let mut moved = a.clone();
    moved.window.min[0] = 11;
    let error = compare(&a, &moved).expect_err("other pixels").to_string();
    assert!(error.contains("2 x 2 at (10 -20)") && error.contains("2 x 2 at (11 -20)"), "{error}");
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
    close(all.mse(), (1.0 + 4.0 + 9.0 + 1.0 + 4.0) / 10.0);
    assert_eq!((all.compared, all.undefined_mismatch, all.maximum), (10, 2, Some((3.0, 3))));
    let right = of(Region::Rect { width: 3, rect: PixelRect { min: [1, 0], max: [3, 2] } });
    close(right.mse(), (1.0 + 4.0 + 1.0) / 6.0);
    close(right.rel_mse(), (1.0 / 1.01 + 4.0 / 1.01 + 1.0 / 1.01) / 6.0);
    close(right.mean(), (2.0 + 3.0 + 6.0) / 7.0);
    close(right.reference_mean(), (1.0 + 1.0 + 1.0 + 1.0) / 7.0);
    assert_eq!(of(Region::Mask(&[false, true, true, false, true, true])), right);
    assert_eq!(of(Region::Mask(&[false; 6])).mse(), None);
    assert_eq!(of(Region::Mask(&[true; 6])), all);
    let mut parts = of(Region::Mask(&[true, false, false, true, false, false]));
    parts.merge(&right);
    assert_eq!(
        (parts.mse(), parts.rel_mse(), parts.compared, parts.maximum),
        (all.mse(), all.rel_mse(), 10, all.maximum)
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
