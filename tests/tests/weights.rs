//! The two weights of every direction sum to 1 and are never negative.

use glam::Vec3;
use mislab_kernel::bsdf::{self, BuiltMaterial, Surface};
use mislab_kernel::estimator::heuristic::{self, Rivals};
use mislab_kernel::lanes::{Lanes, Lanewise, Mask, PACKET, Real, Task, V3};
use mislab_kernel::sampler::{Dimension, Numbers, pixel_keys};
use mislab_renderer::{Bsdf, Heuristic, Reflectance};
use mislab_tests::draws::Draws;
use mislab_tests::light_scenes::{View, many, mixtures};
use mislab_tests::pair::INDEPENDENT;

/// Directions over all scenes.
const DIRECTIONS: u32 = 1_000_000;
/// Four units in the last place of 1.
const ULPS: f32 = 4.0 * f32::EPSILON;

/// Weights at directions drawn by the light, by the BSDF and over the whole sphere in turn.
struct Directions<'a> {
    view: &'a View,
    material: &'a BuiltMaterial,
    scene: u32,
    count: u32,
}

/// How many directions only light sampling reaches, only BSDF sampling, and both.
#[derive(Clone, Copy, Debug, Default)]
struct Reached {
    light: u32,
    bsdf: u32,
    both: u32,
}

impl Task for Directions<'_> {
    type Output = Reached;
    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Reached {
        let mut sampler = Draws::new(l, &INDEPENDENT, [true; Dimension::ALL.len()]);
        sampler.start(pixel_keys(l, 77, l.iota(), l.u(self.scene)), self.scene);
        let mut reached = Reached::default();
        for i in 0..self.count / L::N as u32 {
            let random = sampler.draw(i);
            let p = jittered(l, self.view.p, &random);
            let n = sphere(l, random.get_2d(Dimension::Pixel));
            let s = Surface { p, n, material: self.material };
            // A viewer above the surface: the normal and a direction across.
            let across = sphere(l, [random.get_1d(Dimension::Technique), random.get_1d(Dimension::Lobe)]);
            let wo = (n * l.f(1.001) + across).normalize(l);
            let wi = match i % 3 {
                0 => self.view.lights.sample(l, p, &random).wi,
                1 => bsdf::sample(l, &s, wo, &random).0,
                _ => sphere(l, random.get_2d(Dimension::Bsdf)),
            };
            let p_light = self.view.lights.look(l, p, wi, l.f(1e-5), false).pdf;
            let p_bsdf = bsdf::evaluate(l, &s, wo, wi).pdf;
            let c = random.get_1d(Dimension::LightChoice);
            for (a, b) in [(p_light, p_bsdf), (c * p_light, (l.f(1.0) - c) * p_bsdf)] {
                let some = !(a.le(l.f(0.0)) & b.le(l.f(0.0)));
                for heuristic in Heuristic::ALL {
                    let w_a = heuristic::weigh(l, heuristic, &Rivals { own: a, other: b, wins_ties: l.m(true) }).w;
                    let w_b = heuristic::weigh(l, heuristic, &Rivals { own: b, other: a, wins_ties: l.m(false) }).w;
                    let off = (w_a + w_b - 1.0).abs();
                    let sound = w_a.ge(l.f(0.0)) & w_b.ge(l.f(0.0)) & off.le(l.f(ULPS));
                    let bad = (some & !sound).bits();
                    if bad != 0 {
                        let k = bad.trailing_zeros() as usize;
                        let w = [w_a.lane(k), w_b.lane(k)];
                        let heuristic = heuristic.name();
                        panic!("{}, {heuristic}: {} and {} get {w:?}", self.view.name, a.lane(k), b.lane(k));
                    }
                }
            }
            let (by_light, by_bsdf) = (p_light.gt(l.f(0.0)), p_bsdf.gt(l.f(0.0)));
            reached.light += (by_light & !by_bsdf).bits().count_ones();
            reached.bsdf += (by_bsdf & !by_light).bits().count_ones();
            reached.both += (by_light & by_bsdf).bits().count_ones();
        }
        reached
    }
}

/// A direction, uniform over the sphere (by the difference of two numbers and no map of the renderer's).
#[inline(always)]
fn sphere<L: Lanes>(l: L, [u, v]: [L::F; 2]) -> V3<L> {
    let (mut x, mut y, mut z) = ([0.0; PACKET], [0.0; PACKET], [0.0; PACKET]);
    for i in 0..L::N {
        let (height, turn) = (1.0 - 2.0 * f64::from(u.lane(i)), std::f64::consts::TAU * f64::from(v.lane(i)));
        let r = (1.0 - height * height).max(0.0).sqrt();
        (x[i], y[i], z[i]) = ((r * turn.cos()) as f32, (r * turn.sin()) as f32, height as f32);
    }
    V3 { x: l.load(&x), y: l.load(&y), z: l.load(&z) }
}

/// Points near `p`.
#[inline(always)]
fn jittered<L: Lanes>(l: L, p: Vec3, random: &Numbers<L>) -> V3<L> {
    let [x, y] = random.get_2d(Dimension::Pixel);
    V3::splat(l, p) + V3 { x: x - 0.5, y: y - 0.5, z: x - y } * l.f(0.3)
}

#[test]
fn weights_of_random_directions_sum_to_one() {
    let metal = |alpha| Bsdf::Conductor { reflectance: Reflectance::Constant(Vec3::ONE), alpha };
    let materials = [
        Bsdf::Matte { kd: Vec3::splat(0.5) },
        metal(0.0),
        metal(1e-3),
        metal(0.1),
        metal(1.0),
        Bsdf::Plastic { kd: Vec3::splat(0.3), ks: Vec3::splat(0.4), alpha: 0.05, swapped_indices: false },
    ];
    let views: Vec<View> = (1..=64).map(many).chain(mixtures()).collect();
    let count = DIRECTIONS.div_ceil((views.len() * materials.len()) as u32).next_multiple_of(PACKET as u32);
    for how in [Lanewise::best(), Lanewise::Single] {
        let mut sum = Reached::default();
        for (i, view) in views.iter().enumerate() {
            for (j, bsdf) in materials.iter().enumerate() {
                let material = &BuiltMaterial::new(bsdf);
                let scene = (i * materials.len() + j) as u32;
                let reached = how.run(Directions { view, material, scene, count });
                sum.light += reached.light;
                sum.bsdf += reached.bsdf;
                sum.both += reached.both;
            }
        }
        assert!(sum.light.min(sum.bsdf).min(sum.both) > DIRECTIONS / 50, "all kinds of directions: {sum:?}");
    }
}
