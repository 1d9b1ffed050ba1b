//! How the time of a picture grows with samples, pixels, lights, triangles and threads:
//! `cargo bench -p mislab-renderer --bench scaling`. All but the last on one thread; items are paths.

use std::num::NonZeroU32;
use std::sync::Arc;

use divan::Bencher;
use divan::counter::ItemsCount;
use glam::Vec3;
use mislab_renderer::{
    Estimator, Geometry, ImageSettings, Light, Request, Sampling, Scene, Settings, Shape, Strategy, pbrt, render,
};

fn main() {
    divan::main();
}

/// Renders one picture of `side` squared pixels, `spp` samples each, the building of the scene included.
fn picture(bencher: Bencher<'_, '_>, scene: Scene, strategy: Strategy, side: u32, spp: u32, threads: usize) {
    let settings = Settings {
        estimator: Estimator { strategy, ..Estimator::default() },
        sampling: Sampling { spp: NonZeroU32::new(spp), ..Sampling::default() },
        image: ImageSettings { resolution: [side; 2], ..ImageSettings::default() },
    };
    let request = Request { scene: Arc::new(scene), settings };
    let paths = side * side * spp * strategy.rays_per_sample();
    bencher
        .counter(ItemsCount::new(paths))
        .bench_local(|| render(&request, threads, &mut |_| true).map(|frame| frame.spp()));
}

fn veach() -> Scene {
    pbrt::embedded_scene().scene
}

/// The default scene under `n` spheres in rows, which together shine about as much as one light of the scene does.
fn under(n: usize) -> Scene {
    let mut scene = veach();
    scene.shapes.retain(|shape| shape.light.is_none());
    let columns = (n as f32).sqrt().ceil();
    for i in 0..n {
        let (row, column) = (i as f32 / columns, i as f32 % columns);
        let center = Vec3::new(8.0 * column / columns - 4.0, 2.0, 3.0 * row.floor() / columns - 1.5);
        let light = Light { name: format!("light {i}"), radiance: Vec3::splat(10.0), on: true };
        let geometry = Geometry::Sphere { center, radius: 0.5 / columns };
        scene.shapes.push(Shape { geometry, reverse_orientation: false, material: None, light: Some(light) });
    }
    scene
}

/// The default scene, its plates replaced by hills of about `n` triangles.
fn hills(n: usize) -> Scene {
    let mut scene = veach();
    let mut model = scene.shapes.iter().find(|shape| shape.light.is_none()).expect("the scene has plates").clone();
    scene.shapes.retain(|shape| shape.light.is_some());
    let side = ((n / 2) as f32).sqrt().ceil() as u32;
    let positions = (0..=side).flat_map(|z| {
        (0..=side).map(move |x| {
            let (x, z) = (10.0 * x as f32 / side as f32 - 5.0, 10.0 * z as f32 / side as f32 - 5.0);
            Vec3::new(x, 0.4 * (2.0 * x).sin() * (3.0 * z).cos() - 2.0, z)
        })
    });
    let triangles = (0..side * side).flat_map(|cell| {
        let a = cell / side * (side + 1) + cell % side;
        [[a, a + 1, a + side + 2], [a, a + side + 2, a + side + 1]]
    });
    model.geometry =
        Geometry::Mesh { positions: Arc::new(positions.collect()), triangles: Arc::new(triangles.collect()) };
    scene.shapes.push(model);
    scene
}

#[divan::bench(args = [1, 4, 16, 64, 256])]
fn samples(bencher: Bencher<'_, '_>, spp: u32) {
    picture(bencher, veach(), Strategy::Mis, 200, spp, 1);
}

#[divan::bench(args = [100, 200, 400, 800])]
fn resolution(bencher: Bencher<'_, '_>, side: u32) {
    picture(bencher, veach(), Strategy::Mis, side, 8, 1);
}

#[divan::bench(args = [1, 4, 16, 64, 256, 1024])]
fn lights_by_light(bencher: Bencher<'_, '_>, n: usize) {
    picture(bencher, under(n), Strategy::Light, 200, 8, 1);
}

#[divan::bench(args = [1, 4, 16, 64, 256, 1024])]
fn lights_by_bsdf(bencher: Bencher<'_, '_>, n: usize) {
    picture(bencher, under(n), Strategy::Bsdf, 200, 8, 1);
}

#[divan::bench(args = [100, 1000, 10_000, 100_000], sample_count = 20)]
fn triangles(bencher: Bencher<'_, '_>, n: usize) {
    picture(bencher, hills(n), Strategy::MisAll, 200, 64, 1);
}

#[divan::bench(args = [1, 2, 4])]
fn threads(bencher: Bencher<'_, '_>, count: usize) {
    picture(bencher, veach(), Strategy::Mis, 400, 16, count);
}
