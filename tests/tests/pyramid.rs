//! The technique pyramid: what both techniques add to a picture is the picture.

use std::sync::Arc;

use mislab_renderer::{Channel, Estimator, Layer, Settings, Strategy};
use mislab_tests::experiment::{independent, render, veach};

#[test]
fn weighted_pictures_add_up_to_the_picture() {
    let scene = Arc::new(veach());
    for strategy in [Strategy::MisAll, Strategy::Mis] {
        let estimator = Estimator { strategy, light_prob: 0.3, ..Estimator::default() };
        let frame = render(&scene, &Settings { estimator, ..independent(16, 3, [96, 96]) });
        let mut emitting = 0;
        for ((sum, light), bsdf) in
            Layer::Picture.channels().iter().zip(Layer::Light.channels()).zip(Layer::Bsdf.channels())
        {
            let planes = [*sum, *light, *bsdf].map(|channel: Channel| frame.channel(channel));
            for ((&sum, &light), &bsdf) in planes[0].iter().zip(&planes[1]).zip(&planes[2]) {
                // A light seen directly is in the picture alone: far brighter than rounding.
                if sum - light - bsdf > 1e-3 * sum && light == 0.0 && bsdf == 0.0 {
                    emitting += 1;
                    continue;
                }
                // Each value is rounded once from sums in f64, and a pixel at a light's rim has some of its emission.
                let rounding = 2.0 * f32::EPSILON * sum;
                assert!(sum - light - bsdf >= -rounding, "{sum} is less than {light} + {bsdf}");
                emitting += usize::from(sum - light - bsdf > rounding);
            }
        }
        let values = 3 * 96 * 96;
        assert!(emitting > 0 && emitting < values / 20, "{emitting} of {values} values hold emission");
    }
}
