//! `mislab replay`: one sample of one pixel, with all its numbers.

use std::fmt::Write as _;

use mislab_renderer::inspect::{Drawn, Ray, Replayed, Weighted, replay, weighted};
use mislab_renderer::kernel::lanes::Lanewise;
use mislab_renderer::kernel::world::BuiltScene;
use mislab_renderer::{Error, Request, Settings, Strategy, Technique};
use serde::Serialize;

use super::args::ReplayArgs;
use super::failure::Failure;
use super::output::{self, technique_name};
use super::render::place;

pub(super) fn run(args: &ReplayArgs) -> Result<(), Failure> {
    let (input, Request { scene, settings }, pixel) = place(&args.place, &args.numbers)?;
    if let Some(spp) = settings.sampling.target().filter(|spp| args.index >= *spp) {
        let (index, last) = (args.index, spp - 1);
        return Err(Failure::Usage(format!("--index {index}: not in the picture, expected a number from 0 to {last}")));
    }
    let built = BuiltScene::new(&scene, &settings).map_err(Error::from)?;
    let sample = replay(Lanewise::best(), &built, &settings, pixel, args.index);
    let report = Report::new(&input.source, pixel, args.index, &settings, &sample);
    output::report(args.numbers.json.as_ref(), &report, &report.text())
}

/// The object of `--json`. Its keys are an interface.
#[derive(Serialize)]
struct Report<'a> {
    scene: &'a str,
    pixel: [u32; 2],
    index: u32,
    spp: Option<u32>,
    strategy: &'static str,
    heuristic: &'static str,
    weights: &'static str,
    light_prob: f32,
    seed: u32,
    /// Number of the shape whose surface the camera ray hits; null if it hits none that reflects.
    shape: Option<usize>,
    /// Of everything: what the picture's variance is made of.
    luminance: f32,
    /// Radiance of a light that the camera ray hits.
    emitted: [f32; 3],
    /// The ray that adds more.
    #[serde(flatten)]
    ray: OneRay,
    /// All of them: one, none where nothing reflects, two with `mis_all`.
    rays: Vec<OneRay>,
    random: Random,
}

/// A secondary ray. All null without one.
#[derive(Clone, Serialize)]
struct OneRay {
    technique: Option<&'static str>,
    /// Unit vector away from the surface.
    wi: Option<[f32; 3]>,
    f: Option<[f32; 3]>,
    /// Per solid angle.
    p_light: Option<f32>,
    /// Per solid angle; of a mirror's direction a probability.
    p_bsdf: Option<f32>,
    weight: Option<f32>,
    /// What the picture adds up.
    value: Option<[f32; 3]>,
    /// Drawn from a mirror's Dirac delta.
    dirac: Option<bool>,
    /// False where the light chosen turns its back.
    valid: Option<bool>,
    /// It hits a light.
    lit: Option<bool>,
    /// The same direction drawn by the other technique: its weight and what it would add.
    other_weight: Option<f32>,
    other_value: Option<[f32; 3]>,
}

/// Null for what was not asked.
#[derive(Serialize)]
struct Random {
    pixel: [f32; 2],
    technique: Option<f32>,
    light_choice: Option<f32>,
    light: Option<[f32; 2]>,
    lobe: Option<f32>,
    bsdf: Option<[f32; 2]>,
}

impl OneRay {
    const NONE: Self = Self {
        technique: None,
        wi: None,
        f: None,
        p_light: None,
        p_bsdf: None,
        weight: None,
        value: None,
        dirac: None,
        valid: None,
        lit: None,
        other_weight: None,
        other_value: None,
    };

    fn new(ray: &Ray, settings: &Settings) -> Self {
        let Ray { technique, valid, wi, dirac, f, p_light, p_bsdf, weight, value, lit } = *ray;
        let [by_light, by_bsdf] = weighted(f, [p_light, p_bsdf], &settings.estimator);
        let other: Weighted = match technique {
            Technique::Light => by_bsdf,
            Technique::Bsdf => by_light,
        };
        Self {
            technique: Some(technique_name(technique)),
            wi: Some(wi.to_array()),
            f: Some(f.to_array()),
            p_light: Some(p_light),
            p_bsdf: Some(p_bsdf),
            weight: Some(weight),
            value: Some(value.to_array()),
            dirac: Some(dirac),
            valid: Some(valid),
            lit: Some(lit),
            other_weight: Some(other.weight),
            other_value: Some(other.value.to_array()),
        }
    }
}

impl<'a> Report<'a> {
    fn new(source: &'a str, pixel: [u32; 2], index: u32, settings: &Settings, sample: &Replayed) -> Self {
        let Settings { estimator, sampling, .. } = settings;
        let Replayed { drawn, emitted, emits: _, shape, rays, luminance } = sample;
        let Drawn { pixel: position, technique, light_choice, light, lobe, bsdf } = *drawn;
        let rays: Vec<OneRay> = rays.iter().map(|ray| OneRay::new(ray, settings)).collect();
        let brightness = |ray: &OneRay| ray.value.map_or(0.0, |value| value.iter().sum::<f32>());
        // Of two alike the first.
        let brightest = rays.iter().rev().max_by(|a, b| brightness(a).total_cmp(&brightness(b)));
        Self {
            scene: source,
            pixel,
            index,
            spp: sampling.target(),
            strategy: estimator.strategy.name(),
            heuristic: estimator.heuristic.name(),
            weights: estimator.weights.name(),
            light_prob: estimator.light_prob,
            seed: sampling.seed,
            shape: *shape,
            luminance: *luminance,
            emitted: emitted.to_array(),
            ray: brightest.cloned().unwrap_or(OneRay::NONE),
            rays,
            random: Random { pixel: position, technique, light_choice, light, lobe, bsdf },
        }
    }

    /// For people.
    fn text(&self) -> String {
        let Self { scene, pixel: [x, y], index, spp, strategy, heuristic, weights, light_prob, seed, .. } = self;
        let of = spp.map_or_else(String::new, |spp| format!(" of {spp}"));
        let mut text = format!("{scene}, pixel {x} {y}, sample {index}{of}, seed {seed}: strategy {strategy}");
        let c = format!(", c {light_prob}, weights {weights}");
        let _ = match Strategy::from_name(strategy) {
            Some(Strategy::Mis) => writeln!(text, ", heuristic {heuristic}{c}"),
            Some(Strategy::MisAll) => writeln!(text, ", heuristic {heuristic}"),
            Some(Strategy::Light | Strategy::Bsdf) | None => writeln!(text),
        };
        let [jx, jy] = self.random.pixel;
        let _ = writeln!(text, "in the pixel  {jx:>12.9} {jy:>12.9}");
        if self.emitted != [0.0; 3] {
            let _ = writeln!(text, "a light seen  {}  emits", numbers(&self.emitted));
        }
        if self.rays.is_empty() {
            text.push_str("no ray        nothing that reflects is seen\n");
        }
        for ray in &self.rays {
            self.ray_text(ray, &mut text);
        }
        let _ = writeln!(text, "\nluminance     {:>12.5e}  of the whole sample", self.luminance);
        text
    }

    fn ray_text(&self, ray: &OneRay, text: &mut String) {
        let technique = ray.technique.unwrap_or_default();
        let Random { technique: number, light_choice, light, lobe, bsdf, pixel: _ } = &self.random;
        let by_light = technique == technique_name(Technique::Light);
        let why = match number {
            Some(u) if by_light => format!("{u:.9} is less than c = {}", self.light_prob),
            Some(u) => format!("{u:.9} is not less than c = {}", self.light_prob),
            None => "as this strategy always does".to_owned(),
        };
        let _ = writeln!(text, "\ntechnique     {technique}: {why}");
        let (choice, direction) =
            if by_light { (("which light", light_choice), light) } else { (("which lobe", lobe), bsdf) };
        if let (name, Some(u)) = choice {
            let _ = writeln!(text, "{name:<12}  {u:>12.9}");
        }
        if let Some(u) = direction {
            let _ = writeln!(text, "direction     {:>12.9} {:>12.9}", u[0], u[1]);
        }
        if ray.valid == Some(false) {
            text.push_str("failed        the light chosen turns its back\n");
            return;
        }
        let triple = |v: Option<[f32; 3]>| v.map_or_else(String::new, |v| numbers(&v));
        let single = |v: Option<f32>| v.map_or_else(String::new, |v| format!("{v:>12.5e}"));
        let formula = match Strategy::from_name(self.strategy) {
            Some(Strategy::Mis) => "W/(m^2 sr), w f / (c p)",
            Some(Strategy::MisAll) => "W/(m^2 sr), w f / p",
            Some(Strategy::Light | Strategy::Bsdf) | None => "W/(m^2 sr), f / p",
        };
        let lit = ray.lit == Some(true);
        let bsdf_unit = if ray.dirac == Some(true) { "a mirror's probability" } else { "1/sr" };
        for (name, value, unit) in [
            ("wi", triple(ray.wi), ""),
            ("f", triple(ray.f), if lit { "W/(m^2 sr^2)" } else { "hits no light" }),
            ("p_L", single(ray.p_light), "1/sr"),
            ("p_B", single(ray.p_bsdf), bsdf_unit),
        ] {
            let _ = writeln!(text, "{}", format!("{name:<12}  {value}  {unit}").trim_end());
        }
        if !lit {
            return;
        }
        let _ = writeln!(text, "weight w      {}\nvalue         {}  {formula}", single(ray.weight), triple(ray.value));
        let other = if by_light { "by BSDF" } else { "by light" };
        let _ =
            writeln!(text, "{other:<12}  {}  with weight {}", triple(ray.other_value), single(ray.other_weight).trim());
    }
}

/// Three numbers in columns.
fn numbers(v: &[f32; 3]) -> String {
    v.map(|v| format!("{v:>12.5e}")).join(" ")
}
