//! Rays per second of our packets, of obvhs ray by ray and of Embree's widest packets, on one thread; and how
//! long a scene of a million triangles takes to open. See README.md.

mod embree;
mod mesh;
mod open;
mod rays;

use std::time::Instant;

use glam::Vec3A;
use mislab_kernel::world::BuiltScene;
use mislab_kernel::lanes::Lanewise;
use mislab_kernel::lanes::{Lanes, Mask, Real, Simd, Uint, V3, Wide};
use mislab_renderer::{Camera, Geometry, Scene, Settings, Shape};
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::ray::{Ray, RayHit};
use obvhs::triangle::Triangle;

use embree::Embree;
use mesh::Mesh;
use rays::{Packet, WIDTH};

/// The shortest of so many runs counts.
const REPEATS: usize = 5;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["compare", sizes @ ..] => {
            let sizes: Vec<usize> = sizes.iter().map(|s| s.parse().expect("a number of triangles")).collect();
            let sizes = if sizes.is_empty() { vec![100_000, 1_000_000] } else { sizes };
            println!("| mesh | rays | ours | Embree | obvhs | ours / Embree | ours / obvhs | differ |");
            println!("|---|---|---|---|---|---|---|---|");
            for size in sizes {
                for mesh in [mesh::terrain(size), mesh::cave(size)] {
                    compare(&mesh);
                }
            }
        }
        ["scene", folder, size] => open::write(folder.as_ref(), size.parse().expect("a number of triangles")),
        ["open", file] => open::measure(file.as_ref()),
        _ => eprintln!("expected: compare [TRIANGLES...] | scene FOLDER TRIANGLES | open FILE"),
    }
}

/// Shortest time of `REPEATS` runs of each of some tasks, in seconds; the runs take turns.
fn shortest<const N: usize>(mut tasks: [&mut dyn FnMut(); N]) -> [f64; N] {
    let mut best = [f64::INFINITY; N];
    for _ in 0..REPEATS {
        for (task, best) in tasks.iter_mut().zip(&mut best) {
            let start = Instant::now();
            task();
            *best = best.min(start.elapsed().as_secs_f64());
        }
    }
    best
}

fn compare(mesh: &Mesh) {
    let start = Instant::now();
    let ours = build(mesh);
    let ours_seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let embree = Embree::new(&mesh.positions, &mesh.triangles);
    let embree_seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let obvhs = Obvhs::new(mesh);
    let obvhs_seconds = start.elapsed().as_secs_f64();
    eprintln!(
        "{} of {} triangles built in {ours_seconds:.2} s, Embree {embree_seconds:.2} s, obvhs {obvhs_seconds:.2} s",
        mesh.name,
        mesh.triangles.len()
    );

    let primary = rays::primary(mesh);
    let none = ([f32::INFINITY; WIDTH], [u32::MAX; WIDTH]);
    let mut hits = vec![none; primary.len()];
    embree.nearest(&primary, true, &mut hits);
    let (shadow, diffuse) = rays::secondary(mesh, &primary, &hits);

    for (name, packets, coherent) in [("primary", &primary, true), ("diffuse", &diffuse, false)] {
        let (mut a, mut b, mut c) = (hits.clone(), hits.clone(), hits.clone());
        a.resize(packets.len(), none);
        b.resize(packets.len(), none);
        c.resize(packets.len(), none);
        let times = shortest([
            &mut || nearest(&ours, packets, &mut a),
            &mut || embree.nearest(packets, coherent, &mut b),
            &mut || obvhs.nearest(packets, &mut c),
        ]);
        let differ = |x: &[([f32; WIDTH], [u32; WIDTH])]| {
            let pairs = x.iter().zip(&b).flat_map(|(x, b)| x.0.iter().zip(&b.0));
            pairs.filter(|(x, b)| !(x == b || (*x - *b).abs() <= 1e-4 * b.abs())).count()
        };
        report(mesh, name, packets.len(), times, [differ(&a), differ(&c)]);
    }
    let (mut a, mut b, mut c) = (vec![0; shadow.len()], vec![0; shadow.len()], vec![0; shadow.len()]);
    let times =
        shortest([&mut || blocked(&ours, &shadow, &mut a), &mut || embree.blocked(&shadow, true, &mut b), &mut || {
            obvhs.blocked(&shadow, &mut c)
        }]);
    let differ = |x: &[u32]| x.iter().zip(&b).map(|(x, b)| (x ^ b).count_ones() as usize).sum();
    report(mesh, "shadow", shadow.len(), times, [differ(&a), differ(&c)]);
}

fn report(mesh: &Mesh, rays: &str, packets: usize, times: [f64; 3], differ: [usize; 2]) {
    let count = (packets * WIDTH) as f64;
    let [ours, embree, obvhs] = times.map(|t| count / t / 1e6);
    println!(
        "| {} {} k | {rays} | {ours:.1} | {embree:.1} | {obvhs:.2} | {:.2} | {:.1} | {:.4} %, obvhs {:.4} % |",
        mesh.name,
        mesh.triangles.len() / 1000,
        ours / embree,
        ours / obvhs,
        100.0 * differ[0] as f64 / count,
        100.0 * differ[1] as f64 / count
    );
}

// ---------------------------------------------------------------------------------------------
// Ours, as the kernel does it

fn build(mesh: &Mesh) -> BuiltScene {
    let geometry =
        Geometry::Mesh { positions: mesh.positions.clone().into(), triangles: mesh.triangles.clone().into() };
    let shape = Shape { geometry, reverse_orientation: false, material: None, light: None };
    let camera = Camera { world_from_camera: glam::DMat4::IDENTITY, fov_deg: 50.0, screen_window: None };
    let scene = Scene { name: mesh.name.to_owned(), camera, materials: Vec::new(), shapes: vec![shape] };
    BuiltScene::new(&scene, &Settings::default()).expect("the mesh can be built")
}

/// At the level of this machine; a closure that is inlined into the function for that level, see `lanes/level.rs`.
macro_rules! dispatched {
    ($call:ident($($argument:expr),*)) => {
        if let Lanewise::Wide(level) = Lanewise::best() {
            if let Some(simd) = level.as_avx512() {
                simd.vectorize(#[inline(always)] || $call(Wide(simd), $($argument),*));
            } else if let Some(simd) = level.as_avx2() {
                simd.vectorize(#[inline(always)] || $call(Wide(simd), $($argument),*));
            }
        }
    };
}

fn nearest(scene: &BuiltScene, packets: &[Packet], out: &mut [([f32; WIDTH], [u32; WIDTH])]) {
    dispatched!(nearest_in_lanes(scene, packets, out));
}

fn blocked(scene: &BuiltScene, packets: &[Packet], out: &mut [u32]) {
    dispatched!(blocked_in_lanes(scene, packets, out));
}

#[inline(always)]
fn load<L: Lanes>(l: L, v: &[[f32; WIDTH]; 3]) -> V3<L> {
    V3 { x: l.load(&v[0]), y: l.load(&v[1]), z: l.load(&v[2]) }
}

#[inline(always)]
fn nearest_in_lanes<L: Lanes>(l: L, scene: &BuiltScene, packets: &[Packet], out: &mut [([f32; WIDTH], [u32; WIDTH])]) {
    let list = scene.patches.everything().surfaces;
    for (packet, out) in packets.iter().zip(out) {
        let hit = scene.geometry.nearest(l, load(l, &packet.origin), load(l, &packet.dir), &list);
        hit.t.store(&mut out.0);
        for (i, id) in out.1.iter_mut().enumerate() {
            *id = hit.id.lane(i);
        }
    }
}

#[inline(always)]
fn blocked_in_lanes<L: Lanes>(l: L, scene: &BuiltScene, packets: &[Packet], out: &mut [u32]) {
    let list = scene.patches.everything().surfaces;
    for (packet, out) in packets.iter().zip(out) {
        let (origin, dir) = (load(l, &packet.origin), load(l, &packet.dir));
        let blocked = scene.geometry.blocked(l, origin, dir, l.load(&packet.t_max), l.m(true), &list);
        *out = blocked.bits();
    }
}

// ---------------------------------------------------------------------------------------------
// obvhs, ray by ray

struct Obvhs {
    bvh: Bvh2,
    /// In the order of the leaves.
    triangles: Vec<Triangle>,
}

impl Obvhs {
    fn new(mesh: &Mesh) -> Self {
        let corner = |i: u32| Vec3A::from(mesh.positions[i as usize]);
        let triangles: Vec<Triangle> =
            mesh.triangles.iter().map(|t| Triangle { v0: corner(t[0]), v1: corner(t[1]), v2: corner(t[2]) }).collect();
        let bvh = build_bvh2_from_tris(&triangles, BvhBuildParams::medium_build(), &mut Default::default());
        let triangles = bvh.primitive_indices.iter().map(|&i| triangles[i as usize]).collect();
        Self { bvh, triangles }
    }

    fn nearest(&self, packets: &[Packet], out: &mut [([f32; WIDTH], [u32; WIDTH])]) {
        for (packet, out) in packets.iter().zip(out) {
            for i in 0..WIDTH {
                let (o, d) = packet.ray(i);
                let mut hit = RayHit::none();
                self.bvh.ray_traverse(Ray::new_inf(o.into(), d.into()), &mut hit, |ray, id| {
                    self.triangles[id].intersect(ray)
                });
                out.0[i] = hit.t;
            }
        }
    }

    fn blocked(&self, packets: &[Packet], out: &mut [u32]) {
        for (packet, out) in packets.iter().zip(out) {
            *out = 0;
            for i in 0..WIDTH {
                let (o, d) = packet.ray(i);
                let ray = Ray::new(o.into(), d.into(), 0.0, packet.t_max[i]);
                let miss = self.bvh.ray_traverse_miss(ray, |ray, id| self.triangles[id].intersect(ray));
                *out |= u32::from(!miss) << i;
            }
        }
    }
}
