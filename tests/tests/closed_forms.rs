//! Scenes whose radiance is known in closed form, by all strategies.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use mislab_renderer::{
    Bsdf, Estimator, Geometry, Light, Material, Reflectance, Sampling, Scene, Settings, Shape, Strategy,
};
use mislab_tests::depth::depth;
use mislab_tests::experiment::{camera, independent, keyhole, measure};
use mislab_tests::oracle::World;
use mislab_tests::statistics::Family;

const SAMPLES: u32 = 1 << 20;
/// Most samples where a strategy is noisy, in the ordinary run and in the deep one.
const MOST_SAMPLES: u32 = 1 << 26;
const MOST_SAMPLES_DEEP: u32 = 1 << 30;
/// Relative rounding errors of single precision, counted as if they were noise.
const ROUNDING: f64 = 1e-5;

fn shape(geometry: Geometry, material: Option<usize>, radiance: Option<Vec3>) -> Shape {
    let light = radiance.map(|radiance| Light { name: "light".to_owned(), radiance, on: true });
    Shape { geometry, reverse_orientation: false, material, light }
}

fn sphere(center: DVec3, radius: f64) -> Geometry {
    Geometry::Sphere { center: center.as_vec3(), radius: radius as f32 }
}

fn mesh(points: &[DVec3], triangles: Vec<[u32; 3]>) -> Geometry {
    Geometry::Mesh { positions: Arc::new(points.iter().map(|p| p.as_vec3()).collect()), triangles: Arc::new(triangles) }
}

/// A large square at z = 0, facing up.
fn ground() -> Geometry {
    let s = 50.0;
    let corners = [[-s, -s], [s, -s], [s, s], [-s, s]].map(|[x, y]| DVec3::new(x, y, 0.0));
    mesh(&corners, vec![[0, 1, 2], [0, 2, 3]])
}

fn scene(bsdf: Bsdf, shapes: Vec<Shape>) -> Scene {
    Scene {
        name: "closed form".to_owned(),
        camera: camera(DVec3::Z, DVec3::ZERO, 30.0),
        materials: vec![Material { name: "surface".to_owned(), bsdf }],
        shapes,
    }
}

fn matte(kd: f32) -> Bsdf {
    Bsdf::Matte { kd: Vec3::splat(kd) }
}

/// Every strategy finds `expected` where the ray from `eye` to `target` ends.
fn expect(family: &mut Family, label: &str, scene: &Scene, [eye, target]: [DVec3; 2], expected: f64) {
    let view = keyhole(scene, eye, target);
    let mut sharp = 0;
    for (i, strategy) in Strategy::ALL.into_iter().enumerate() {
        let base = independent(1, 40 + i as u32, [32, 32]);
        let settings = Settings { estimator: Estimator { strategy, light_prob: 0.4, ..base.estimator }, ..base };
        let pilot = measure(&view, &settings, SAMPLES);
        // So many that five standard errors are 0.1 % of the value.
        let needed = pilot.variance * (5.0 / (1e-3 * expected)).powi(2);
        let samples = needed.max(f64::from(SAMPLES)).min(f64::from(depth(MOST_SAMPLES, MOST_SAMPLES_DEEP))) as u32;
        let settings =
            Settings { sampling: Sampling { seed: settings.sampling.seed + 50, ..settings.sampling }, ..settings };
        let measured = measure(&view, &settings, samples);
        let noise = (measured.variance / measured.n).sqrt();
        sharp += usize::from(noise * 5.0 < 1.05e-3 * expected);
        let label = format!("{label}, {}", strategy.name());
        family.test(label, measured.mean, expected, noise.hypot(ROUNDING * expected));
    }
    // BSDF samples of small lights are hopeless, and their share of the one-sample model noisy.
    println!("{label}: {sharp} of 4 strategies to 0.1 %");
    assert!(sharp >= 1, "{label}: no strategy is measured to 0.1 %");
}

/// Irradiance from a polygon of unit radiance, all above the horizon (Lambert 1760): half the sum
/// over its edges of the angle they fill times the cosine of their plane's normal.
fn lambert(p: DVec3, n: DVec3, corners: &[DVec3]) -> f64 {
    let edges = (0..corners.len()).map(|i| (corners[i] - p, corners[(i + 1) % corners.len()] - p));
    edges.map(|(a, b)| a.angle_between(b) * n.dot(a.cross(b).normalize()) / 2.0).sum::<f64>().abs()
}

#[test]
fn lights_over_a_plane() {
    let mut family = Family::new("lights over a plane");
    let eye = DVec3::new(4.0, -3.0, 6.0);
    // A sphere, wholly above the horizon: E = pi L (r / d)^2 cos.
    for (center, radius) in [
        (DVec3::new(0.0, 0.0, 2.0), 0.5),
        (DVec3::new(1.5, 0.7, 1.0), 0.9),
        (DVec3::new(-1.0, 1.0, 2.5), 0.7),
        (DVec3::new(0.1, 0.0, 1.0), 0.99),
    ] {
        let shapes = vec![shape(ground(), Some(0), None), shape(sphere(center, radius), None, Some(Vec3::splat(7.0)))];
        let scene = scene(matte(0.6), shapes);
        let target = DVec3::new(0.2, 0.1, 0.0);
        // The sphere as the renderer has it, in single precision.
        let radius = f64::from(radius as f32);
        let to = center.as_vec3().as_dvec3() - target;
        let irradiance = PI * 7.0 * (radius / to.length()).powi(2) * to.normalize().z;
        let expected = f64::from(0.6f32) / PI * irradiance;
        let eye = if radius > 0.9 { DVec3::new(20.0, 5.0, 3.0) } else { eye };
        expect(&mut family, &format!("sphere at {center}"), &scene, [eye, target], expected);
    }
    // A rectangle and a triangle, facing down, one of them tilted.
    let corners = [[-0.5, -0.8, 1.5], [-0.5, 1.2, 1.5], [1.5, 1.2, 1.5], [1.5, -0.8, 1.5]].map(DVec3::from);
    let tilted = [[-0.5, -0.5, 1.25], [-0.75, 1.5, 2.0], [1.25, 0.5, 0.5]].map(DVec3::from);
    for (label, corners, triangles) in
        [("rectangle", &corners[..], vec![[0, 1, 2], [0, 2, 3]]), ("triangle", &tilted[..], vec![[0, 1, 2]])]
    {
        let light = shape(mesh(corners, triangles), None, Some(Vec3::splat(3.0)));
        let scene = scene(matte(0.8), vec![shape(ground(), Some(0), None), light]);
        let target = DVec3::new(0.3, -0.2, 0.0);
        let expected = f64::from(0.8f32) / PI * 3.0 * lambert(target, DVec3::Z, corners);
        // From beside, below the light's edge.
        expect(&mut family, label, &scene, [DVec3::new(9.0, -7.0, 2.0), target], expected);
    }
    // A light behind another, hidden by it: the nearer one's light, and no more.
    let near = shape(sphere(DVec3::new(0.0, 0.0, 1.0), 0.5), None, Some(Vec3::splat(2.0)));
    let far = shape(sphere(DVec3::new(0.0, 0.0, 3.0), 0.9), None, Some(Vec3::splat(50.0)));
    let hidden = scene(matte(0.5), vec![shape(ground(), Some(0), None), near, far]);
    expect(&mut family, "hidden light", &hidden, [DVec3::new(9.0, 0.0, 2.0), DVec3::ZERO], 0.5 * 2.0 * 0.25);
    // A rectangle of which an opaque one hides half, as seen from the point.
    let rectangle = |x: [f64; 2], y: [f64; 2], z: f64| {
        [[x[0], y[0], z], [x[0], y[1], z], [x[1], y[1], z], [x[1], y[0], z]].map(DVec3::from)
    };
    let (lit, light) = (rectangle([-1.0, 0.0], [-1.0, 1.0], 2.0), rectangle([-1.0, 1.0], [-1.0, 1.0], 2.0));
    let screen = mesh(&rectangle([0.0, 0.75], [-2.0, 2.0], 1.0), vec![[0, 1, 2], [0, 2, 3]]);
    let light = shape(mesh(&light, vec![[0, 1, 2], [0, 2, 3]]), None, Some(Vec3::splat(5.0)));
    let half = scene(matte(0.5), vec![shape(ground(), Some(0), None), shape(screen, None, None), light]);
    let expected = 0.5 / PI * 5.0 * lambert(DVec3::ZERO, DVec3::Z, &lit);
    expect(&mut family, "half hidden light", &half, [DVec3::new(9.0, 0.0, 0.5), DVec3::ZERO], expected);
    family.judge(32);
}

/// Inside a sphere of radius 10 that shines inwards with radiance 1.
fn furnace(bsdf: Bsdf, body: Geometry) -> Scene {
    let mut shell = shape(sphere(DVec3::ZERO, 10.0), None, Some(Vec3::ONE));
    shell.reverse_orientation = true;
    scene(bsdf, vec![shape(body, Some(0), None), shell])
}

#[test]
fn inside_a_uniform_sphere() {
    let mut family = Family::new("inside a uniform sphere");
    let small = || sphere(DVec3::new(1.0, 0.5, -2.0), 0.7);
    let square = || {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.5));
        mesh(&corners, vec![[0, 1, 2], [0, 2, 3]])
    };
    let views = [
        ("sphere", small(), [DVec3::new(5.0, 1.0, 2.0), DVec3::new(1.2, 0.5, -1.7)]),
        ("square", square(), [DVec3::new(3.0, 1.0, 2.0), DVec3::new(0.3, -0.4, 0.5)]),
        ("square from below", square(), [DVec3::new(1.0, 1.0, -6.0), DVec3::new(0.3, -0.4, 0.5)]),
    ];
    for (label, body, view) in views {
        // A convex Lambert body reflects its albedo.
        let scene = furnace(matte(0.7), body.clone());
        expect(&mut family, &format!("Lambert {label}"), &scene, view, f64::from(0.7f32));
        // A GGX lobe loses what single scattering loses: a number by the oracle, below 1.
        for alpha in [0.3, 0.8] {
            let bsdf = Bsdf::Conductor { reflectance: Reflectance::Constant(Vec3::ONE), alpha };
            let scene = furnace(bsdf, body.clone());
            let expected = World::new(&scene).point(view[0], view[1]).radiance().x;
            println!("GGX {label}, alpha {alpha}: reflects {expected:.5}");
            assert!(expected < 1.0 && expected > 0.3, "GGX reflects {expected}");
            expect(&mut family, &format!("GGX {alpha} {label}"), &scene, view, expected);
        }
    }
    family.judge(36);
}

#[test]
fn a_mirror_shows_what_it_reflects() {
    // Exactly: BSDF samples of a mirror have no noise. Light samples never meet its one direction.
    let kr = Vec3::new(0.9, 0.5, 0.25);
    let bsdf = Bsdf::Conductor { reflectance: Reflectance::Constant(kr), alpha: 0.0 };
    let light = shape(sphere(DVec3::new(-2.0, 0.0, 2.0), 0.2), None, Some(Vec3::new(4.0, 8.0, 2.0)));
    let scene = scene(bsdf, vec![shape(ground(), Some(0), None), light]);
    let view = keyhole(&scene, DVec3::new(2.0, 0.0, 2.0), DVec3::ZERO);
    for (strategy, factor) in [(Strategy::Light, 0.0), (Strategy::Bsdf, 1.0), (Strategy::MisAll, 1.0)] {
        let base = independent(1, 1, [32, 32]);
        let measured =
            measure(&view, &Settings { estimator: Estimator { strategy, ..base.estimator }, ..base }, 1 << 12);
        let expected = factor * DVec3::new(3.6, 4.0, 0.5);
        assert!((measured.mean_rgb - expected).abs().max_element() < 1e-6, "{}: {measured:?}", strategy.name());
    }
    // The draws that choose light are lost: E Y^2 = L^2 / (1 - c).
    let mut family = Family::new("mirror in the one-sample model");
    for c in [0.25f32, 0.5, 0.75] {
        let base = independent(1, 2, [32, 32]);
        let settings =
            Settings { estimator: Estimator { strategy: Strategy::Mis, light_prob: c, ..base.estimator }, ..base };
        let measured = measure(&view, &settings, SAMPLES);
        let mean = 0.212_671 * 3.6 + 0.715_160 * 4.0 + 0.072_169 * 0.5;
        let c = f64::from(c);
        let variance = mean * mean * c / (1.0 - c);
        family.test(format!("mean, c = {c}"), measured.mean, mean, (variance / measured.n).sqrt());
        // Fourth central moment of a coin with values 0 and mean / (1 - c).
        let m4 = (mean / (1.0 - c)).powi(4) * c * (1.0 - c) * (1.0 - 3.0 * c * (1.0 - c));
        // At c = 1/2 the estimate has no noise of first order: what is left is of order 1 / n.
        let error = ((m4 - variance * variance).max(0.0) / measured.n).sqrt().hypot(5e-6 * variance);
        family.test(format!("variance, c = {c}"), measured.variance, variance, error);
    }
    family.judge(6);
}
