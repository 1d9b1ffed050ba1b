//! The tree over many primitives loses nothing and invents nothing: what it finds is what asking every primitive
//! finds, bit for bit, alone or in a packet, at every vector level; and an edit that keeps the shapes keeps it.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use mislab_kernel::film::Tile;
use mislab_kernel::geometry::BuiltGeometry;
use mislab_kernel::geometry::list::List;
use mislab_kernel::geometry::shape::{Ball, Facet};
use mislab_kernel::lanes::{Lanes, Lanewise, Mask, PACKET, Real, Task, Uint};
use mislab_kernel::stop::Stop;
use mislab_kernel::tile::render_tile;
use mislab_kernel::world::BuiltScene;
use mislab_renderer::{Bsdf, Estimator, ImageSettings, Light, Material, PixelRect, Scene, Settings, Shape, Strategy};
use mislab_tests::depth::depth;
use mislab_tests::experiment::camera;
use mislab_tests::packets::vector;

/// Numbers in [0, 1) from a counter (SplitMix64).
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }

    fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f32) as usize
    }

    /// In a cube of half side `s`.
    fn point(&mut self, s: f32) -> Vec3 {
        (Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0) * s
    }

    fn direction(&mut self) -> Vec3 {
        loop {
            let d = self.point(1.0);
            if (0.01..1.0).contains(&d.length_squared()) {
                return d.normalize();
            }
        }
    }
}

/// What a heap is made of.
const KINDS: [&str; 9] =
    ["triangles", "slivers", "grids on axes", "copies", "all sizes", "steps to zero", "balls", "everything", "bumps"];

/// "steps to zero".
const STEPS: usize = 5;

fn triangle(p: Vec3, a: Vec3, b: Vec3, quad: bool) -> Option<Facet> {
    Facet::new(p, p + a, p + b, quad, false, 0)
}

/// Primitives of one kind, more than a flat list is used for.
fn heap(kind: usize, random: &mut Random) -> (Vec<Facet>, Vec<Ball>) {
    let (mut facets, mut balls) = (Vec::new(), Vec::new());
    let count = 40 + random.below(400);
    let ball = |center, radius| Ball { center, radius, inward: false, shape: 0 };
    for i in 0..count {
        let p = random.point(2.0);
        match kind {
            0 => facets.extend(triangle(p, random.point(0.5), random.point(0.5), false)),
            1 => {
                let along = random.point(3.0);
                facets.extend(triangle(p, along, along * 0.5 + random.point(1e-3), false));
            }
            2 => {
                // Cells of three planes of a lattice: boxes without thickness, shared edges and corners.
                let cell = Vec3::new(random.below(6) as f32, random.below(6) as f32, random.below(3) as f32) - 3.0;
                let axis = random.below(3);
                let (a, b) = ([Vec3::Y, Vec3::Z, Vec3::X][axis], [Vec3::Z, Vec3::X, Vec3::Y][axis]);
                let quad = random.unit() < 0.5;
                facets.extend(triangle(cell, a, b, quad));
                if !quad {
                    facets.extend(triangle(cell + a + b, -a, -b, false));
                }
            }
            3 => {
                let one = triangle(p, random.point(1.0), random.point(1.0), random.unit() < 0.3);
                facets.extend([one; 12].into_iter().flatten());
                balls.extend([ball(random.point(2.0), 0.3); 3]);
            }
            4 => {
                let size = 10f32.powf(random.unit() * 7.0 - 4.0);
                facets.extend(triangle(random.point(2.0 * size), random.point(size), random.point(size), false));
            }
            STEPS => {
                // Every one half as large and as far off as the one before: no tree over these is balanced, and
                // its depth has to be kept in bounds.
                let s = 0.5f32.powi(i as i32 % 170 - 50);
                facets.extend(triangle(Vec3::splat(s), random.point(0.3 * s), random.point(0.3 * s), i % 3 == 0));
            }
            6 => balls.push(ball(p, 0.01 + 0.3 * random.unit())),
            7 => {
                facets.extend(triangle(p, random.point(0.7), random.point(0.7), random.unit() < 0.4));
                balls.extend((random.unit() < 0.3).then(|| ball(random.point(2.0), 0.2 * random.unit() + 0.01)));
            }
            _ => {
                let (x, y) = ((i % 20) as f32 / 5.0 - 2.0, (i / 20) as f32 / 5.0 - 2.0);
                let at = |x: f32, y: f32| Vec3::new(x, 0.3 * (3.0 * x).sin() * (4.0 * y).cos(), y);
                let (a, b, c, d) = (at(x, y), at(x + 0.2, y), at(x + 0.2, y + 0.2), at(x, y + 0.2));
                facets.extend(Facet::new(a, b, c, false, false, 0));
                facets.extend(Facet::new(a, c, d, false, false, 0));
            }
        }
    }
    (facets, balls)
}

/// Ways to choose a packet; the first three are rays in general position.
const STYLES: usize = 7;

/// Origin, direction, and how far it is asked whether the ray is blocked.
type Ray = (Vec3, Vec3, f32);

/// Sixteen rays that are like each other, or not at all.
fn packet(geometry: &BuiltGeometry, style: usize, steps: bool, random: &mut Random) -> [Ray; PACKET] {
    let mut far = [0.5, 3.0, 30.0][random.below(3)];
    let mut some = 0..geometry.facets.len();
    if steps {
        // Looked at from as far as it is large: from farther, it is smaller than rounding.
        let one = random.below(geometry.facets.len() - 4);
        some = one..one + 4;
        far *= geometry.facets[one].e1.length();
    }
    let eye = random.point(far);
    let corner = |random: &mut Random| {
        if some.is_empty() {
            return random.point(2.0);
        }
        let facet = &geometry.facets[some.start + random.below(some.len())];
        let corners: Vec<Vec3> = facet.corners().collect();
        corners[random.below(corners.len())]
    };
    let target = corner(random);
    std::array::from_fn(|_| {
        let (o, d) = match style {
            // From one point to a small region, as the camera and shadows do.
            0 => (eye, target + random.point(0.05) - eye),
            1 => (eye + random.point(0.01), target + random.point(0.3) - eye),
            2 => (random.point(3.0), random.direction()),
            // At corners and edges, exactly.
            3 => (eye, corner(random) - eye),
            4 => (eye, corner(random).midpoint(corner(random)) - eye),
            // Along axes, from planes of the lattice.
            5 => {
                let o = (random.point(3.0) * 2.0).round() / 2.0;
                (o, Vec3::AXES[random.below(3)] * if random.unit() < 0.5 { 1.0 } else { -1.0 })
            }
            // Along edges and in planes, with directions that have zeros.
            _ => {
                let (a, b) = (corner(random), corner(random));
                let mut d = b - a;
                d[random.below(3)] = 0.0;
                (a - d * 0.5, d)
            }
        };
        let d = d.as_dvec3().try_normalize().map_or(Vec3::X, DVec3::as_vec3);
        (o, d, [0.3, 2.0, 10.0, f32::INFINITY, -1.0][random.below(5)])
    })
}

/// Nearest distance (as bits), its primitive, and whether the ray is blocked.
type Answer = (u32, u32, bool);

/// Asks the tree about rays, `L::N` at a time.
struct AskTree<'a>(&'a BuiltGeometry, &'a [Ray], &'a List);

impl Task for AskTree<'_> {
    type Output = Vec<Answer>;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Vec<Answer> {
        let Self(geometry, rays, list) = self;
        let mut answers = Vec::new();
        for chunk in rays.chunks(L::N) {
            let (mut o, mut d, mut t) = ([Vec3::ZERO; PACKET], [Vec3::X; PACKET], [0.0; PACKET]);
            for (i, ray) in chunk.iter().enumerate() {
                (o[i], d[i], t[i]) = *ray;
            }
            let (o, d) = (vector(l, &o), vector(l, &d));
            let nearest = geometry.nearest(l, o, d, list);
            let blocked = geometry.blocked(l, o, d, l.load(&t), l.m(true), list).bits();
            for i in 0..chunk.len() {
                let t = nearest.t.lane(i);
                let id = if t.is_finite() { nearest.id.lane(i) } else { 0 };
                answers.push((t.to_bits(), id, blocked >> i & 1 == 1));
            }
        }
        answers
    }
}

/// Asks every primitive about every ray.
struct AskAll<'a>(&'a BuiltGeometry, &'a [Ray]);

impl Task for AskAll<'_> {
    type Output = Vec<Answer>;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Vec<Answer> {
        let Self(geometry, rays) = self;
        let mut answers = Vec::new();
        for ray in rays {
            let (o, d) = (vector(l, &[ray.0; PACKET]), vector(l, &[ray.1; PACKET]));
            let (mut t, mut id, mut blocked) = (f32::INFINITY, 0, false);
            for (i, facet) in geometry.facets.iter().enumerate() {
                let (distance, hit) = facet.intersect(l, o, d);
                let distance = distance.lane(0);
                if hit.bits() & 1 == 1 && distance > 0.0 {
                    blocked |= distance < ray.2;
                    if distance < t {
                        (t, id) = (distance, i as u32);
                    }
                }
            }
            for (i, ball) in geometry.balls.iter().enumerate() {
                let distance = ball.nearest(l, o, d, l.f(0.0)).lane(0);
                blocked |= distance < ray.2;
                if distance < t {
                    (t, id) = (distance, (geometry.facets.len() + i) as u32);
                }
            }
            answers.push((t.to_bits(), id, blocked));
        }
        answers
    }
}

#[test]
fn the_tree_finds_what_asking_every_primitive_finds() {
    let list = List::all(0);
    let (mut hits, mut rays_asked, mut blocked) = (0, 0, 0);
    // Rays in planes that differ, at each level: in the heaps of steps to zero and in all others.
    let mut hairs = vec![[0; 2]; Lanewise::all().len()];
    for seed in 0..depth(60, 3000) {
        let kind = seed as usize % KINDS.len();
        let mut random = Random(seed);
        let (facets, balls) = heap(kind, &mut random);
        let geometry = BuiltGeometry::new(facets, balls, Stop::NEVER).expect("nobody stops it");
        assert!(geometry.has_tree());
        let styles: Vec<usize> = (0..60).map(|i| i % STYLES).collect();
        let rays = styles.iter().flat_map(|&style| packet(&geometry, style, kind == STEPS, &mut random));
        let rays: Vec<Ray> = rays.collect();
        for (how, hairs) in Lanewise::all().into_iter().zip(&mut hairs) {
            let all = how.run(AskAll(&geometry, &rays));
            let tree = how.run(AskTree(&geometry, &rays, &list));
            for (number, (ray, (all, tree))) in rays.iter().zip(all.iter().zip(&tree)).enumerate() {
                let name = how.name();
                // In the very plane of a facet the distance is nothing but rounding, and the tree keeps it in the box.
                if styles[number / PACKET] > 2 {
                    hairs[usize::from(kind != STEPS)] += usize::from(tree != all);
                    continue;
                }
                assert_eq!(
                    tree,
                    all,
                    "heap {seed} of {}, {name}: {ray:?}, {} and {}",
                    KINDS[kind],
                    f32::from_bits(tree.0),
                    f32::from_bits(all.0)
                );
            }
            rays_asked += rays.len();
            hits += all.iter().filter(|a| f32::from_bits(a.0).is_finite()).count();
            blocked += all.iter().filter(|a| a.2).count();
        }
    }
    println!("{rays_asked} rays, {hits} hits, {blocked} blocked, in planes differ at each level {hairs:?}");
    // Without fused products most: 16 of the 57 600 rays of the shallow test.
    let each = rays_asked / hairs.len();
    for ([steps, others], how) in hairs.into_iter().zip(Lanewise::all()) {
        let name = how.name();
        assert!(steps * 2000 <= each && others * 20_000 <= each, "{name}: {steps} and {others} of {each} rays differ");
    }
    assert!(hits * 3 > rays_asked && blocked * 5 > rays_asked, "{hits} hits, {blocked} blocked of {rays_asked}");
}

#[test]
fn a_ray_hits_the_same_alone_and_in_any_packet() {
    let list = List::all(0);
    for seed in 0..depth(27, 1000) {
        let mut random = Random(1000 + seed);
        let kind = seed as usize % KINDS.len();
        let (facets, balls) = heap(kind, &mut random);
        let geometry = BuiltGeometry::new(facets, balls, Stop::NEVER).expect("nobody stops it");
        let rays: Vec<Ray> = (0..12).flat_map(|i| packet(&geometry, i % STYLES, kind == STEPS, &mut random)).collect();
        let ways = Lanewise::all();
        let answers: Vec<_> = ways.iter().map(|&how| how.run(AskTree(&geometry, &rays, &list))).collect();
        for (&how, together) in ways.iter().zip(&answers) {
            // Alone among fifteen copies, and among strangers: every 12th ray stands beside rays of other packets.
            let copies: Vec<Ray> = rays.iter().flat_map(|&ray| [ray; PACKET]).collect();
            let copies = how.run(AskTree(&geometry, &copies, &list));
            assert!(copies.iter().step_by(PACKET).eq(together), "heap {seed}, {}: copies", how.name());
            let order: Vec<usize> = (0..rays.len()).map(|i| i * 12 % rays.len() + i * 12 / rays.len()).collect();
            let mixed: Vec<Ray> = order.iter().map(|&i| rays[i]).collect();
            let mixed = how.run(AskTree(&geometry, &mixed, &list));
            let equal = order.iter().zip(&mixed).all(|(&i, answer)| *answer == together[i]);
            assert!(equal, "heap {seed}, {}: among strangers", how.name());
        }
        // Levels that round alike: all but the one that cannot multiply and add at once.
        let fused: Vec<_> = ways.iter().zip(&answers).filter(|(how, _)| how.name() != "SSE4.2").collect();
        for pair in fused.windows(2) {
            assert!(pair[0].1 == pair[1].1, "heap {seed}: {} and {}", pair[0].0.name(), pair[1].0.name());
        }
    }
}

/// Bumps under two balls of light, and a ball among them.
fn scene() -> Scene {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    let n = 24;
    for j in 0..=n {
        for i in 0..=n {
            let (x, y) = (i as f32 / 6.0 - 2.0, j as f32 / 6.0 - 2.0);
            positions.push(Vec3::new(x, 0.4 * (3.0 * x).sin() * (4.0 * y).cos(), y));
            if i < n && j < n {
                let at = j * (n + 1) + i;
                triangles.extend([[at, at + 1, at + n + 2], [at, at + n + 2, at + n + 1]]);
            }
        }
    }
    let mesh = mislab_renderer::Geometry::Mesh { positions: Arc::new(positions), triangles: Arc::new(triangles) };
    let sphere = |center, radius| mislab_renderer::Geometry::Sphere { center, radius };
    let shape = |geometry, light: bool| Shape {
        geometry,
        reverse_orientation: false,
        material: (!light).then_some(0),
        light: light.then(|| Light { name: "light".to_owned(), radiance: Vec3::splat(5.0), on: true }),
    };
    Scene {
        name: "bumps".to_owned(),
        camera: camera(DVec3::new(0.0, 2.0, 4.0), DVec3::ZERO, 50.0),
        materials: vec![Material { name: "m".to_owned(), bsdf: Bsdf::Matte { kd: Vec3::splat(0.5) } }],
        shapes: vec![
            shape(mesh, false),
            shape(sphere(Vec3::new(1.0, 2.0, 0.0), 0.2), true),
            shape(sphere(Vec3::new(0.0, 0.6, 0.0), 0.3), false),
        ],
    }
}

fn picture(built: &BuiltScene, settings: &Settings) -> Vec<Tile> {
    let mut tiles = Vec::new();
    for bounds in Tile::cut(PixelRect { min: [0, 0], max: settings.image.resolution }) {
        let mut tile = Tile::new(bounds, settings.estimator.strategy, None);
        render_tile(Lanewise::best(), built, settings, &mut tile, 2, Stop::NEVER).expect("nobody stops it");
        tiles.push(tile);
    }
    tiles
}

#[test]
fn shared_geometry_gives_the_picture_of_a_fresh_build() {
    let settings = Settings {
        estimator: Estimator { strategy: Strategy::MisAll, ..Estimator::default() },
        image: ImageSettings { resolution: [48, 48], ..ImageSettings::default() },
        ..Settings::default()
    };
    let first = scene();
    let known = [Arc::new(BuiltScene::new(&first, &settings).expect("the scene can be built"))];
    let edit = |change: &dyn Fn(&mut Scene)| {
        let mut scene = first.clone();
        change(&mut scene);
        let fresh = BuiltScene::new(&scene, &settings).expect("the scene can be built");
        let shared = BuiltScene::with_known(&scene, &settings, &known, Stop::NEVER).expect("the scene can be built");
        assert!(picture(&shared, &settings) == picture(&fresh, &settings), "the same picture");
        Arc::ptr_eq(&shared.geometry, &known[0].geometry)
    };
    let sphere = |shape: &mut Shape, r: f32| match &mut shape.geometry {
        mislab_renderer::Geometry::Sphere { radius, .. } => *radius = r,
        mislab_renderer::Geometry::Mesh { .. } => panic!("a sphere"),
    };
    assert!(edit(&|_| {}));
    assert!(edit(&|s| s.materials[0].bsdf = Bsdf::Matte { kd: Vec3::ONE }));
    assert!(edit(&|s| s.shapes[0].material = None));
    assert!(edit(&|s| s.camera.fov_deg = 30.0));
    assert!(edit(&|s| sphere(&mut s.shapes[1], 0.4)));
    assert!(edit(&|s| s.shapes[1].light.as_mut().expect("a light").radiance = Vec3::X));
    // What patches see changes with the camera and the lights' shapes and materials, not with colours.
    let veach = mislab_tests::experiment::veach();
    let known = [Arc::new(BuiltScene::new(&veach, &settings).expect("the scene can be built"))];
    // Asked of all patches.
    picture(&known[0], &settings);
    let edit_view = |settings: &Settings, change: &dyn Fn(&mut Scene)| {
        let mut scene = veach.clone();
        change(&mut scene);
        let fresh = BuiltScene::new(&scene, settings).expect("the scene can be built");
        let shared = BuiltScene::with_known(&scene, settings, &known, Stop::NEVER).expect("the scene can be built");
        assert!(picture(&shared, settings) == picture(&fresh, settings), "the same picture");
        assert!(Arc::ptr_eq(&shared.geometry, &known[0].geometry), "shared geometry");
        shared.sees_with(&known[0])
    };
    let light = veach.light_shapes().next().expect("there are lights");
    assert!(edit_view(&settings, &|_| {}));
    assert!(edit_view(&settings, &|s| *s.materials[0].bsdf.alpha_mut().expect("metal") = 0.3));
    assert!(edit_view(&settings, &|s| s.shapes[light].light.as_mut().expect("a light").radiance = Vec3::X));
    assert!(edit_view(
        &Settings { estimator: Estimator { strategy: Strategy::Light, ..settings.estimator }, ..settings.clone() },
        &|_| {}
    ));
    assert!(!edit_view(&settings, &|s| sphere(&mut s.shapes[light], 1.5)));
    assert!(!edit_view(&settings, &|s| s.shapes[light].material = Some(0)));
    assert!(!edit_view(&settings, &|s| s.camera.fov_deg = 30.0));
    for resolution in [[96, 96], [48, 56], [56, 48]] {
        assert!(!edit_view(
            &Settings { image: ImageSettings { resolution, ..settings.image }, ..settings.clone() },
            &|_| {}
        ));
    }
    // What changes the shapes, or which of them are lights, is built anew.
    assert!(!edit(&|s| s.shapes[1].light.as_mut().expect("a light").on = false));
    assert!(!edit(&|s| sphere(&mut s.shapes[2], 0.4)));
    assert!(!edit(&|s| s.shapes[2].reverse_orientation = true));
    assert!(!edit(&|s| s.shapes.truncate(2)));
    assert!(!edit(&|s| s.shapes.swap(0, 1)));
}
