//! Rectangles and chosen pixels of a frame are the same bits as the whole.

use std::num::NonZeroU32;
use std::sync::Arc;

use mislab_renderer::{Channel, Frame, PixelRect, Strategy};
use mislab_tests::experiment::{independent, render, veach};

/// Wider than a tile, of whole blocks nowhere, cropped on all sides.
fn frame() -> Arc<Frame> {
    let mut settings = independent(3, 5, [830, 37]);
    settings.estimator.strategy = Strategy::MisAll;
    settings.sampling.spp = NonZeroU32::new(3);
    settings.image.crop = [0.01, 0.995, 0.1, 0.96];
    render(&Arc::new(veach()), &settings)
}

/// Numbers below `n` (a linear congruential generator, fixed seed).
fn numbers() -> impl FnMut(u32) -> u32 {
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    move |n| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) as u32) % n
    }
}

struct Whole {
    frame: Arc<Frame>,
    planes: Vec<Vec<f32>>,
}

impl Whole {
    fn new() -> Self {
        let frame = frame();
        let planes = Channel::ALL.map(|channel| frame.channel(channel)).into();
        Self { frame, planes }
    }

    fn at(&self, channel: usize, [x, y]: [u32; 2]) -> u32 {
        let bounds = self.frame.bounds();
        let index = (y - bounds.min[1]) as usize * bounds.width() as usize + (x - bounds.min[0]) as usize;
        self.planes[channel][index].to_bits()
    }

    fn check_rect(&self, rect: PixelRect) {
        let mut out = vec![-1.0; Channel::ALL.len() * rect.area()];
        self.frame.resolve_rect(&Channel::ALL, rect, &mut out);
        let mut found = out.iter();
        for channel in 0..Channel::ALL.len() {
            for y in rect.min[1]..rect.max[1] {
                for x in rect.min[0]..rect.max[0] {
                    let value = found.next().expect("one value per channel and pixel").to_bits();
                    assert_eq!(value, self.at(channel, [x, y]), "{rect:?}, channel {channel} at {x}, {y}");
                }
            }
        }
    }
}

#[test]
fn rectangles_are_parts_of_the_whole() {
    let whole = Whole::new();
    let bounds = whole.frame.bounds();
    assert!(bounds.min[0] > 0 && bounds.min[1] > 0 && bounds.max[0] > 800, "{bounds:?}");
    whole.check_rect(bounds);
    whole.check_rect(PixelRect { min: bounds.min, max: [bounds.max[0], bounds.min[1] + 1] });
    whole.check_rect(PixelRect { min: bounds.min, max: bounds.min });
    // Across the border of two tiles.
    whole.check_rect(PixelRect { min: [799, 15], max: [801, 17] });
    let mut number = numbers();
    for _ in 0..300 {
        let min = [0, 1].map(|i| bounds.min[i] + number(bounds.max[i] - bounds.min[i]));
        // Mostly small ones.
        let most = if number(4) == 0 { 900 } else { 20 };
        let max = [0, 1].map(|i| min[i] + 1 + number((bounds.max[i] - min[i]).min(most)));
        whole.check_rect(PixelRect { min, max });
    }
}

#[test]
fn chosen_pixels_come_in_the_order_asked_for() {
    let whole = Whole::new();
    let bounds = whole.frame.bounds();
    let mut number = numbers();
    let mut pixels: Vec<[u32; 2]> =
        (0..2000).map(|_| [0, 1].map(|i| bounds.min[i] + number(bounds.max[i] - bounds.min[i]))).collect();
    // Some twice, and a run of neighbours.
    pixels.extend_from_within(..100);
    pixels.extend((bounds.min[0]..bounds.max[0]).map(|x| [x, 20]));
    let mut out = vec![-1.0; Channel::ALL.len() * pixels.len()];
    whole.frame.resolve_pixels(&Channel::ALL, &pixels, &mut out);
    for (channel, plane) in out.chunks_exact(pixels.len()).enumerate() {
        for (value, &pixel) in plane.iter().zip(&pixels) {
            assert_eq!(value.to_bits(), whole.at(channel, pixel), "channel {channel} at {pixel:?}");
        }
    }
    whole.frame.resolve_pixels(&Channel::ALL, &[], &mut []);
}
