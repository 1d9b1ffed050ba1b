//! Trees are built in a time near n log n whatever the boxes, and given up as soon as nobody wants them.

use std::cell::Cell;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::Vec3;
use mislab_kernel::geometry::BuiltGeometry;
use mislab_kernel::geometry::shape::{Ball, Facet};
use mislab_kernel::light::{BuiltLight, Lights};
use mislab_kernel::stop::{Stop, Stopped};
use mislab_renderer::{Renderer, Request, State, pbrt};
use mislab_tests::light_scenes::ball;

/// Numbers in [0, 1) that fill it evenly.
fn part(i: usize, by: f64) -> f32 {
    (i as f64 * by).fract() as f32
}

fn scattered(i: usize) -> Vec3 {
    Vec3::new(part(i, 0.618_033_99), part(i, 0.754_877_67), part(i, 0.569_840_29)) * 10.0
}

fn triangle(p: Vec3, a: Vec3, b: Vec3) -> Facet {
    Facet::new(p, p + a, p + b, false, false, 0).expect("it has an area")
}

fn sphere(center: Vec3, radius: f32) -> Ball {
    Ball { center, radius, inward: false, shape: 0 }
}

/// Heaps of `n` primitives with boxes of every awkward kind.
fn heaps(n: usize) -> Vec<(&'static str, Vec<Facet>, Vec<Ball>)> {
    let facets = |one: &dyn Fn(usize) -> Facet| (0..n).map(one).collect::<Vec<_>>();
    let balls = |one: &dyn Fn(usize) -> Ball| (0..n).map(one).collect::<Vec<_>>();
    let side = n as f32;
    vec![
        ("scattered", facets(&|i| triangle(scattered(i), Vec3::X * 0.1, Vec3::new(0.0, 0.1, 0.1))), Vec::new()),
        ("all equal", facets(&|_| triangle(Vec3::ONE, Vec3::X, Vec3::new(0.0, 1.0, 1.0))), Vec::new()),
        ("equal by dozens", facets(&|i| triangle(scattered(i / 12), Vec3::X, Vec3::new(0.0, 1.0, 1.0))), Vec::new()),
        ("equal and flat", facets(&|_| triangle(Vec3::ONE, Vec3::X, Vec3::Y)), Vec::new()),
        ("nested", Vec::new(), balls(&|i| sphere(Vec3::ZERO, 1.0 + i as f32 / side))),
        ("nested, from outside", Vec::new(), balls(&|i| sphere(Vec3::ZERO, 2.0 - i as f32 / side))),
        (
            "in a row, without thickness",
            facets(&|i| triangle(Vec3::X * i as f32, Vec3::X, Vec3::Y * 1e-10)),
            Vec::new(),
        ),
        (
            "on one point and far off",
            facets(&|i| {
                let p = if i == 0 { Vec3::splat(1e6) } else { Vec3::ZERO };
                triangle(p, Vec3::X * (1.0 + i as f32), Vec3::Y)
            }),
            Vec::new(),
        ),
        (
            "everywhere",
            facets(&|i| triangle(scattered(i), scattered(i + n) - 5.0, scattered(i + 2 * n) - 5.0)),
            Vec::new(),
        ),
        (
            "a few large ones over small ones",
            facets(&|i| {
                let size = if i % 10 == 0 { 10.0 } else { 1e-3 };
                triangle(scattered(i) * 0.1, Vec3::X * size, Vec3::new(0.0, size, size))
            }),
            Vec::new(),
        ),
        (
            "ever larger",
            facets(&|i| {
                let s = 1.02f32.powi(i as i32 % 2000 - 1000);
                triangle(Vec3::splat(s), Vec3::X * s, Vec3::new(0.0, s, s))
            }),
            Vec::new(),
        ),
    ]
}

/// Builds it; how often it asked whether to go on, and how long it took.
fn effort(facets: Vec<Facet>, balls: Vec<Ball>) -> (usize, Duration) {
    let asked = Cell::new(0);
    let start = Instant::now();
    let stopped = || {
        asked.set(asked.get() + 1);
        false
    };
    BuiltGeometry::new(facets, balls, Stop::when(&stopped)).expect("nobody stops it");
    (asked.get(), start.elapsed())
}

#[test]
fn no_heap_takes_much_longer_than_a_scattered_one() {
    const N: usize = 40_000;
    let mut ordinary = None;
    for (name, facets, balls) in heaps(N) {
        let (asked, time) = effort(facets, balls);
        println!("{name}: asked {asked} times, {time:?}");
        let &mut (most, longest) = ordinary.get_or_insert((8 * asked, 12 * time + Duration::from_secs(1)));
        assert!(asked <= most, "{name}: asked {asked} times, scattered ones {}", most / 8);
        // Quadratic builds took minutes.
        assert!(time <= longest, "{name}: {time:?}, expected at most {longest:?}");
    }
}

#[test]
fn four_times_as_many_take_little_more_than_four_times_as_long() {
    for ((name, facets, balls), (_, four_facets, four_balls)) in heaps(10_000).into_iter().zip(heaps(40_000)) {
        let (one, four) = (effort(facets, balls).0, effort(four_facets, four_balls).0);
        assert!(four <= 6 * one, "{name}: asked {one} times, with four times as many {four}");
    }
}

#[test]
fn many_equal_lights_are_built_as_quickly() {
    let lights = |one: &dyn Fn(usize) -> BuiltLight| (0..20_000).map(one).collect::<Vec<_>>();
    let build = |lights| {
        let start = Instant::now();
        Lights::new(lights, Stop::NEVER).expect("nobody stops it");
        start.elapsed()
    };
    let ordinary = build(lights(&|i| ball(scattered(i), 0.1, false)));
    let equal = build(lights(&|_| ball(Vec3::ONE, 0.1, false)));
    assert!(equal <= 12 * ordinary + Duration::from_secs(1), "{equal:?}, scattered ones {ordinary:?}");
}

#[test]
fn a_build_stops_wherever_it_is_asked_to() {
    let (_, facets, _) = heaps(20_000).swap_remove(0);
    let (asked, _) = effort(facets.clone(), Vec::new());
    assert!(asked > 100, "asked {asked} times");
    for at in (1..=asked).step_by(asked / 50) {
        let count = Cell::new(0);
        let stopped = || {
            count.set(count.get() + 1);
            count.get() >= at
        };
        let built = BuiltGeometry::new(facets.clone(), Vec::new(), Stop::when(&stopped));
        assert_eq!(built.err(), Some(Stopped), "at the {at}th question");
        assert_eq!(count.get(), at, "it asks no more");
    }
}

/// The longest time between two questions, of three builds the shortest: others use this machine, too.
#[test]
fn a_build_asks_often() {
    let longest = (0..3).map(|_| {
        let (last, longest) = (Cell::new(Instant::now()), Cell::new(Duration::ZERO));
        let stopped = || {
            let now = Instant::now();
            longest.set(longest.get().max(now - last.replace(now)));
            false
        };
        let (_, facets, _) = heaps(200_000).swap_remove(0);
        last.set(Instant::now());
        BuiltGeometry::new(facets, Vec::new(), Stop::when(&stopped)).expect("nobody stops it");
        longest.get()
    });
    let longest = longest.min().expect("three builds");
    assert!(longest < Duration::from_millis(100), "{longest:?}");
}

/// The default scene with a heap of triangles in it that takes a while to build.
fn large(n: usize) -> Request {
    let file = pbrt::embedded_scene();
    let mut scene = file.scene;
    let corners = |i: usize| [scattered(i), scattered(i) + Vec3::X * 0.1, scattered(i) + Vec3::new(0.0, 0.1, 0.1)];
    let opaque = scene.shapes.iter_mut().find(|shape| shape.light.is_none()).expect("a plate");
    opaque.geometry = mislab_renderer::Geometry::Mesh {
        positions: Arc::new((0..n).flat_map(corners).collect()),
        triangles: Arc::new((0..n as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect()),
    };
    let mut settings = file.settings;
    settings.image.resolution = [16, 16];
    settings.sampling.spp = std::num::NonZeroU32::new(1);
    Request { scene: Arc::new(scene), settings }
}

fn small() -> Request {
    let file = pbrt::embedded_scene();
    Request { scene: Arc::new(file.scene), settings: large(1).settings }
}

fn wait_for(what: &str, mut done: impl FnMut() -> bool) -> Duration {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < Duration::from_secs(120), "waited two minutes for: {what}");
        std::thread::sleep(Duration::from_millis(1));
    }
    start.elapsed()
}

#[test]
fn a_window_never_waits_for_a_scene_that_nobody_wants() {
    let slow = large(1_000_000);
    let building = || {
        let renderer = Renderer::new(1, || {});
        let picture = renderer.add_picture();
        picture.submit(slow.clone());
        // The only worker is at it.
        std::thread::sleep(Duration::from_millis(150));
        assert_eq!(picture.status().state, State::Building, "a scene that takes longer to build");
        (renderer, picture)
    };
    let soon = Duration::from_millis(700);

    // Another scene.
    let (renderer, picture) = building();
    picture.submit(small());
    let waited = wait_for("another scene", || picture.status().state == State::Finished);
    assert!(waited < soon, "another scene: {waited:?}");

    // No scene at all.
    picture.submit(slow.clone());
    std::thread::sleep(Duration::from_millis(150));
    drop(picture);
    let other = renderer.add_picture();
    other.submit(small());
    let waited = wait_for("another picture", || other.status().state == State::Finished);
    assert!(waited < soon, "another picture: {waited:?}");
    drop(other);

    // No window.
    let (renderer, picture) = building();
    let start = Instant::now();
    drop(picture);
    drop(renderer);
    assert!(start.elapsed() < soon, "the end: {:?}", start.elapsed());
}

/// Every ray that meets one of its triangles meets all: nothing is left to a tree.
fn slow_to_render() -> Request {
    const N: u32 = 100_000;
    let mut r = large(1);
    r.settings.image.resolution = [256, 256];
    let mut scene = (*r.scene).clone();
    let opaque = scene.shapes.iter_mut().find(|shape| shape.light.is_none()).expect("a plate");
    opaque.geometry = mislab_renderer::Geometry::Mesh {
        positions: Arc::new(vec![
            Vec3::new(-90.0, -50.0, -2.0),
            Vec3::new(90.0, -50.0, -2.0),
            Vec3::new(0.0, 90.0, 1.0),
        ]),
        triangles: Arc::new(vec![[0, 1, 2]; N as usize]),
    };
    r.scene = Arc::new(scene);
    r
}

#[test]
fn a_window_never_waits_for_a_tile_that_nobody_wants() {
    let rendering = || {
        let renderer = Renderer::new(1, || {});
        let picture = renderer.add_picture();
        picture.submit(slow_to_render());
        wait_for("a pass", || picture.status().state != State::Building);
        std::thread::sleep(Duration::from_millis(100));
        assert_eq!(picture.status().state, State::Rendering, "a scene that takes longer to render");
        (renderer, picture)
    };
    let soon = Duration::from_millis(700);
    let (renderer, picture) = rendering();
    picture.submit(small());
    let waited = wait_for("another scene", || picture.status().state == State::Finished);
    assert!(waited < soon, "another scene: {waited:?}");
    drop((picture, renderer));

    let (renderer, picture) = rendering();
    let start = Instant::now();
    drop(renderer);
    drop(picture);
    assert!(start.elapsed() < soon, "the end: {:?}", start.elapsed());
}

#[test]
fn an_edit_that_keeps_the_shapes_does_not_start_their_build_again() {
    const N: usize = 400_000;
    let renderer = Renderer::new(2, || {});
    let picture = renderer.add_picture();
    picture.submit(large(N));
    let alone = wait_for("a first build", || picture.status().state == State::Finished);
    drop(picture);
    let picture = renderer.add_picture();
    let mut edited = large(N);
    let start = Instant::now();
    picture.submit(edited.clone());
    // A dozen times in the time that a build takes. Some of them are slow enough for a picture of their own.
    let mut edits = 0;
    while picture.latest().is_none() {
        std::thread::sleep(alone / 12);
        edits += 1;
        Arc::make_mut(&mut edited.scene).materials[0].name = format!("edit {edits}");
        picture.submit(edited.clone());
        assert!(start.elapsed() < 10 * alone + Duration::from_secs(5), "built again and again: {edits} edits");
    }
    println!("{alone:?} alone, {:?} with {edits} edits", start.elapsed());
    assert!(edits > 2, "{edits} edits");
}
