//! Many lights: what the tree over them finds in a direction is what asking every light finds, bit for bit, at every vector
//! level, however the lights lie and wherever a ray starts.

use glam::{DVec3, Vec3};
use mislab_kernel::geometry::list::List;
use mislab_kernel::lanes::{Lanes, Lanewise, PACKET, Real, Task, Uint};
use mislab_kernel::light::{BuiltLight, LightShape, Lights};
use mislab_kernel::stop::Stop;
use mislab_tests::depth::depth;
use mislab_tests::light_scenes::{ball, facet, random};
use mislab_tests::packets::vector;

/// Random numbers of one case.
struct Random(u32, u32);

impl Random {
    fn unit(&mut self) -> f32 {
        self.1 += 1;
        random(self.0, self.1)
    }

    fn below(&mut self, n: usize) -> usize {
        ((self.unit() * n as f32) as usize).min(n - 1)
    }

    /// In a cube of half side `s`.
    fn point(&mut self, s: f32) -> Vec3 {
        (Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0) * s
    }

    fn direction(&mut self) -> Vec3 {
        unit(self.point(1.0).as_dvec3())
    }
}

fn unit(v: DVec3) -> Vec3 {
    v.try_normalize().map_or(Vec3::X, DVec3::as_vec3)
}

/// What a heap of lights is made of.
const KINDS: [&str; 7] =
    ["balls", "facets", "both", "all sizes", "on a lattice", "inside each other", "far from the origin"];

/// More lights than are asked one by one, each of a radiance of its own.
fn heap(kind: usize, random: &mut Random) -> Vec<BuiltLight> {
    let count = 33 + random.below(600);
    let mut lights = Vec::new();
    for i in 0..count {
        let p = random.point(3.0);
        let inward = random.unit() < 0.2;
        let rectangle = |random: &mut Random, p: Vec3, size: f32| {
            let [a, b] = [random.direction() * size, random.direction() * size];
            facet(p, a, b, random.unit() < 0.5, inward)
        };
        lights.push(match kind {
            0 => ball(p, 0.01 + 0.3 * random.unit(), inward),
            1 => rectangle(random, p, 0.5),
            2 if i % 2 == 0 => ball(p, 0.3 * random.unit() + 0.01, inward),
            2 => rectangle(random, p, 0.5),
            3 => {
                let size = 10f32.powf(random.unit() * 6.0 - 5.0);
                if i % 2 == 0 { ball(p, size, inward) } else { rectangle(random, p, size) }
            }
            4 => {
                // Boxes that share planes, balls that touch.
                let cell = (p * 2.0).round();
                if i % 2 == 0 {
                    ball(cell, 0.5, inward)
                } else {
                    let (a, b) = (Vec3::AXES[i % 3], Vec3::AXES[(i + 1) % 3]);
                    facet(cell, a, b, i % 4 == 1, inward)
                }
            }
            5 => ball(Vec3::splat(0.1) * (i % 5) as f32, 0.05 * (1 + i) as f32, inward),
            _ => ball(p + Vec3::new(1000.0, -300.0, 50.0), 0.02 + 0.2 * random.unit(), inward),
        });
    }
    for (i, light) in lights.iter_mut().enumerate() {
        light.radiance = Vec3::new(1.0 + i as f32, 0.5, 1000.0 - i as f32);
    }
    lights
}

type Ray = (Vec3, Vec3);

/// Rays in general, at lights' rims and edges, along axes, from inside and from surfaces, from far away.
fn ray(lights: &[BuiltLight], random: &mut Random) -> Ray {
    let (a, b) = (random.below(lights.len()), random.below(lights.len()));
    let place = |light: &BuiltLight| match &light.shape {
        LightShape::Ball(ball) => (ball.center, ball.radius),
        LightShape::Facet(facet) => (facet.p0, facet.e1.length()),
    };
    let ((from, size), (to, radius)) = (place(&lights[a]), place(&lights[b]));
    let origin = match random.below(5) {
        0 => from + random.point(3.0),
        1 => from + random.direction() * size,
        2 => from + random.point(size),
        3 => from + random.point(200.0),
        _ => to + Vec3::AXES[random.below(3)] * 2.5,
    };
    let toward = (to - origin).as_dvec3();
    let dir = match (random.below(6), &lights[b].shape) {
        (0, _) => random.direction(),
        (1, _) => unit(toward),
        // At the rim of a ball, to a few roundings.
        (2, LightShape::Ball(_)) if toward.length() > f64::from(radius) => {
            let axis = toward.normalize();
            let across = axis.cross(random.direction().as_dvec3()).try_normalize().unwrap_or(DVec3::Z);
            let sin = f64::from(radius) / toward.length() * (1.0 + 1e-7 * f64::from(random.below(9) as u32) - 4e-7);
            unit(axis * (1.0 - (sin * sin).min(1.0)).sqrt() + across * sin)
        }
        // At corners, along edges.
        (2, LightShape::Facet(facet)) => unit((facet.p0 + facet.e2 - origin).as_dvec3()),
        (3, _) => Vec3::AXES[random.below(3)] * if random.unit() < 0.5 { 1.0 } else { -1.0 },
        (4, _) => {
            let mut dir = toward;
            dir[random.below(3)] = 0.0;
            unit(dir)
        }
        _ => unit(toward + random.point(2.0 * radius).as_dvec3()),
    };
    (origin, dir)
}

/// Bits of density, distance and radiance; then of the distance, number and radiance of what is seen directly.
type Answer = ([u32; 5], [u32; 5]);

struct Ask<'a>(&'a Lights, &'a [Ray], &'a List);

impl Task for Ask<'_> {
    type Output = Vec<Answer>;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Vec<Answer> {
        let Self(lights, rays, list) = self;
        let mut answers = Vec::new();
        for chunk in rays.chunks(L::N) {
            let (mut o, mut d) = ([Vec3::ZERO; PACKET], [Vec3::X; PACKET]);
            for (i, ray) in chunk.iter().enumerate() {
                (o[i], d[i]) = *ray;
            }
            let (o, d) = (vector(l, &o), vector(l, &d));
            let sight = lights.look(l, o, d, l.f(1e-5), true);
            let (t, index, radiance) = lights.nearest(l, o, d, list);
            for i in 0..chunk.len() {
                let r = sight.radiance;
                let look = [sight.pdf.lane(i), sight.t.lane(i), r.x.lane(i), r.y.lane(i), r.z.lane(i)];
                let number = if t.lane(i) < f32::INFINITY { index.lane(i) } else { 0 };
                let seen = [t.lane(i), radiance.x.lane(i), radiance.y.lane(i), radiance.z.lane(i)].map(f32::to_bits);
                answers.push((look.map(f32::to_bits), [number, seen[0], seen[1], seen[2], seen[3]]));
            }
        }
        answers
    }
}

#[test]
fn the_tree_finds_what_asking_every_light_finds() {
    let list = List::all(0);
    // By kind: rays that meet nothing, one light, several; and of facets edge-on, which differ.
    let mut count = [[0u32; 3]; KINDS.len()];
    let mut differ = [0u32; KINDS.len()];
    for seed in 0..depth(21, 2000) {
        let kind = seed as usize % KINDS.len();
        let mut random = Random(seed, 0);
        let lights = heap(kind, &mut random);
        let rays: Vec<Ray> = (0..600).map(|_| ray(&lights, &mut random)).collect();
        let tree = Lights::new(lights.clone(), Stop::NEVER).expect("nobody stops it");
        let all = Lights::new(lights, Stop::NEVER).expect("nobody stops it").without_tree();
        assert!(tree.has_tree() && !all.has_tree());
        for how in Lanewise::all() {
            let found = how.run(Ask(&tree, &rays, &list));
            let expected = how.run(Ask(&all, &rays, &list));
            for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
                let pdf = f32::from_bits(expected.0[0]);
                count[kind][if expected.0[1] == f32::INFINITY.to_bits() { 0 } else { 1 + usize::from(pdf == 0.0) }] +=
                    1;
                if found != expected {
                    let facets = all.list.iter().any(|light| matches!(light.shape, LightShape::Facet(_)));
                    assert!(
                        facets,
                        "{}, seed {seed}, ray {i} {:?}, {}: {found:?}, expected {expected:?}",
                        KINDS[kind],
                        rays[i],
                        how.name()
                    );
                    differ[kind] += 1;
                }
            }
        }
    }
    for ((kind, count), differ) in KINDS.iter().zip(count).zip(differ) {
        let total: u32 = count.iter().sum();
        println!("{kind}: {count:?}, {differ} differ");
        assert!(count[1] > total / 20, "{kind}: {count:?} rays meet nothing, a light's front, its back");
        assert!(differ * 3000 <= total, "{kind}: {differ} of {total} rays differ");
    }
}

/// Whichever rays share a packet.
#[test]
fn lanes_do_not_know_of_each_other() {
    let list = List::all(0);
    for seed in 100..107 {
        let kind = seed as usize % KINDS.len();
        let mut random = Random(seed, 0);
        let lights = heap(kind, &mut random);
        let rays: Vec<Ray> = (0..200).map(|_| ray(&lights, &mut random)).collect();
        let lights = Lights::new(lights, Stop::NEVER).expect("nobody stops it");
        for how in Lanewise::all() {
            let together = how.run(Ask(&lights, &rays, &list));
            for (i, expected) in together.iter().enumerate() {
                let alone = how.run(Ask(&lights, &rays[i..=i], &list));
                assert_eq!(alone[0], *expected, "{}, ray {i}, {}", KINDS[kind], how.name());
            }
        }
    }
}

/// Levels that fuse multiplications and additions agree to the bit.
#[test]
fn levels_agree() {
    let list = List::all(0);
    for seed in 200..207 {
        let mut random = Random(seed, 0);
        let lights = heap(seed as usize % KINDS.len(), &mut random);
        let rays: Vec<Ray> = (0..500).map(|_| ray(&lights, &mut random)).collect();
        let lights = Lights::new(lights, Stop::NEVER).expect("nobody stops it");
        let fused: Vec<_> = Lanewise::all().into_iter().filter(|how| how.name() != "SSE4.2").collect();
        let answers: Vec<_> = fused.iter().map(|how| how.run(Ask(&lights, &rays, &list))).collect();
        assert!(answers.windows(2).all(|pair| pair[0] == pair[1]), "seed {seed}");
    }
}
