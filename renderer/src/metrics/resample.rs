//! Pictures of different sizes on one grid.

use crate::error::Error;
use crate::snapshot::{Image, Window};

/// Both pictures on the coarser grid of the two, in each direction: every pixel is the mean over its area (a box filter). Noise
/// becomes smaller by that, as by looking from further away. Pixels that a crop fills in part are left out; a mean over
/// something undefined is undefined.
///
/// # Errors
/// [`Error::Invalid`] if the images differ in shape by more than a pixel, or nothing is left.
pub fn on_one_grid(a: &Image, b: &Image) -> Result<[Image; 2], Error> {
    let ([wa, ha], [wb, hb]) = (a.display.size, b.display.size);
    let size = [wa.min(wb), ha.min(hb)];
    // Both shapes on the common width differ by less than a pixel of height.
    let heights = [f64::from(ha) / f64::from(wa), f64::from(hb) / f64::from(wb)].map(|h| h * f64::from(size[0]));
    if (heights[0] - heights[1]).abs() > 1.0 {
        return Err(Error::Invalid(format!(
            "A is of an image of {wa} x {ha}, B of {wb} x {hb}: expected images of the same shape to resample"
        )));
    }
    Ok([on_grid(a, size)?, on_grid(b, size)?])
}

/// One axis: the pixels that are filled, and for each the pixels it takes with their shares.
struct Axis {
    first: u32,
    taps: Vec<Vec<(usize, f64)>>,
}

impl Axis {
    /// `held`: first pixel and number of pixels, of `from`, that come on a grid of `to` pixels.
    fn new([first, count]: [u64; 2], from: u64, to: u64) -> Self {
        // In parts of which a pixel of the image has `to` and one of the grid has `from`.
        let low = (first * to).div_ceil(from);
        let high = (first + count) * to / from;
        let taps = |i: u64| {
            let [start, end] = [i * from, (i + 1) * from];
            (start / to..end.div_ceil(to))
                .map(|j| {
                    let part = end.min((j + 1) * to) - start.max(j * to);
                    ((j - first) as usize, part as f64 / from as f64)
                })
                .collect()
        };
        Self { first: low as u32, taps: (low..high.max(low)).map(taps).collect() }
    }
}

fn on_grid(image: &Image, size: [u32; 2]) -> Result<Image, Error> {
    let Window { min, size: held } = image.window;
    let axis = |k: usize| {
        // What lies outside the display window is not part of the image.
        let from = i64::from(image.display.size[k]);
        let first = i64::from(min[k]) - i64::from(image.display.min[k]);
        let [low, high] = [first, first + i64::from(held[k])].map(|v| v.clamp(0, from));
        let skipped = (low - first) as usize;
        (Axis::new([low as u64, (high - low) as u64], from as u64, u64::from(size[k])), skipped)
    };
    let ((columns, left), (rows, top)) = (axis(0), axis(1));
    if columns.taps.is_empty() || rows.taps.is_empty() {
        let [w, h] = size;
        return Err(Error::Invalid(format!("{} fills no pixel of a grid of {w} x {h}", image.window)));
    }
    let width = held[0] as usize;
    let resampled = |plane: &[f32]| -> Vec<f32> {
        let mut out = Vec::with_capacity(columns.taps.len() * rows.taps.len());
        for row in &rows.taps {
            for column in &columns.taps {
                let mut sum = 0.0;
                for &(y, of_row) in row {
                    for &(x, of_column) in column {
                        sum += of_row * of_column * f64::from(plane[(y + top) * width + x + left]);
                    }
                }
                out.push(sum as f32);
            }
        }
        out
    };
    Ok(Image {
        window: Window {
            min: [columns.first as i32, rows.first as i32],
            size: [columns.taps.len() as u32, rows.taps.len() as u32],
        },
        display: Window { min: [0; 2], size },
        channels: image.channels.iter().map(|(name, plane)| (name.clone(), resampled(plane))).collect(),
        attributes: image.attributes.clone(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(window: Window, display: [u32; 2], value: impl Fn(i32, i32) -> f32) -> Image {
        let [w, h] = window.size.map(|n| n as i32);
        let plane = (0..h).flat_map(|y| (0..w).map(move |x| (x, y)));
        let values = plane.map(|(x, y)| value(x + window.min[0], y + window.min[1])).collect();
        let channels = vec![("Y".to_owned(), values)];
        Image { window, display: Window { min: [0; 2], size: display }, channels, attributes: Vec::new() }
    }

    fn whole(size: [u32; 2], value: impl Fn(i32, i32) -> f32) -> Image {
        image(Window { min: [0; 2], size }, size, value)
    }

    #[test]
    fn means_over_areas() {
        // Four pixels on three: 1, 1/3 and 2/3, 2/3 and 1/3, 1 of each.
        let [a, b] =
            on_one_grid(&whole([4, 4], |x, _| x as f32), &whole([3, 3], |x, y| (x + y) as f32)).expect("one shape");
        let expected = [0.25, 1.5, 2.75];
        for (found, expected) in a.channels[0].1.iter().zip(expected.iter().cycle()) {
            assert!((found - expected).abs() < 1e-6, "{found}, expected {expected}");
        }
        assert_eq!((a.window, a.display), (b.window, b.display));
        assert_eq!(b.channels[0].1, [0.0, 1.0, 2.0, 1.0, 2.0, 3.0, 2.0, 3.0, 4.0], "the coarser one stays");
    }

    #[test]
    fn the_mean_of_a_picture_stays() {
        let value = |x: i32, y: i32| ((x * 7919 + y * 104_729) % 101) as f32;
        let mean = |image: &Image| {
            image.channels[0].1.iter().map(|&v| f64::from(v)).sum::<f64>() / image.channels[0].1.len() as f64
        };
        let fine = whole([80, 60], value);
        let [found, _] = on_one_grid(&fine, &whole([28, 21], value)).expect("one shape");
        assert!((mean(&found) - mean(&fine)).abs() < 1e-5);
    }

    #[test]
    fn a_crop_fills_the_pixels_it_covers() {
        let crop = image(Window { min: [3, 2], size: [5, 6] }, [8, 8], |x, y| (10 * y + x) as f32);
        let [found, _] = on_one_grid(&crop, &whole([4, 4], |_, _| 0.0)).expect("one shape");
        // Pixels 4 and 5, 6 and 7 across; 2 and 3, 4 and 5, 6 and 7 down.
        assert_eq!(found.window, Window { min: [2, 1], size: [2, 3] });
        assert_eq!(found.channels[0].1[0], 29.5);
        let beyond = image(Window { min: [-2, -2], size: [12, 12] }, [8, 8], |x, y| (10 * y + x) as f32);
        let [found, _] = on_one_grid(&beyond, &whole([4, 4], |_, _| 0.0)).expect("one shape");
        assert_eq!((found.window.size, found.channels[0].1[0]), ([4, 4], 5.5));
    }

    #[test]
    fn holes_stay_holes_and_other_shapes_are_refused() {
        let hole = whole([4, 4], |x, y| if (x, y) == (3, 3) { f32::NAN } else { 1.0 });
        let [found, _] = on_one_grid(&hole, &whole([2, 2], |_, _| 1.0)).expect("one shape");
        assert!(found.channels[0].1[3].is_nan() && found.channels[0].1[0] == 1.0);
        let error = on_one_grid(&hole, &whole([4, 2], |_, _| 1.0)).expect_err("another shape").to_string();
        assert!(error.contains("4 x 4") && error.contains("4 x 2") && error.contains("same shape"), "{error}");
        let sliver = image(Window { min: [1, 0], size: [1, 4] }, [4, 4], |_, _| 1.0);
        assert!(on_one_grid(&sliver, &whole([2, 2], |_, _| 1.0)).is_err());
    }
}
