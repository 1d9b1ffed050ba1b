//! `mislab inspect`: what is exactly true of one pixel.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use mislab_renderer::inspect::{Accuracy, AtC, Inspector, LightSeen, Moments, Point, Seen, Table};
use mislab_renderer::kernel::world::BuiltScene;
use mislab_renderer::{Error, Estimator, Request, Scene, Strategy};
use serde::Serialize;

use super::args::InspectArgs;
use super::failure::Failure;
use super::output;
use super::render::place;

/// Steps of the curve over c.
const STEPS: u16 = 100;

pub(super) fn run(args: &InspectArgs) -> Result<(), Failure> {
    let (input, Request { scene, settings }, pixel) = place(&args.place, &args.numbers)?;
    let built = BuiltScene::new(&scene, &settings).map_err(Error::from)?;
    let [x, y] = pixel.map(|v| v as f32 + 0.5);
    let shows = |what: &str| {
        let [x, y] = pixel;
        Failure::Run(format!("{}: pixel {x} {y} shows {what}, expected a surface", input.source))
    };
    let point = match Inspector::new(&built, &settings).at_pixel(x, y) {
        Seen::Nothing => return Err(shows("nothing of the scene")),
        Seen::Light(_) => return Err(shows("a light itself, which reflects nothing")),
        Seen::Surface(point) => point,
    };
    let report = Report::new(&input.source, pixel, &scene, &settings.estimator, &point);
    output::report(args.numbers.json.as_ref(), &report, &report.text())
}

/// The object of `--json`. Its keys are an interface.
#[derive(Serialize)]
struct Report<'a> {
    scene: &'a str,
    pixel: [u32; 2],
    light_prob: f32,
    heuristic: &'static str,
    weights: &'static str,
    surface: Surface<'a>,
    /// Luminance of the reflected radiance.
    mean: f64,
    /// The same per channel.
    radiance: [f64; 3],
    strategies: BTreeMap<&'static str, OneSample>,
    one_sample: OneSampleModel,
    lights: Vec<Light<'a>>,
    /// Of all integrals, relative to themselves.
    tolerance: f64,
    /// Directions that were asked about.
    directions: usize,
}

#[derive(Serialize)]
struct Surface<'a> {
    shape: usize,
    /// Name of its material; null for the surface of a light.
    material: Option<&'a str>,
    /// GGX width; null without a specular lobe.
    alpha: Option<f32>,
    mirror: bool,
    position: [f32; 3],
    /// On the viewer's side.
    normal: [f32; 3],
    /// Towards the viewer.
    wo: [f32; 3],
    /// Radiance of its own.
    emitted: [f32; 3],
}

/// One sample of a strategy.
#[derive(Serialize)]
struct OneSample {
    mean: f64,
    variance: f64,
    second_moment: f64,
    rays: u32,
    /// Its mean is not the reflected radiance.
    biased: bool,
}

#[derive(Serialize)]
struct OneSampleModel {
    /// With the weights given; null where no light is reflected.
    best_c: Option<f32>,
    variance_at_best_c: Option<f64>,
    /// Second moments.
    curve: Vec<OnCurve>,
}

/// Null where the mean is another one.
#[derive(Serialize)]
struct OnCurve {
    c: f32,
    veach: Option<f64>,
    tutorial: Option<f64>,
}

/// A light, and the direction towards its middle.
#[derive(Serialize)]
struct Light<'a> {
    name: &'a str,
    p_light: f32,
    p_bsdf: f32,
    solid_angle: f64,
    /// Of the mean.
    share: f64,
    visible: bool,
}

/// A mean that is off by more than this share is another one's.
const SAME_MEAN: f64 = 1e-4;

impl<'a> Report<'a> {
    fn new(source: &'a str, pixel: [u32; 2], scene: &'a Scene, own: &Estimator, point: &Point<'_>) -> Self {
        let table = point.tabulate(&Accuracy::default());
        let radiance = table.radiance();
        let of = |strategy| table.moments(&Estimator { strategy, ..*own }).total;
        let truth = of(Strategy::Bsdf).mean;
        let strategies = Strategy::ALL.into_iter().map(|strategy| {
            let Moments { mean, variance, second, .. } = of(strategy);
            let biased = (mean - truth).abs() > SAME_MEAN * truth;
            let rays = strategy.rays_per_sample();
            (strategy.name(), OneSample { mean, variance, second_moment: second, rays, biased })
        });
        let shape = point.shape();
        let material = scene.shapes[shape].material.map(|material| scene.materials[material].name.as_str());
        Self {
            scene: source,
            pixel,
            light_prob: own.light_prob,
            heuristic: own.heuristic.name(),
            weights: own.weights.name(),
            surface: Surface {
                shape,
                material,
                alpha: point.alpha(),
                mirror: point.is_mirror(),
                position: point.position().to_array(),
                normal: point.normal().to_array(),
                wo: point.wo().to_array(),
                emitted: point.emitted().to_array(),
            },
            mean: truth,
            radiance: radiance.to_array(),
            strategies: strategies.collect(),
            one_sample: OneSampleModel::new(&table, own),
            lights: point.lights(&table).into_iter().map(|light| Light::new(scene, &light, truth)).collect(),
            tolerance: table.relative_error(),
            directions: table.evaluations(),
        }
    }

    /// For people.
    fn text(&self) -> String {
        let Self { scene, pixel: [x, y], surface, mean, strategies, one_sample, lights, .. } = self;
        let material = surface.material.unwrap_or("of a light");
        let lobe = match surface.alpha {
            Some(_) if surface.mirror => ", a mirror".to_owned(),
            Some(alpha) => format!(", alpha {alpha}"),
            None => String::new(),
        };
        let mut text =
            format!("{scene}, centre of pixel {x} {y}: material {material}{lobe}, shape {}\n", surface.shape);
        for (name, [x, y, z]) in
            [("position", surface.position), ("normal", surface.normal), ("to the eye", surface.wo)]
        {
            let _ = writeln!(text, "{name:<12}  {x:>12.5} {y:>12.5} {z:>12.5}");
        }
        if surface.emitted != [0.0; 3] {
            let [r, g, b] = surface.emitted;
            let _ = writeln!(text, "emits         {r:>12.5e} {g:>12.5e} {b:>12.5e}  W/(m^2 sr), not counted below");
        }
        let [r, g, b] = self.radiance;
        let _ = writeln!(
            text,
            "radiance      {r:>12.5e} {g:>12.5e} {b:>12.5e}  W/(m^2 sr), luminance {mean:.5e}\n\
             by quadrature over {} directions, tolerance {:.0e}",
            self.directions, self.tolerance
        );
        let Self { light_prob, heuristic, weights, .. } = self;
        let _ = writeln!(
            text,
            "\n{:<12}  {:>12} {:>12} {:>12}  rays   (c {light_prob}, heuristic {heuristic}, weights {weights})",
            "one sample", "mean", "std. dev.", "variance"
        );
        for strategy in Strategy::ALL {
            let Some(OneSample { mean, variance, rays, biased, .. }) = strategies.get(strategy.name()) else {
                continue;
            };
            let biased = if *biased { "   biased" } else { "" };
            let _ = writeln!(
                text,
                "{:<12}  {mean:>12.5e} {:>12.5e} {variance:>12.5e}  {rays:>4}{biased}",
                strategy.name(),
                variance.sqrt()
            );
        }
        if let (Some(c), Some(variance)) = (one_sample.best_c, one_sample.variance_at_best_c) {
            let _ = writeln!(text, "best c {c:.4}: std. dev. {:.5e}, variance {variance:.5e}", variance.sqrt());
        }
        let widest = lights.iter().map(|light| light.name.chars().count()).max().unwrap_or(0).max(12);
        let _ = writeln!(
            text,
            "\n{:<widest$}  {:>12} {:>12} {:>12}  share of the luminance",
            "light", "p_L (1/sr)", "p_B (1/sr)", "size (sr)"
        );
        for Light { name, p_light, p_bsdf, solid_angle, share, visible } in lights {
            let hidden = if *visible { "" } else { "   its middle is hidden" };
            let _ = writeln!(
                text,
                "{name:<widest$}  {p_light:>12.5e} {p_bsdf:>12.5e} {solid_angle:>12.5e}  {:>6.2} %{hidden}",
                100.0 * share
            );
        }
        text
    }
}

impl OneSampleModel {
    fn new(table: &Table, own: &Estimator) -> Self {
        let best = table.best_c(own.heuristic, own.weights);
        let cs: Vec<f32> = (0..=STEPS).map(|k| f32::from(k) / f32::from(STEPS)).collect();
        let curve = table.curve(own.heuristic, &cs);
        Self {
            best_c: best.map(|best| best.c),
            variance_at_best_c: best.map(|best| best.variance),
            curve: curve.into_iter().map(|AtC { c, veach, tutorial }| OnCurve { c, veach, tutorial }).collect(),
        }
    }
}

impl<'a> Light<'a> {
    fn new(scene: &'a Scene, seen: &LightSeen, mean: f64) -> Self {
        let LightSeen { shape, middle, solid_angle, luminance } = *seen;
        Self {
            name: scene.shapes[shape].light.as_ref().map_or("", |light| light.name.as_str()),
            p_light: middle.p_light,
            p_bsdf: middle.p_bsdf,
            solid_angle,
            share: if mean > 0.0 { luminance / mean } else { 0.0 },
            visible: middle.visible,
        }
    }
}
