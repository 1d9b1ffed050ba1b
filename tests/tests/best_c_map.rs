//! The map of the best c against fine quadrature, pixel by pixel.

use std::sync::atomic::{AtomicUsize, Ordering};

use mislab_kernel::world::BuiltScene;
use mislab_renderer::inspect::{Accuracy, BestMap, Inspector, Pixels, Seen, best_map};
use mislab_renderer::{Estimator, Heuristic, ImageSettings, OneSampleWeights, Scene, Settings, Strategy, pbrt};
use mislab_tests::experiment::{mesh_lights, veach};

fn settings(resolution: [u32; 2], heuristic: Heuristic, weights: OneSampleWeights) -> Settings {
    let estimator = Estimator { strategy: Strategy::Mis, heuristic, weights, light_prob: 0.3 };
    Settings { estimator, image: ImageSettings { resolution, ..ImageSettings::default() }, ..Settings::default() }
}

fn map_of(scene: &Scene, settings: &Settings, threads: usize) -> (BuiltScene, BestMap) {
    let built = BuiltScene::new(scene, settings).expect("the scene can be built");
    let map = best_map(&built, settings, threads, &|| true, &mut |_| {}).expect("nobody stops it");
    (built, map)
}

/// Exact best c, and variances at 1/2, at the best c and at `other`, of a pixel; `None` where no light is reflected.
fn exact(built: &BuiltScene, settings: &Settings, [x, y]: [u32; 2], other: f32) -> Option<(f32, [f64; 3], f64)> {
    let Seen::Surface(point) = Inspector::new(built, settings).at_pixel(x as f32 + 0.5, y as f32 + 0.5) else {
        return None;
    };
    let table = point.tabulate(&Accuracy { relative_error: 1e-3, evaluations: 50_000 });
    let best = table.best_c(settings.estimator.heuristic, settings.estimator.weights)?;
    let at = |light_prob| table.moments(&Estimator { strategy: Strategy::Mis, light_prob, ..settings.estimator }).total;
    Some((best.c, [at(0.5).variance, best.variance, at(other).variance], at(0.5).mean))
}

/// How far a map is from the truth.
#[derive(Default)]
struct Errors {
    c: Vec<f32>,
    /// Logarithms.
    loss: Vec<f64>,
    /// Logarithm of the variance at the map's c over the least.
    regret: Vec<f64>,
    dark: usize,
    /// Pixels that reflect light, though the map says they do not.
    missed: usize,
}

impl Errors {
    fn of(built: &BuiltScene, settings: &Settings, map: &BestMap, pixels: impl Iterator<Item = [u32; 2]>) -> Self {
        let mut errors = Self::default();
        for [x, y] in pixels {
            let at = (y * map.bounds.width() + x) as usize;
            let (c, loss) = (map.c[at], map.loss[at]);
            match exact(built, settings, [x, y], if c.is_nan() { 0.5 } else { c }) {
                None => {
                    assert!(c.is_nan() && loss.is_nan(), "({x}, {y}): {c}, {loss} where nothing is reflected");
                    errors.dark += 1;
                }
                // The last bit of a light beside a shadow.
                Some(_) if c.is_nan() && loss.is_nan() => errors.missed += 1,
                Some((best, [half, least, there], mean)) => {
                    assert!(
                        (0.0..=1.0).contains(&c) && (1.0..=BestMap::MOST).contains(&loss),
                        "({x}, {y}): {c}, {loss}"
                    );
                    errors.c.push((c - best).abs());
                    let expected = (half / least).min(f64::from(BestMap::MOST));
                    errors.loss.push((f64::from(loss).ln() - expected.ln()).abs());
                    // Where next to nothing varies, ratios are of rounding errors.
                    let floor = 1e-3 * mean * mean;
                    errors.regret.push(((there + floor) / (least + floor)).ln());
                }
            }
        }
        errors.c.sort_by(f32::total_cmp);
        errors.loss.sort_by(f64::total_cmp);
        errors.regret.sort_by(f64::total_cmp);
        errors
    }

    /// Errors that 50, 90, 99 of 100 pixels stay below, and the largest.
    fn quantiles(&self) -> [[f64; 4]; 3] {
        let of = |values: Vec<f64>| [0.5, 0.9, 0.99, 1.0].map(|q| values[((values.len() - 1) as f64 * q) as usize]);
        [of(self.c.iter().map(|&c| f64::from(c)).collect()), of(self.loss.clone()), of(self.regret.clone())]
    }
}

/// Every so many pixels of a picture, in no row.
fn every(step: u32, [width, height]: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
    (0..width * height).step_by(step as usize).map(move |k| [k % width, k / width])
}

#[test]
fn the_map_agrees_with_fine_quadrature() {
    let size = [160, 120];
    let settings = settings(size, Heuristic::Balance, OneSampleWeights::Veach);
    for (label, scene) in [
        ("default scene", veach()),
        ("plastic", pbrt::embedded_plastic_scene().scene),
        ("mesh lights", mesh_lights(glam::Vec3::splat(3.0))),
    ] {
        let (built, map) = map_of(&scene, &settings, 2);
        let errors = Errors::of(&built, &settings, &map, every(59, size));
        let [c, loss, regret] = errors.quantiles();
        let (lit, missed) = (errors.c.len(), errors.missed);
        println!(
            "{label}: {lit} pixels, {} dark, {missed} missed; c {c:.4?}, loss {loss:.4?}, regret {regret:.5?}",
            errors.dark
        );
        assert!(missed * 100 <= lit, "{label}: {missed} missed of {lit}");
        assert!(errors.c.len() > 250, "{label}: {} pixels", errors.c.len());
        assert!(c[2] <= 0.05 && loss[2] <= 0.1 && regret[2] <= 0.01, "{label}: {c:?} {loss:?} {regret:?}");
    }
}

#[test]
fn every_heuristic_and_both_weights_have_a_map() {
    let size = [48, 36];
    for heuristic in Heuristic::ALL {
        for weights in OneSampleWeights::ALL {
            let settings = settings(size, heuristic, weights);
            let (built, map) = map_of(&veach(), &settings, 2);
            let errors = Errors::of(&built, &settings, &map, every(17, size));
            let [c, loss, regret] = errors.quantiles();
            let label = format!("{} {}", heuristic.name(), weights.name());
            println!("{label}: {} pixels; c {c:.4?}, loss {loss:.4?}, regret {regret:.5?}", errors.c.len());
            assert!(c[1] <= 0.1 && loss[1] <= 0.1 && regret[1] <= 0.03, "{label}: {c:?} {loss:?} {regret:?}");
        }
    }
}

#[test]
fn it_grows_from_coarse_to_fine_and_can_be_given_up() {
    let size = [70, 41];
    let settings = settings(size, Heuristic::Balance, OneSampleWeights::Veach);
    let built = BuiltScene::new(&veach(), &settings).expect("the scene can be built");
    let mut seen = Vec::new();
    let map = best_map(&built, &settings, 1, &|| true, &mut |map| seen.push(map.clone())).expect("nobody stops it");
    assert_eq!(seen.iter().map(|map| map.step).collect::<Vec<_>>(), [8, 4, 2, 1]);
    let last = seen.last().expect("there are maps");
    let same = |a: &[f32], b: &[f32]| a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits());
    assert!(same(&last.c, &map.c) && same(&last.loss, &map.loss), "the last report is the map");
    for coarse in &seen {
        assert_eq!((coarse.c.len(), coarse.loss.len()), (70 * 41, 70 * 41));
        // Known pixels keep what they have; the ends of rows and columns are among them.
        for y in (0..41).step_by(8).chain([40]) {
            for x in (0..70).step_by(8).chain([69]) {
                let at = y * 70 + x;
                assert_eq!(coarse.c[at].to_bits(), map.c[at].to_bits(), "({x}, {y}) at step {}", coarse.step);
            }
        }
    }
    for threads in [2, 3, 0] {
        let other = best_map(&built, &settings, threads, &|| true, &mut |_| {}).expect("nobody stops it");
        assert!(same(&other.c, &map.c) && same(&other.loss, &map.loss), "{threads} threads");
    }
    // At any question.
    for most in [0, 1, 5, 20] {
        let asked = AtomicUsize::new(0);
        let goes_on = || asked.fetch_add(1, Ordering::Relaxed) < most;
        assert_eq!(best_map(&built, &settings, 2, &goes_on, &mut |_| {}), None, "stopped at {most}");
    }
}

#[test]
fn odd_sizes_and_parts_of_pictures_have_maps() {
    for (resolution, crop) in
        [([1, 1], [0.0, 1.0, 0.0, 1.0]), ([9, 1], [0.0, 1.0, 0.0, 1.0]), ([40, 30], [0.3, 0.62, 0.4, 0.95])]
    {
        let mut settings = settings(resolution, Heuristic::Balance, OneSampleWeights::Veach);
        settings.image.crop = crop;
        let (built, map) = map_of(&veach(), &settings, 2);
        let bounds = settings.pixel_bounds();
        assert_eq!((map.bounds, map.c.len()), (bounds, bounds.area()));
        for y in bounds.min[1]..bounds.max[1] {
            for x in bounds.min[0]..bounds.max[0] {
                let at = ((y - bounds.min[1]) * bounds.width() + x - bounds.min[0]) as usize;
                let lit = exact(&built, &settings, [x, y], 0.5).is_some();
                assert_eq!(lit, !map.c[at].is_nan(), "({x}, {y}) of {resolution:?}");
            }
        }
    }
}

#[test]
fn curves_of_many_pixels_are_those_of_fine_quadrature_on_average() {
    let size = [80, 60];
    let settings = settings(size, Heuristic::Power, OneSampleWeights::Veach);
    let built = BuiltScene::new(&veach(), &settings).expect("the scene can be built");
    let pixels: Vec<[u32; 2]> = every(23, size).collect();
    let cs = [0.1, 0.5, 0.8];
    let mut ask = Pixels { scene: &built, settings: &settings, threads: 2, goes_on: &|| true };
    let found = ask.curves(&pixels, Heuristic::Power, &cs).expect("nobody stops it");
    assert!(found.len() > 100 && found.len() < pixels.len(), "{} of {}", found.len(), pixels.len());
    let mut off = [0.0; 3];
    for curve in &found {
        let [x, y] = curve.pixel.map(|v| v as f32 + 0.5);
        let Seen::Surface(point) = Inspector::new(&built, &settings).at_pixel(x, y) else { panic!("a surface") };
        let exact =
            point.tabulate(&Accuracy { relative_error: 1e-3, evaluations: 50_000 }).curve(Heuristic::Power, &cs);
        for ((off, found), exact) in off.iter_mut().zip(&curve.at).zip(exact) {
            assert!(found.tutorial.is_some() && exact.tutorial.is_some());
            *off += (found.veach.expect("unbiased") / exact.veach.expect("unbiased")).ln() / pixels.len() as f64;
        }
    }
    assert!(off.iter().all(|off| off.abs() < 0.02), "{off:?}");
    ask.goes_on = &|| false;
    assert_eq!(ask.curves(&pixels, Heuristic::Power, &cs), None);
}
