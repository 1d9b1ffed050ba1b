//! What `culling.rs` takes off its lists, no ray meets: pictures with lists and without are the same, bit
//! for bit, however nasty the scene.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use mislab_kernel::film::Tile;
use mislab_kernel::lanes::Lanewise;
use mislab_kernel::light::LightShape;
use mislab_kernel::stop::Stop;
use mislab_kernel::tile::render_tile;
use mislab_kernel::world::BuiltScene;
use mislab_renderer::{
    Bsdf, Estimator, Geometry, Light, Material, PixelRect, Reflectance, SamplerKind, Scene, Settings, Shape, Strategy,
};
use mislab_tests::depth::depth;
use mislab_tests::experiment::{camera, highlight, independent, veach};

/// Numbers in [0, 1) from a counter (SplitMix64).
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }

    /// In a cube of half side `s`; now and then on a grid, so that things touch and planes coincide.
    fn point(&mut self, s: f64) -> DVec3 {
        let p = DVec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0;
        if self.unit() < 0.3 { (p * 3.0).round() / 3.0 * s } else { p * s }
    }
}

fn mesh(points: &[DVec3], triangles: Vec<[u32; 3]>) -> Geometry {
    Geometry::Mesh { positions: Arc::new(points.iter().map(|p| p.as_vec3()).collect()), triangles: Arc::new(triangles) }
}

fn sphere(center: DVec3, radius: f64) -> Geometry {
    Geometry::Sphere { center: center.as_vec3(), radius: radius as f32 }
}

fn shape(geometry: Geometry, material: Option<usize>, light: bool) -> Shape {
    let light = light.then(|| Light { name: "light".to_owned(), radiance: Vec3::new(3.0, 2.0, 1.0), on: true });
    Shape { geometry, reverse_orientation: false, material, light }
}

fn materials() -> Vec<Material> {
    let conductor = |alpha| Bsdf::Conductor { reflectance: Reflectance::Constant(Vec3::ONE), alpha };
    [Bsdf::Matte { kd: Vec3::splat(0.6) }, conductor(0.0), conductor(0.05), conductor(0.5)]
        .into_iter()
        .map(|bsdf| Material { name: "surface".to_owned(), bsdf })
        .collect()
}

/// A triangle, a sliver, a parallelogram or a ball, of any size, anywhere.
fn anything(random: &mut Random) -> Geometry {
    let p = random.point(2.0);
    let size = [0.05, 0.5, 2.0, 20.0][random.below(4)];
    match random.below(4) {
        0 => mesh(&[p, p + random.point(size), p + random.point(size)], vec![[0, 1, 2]]),
        1 => {
            let along = random.point(size);
            mesh(&[p, p + along, p + along * 0.5 + random.point(1e-4)], vec![[0, 1, 2]])
        }
        2 => {
            let (a, b) = (random.point(size), random.point(size));
            mesh(&[p, p + a, p + a + b, p + b], vec![[0, 1, 2], [0, 2, 3]])
        }
        _ => sphere(p, 0.4 * size.min(2.0)),
    }
}

/// Up to 20 surfaces and 6 lights in a heap, seen from among them or from outside.
fn heap(seed: u64) -> Scene {
    let mut random = Random(seed);
    let materials = materials();
    let mut shapes = Vec::new();
    for _ in 0..1 + random.below(20) {
        shapes.push(shape(anything(&mut random), Some(random.below(materials.len())), false));
    }
    for _ in 0..1 + random.below(6) {
        let material = (random.unit() < 0.3).then(|| random.below(materials.len()));
        let mut light = shape(anything(&mut random), material, true);
        light.reverse_orientation = random.unit() < 0.2;
        shapes.push(light);
    }
    let far = [0.5, 3.0, 8.0][random.below(3)];
    let eye = random.point(far);
    let target = random.point(1.0) + DVec3::splat(1e-3);
    let fov = [0.001, 1.0, 30.0, 90.0, 170.0][random.below(5)];
    Scene { name: "heap".to_owned(), camera: camera(eye, target, fov), materials, shapes }
}

/// Up to 8 spheres that shine above a floor, from close to far, in groups that nearly touch or just overlap as seen from
/// a point of it.
fn lamps(seed: u64) -> Scene {
    let mut random = Random(seed);
    let materials = materials();
    let corners = [[-3.0, -3.0], [3.0, -3.0], [3.0, 3.0], [-3.0, 3.0]].map(|[x, z]| DVec3::new(x, -1.0, z));
    let floor = mesh(&corners, vec![[0, 1, 2], [0, 2, 3]]);
    let mut shapes = vec![shape(floor, Some(random.below(materials.len())), false)];
    let seen = DVec3::new(random.unit() - 0.5, -1.0, random.unit() - 0.5) * 2.0 + DVec3::Y;
    let up = |random: &mut Random| (random.point(1.0) + DVec3::Y * 1.5).normalize();
    let mut last = (up(&mut random), 0.1);
    for _ in 0..1 + random.below(8) {
        let distance = [0.5, 1.0, 2.0, 8.0][random.below(4)];
        let axis = if random.unit() < 0.5 { up(&mut random) } else { (last.0 + random.point(0.5)).normalize() };
        let between = axis.angle_between(last.0);
        let touching = between - last.1 + [-0.1, -0.01, -1e-4, 0.0, 1e-4, 0.01][random.below(6)];
        let angle = if random.unit() < 0.5 { touching } else { 0.3 * random.unit() };
        let angle = angle.clamp(0.002, 0.4);
        shapes.push(shape(sphere(seen + axis * distance, distance * angle.sin()), None, true));
        last = (axis, angle);
    }
    let eye = seen + up(&mut random) * [1.5, 6.0][random.below(2)];
    let fov = [2.0, 10.0, 40.0][random.below(3)];
    Scene { name: "lamps".to_owned(), camera: camera(eye, seen + DVec3::splat(1e-3), fov), materials, shapes }
}

/// The default scene in shapes that invite mistakes.
fn edited() -> Vec<(String, Scene)> {
    let mut all = vec![("default".to_owned(), veach())];
    all.push(("plastic".to_owned(), mislab_renderer::pbrt::embedded_plastic_scene().scene));
    let plate = |scene: &Scene| scene.shapes.iter().position(|s| s.light.is_none() && s.material.is_some());
    // A light on its way through a plate, from above its edge to below.
    for step in 0..8 {
        let mut scene = veach();
        let light = scene.light_shapes().next().expect("there are lights");
        let plate = plate(&scene).expect("there are plates");
        let at = highlight(&scene, plate, light, DVec3::new(0.0, 2.0, 15.0));
        let center = at + DVec3::new(0.0, 0.8 - 0.2 * f64::from(step), 0.1);
        scene.shapes[light].geometry = sphere(center, 0.05 * f64::from(step + 1));
        all.push((format!("light through a plate, step {step}"), scene));
    }
    // Along a plate's plane, where it is a line, and just above and below it; behind its edge.
    for (i, height) in [0.0, 1e-6, 1e-3, -1e-3, 0.1].into_iter().enumerate() {
        let mut scene = veach();
        let plate = plate(&scene).expect("there are plates");
        let Geometry::Mesh { positions, .. } = &scene.shapes[plate].geometry else { panic!("plates are meshes") };
        let [a, b, c] = [0, 1, 2].map(|i| positions[i].as_dvec3());
        let up = (b - a).cross(c - a).normalize() * height;
        scene.camera = camera(a + (a - c) * 2.0 + up, c + up * 0.5, 40.0);
        all.push((format!("along a plate {i}"), scene));
    }
    all
}

#[test]
fn lists_lose_nothing() {
    let mut scenes = edited();
    scenes.extend((0..depth(400, 20_000)).map(|seed| (format!("heap {seed}"), heap(seed))));
    scenes.extend((0..depth(400, 20_000)).map(|seed| (format!("lamps {seed}"), lamps(seed))));
    let (mut pictures, mut narrowed, mut apart) = (0, 0, [0, 0]);
    for (number, (name, scene)) in scenes.into_iter().enumerate() {
        let side = if number < 16 { 96 } else { 32 };
        let strategy = Strategy::ALL[number % 4];
        let base = independent(4, number as u32, [side, side]);
        let settings = Settings { estimator: Estimator { strategy, light_prob: 0.4, ..base.estimator }, ..base };
        assert_eq!(settings.sampling.sampler.kind, SamplerKind::Independent);
        let Ok(listed) = BuiltScene::new(&scene, &settings) else { continue };
        let plain = BuiltScene::new(&scene, &settings).expect("as before").without_lists();
        for bounds in Tile::cut(PixelRect { min: [0, 0], max: [side, side] }) {
            let render = |scene: &BuiltScene| {
                let mut tile = Tile::new(bounds, strategy, None);
                let invalid = render_tile(Lanewise::best(), scene, &settings, &mut tile, 4, Stop::NEVER)
                    .expect("nobody stops it");
                assert_eq!(invalid, 0, "{name}: invalid samples");
                tile
            };
            assert!(render(&listed) == render(&plain), "{name}: {} differs in {bounds:?}", strategy.name());
            pictures += 1;
            let everything = listed.patches.everything();
            let corner = |[x, y]: [u32; 2]| [x / 8 * 8, y / 8 * 8];
            let near = listed.patches.cull(&listed.camera, corner(bounds.min), corner(bounds.max));
            narrowed += usize::from(near.surfaces.len() < everything.surfaces.len());
            if name.starts_with("lamps") {
                for x in (bounds.min[0]..bounds.max[0]).step_by(8) {
                    let near = listed.culled([x, bounds.min[1]]);
                    apart[usize::from(near.lights_disjoint)] += usize::from(near.covered);
                }
            }
        }
    }
    println!(
        "{pictures} strips compared, {narrowed} of them with shorter lists; of lamps, {} patches see no two in one \
         direction, {} may",
        apart[1], apart[0]
    );
    // Else nothing has been tested.
    assert!(narrowed * 10 > pictures, "{narrowed} of {pictures} strips have shorter lists");
    assert!(apart.iter().all(|&n| n > 500), "{apart:?} patches see lamps in one direction and apart");
}

#[test]
fn most_patches_of_the_default_scene_see_one_surface_no_occluder_and_lights_apart() {
    let settings = Settings::default();
    let scene = BuiltScene::new(&veach(), &settings).expect("the default scene");
    let (mut alone, mut open, mut apart, mut all) = (0, 0, 0, 0);
    for y in (0..800).step_by(8) {
        for x in (0..800).step_by(8) {
            let near = scene.patches.cull(&scene.camera, [x, y], [x + 8, y + 8]);
            alone += usize::from(near.covered);
            open += usize::from(!near.may_be_blocked());
            apart += usize::from(near.lights_disjoint);
            all += 1;
        }
    }
    println!("of {all} patches {alone} see one surface, {open} have no occluder, {apart} see all lights apart");
    assert!(alone * 10 > all * 8, "only {alone} of {all} patches see one surface");
    assert!(open * 10 > all * 5, "only {open} of {all} patches have no occluder");
    assert!(apart * 10 > all * 5, "only {apart} of {all} patches see all lights apart");
}

/// Where a scene is said to be clear, no surface comes near a ball light, not at its corners, on a grid of points or
/// below the light's centre.
#[test]
fn clear_scenes_are_clear() {
    let mut scenes = edited();
    scenes.extend((0..depth(400, 20_000)).map(|seed| (format!("heap {seed}"), heap(seed))));
    let mut count = [0, 0];
    for (name, scene) in scenes {
        let Ok(built) = BuiltScene::new(&scene, &independent(1, 0, [8, 8])) else { continue };
        let balls = built.lights.list.iter().filter_map(|light| match light.shape {
            LightShape::Ball(ball) => Some((ball.center.as_dvec3(), f64::from(ball.radius))),
            LightShape::Facet(_) => None,
        });
        let balls: Vec<_> = balls.collect();
        if balls.is_empty() {
            continue;
        }
        count[usize::from(built.lights.are_seen_from_outside())] += 1;
        if name == "default" || name == "plastic" {
            assert!(built.lights.are_seen_from_outside(), "{name}");
        }
        if !built.lights.are_seen_from_outside() {
            continue;
        }
        for (center, radius) in balls {
            let mut nearest = f64::INFINITY;
            for facet in &built.geometry.facets {
                let [p, a, b] = [facet.p0, facet.e1, facet.e2].map(Vec3::as_dvec3);
                // Barycentric coordinates of the point of the plane below the centre, moved into the facet.
                let n = a.cross(b);
                let q = center - p;
                let below = [q.cross(b).dot(n), a.cross(q).dot(n)].map(|t| (t / n.length_squared()).clamp(0.0, 1.0));
                let grid = (0..=40).flat_map(|i| (0..=40).map(move |j| [i, j].map(|k| f64::from(k) / 40.0)));
                for [u, v] in grid.chain([below]).filter(|[u, v]| facet.quad || u + v <= 1.0) {
                    nearest = nearest.min((p + a * u + b * v - center).length());
                }
            }
            for ball in &built.geometry.balls {
                let apart = (ball.center.as_dvec3() - center).length();
                nearest = nearest.min((apart - f64::from(ball.radius)).abs());
            }
            assert!(
                nearest > 1.001 * radius,
                "{name}: a surface {nearest} from the centre of a light of radius {radius}"
            );
        }
    }
    assert!(count[0] >= 100 && count[1] >= 50, "{count:?} scenes are not clear and clear");
}
