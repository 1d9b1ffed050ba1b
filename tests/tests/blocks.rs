//! Errors kept by blocks of pixels are those of the pixels.

use std::num::NonZeroU32;
use std::sync::Arc;

use mislab_renderer::study::reference::Wish;
use mislab_renderer::study::{Against, News, Part, grow, whole_blocks};
use mislab_renderer::{
    Channel, Estimator, ImageSettings, PixelRect, Request, Sampling, Settings, Strategy, pbrt, render,
};

#[test]
fn a_rectangle_of_blocks_has_the_errors_of_its_pixels() {
    let image = ImageSettings { resolution: [60, 50], crop: [0.1, 0.93, 0.2, 1.0] };
    let scene = Arc::new(pbrt::embedded_scene().scene);
    let mut against: Option<Arc<Against>> = None;
    grow(&scene, image, [1, 128], 1, &mut |news| {
        if let News::Better(better) = news {
            against = Some(better);
        }
        Wish::GoOn
    })
    .expect("the scene can be rendered");
    let against = against.expect("it was reported");
    let estimator = Estimator { strategy: Strategy::Bsdf, ..Estimator::default() };
    let sampling = Sampling { spp: NonZeroU32::new(4), seed: 5, ..Sampling::default() };
    let request = Request { scene, settings: Settings { estimator, sampling, image } };
    let bounds = request.settings.pixel_bounds();
    assert_eq!(against.cells.bounds, bounds);
    let frame = render(&request, 1, &mut |_| true).expect("it can be rendered");
    let planes = [Channel::R, Channel::G, Channel::B].map(|channel| frame.channel(channel));
    let picture = planes.each_ref().map(Vec::as_slice);
    let blocks = against.block_errors(picture);
    let whole = PixelRect { min: [0; 2], max: [1000; 2] };
    let mut seen = Vec::new();
    for rect in [whole, PixelRect { min: [20, 20], max: [31, 40] }, PixelRect { min: [50, 45], max: [60, 50] }] {
        let rect = whole_blocks(rect, bounds).expect("it touches the picture");
        let pixels = against.errors(picture, Part::Rect(rect));
        let expected = [pixels.rel_mse(), pixels.mse()].map(|value| value.expect("it has pixels"));
        let found = blocks.over(rect);
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() <= 1e-5 * expected.abs(), "{found}, {expected} by pixels of {rect:?}");
        }
        assert_eq!(pixels.compared as usize, 3 * rect.area(), "all of them: {rect:?}");
        seen.push(found);
    }
    let all = against.errors(picture, Part::Whole).rel_mse().expect("it has pixels");
    assert!((seen[0][0] - all).abs() <= 1e-5 * all, "{} over all blocks, {all} over all", seen[0][0]);
    assert!(seen[0] != seen[1] && seen[1] != seen[2], "parts differ");
}
