//! The page: each single contribution is `w f / (n p)` or `w f / (c p)`, with f, both densities and the weights of the
//! oracle.

use glam::{DVec3, Vec3};
use mislab_kernel::bsdf;
use mislab_kernel::estimator::{Contribution, Reflected};
use mislab_kernel::lanes::{Single, V3};
use mislab_kernel::sampler::{Dimension, Numbers};
use mislab_kernel::world::{BuiltScene, View};
use mislab_renderer::{Bsdf, Estimator, Heuristic, OneSampleWeights, Reflectance, Scene, Settings, Strategy};
use mislab_tests::draws::Draws;
use mislab_tests::experiment::{independent, mesh_lights, veach};
use mislab_tests::lobes::Lobes;
use mislab_tests::oracle::{World, heuristic};

use crate::once::{self, d};

/// Side of the pictures, in pixels.
pub const SIDE: u32 = 24;

/// The default scene, plastic under coloured lights, and rectangles and a triangle as lights, with a metal and mirrors.
pub fn scenes() -> Vec<(&'static str, Scene)> {
    let mut plastic = mislab_renderer::pbrt::embedded_plastic_scene().scene;
    let colours = [Vec3::X, Vec3::ONE, Vec3::new(0.1, 1.5, 0.3), Vec3::new(0.0, 0.0, 1.0)];
    for (i, shape) in plastic.light_shapes().collect::<Vec<_>>().into_iter().enumerate() {
        if let Some(light) = &mut plastic.shapes[shape].light {
            light.radiance *= colours[i % 4];
        }
    }
    let mut coated = plastic.clone();
    for material in &mut coated.materials {
        if let Some(alpha) = material.bsdf.alpha_mut() {
            *alpha = 0.0;
        }
    }
    let mut mesh = mesh_lights(Vec3::new(3.0, 2.0, 1.0));
    if let Some(material) = mesh.material_mut("plate4") {
        let reflectance = Reflectance::Fresnel { eta: Vec3::new(0.14, 0.37, 1.44), k: Vec3::new(3.98, 2.39, 1.6) };
        material.bsdf = Bsdf::Conductor { reflectance, alpha: 0.2 };
    }
    let mut dark = veach();
    for shape in &mut dark.shapes {
        shape.light = None;
    }
    vec![("veach", veach()), ("plastic", plastic), ("coated", coated), ("mesh lights", mesh), ("no lights", dark)]
}

/// Every strategy with every heuristic and kind of weights, and with c at both ends.
pub fn all_settings() -> Vec<Settings> {
    let base = independent(1, 3, [SIDE, SIDE]);
    let mut all = Vec::new();
    for strategy in Strategy::ALL {
        for heuristic in Heuristic::ALL {
            for weights in OneSampleWeights::ALL {
                for light_prob in [0.0, 0.3, 0.5, 1.0] {
                    let once = strategy == Strategy::Mis || weights == OneSampleWeights::Veach && light_prob == 0.3;
                    let weighted = matches!(strategy, Strategy::Mis | Strategy::MisAll);
                    if once && (weighted || heuristic == Heuristic::Balance) {
                        all.push(Settings {
                            estimator: Estimator { strategy, heuristic, weights, light_prob },
                            ..base.clone()
                        });
                    }
                }
            }
        }
    }
    all
}

/// What the oracle says about one direction.
#[derive(Clone, Copy, Debug)]
struct Direction {
    f: DVec3,
    p_light: f64,
    p_bsdf: f64,
}

/// A point, its normal towards the viewer, and the viewer.
struct Place<'a> {
    world: &'a World,
    lobes: &'a Lobes,
    p: DVec3,
    n: DVec3,
    wo: DVec3,
}

impl Place<'_> {
    /// The smooth part at one direction; `None` within rounding of an edge: of a light, a shadow, or the surface.
    fn smooth(&self, wi: DVec3) -> Option<Direction> {
        let above = self.p + self.n * 3e-5;
        let at = |wi: DVec3| {
            let (_, radiance) = self.world.look(above, wi);
            (radiance, self.world.p_light(self.p, wi))
        };
        let (radiance, p_light) = at(wi);
        if self.n.dot(wi).abs() < 1e-4 {
            return None;
        }
        let (t, b) = wi.any_orthonormal_pair();
        for (x, y) in [(1.0, 0.0), (-0.5, 0.866), (-0.5, -0.866)] {
            let (near, p) = at((wi + (t * x + b * y) * 4e-6).normalize());
            if near != radiance || (p - p_light).abs() > 1e-3 * p_light {
                return None;
            }
        }
        let (f_cos, p_bsdf) = self.lobes.evaluate(self.n, self.wo, wi);
        Some(Direction { f: f_cos * radiance, p_light, p_bsdf })
    }

    /// The mirror's one direction, with a probability in place of a density.
    fn mirrored(&self) -> Option<Direction> {
        let cos = self.n.dot(self.wo);
        let wi = self.n * (2.0 * cos) - self.wo;
        // Not at an edge.
        self.smooth(wi)?;
        let (_, radiance) = self.world.look(self.p + self.n * 3e-5, wi);
        Some(Direction { f: self.lobes.mirror(cos) * radiance, p_light: 0.0, p_bsdf: self.lobes.specular_prob() })
    }
}

/// One technique's contribution and weight.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    value: DVec3,
    weight: f64,
    /// The technique was drawn and met a light; the weight may still be 0.
    carries: bool,
}

const NOTHING: Part = Part { value: DVec3::ZERO, weight: 0.0, carries: false };

/// `w f / (c p)` by one technique, the first of the pairs being its own.
fn part(settings: &Settings, by_light: bool, x: &Direction) -> Part {
    let c = f64::from(settings.estimator.light_prob);
    let (c_light, c_bsdf) = if settings.estimator.strategy == Strategy::Mis { (c, 1.0 - c) } else { (1.0, 1.0) };
    let (q_light, q_bsdf) = match settings.estimator.weights {
        OneSampleWeights::Veach => (c_light * x.p_light, c_bsdf * x.p_bsdf),
        OneSampleWeights::Tutorial => (x.p_light, x.p_bsdf),
    };
    let (c, p) = if by_light { (c_light, x.p_light) } else { (c_bsdf, x.p_bsdf) };
    if x.f == DVec3::ZERO || p == 0.0 {
        return NOTHING;
    }
    let weights = heuristic(settings.estimator.heuristic, q_light, q_bsdf);
    let weight = match settings.estimator.strategy {
        Strategy::Light | Strategy::Bsdf => 1.0,
        Strategy::MisAll | Strategy::Mis if by_light => weights.0,
        Strategy::MisAll | Strategy::Mis => weights.1,
    };
    Part { value: x.f * (weight / (c * p)), weight, carries: true }
}

/// Heuristics that jump are not asked within rounding of a jump.
fn near_a_jump(settings: &Settings, x: &Direction) -> bool {
    let c = f64::from(settings.estimator.light_prob);
    let (c_light, c_bsdf) = match (settings.estimator.strategy, settings.estimator.weights) {
        (Strategy::Mis, OneSampleWeights::Veach) => (c, 1.0 - c),
        _ => (1.0, 1.0),
    };
    let ratio = c_light * x.p_light / (c_bsdf * x.p_bsdf);
    [0.1, 1.0, 10.0].iter().any(|jump| (ratio / jump - 1.0).abs() < 3e-3)
}

fn assert_part(found: &Contribution<Single>, expected: Part, what: impl Fn() -> String) {
    let Part { value, weight, carries } = expected;
    let off = (d(found.value) - value).abs();
    let near = off.x <= 2e-3 * value.x && off.y <= 2e-3 * value.y && off.z <= 2e-3 * value.z;
    let right = near && (f64::from(found.weight) - weight).abs() < 1e-3 && found.lit == carries;
    assert!(
        right,
        "{}: {} with weight {}, carries {}; expected {expected:?}",
        what(),
        d(found.value),
        found.weight,
        found.lit
    );
}

/// What was compared.
#[derive(Debug, Default)]
struct Tally {
    carried: [usize; 2],
    nothing: usize,
    shadowed: usize,
    mirrored: usize,
    skipped: usize,
}

#[expect(clippy::too_many_arguments, reason = "what the estimator itself is asked, and the oracle")]
fn check(
    scene: &BuiltScene,
    settings: &Settings,
    surface: &bsdf::Surface<'_, Single>,
    wo: V3<Single>,
    random: &Numbers<Single>,
    place: &Place<'_>,
    found: &Reflected<Single>,
    tally: &mut Tally,
    what: &dyn Fn() -> String,
) {
    let chosen = match settings.estimator.strategy {
        Strategy::Light => [true, false],
        Strategy::Bsdf => [false, true],
        Strategy::MisAll => [true, true],
        Strategy::Mis => {
            let light = random.get_1d(Dimension::Technique) < settings.estimator.light_prob;
            [light, !light]
        }
    };
    for (by_light, drawn, found) in [(true, chosen[0], &found.light), (false, chosen[1], &found.bsdf)] {
        let technique = || format!("{}, {} technique", what(), if by_light { "light" } else { "BSDF" });
        if !drawn {
            assert_part(found, NOTHING, || format!("{}, not drawn", technique()));
            continue;
        }
        let direction = if by_light {
            let (wi, valid) = once::sample_light(&scene.lights, surface.p, random);
            if !valid {
                assert_part(found, NOTHING, || format!("{}, failed", technique()));
                tally.nothing += 1;
                continue;
            }
            place.smooth(d(wi))
        } else {
            let drawn = once::sample(surface, wo, random);
            tally.mirrored += usize::from(drawn.dirac);
            if drawn.dirac { place.mirrored() } else { place.smooth(d(drawn.wi)) }
        };
        let Some(x) = direction.filter(|x| !near_a_jump(settings, x)) else {
            tally.skipped += 1;
            continue;
        };
        let expected = part(settings, by_light, &x);
        assert_part(found, expected, || format!("{}, {x:?}", technique()));
        tally.carried[usize::from(!by_light)] += usize::from(expected != NOTHING);
        tally.nothing += usize::from(expected == NOTHING);
        tally.shadowed += usize::from(expected == NOTHING && x.p_light > 0.0);
    }
}

#[test]
fn every_contribution_is_weight_times_integrand_over_density() {
    let settings = all_settings();
    let mut tally = Tally::default();
    let mut total = 0;
    for (name, scene) in scenes() {
        let world = World::new(&scene);
        let built = BuiltScene::new(&scene, &settings[0]).expect("the scene can be built");
        let lists = [true, false].map(|lists| {
            let scene = BuiltScene::new(&scene, &settings[0]).expect("the scene can be built");
            if lists { scene } else { scene.without_lists() }
        });
        for pixel in 0..SIDE * SIDE {
            let [x, y] = [pixel % SIDE, pixel / SIDE];
            let dir = built.camera.direction(Single, x as f32 + 0.5, y as f32 + 0.5);
            let corner = [x / 8 * 8, y / 8 * 8];
            let near = lists.each_ref().map(|scene| scene.patches.cull(&scene.camera, corner, corner.map(|c| c + 8)));
            let hit = once::camera_hit(&built, dir, &near[0]);
            if !hit.surface {
                continue;
            }
            let Some(surface) = once::surface(&built, &hit) else { continue };
            let wo = -dir;
            // The shape that was met, by the renderer's own account; its material by the scene's.
            let lobes = world.lobes(scene.shapes[hit.first as usize].material);
            let place = Place {
                world: &world,
                lobes: &lobes,
                p: d(surface.p),
                n: d(surface.n).normalize(),
                wo: d(wo).normalize(),
            };
            for (i, settings) in settings.iter().enumerate() {
                let mut sampler = Draws::of(Single, settings);
                sampler.start(once::key(i as u32, x, y), once::patch(i as u32, x, y));
                let random = once::draw(&mut sampler, 0);
                let scene = &lists[i % 2];
                let view = View { l: Single, scene, culled: &near[i % 2] };
                let found = once::reflected(view, settings, &surface, wo, &random);
                let what = || format!("{name}, pixel {x}, {y}, {settings:?}");
                check(scene, settings, &surface, wo, &random, &place, &found, &mut tally, &what);
                total += 1;
            }
        }
    }
    // That none of them vanishes unnoticed.
    let Tally { carried: [light, bsdf], nothing, shadowed, mirrored, skipped } = tally;
    let enough = light > 20_000 && bsdf > 2000 && nothing > 20_000 && shadowed > 4000 && mirrored > 3000;
    assert!(enough && 1000 * skipped < total, "{total} samples: {tally:?}");
}
