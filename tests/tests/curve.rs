//! The curve over c, its lowest point and the lights of a point, against the oracle.

use glam::{DVec3, Vec3};
use mislab_renderer::inspect::{Accuracy, weighted};
use mislab_renderer::{Estimator, Geometry, Heuristic, OneSampleWeights, Scene, Settings, Strategy};
use mislab_tests::experiment::veach;
use mislab_tests::oracle::{self, LUMINANCE, World};
use mislab_tests::pair::in_parallel;
use mislab_tests::places::{EYE, of_one_sample, places, through_keyhole, variants};

/// Largest relative difference to the oracle.
const CLOSE: f64 = 1e-4;

fn one_sample(weights: OneSampleWeights, c: f64) -> Settings {
    let (strategy, heuristic) = (Strategy::Mis, Heuristic::Balance);
    of_one_sample(Estimator { strategy, heuristic, weights, light_prob: c as f32 })
}

/// Where a function on [0, 1] that falls and then rises is least.
fn golden_section(value: impl Fn(f64) -> f64) -> f64 {
    let ratio = (5.0f64.sqrt() - 1.0) / 2.0;
    let (mut a, mut b) = (0.0, 1.0);
    while b - a > 1e-5 {
        let (x, y) = (b - ratio * (b - a), a + ratio * (b - a));
        if value(x) < value(y) { b = y } else { a = x }
    }
    0.5 * (a + b)
}

#[test]
fn the_best_c_is_where_a_golden_section_search_on_the_oracle_finds_it() {
    let all: Vec<_> = places(&veach()).into_iter().step_by(2).collect();
    let found = in_parallel(all.len(), |i| {
        let (mut sharp, mut inside) = (0, 0);
        let (label, scene, target) = &all[i];
        let point = World::new(scene).point(EYE, *target);
        let truth = point.radiance().dot(LUMINANCE);
        let table = through_keyhole(scene, *target, |point| point.tabulate(&Accuracy::default()));
        for weights in OneSampleWeights::ALL {
            let variance = |c: f64| point.sample(&one_sample(weights, c), LUMINANCE).total.variance();
            // The tutorial's weights are biased at the ends themselves.
            let expected = golden_section(|c| variance(c.clamp(1e-6, 1.0 - 1e-6)));
            let label = format!("{label}, {}", weights.name());
            let Some(best) = table.best_c(Heuristic::Balance, weights) else {
                assert_eq!(truth, 0.0, "{label}: there is light");
                continue;
            };
            let c = f64::from(best.c);
            let least = variance(expected.clamp(1e-6, 1.0 - 1e-6));
            let there = variance(c);
            let slack = CLOSE * least + 1e-6 * truth * truth;
            assert!(there <= least + slack, "{label}: {best:?} has {there}, {least} at {expected}");
            assert!((best.variance - there).abs() <= slack, "{label}: {best:?}, {there} by the oracle");
            // Where the curve is so flat that the oracle's own error moves its lowest point, c says little.
            let step = 0.01;
            let rises = [expected - step, expected + step].into_iter().filter(|c| (0.0..=1.0).contains(c));
            if rises.map(variance).all(|beside| beside > least + 4.0 * slack) {
                sharp += 1;
                assert!((c - expected).abs() <= step, "{label}: {c}, by the oracle {expected}");
            }
            inside += usize::from(c > 0.02 && c < 0.98);
        }
        [sharp, inside]
    });
    let [sharp, inside] = [0, 1].map(|k| found.iter().map(|found| found[k]).sum::<usize>());
    println!("{sharp} sharp, {inside} inside");
    assert!(sharp >= 20 && inside >= 15, "{sharp} sharp, {inside} inside");
}

#[test]
fn the_curve_has_the_second_moments_of_the_oracle() {
    let cs = [0.0f32, 0.01, 0.1, 0.5, 0.9, 0.99, 1.0];
    let (mut compared, mut biased) = (0, 0);
    for (label, scene, target) in places(&veach()).into_iter().step_by(3) {
        let point = World::new(&scene).point(EYE, target);
        let truth = point.radiance().dot(LUMINANCE);
        let table = through_keyhole(&scene, target, |point| point.tabulate(&Accuracy::default()));
        for at in table.curve(Heuristic::Balance, &cs) {
            for (weights, found) in [(OneSampleWeights::Veach, at.veach), (OneSampleWeights::Tutorial, at.tutorial)] {
                let label = format!("{label}, {} c = {}", weights.name(), at.c);
                let moments = point.sample(&one_sample(weights, f64::from(at.c)), LUMINANCE).total;
                let bias = (moments.mean() - truth).abs() / truth;
                if bias > 1e-4 || truth == 0.0 {
                    biased += 1;
                    assert_eq!(found, None, "{label}: biased by {bias}");
                }
                // What is between may be either.
                if bias.is_nan() || bias > 1e-6 {
                    continue;
                }
                compared += 1;
                let found = found.unwrap_or_else(|| panic!("{label}: not biased"));
                let expected = moments.variance() + moments.mean().powi(2);
                // Of the narrowest lobes see `inspect.rs`.
                assert!((found - expected).abs() <= 2.0 * CLOSE * expected, "{label}: {found}, expected {expected}");
            }
        }
    }
    println!("{compared} compared, {biased} biased");
    assert!(compared > 120 && biased > 20, "{compared} compared, {biased} biased");
}

#[test]
fn the_best_c_of_every_heuristic_is_the_lowest_point_of_its_curve() {
    let cs: Vec<f32> = (0..=200).map(|i| i as f32 / 200.0).collect();
    let mut compared = 0;
    for (label, scene, target) in places(&veach()).into_iter().step_by(4) {
        let table = through_keyhole(&scene, target, |point| point.tabulate(&Accuracy::default()));
        for heuristic in Heuristic::ALL {
            let Some(best) = table.best_c(heuristic, OneSampleWeights::Veach) else { continue };
            let seconds = |cs: &[f32]| table.curve(heuristic, cs).into_iter().filter_map(|at| at.veach);
            let lowest = seconds(&cs).fold(f64::INFINITY, f64::min);
            let there = seconds(&[best.c]).fold(f64::INFINITY, f64::min);
            assert!(there <= 1.001 * lowest, "{label}, {}: {best:?} has {there}, {lowest}", heuristic.name());
            compared += 1;
        }
    }
    assert!(compared > 20, "{compared} compared");
}

#[test]
fn lights_have_their_solid_angles_densities_and_shares() {
    let mut all = places(&veach());
    all.extend(variants());
    let (mut lights, mut turned) = (0, 0);
    let some = all.into_iter().enumerate().filter(|(i, (label, ..))| i % 4 == 0 || label.starts_with("mesh"));
    for (label, scene, target) in some.map(|(_, place)| place) {
        let world = World::new(&scene);
        let whole = world.point(EYE, target).radiance().dot(LUMINANCE);
        through_keyhole(&scene, target, |point| {
            let table = point.tabulate(&Accuracy::default());
            let seen = point.lights(&table);
            let on = |shape: &usize| scene.shapes[*shape].light.as_ref().is_some_and(|light| light.on);
            assert_eq!(
                seen.iter().map(|light| light.shape).collect::<Vec<_>>(),
                scene.light_shapes().filter(on).collect::<Vec<_>>(),
                "{label}"
            );
            let sum: f64 = seen.iter().map(|light| light.luminance).sum();
            assert!((sum - whole).abs() <= 2.0 * CLOSE * whole, "{label}: {sum}, expected {whole}");
            for light in &seen {
                let label = format!("{label}, shape {}", light.shape);
                lights += 1;
                // With the others off, which still cast their shadows.
                let mut alone = scene.clone();
                for other in scene.light_shapes().filter(|other| *other != light.shape) {
                    if let Some(other) = &mut alone.shapes[other].light {
                        other.on = false;
                    }
                }
                let expected = World::new(&alone).point(EYE, target).radiance().dot(LUMINANCE);
                let allowed = 2.0 * CLOSE * expected + 1e-5 * whole;
                assert!((light.luminance - expected).abs() <= allowed, "{label}: {light:?}, expected {expected}");
                let p = point.position().as_dvec3();
                let w = light.middle.wi.as_dvec3().normalize();
                let p_light = world.p_light(p, w);
                assert!(
                    (f64::from(light.middle.p_light) - p_light).abs() <= 1e-4 * p_light,
                    "{label}: {light:?}, expected {p_light}"
                );
                let solid_angle = solid_angle(&scene, light.shape, p);
                turned += usize::from(solid_angle == 0.0);
                assert!(
                    (light.solid_angle - solid_angle).abs() <= 1e-4 * solid_angle,
                    "{label}: {light:?}, expected {solid_angle}"
                );
            }
        });
    }
    println!("{lights} lights, {turned} turned away");
    assert!(lights > 50 && turned > 0, "{lights} lights, {turned} turned away");
}

/// By a grid over triangles, and the formula for spheres; 0 from behind.
fn solid_angle(scene: &Scene, shape: usize, p: DVec3) -> f64 {
    match &scene.shapes[shape].geometry {
        Geometry::Sphere { center, radius } => {
            let sin = f64::from(*radius) / center.as_dvec3().distance(p);
            std::f64::consts::TAU * (1.0 - (1.0 - sin * sin).sqrt())
        }
        Geometry::Mesh { positions, triangles } => {
            const GRID: usize = 400;
            let mut sum = 0.0;
            for triangle in triangles.iter() {
                let [a, b, c] = triangle.map(|i| positions[i as usize].as_dvec3());
                let normal = (b - a).cross(c - a);
                let sign = if scene.shapes[shape].reverse_orientation { -1.0 } else { 1.0 };
                for k in 0..GRID * GRID {
                    let [u, v] = [k / GRID, k % GRID].map(|i| (i as f64 + 0.5) / GRID as f64);
                    let to = a + (b - a) * u + (c - a) * (v * (1.0 - u)) - p;
                    let facing = -sign * normal.dot(to.normalize());
                    sum += facing.max(0.0) * (1.0 - u) / to.length_squared() / (GRID * GRID) as f64;
                }
            }
            sum
        }
    }
}

#[test]
fn a_direction_can_be_weighted_as_another_estimator_would() {
    let f = Vec3::new(1.0, 2.0, 3.0);
    for (l, b) in [(3.0f32, 7.0f32), (0.0, 2.0), (5.0, 1e-3)] {
        for heuristic in Heuristic::ALL {
            let estimator = Estimator { strategy: Strategy::MisAll, heuristic, ..Estimator::default() };
            let [light, bsdf] = weighted(f, [l, b], &estimator);
            let expected = oracle::heuristic(heuristic, f64::from(l), f64::from(b));
            for (found, weight, p) in [(light, expected.0, l), (bsdf, expected.1, b)] {
                let value = if p > 0.0 { f.as_dvec3() * (weight / f64::from(p)) } else { DVec3::ZERO };
                let label = format!("{heuristic:?} {l} {b}: {found:?}, expected {weight} and {value}");
                assert!((f64::from(found.weight) - weight).abs() < 1e-6, "{label}");
                assert!((found.value.as_dvec3() - value).length() <= 1e-5 * value.length(), "{label}");
            }
        }
    }
}
