//! Lights: what lies in a direction, its density, and where samples go.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DVec3, Vec3};
use mislab_kernel::lanes::Single;
use mislab_kernel::light::{Aim, BuiltLight, LightShape, Lights};
use mislab_kernel::sampler::{Dimension, Numbers};
use mislab_kernel::stop::Stop;
use mislab_kernel::world::BuiltScene;
use mislab_renderer::{Geometry, Scene};
use mislab_tests::experiment::{independent, veach};
use mislab_tests::light_scenes::{ASLANT, View, ball, facets, far_balls, many, mixtures, near_balls, random};
use mislab_tests::oracle::World;

use crate::estimator::scenes;
use crate::once::{self, d, splat};

fn numbers(i: u32) -> Numbers<Single> {
    once::numbers(0x11_9475, i)
}

/// The same scenes with a radiance for each light, so that they can be told apart.
fn views() -> Vec<View> {
    let mut views: Vec<View> = far_balls().into_iter().chain(near_balls()).chain(facets()).chain(mixtures()).collect();
    views.extend((1..=12).map(many));
    // Three in a row, in any order of the list.
    for [a, b, c] in [[2.0, 4.0, 7.0], [4.0, 2.0, 7.0], [7.0, 4.0, 2.0], [2.0, 7.0, 4.0]] {
        let balls = [a, b, c].map(|distance| ball(ASLANT * distance, 0.1 * distance, false));
        views.push(View::new("three spheres in a row", Vec3::ZERO, balls.to_vec()));
        // Seen from elsewhere than the origin, too.
        let p = Vec3::new(3.0, -2.0, 1.0);
        let balls = [a, b, c].map(|distance| ball(p + ASLANT * distance, 0.1 * distance, false));
        views.push(View::new("three spheres in a row, elsewhere", p, balls.to_vec()));
    }
    // Around the point, and one ahead, before and after that in the list.
    for balls in [[(0.5, 2.0), (5.0, 0.6)], [(5.0, 0.6), (0.5, 2.0)]] {
        let balls = balls.map(|(distance, radius)| ball(ASLANT * distance, radius, radius > 1.0));
        views.push(View::new("inside a sphere, another one ahead", Vec3::ZERO, balls.to_vec()));
    }
    // Spheres alone, more than are looked up and fewer than there is a tree over.
    let around = |i: u32| Vec3::new(random(i, 1) - 0.5, random(i, 2) - 0.5, random(i, 3) - 0.5).normalize();
    let balls = (0..40).map(|i| ball(around(i) * (3.0 + 5.0 * random(i, 4)), 0.2 + 0.8 * random(i, 5), false));
    views.push(View::new("40 spheres", Vec3::ZERO, balls.collect()));
    for view in &mut views {
        let mut list = std::mem::take(&mut view.lights).list;
        for (i, light) in list.iter_mut().enumerate() {
            light.radiance = Vec3::new(1.0 + i as f32, 0.5, 100.0 - i as f32);
        }
        view.lights = Lights::new(list, Stop::NEVER).expect("nobody stops it");
    }
    views
}

/// What one light is in one direction, in f64.
#[derive(Clone, Copy, Debug)]
struct Hit {
    /// Distance.
    t: f64,
    /// On the side that emits.
    front: bool,
    /// Density of sampling this light there, per solid angle.
    density: f64,
}

/// Meets one light; the second number is how near the direction is to the light's rim, in radians or in shares of its
/// size: what rounding may decide.
fn hit(light: &BuiltLight, p: DVec3, dir: DVec3) -> (Option<Hit>, f64) {
    match light.shape {
        LightShape::Ball(ball) => {
            let (to, radius) = (ball.center.as_dvec3() - p, f64::from(ball.radius));
            let along = to.dot(dir);
            let half2 = radius * radius - (to - dir * along).length_squared();
            let inside = to.length() < radius;
            let margin = half2.abs() / (radius * radius);
            // A tangent from the surface: whether it is met is anybody's guess.
            let margin = if inside { 1.0 } else { margin.min(along.abs() / radius) };
            if half2 < 0.0 || !inside && along <= 0.0 {
                return (None, margin);
            }
            let sin2 = (radius / to.length()).powi(2).min(1.0);
            let one_minus_cos = sin2 / (1.0 + (1.0 - sin2).sqrt());
            let density = if inside { 1.0 / (4.0 * PI) } else { 1.0 / (TAU * one_minus_cos) };
            let t = if inside { along + half2.sqrt() } else { along - half2.sqrt() };
            (Some(Hit { t, front: inside == ball.inward, density }), margin)
        }
        LightShape::Facet(f) => {
            let [p0, e1, e2] = [f.p0, f.e1, f.e2].map(Vec3::as_dvec3);
            let normal = f.normal.as_dvec3();
            let cross = e1.cross(e2);
            let t = (p0 - p).dot(cross) / dir.dot(cross);
            let q = p + dir * t - p0;
            let u = q.cross(e2).dot(cross) / cross.length_squared();
            let v = e1.cross(q).dot(cross) / cross.length_squared();
            let rims = if f.quad { vec![u, v, 1.0 - u, 1.0 - v] } else { vec![u, v, 1.0 - u - v] };
            let margin = rims.iter().fold(f64::INFINITY, |m, r| m.min(r.abs()));
            if t <= 0.0 || rims.iter().any(|&r| r < 0.0) {
                return (None, margin);
            }
            let area = cross.length() * if f.quad { 1.0 } else { 0.5 };
            let cos = -normal.dot(dir);
            (Some(Hit { t, front: cos > 0.0, density: t * t / (cos.abs() * area) }), margin)
        }
    }
}

/// Directions at and around the lights, and everywhere.
fn directions(view: &View, count: u32) -> Vec<Vec3> {
    let any = |i: u32| {
        let z = 1.0 - 2.0 * random(i, 0);
        let (sin, cos) = (std::f32::consts::TAU * random(i, 1)).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * cos, r * sin, z)
    };
    let at = |i: u32| {
        let light = &view.lights.list[i as usize % view.lights.list.len()];
        let to = match light.shape {
            LightShape::Ball(b) => b.center + any(i) * (b.radius * 1.2 * random(i, 2)),
            LightShape::Facet(f) => f.p0 + f.e1 * (1.2 * random(i, 2) - 0.1) + f.e2 * (1.2 * random(i, 3) - 0.1),
        };
        (to - view.p).normalize()
    };
    (0..count).map(|i| if i % 4 == 0 { any(i) } else { at(i) }).collect()
}

#[test]
fn what_lies_in_a_direction() {
    let (mut met, mut overlaps, mut backs, mut missed) = (0, 0, 0, 0);
    for view in views() {
        for dir in directions(&view, 600) {
            let lights = &view.lights.list;
            let (p, w) = (view.p.as_dvec3(), dir.as_dvec3().normalize());
            let found: Vec<_> = lights.iter().map(|light| hit(light, p, w)).collect();
            // Directions are rounded to 6e-8, and lights may be that small.
            let size = |light: &BuiltLight| match light.shape {
                LightShape::Ball(b) => f64::from(b.radius) / f64::from((b.center - view.p).length().max(1e-9)),
                LightShape::Facet(_) => 1.0,
            };
            if found.iter().zip(lights).any(|((_, margin), light)| *margin < 1e-5 + 1e-6 / size(light)) {
                continue;
            }
            let hits: Vec<_> =
                found.iter().zip(lights).filter_map(|((hit, _), light)| hit.map(|hit| (hit, light))).collect();
            let pdf =
                hits.iter().filter(|(hit, _)| hit.front).map(|(hit, _)| hit.density).sum::<f64>() / lights.len() as f64;
            let nearest = hits.iter().min_by(|a, b| a.0.t.total_cmp(&b.0.t));
            if hits.len() > 1 {
                let mut t: Vec<f64> = hits.iter().map(|(hit, _)| hit.t).collect();
                t.sort_by(f64::total_cmp);
                if t[1] - t[0] < 1e-5 * t[1] {
                    continue;
                }
            }
            let radiance = match nearest {
                Some((hit, light)) if hit.front => light.radiance,
                _ => Vec3::ZERO,
            };
            let t = nearest.map_or(f64::INFINITY, |(hit, _)| hit.t);
            met += usize::from(hits.len() == 1);
            overlaps += usize::from(hits.len() > 1);
            backs += hits.iter().filter(|(hit, _)| !hit.front).count();
            missed += usize::from(hits.is_empty());
            let what = || format!("{}, direction {dir}: {hits:?}", view.name);
            for distances in [false, true] {
                let sight = once::look(&view.lights, splat(view.p), splat(dir), 1e-6, distances);
                let near = (f64::from(sight.pdf) - pdf).abs() <= 3e-5 * pdf;
                assert!(near, "{}: density {}, expected {pdf}", what(), sight.pdf);
                assert_eq!(d(sight.radiance), radiance.as_dvec3(), "{}, distances {distances}", what());
                if distances {
                    let found = f64::from(sight.t);
                    // Squared distances of order 1 are rounded to 1e-7, which a ray at a slope of 0.01 sees as 5e-6.
                    assert!(found == t || (found - t).abs() < 1e-5 * t + 5e-6, "{}: {found}, expected {t}", what());
                }
            }
        }
    }
    assert!(met > 5000 && overlaps > 300 && backs > 300 && missed > 1000, "{met}, {overlaps}, {backs}, {missed}");
}

/// From a light's own surface outwards nothing of it is met, and inwards only what lies beyond the least distance.
#[test]
fn rays_from_surfaces() {
    for inward in [false, true] {
        let sphere = ball(Vec3::ZERO, 2.0, inward);
        let lights = Lights::new(vec![sphere], Stop::NEVER).expect("nobody stops it");
        let look = |p: Vec3, dir: Vec3, t_min: f32| once::look(&lights, splat(p), splat(dir), t_min, true);
        // From just inside, the near side is behind and the far side ahead.
        let p = Vec3::new(0.0, 0.0, 1.999);
        for (dir, t) in [(Vec3::NEG_Z, 3.999f64), (Vec3::Z, 0.001), (Vec3::X, (4.0f64 - 1.999 * 1.999).sqrt())] {
            let sight = look(p, dir, 1e-5);
            assert!((f64::from(sight.t) - t).abs() < 1e-5, "inward {inward}, {dir}: {}, expected {t}", sight.t);
            assert_eq!(sight.pdf > 0.0, inward, "{dir}");
            assert_eq!(sight.radiance.x > 0.0, inward, "{dir}");
        }
        // A surface closer than the least distance is not met, from inside.
        for (dir, t_min, met) in [
            (Vec3::Z, 0.01, false),
            (Vec3::NEG_Z, 3.9, true),
            (Vec3::NEG_Z, 4.1, false),
            (Vec3::X, 0.05, true),
            (Vec3::X, 0.07, false),
        ] {
            let sight = look(p, dir, t_min);
            assert_eq!(sight.t < 10.0, met, "inward {inward}, {dir}, least distance {t_min}: {}", sight.t);
            assert_eq!(sight.pdf > 0.0, met && inward, "inward {inward}, {dir}, least distance {t_min}");
        }
        // From outside it has to lie ahead.
        let p = Vec3::new(0.0, 0.0, 2.5);
        let sight = look(p, Vec3::Z, 1e-5);
        assert!(sight.t > 10.0 && sight.pdf == 0.0 && sight.radiance.x == 0.0, "behind");
        let sight = look(p, Vec3::NEG_Z, 1e-5);
        assert!((sight.t - 0.5).abs() < 1e-5 && (sight.pdf > 0.0) != inward, "ahead: {}", sight.t);
    }
    // A facet is met beyond the least distance only.
    let corner = Vec3::new(-1.0, -1.0, 1.0);
    let facet = mislab_tests::light_scenes::facet(corner, Vec3::X * 3.0, Vec3::Y * 3.0, true, true);
    let lights = Lights::new(vec![facet], Stop::NEVER).expect("nobody stops it");
    for (t_min, met) in [(0.99, true), (1.01, false)] {
        let sight = once::look(&lights, splat(Vec3::ZERO), splat(Vec3::Z), t_min, true);
        assert_eq!(sight.pdf > 0.0 && sight.t < 2.0 && sight.radiance.x > 0.0, met, "least distance {t_min}");
    }
}

#[test]
fn samples_go_where_their_numbers_say() {
    for view in views() {
        let lights = &view.lights.list;
        let n = lights.len() as u32;
        let p = view.p.as_dvec3();
        for i in 0..300 {
            let random = numbers(i);
            let (wi, valid) = once::sample_light(&view.lights, splat(view.p), &random);
            let (wi, u) = (d(wi), random.get_2d(Dimension::Light).map(f64::from));
            // Each light with the same probability.
            let choice = (f64::from(random.get_1d(Dimension::LightChoice)) * f64::from(n)) as usize;
            let light = &lights[choice];
            let what = || format!("{}, sample {i} of light {choice}, numbers {u:?}: {wi}, valid {valid}", view.name);
            assert!((wi.length() - 1.0).abs() < 3e-7, "{}", what());
            match light.shape {
                LightShape::Ball(ball) => {
                    let (to, radius) = (ball.center.as_dvec3() - p, f64::from(ball.radius));
                    let inside = to.length() < radius;
                    assert_eq!(valid, inside == ball.inward, "{}", what());
                    // 1 - cos is uniform up to the rim of the cone, from inside up to 2.
                    let sin2 = (radius / to.length()).powi(2).min(1.0);
                    let rim = if inside { 2.0 } else { sin2 / (1.0 + (1.0 - sin2).sqrt()) };
                    let axis = if to.length() > 0.0 { to.normalize() } else { DVec3::Z };
                    let cos = axis.dot(wi);
                    let one_minus_cos =
                        if cos > 0.5 { axis.cross(wi).length_squared() / (1.0 + cos) } else { 1.0 - cos };
                    // Unit vectors are 1e-7 apart, which is much in a small cone; so is the distance in radii, which is
                    // much next to a sphere.
                    let tolerance = 3e-5 + 1e-6 / rim.sqrt();
                    assert!((one_minus_cos / rim - u[0]).abs() < tolerance, "{}: {}", what(), one_minus_cos / rim);
                }
                LightShape::Facet(f) => {
                    let [p0, e1, e2] = [f.p0, f.e1, f.e2].map(Vec3::as_dvec3);
                    let normal = f.normal.as_dvec3();
                    assert_eq!(valid, normal.dot(p0 - p) < 0.0, "{}", what());
                    let cross = e1.cross(e2);
                    let q = p + wi * ((p0 - p).dot(cross) / wi.dot(cross)) - p0;
                    let b = [q.cross(e2).dot(cross), e1.cross(q).dot(cross)].map(|b| b / cross.length_squared());
                    let expected = if f.quad || u[0] + u[1] <= 1.0 { u } else { [1.0 - u[0], 1.0 - u[1]] };
                    let tolerance = 1e-5 + 1e-6 * (p0 - p).length() / cross.length().sqrt();
                    let off = (b[0] - expected[0]).abs().max((b[1] - expected[1]).abs());
                    // Seen from aside a direction tells less about the point.
                    let grazing = (wi.dot(cross) / cross.length()).abs();
                    assert!(off * grazing < tolerance, "{}: {b:?}, expected {expected:?}", what());
                }
            }
        }
    }
}

#[test]
fn azimuths_around_spheres_are_uniform() {
    // The frame around a light's axis is nobody's business, but directions have to go around it evenly.
    for view in far_balls().into_iter().chain(near_balls()) {
        let LightShape::Ball(ball) = view.lights.list[0].shape else { panic!("{}: a sphere", view.name) };
        let to = (ball.center - view.p).as_dvec3();
        let axis = if to.length() > 0.0 { to.normalize() } else { DVec3::Z };
        let (t, b) = axis.any_orthonormal_pair();
        let mut count = [0u32; 8];
        for i in 0..800 {
            let (wi, _) = once::sample_light(&view.lights, splat(view.p), &numbers(i));
            let turn = d(wi).dot(b).atan2(d(wi).dot(t)) / TAU;
            count[((turn + 1.0).fract() * 8.0) as usize % 8] += 1;
        }
        // Eight binomials of mean 100 and deviation 9.4.
        assert!(count.iter().all(|c| (60..=140).contains(c)), "{}: {count:?}", view.name);
    }
}

#[test]
fn without_lights_nothing_is_sampled() {
    let lights = Lights::new(Vec::new(), Stop::NEVER).expect("nobody stops it");
    let Aim { wi, valid, .. } = lights.sample(Single, splat(Vec3::ZERO), &numbers(0));
    assert!(!valid && d(wi).is_normalized());
    for distances in [false, true] {
        let sight = once::look(&lights, splat(Vec3::ZERO), splat(Vec3::Z), 1e-5, distances);
        assert_eq!((sight.pdf, d(sight.radiance)), (0.0, DVec3::ZERO));
    }
}

/// The default scene with so many lights in sight, every third of them a triangle or rectangle; without `facets`, spheres.
fn crowd(count: usize, facets: bool) -> Scene {
    let mut scene = veach();
    let shapes: Vec<usize> = scene.light_shapes().collect();
    let model = scene.shapes[shapes[0]].clone();
    scene.shapes.retain(|shape| shape.light.is_none());
    for i in 0..count {
        let r = |k| random(i as u32, k);
        let at = Vec3::new(8.0 * r(0) - 4.0, 5.0 * r(1) - 2.5, 3.0 * r(2));
        let mut shape = model.clone();
        shape.reverse_orientation = i % 5 == 4;
        if facets && i % 3 == 0 {
            let [e1, e2] = [Vec3::new(0.9, 0.3 * r(3), 0.2 * r(4)), Vec3::new(-0.2 * r(5), 0.8, 0.3 * r(6))];
            let quad = i % 2 == 0;
            let mut positions = vec![at, at + e1, at + e1 + e2, at + e2];
            // Corners that sum exactly are one light.
            for p in &mut positions {
                *p = (*p * 256.0).round() / 256.0;
            }
            positions[2] = positions[1] + (positions[3] - positions[0]);
            let triangles = if quad { vec![[0, 1, 2], [0, 2, 3]] } else { vec![[0, 1, 3]] };
            shape.geometry = Geometry::Mesh { positions: Arc::new(positions), triangles: Arc::new(triangles) };
        } else {
            shape.geometry = Geometry::Sphere { center: at, radius: 0.1 + 0.4 * r(3) };
        }
        if let Some(light) = &mut shape.light {
            light.radiance = Vec3::new(1.0 + i as f32, 0.0, 100.0 - i as f32);
        }
        scene.shapes.push(shape);
    }
    scene
}

#[test]
fn lights_seen_directly() {
    let mut all = scenes();
    // As many as a list can hold, and more.
    all.extend([
        ("32 spheres", crowd(32, false)),
        ("32 lights", crowd(32, true)),
        ("33 lights", crowd(33, true)),
        ("50 lights", crowd(50, true)),
    ]);
    // In one patch of the picture, which then has all lights on its list, and in many.
    for (side, (name, scene)) in [8, 48].into_iter().flat_map(|side| all.iter().map(move |scene| (side, scene))) {
        let settings = independent(1, 1, [side; 2]);
        let world = World::new(scene);
        let built = BuiltScene::new(scene, &settings).expect("the scene can be built");
        let eye = built.camera.origin.as_dvec3();
        let (mut lit, mut skipped) = (0, 0);
        for pixel in 0..side * side {
            let [x, y] = [pixel % side, pixel / side];
            let corner = [x / 8 * 8, y / 8 * 8];
            let dir = built.camera.direction(Single, x as f32 + 0.5, y as f32 + 0.5);
            let w = d(dir).normalize();
            let (t, radiance) = world.look(eye, w);
            let (a, b) = w.any_orthonormal_pair();
            let edge = [a, -a, b, -b].iter().any(|off| world.look(eye, (w + *off * 3e-6).normalize()).1 != radiance);
            if edge {
                skipped += 1;
                continue;
            }
            let near = built.patches.cull(&built.camera, corner, corner.map(|c| c + 8));
            let hit = once::camera_hit(&built, dir, &near);
            let what = || {
                format!("{name}, pixel {x}, {y}: {} at {}, expected {radiance} at {t}", d(hit.emitted), d(hit.points.p))
            };
            assert_eq!(d(hit.emitted), radiance, "{}", what());
            assert_eq!(hit.emits, radiance != DVec3::ZERO, "{}", what());
            if hit.emits {
                assert!((d(hit.points.p) - (eye + w * t)).length() < 1e-4, "{}", what());
                lit += 1;
            }
        }
        assert!(
            (lit > 5 || side == 8 || *name == "no lights") && skipped < 20,
            "{name}: {lit} pixels show a light, {skipped} skipped"
        );
    }
}
