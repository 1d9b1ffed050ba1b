//! The plane of light sizes and roughnesses against the oracle.

use mislab_renderer::plane::{NO_DIFFERENCE, Square, best_of};
use mislab_renderer::{Estimator, Heuristic, Settings, Strategy};
use mislab_tests::experiment::{independent, veach};
use mislab_tests::oracle::{LUMINANCE, Point, World};
use mislab_tests::places::EYE;

/// Largest relative deviation of a variance: what the plane's quadrature leaves, far below the 10 % that its colours tell apart.
const CLOSE: f64 = 5e-3;

/// The oracle's point of a square, of that roughness and light.
fn point(square: &Square, alpha: f32, radius: f32) -> Point {
    let original = veach();
    let mut scene = original.clone();
    *scene.material_mut(square.plate()).and_then(|m| m.bsdf.alpha_mut()).expect("a plate") = alpha;
    let light = scene
        .light_shapes()
        .find(|&shape| scene.shapes[shape].light.as_ref().is_some_and(|light| light.name == square.light()));
    scene.set_light_radius(&original, light.expect("the light exists"), radius);
    World::new(&scene).point(EYE, square.point())
}

/// Its variance of one ray over the square of the mean.
fn expected(point: &Point, estimator: Estimator) -> f64 {
    let settings = Settings { estimator, ..independent(1, 1, [8, 8]) };
    let moments = point.sample(&settings, LUMINANCE).total;
    let rays = f64::from(estimator.strategy.rays_per_sample());
    rays * moments.variance() / (moments.mean() * moments.mean())
}

#[test]
fn variances_are_the_oracles() {
    let squares = Square::all(&veach());
    assert_eq!(squares.len(), 16, "four plates times four lights");
    let own = Estimator { light_prob: 0.3, heuristic: Heuristic::Power, ..Estimator::default() };
    for (index, alpha, radius) in [(4, 0.02, 0.1), (7, 0.004, 1.2), (10, 0.2, 0.3), (13, 0.5, 0.05)] {
        let square = &squares[index];
        let found = square.variances(alpha, radius, &own).expect("light arrives");
        let point = point(square, alpha, radius);
        for (strategy, found) in Strategy::ALL.into_iter().zip(found.per_ray) {
            let expected = expected(&point, Estimator { strategy, ..own });
            let found = found.expect("nothing is biased");
            let name =
                format!("{} x {}, alpha {alpha}, r {radius}: {}", square.plate(), square.light(), strategy.name());
            assert!((found / expected - 1.0).abs() < CLOSE, "{name}: {found}, expected {expected}");
        }
    }
}

#[test]
fn a_mirror_is_not_for_light_samples() {
    let squares = Square::all(&veach());
    let found = squares[0].variances(0.0, 0.3, &Estimator::default()).expect("light arrives");
    assert_eq!(found.per_ray[0], None, "a light sample never meets a mirror's direction");
    assert!(found.per_ray[1].is_some() && found.per_ray[2].is_some());
}

#[test]
fn small_and_rough_is_for_light_samples_large_and_smooth_for_the_bsdf() {
    let square = &Square::all(&veach())[5];
    let best = |alpha, radius| square.variances(alpha, radius, &Estimator::default()).and_then(|v| v.best());
    let (rough, margin) = best(0.3, 0.02).expect("light arrives");
    assert_eq!(rough, Strategy::Light);
    assert!(margin > NO_DIFFERENCE, "{margin}");
    let (smooth, margin) = best(0.005, 1.2).expect("light arrives");
    assert_eq!(smooth, Strategy::Bsdf);
    assert!(margin > NO_DIFFERENCE, "{margin}");
    assert_eq!(best_of([None, Some(2.0), Some(1.0), None]), Some((Strategy::MisAll, 2.0)));
    assert_eq!(best_of([None; 4]), None);
}
