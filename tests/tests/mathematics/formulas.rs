//! The small functions under the samplers, against their formulas in f64 at many places: what statistics cannot see.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};
use mislab_kernel::bsdf::{BuiltMaterial, Surface};
use mislab_kernel::lanes::{Single, V3};
use mislab_kernel::warp;
use mislab_renderer::{Bsdf, Reflectance};
use mislab_tests::charts::frame;
use mislab_tests::light_scenes::random;

use crate::once::{self, splat};

fn vec3(v: V3<Single>) -> Vec3 {
    Vec3::new(v.x, v.y, v.z)
}

#[test]
fn sine_and_cosine_of_turns() {
    let below_one = 1.0 - f32::EPSILON / 2.0;
    let sweep = (0..2_000_000).map(|i| i as f32 / 2_000_000.0);
    let edges = [0.125f32, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875].map(|u| [u.next_down(), u, u.next_up()]);
    for u in sweep.chain(edges.into_iter().flatten()).chain([below_one, 1.0]) {
        let (sin, cos) = warp::sin_cos_turns(Single, u);
        let (s, c) = (TAU * f64::from(u)).sin_cos();
        let error = (f64::from(sin) - s).abs().max((f64::from(cos) - c).abs());
        assert!(error < 2e-7, "u = {u}: {sin} and {cos}, expected {s} and {c}");
    }
}

#[test]
fn frames_are_orthonormal_and_right_handed() {
    let some = (0..100_000).map(|i| (Vec3::new(random(i, 0), random(i, 1), random(i, 2)) - 0.5).normalize());
    let axes = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z, Vec3::new(1e-4, -1e-4, -1.0)];
    for n in some.chain(axes) {
        let (t, b) = warp::frame(Single, splat(n));
        let (t, b) = (vec3(t), vec3(b));
        let off = (t.cross(b) - n).length().max((t.length() - 1.0).abs()).max((b.length() - 1.0).abs());
        assert!(off < 1e-6 && t.dot(b).abs() < 1e-6, "n = {n}: {t} and {b}");
    }
}

#[test]
fn cones_of_spheres_keep_their_precision() {
    for i in 0..=1600 {
        // (distance / radius)^2 = 1 / sin^2.
        let x = 10f32.powf(16.0 - i as f32 / 100.0).max(1.0);
        let sin2 = 1.0 / f64::from(x);
        let exact = (1.0 + (1.0 - sin2).sqrt()) / sin2;
        let found = f64::from(warp::inverse_one_minus_cos_of_sphere(Single, x));
        assert!((found / exact - 1.0).abs() < 3e-7, "1 / sin^2 {x:e}: {found:e}, expected {exact:e}");
    }
}

/// Metal of width `alpha` at a slanted surface, and a viewer at this cosine.
fn surface(material: &BuiltMaterial, cos: f64) -> (Surface<'_, Single>, Vec3, Vec3) {
    let n = DVec3::new(-0.48, 0.64, 0.6);
    let f = frame(n);
    let wo = (f * DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos)).as_vec3();
    let mirrored = (f * DVec3::new(-(1.0 - cos * cos).sqrt(), 0.0, cos)).as_vec3();
    (Surface { p: splat(Vec3::ZERO), n: splat(n.as_vec3()), material }, wo, mirrored)
}

#[test]
fn mirrors_have_one_direction_and_no_density() {
    let mut below = f32::from_bits(1e-3f32.to_bits() - 1);
    for _ in 0..3 {
        let bsdf = Bsdf::Conductor { reflectance: Reflectance::Constant(Vec3::splat(0.7)), alpha: below };
        for i in 1..=100 {
            let material = BuiltMaterial::new(&bsdf);
            let (s, wo, mirrored) = surface(&material, f64::from(i) / 100.0);
            let drawn = once::sample(&s, splat(wo), &once::numbers(i, 0));
            assert!(drawn.dirac && drawn.dirac_pmf == 1.0, "alpha {below}: a mirror");
            assert!((vec3(drawn.wi) - mirrored).length() < 3e-7, "{}, expected {mirrored}", vec3(drawn.wi));
            assert_eq!(vec3(drawn.dirac_f), Vec3::splat(0.7));
            let value = once::evaluate(&s, splat(wo), drawn.wi);
            assert_eq!((value.pdf, vec3(value.f_cos)), (0.0, Vec3::ZERO), "alpha {below}");
        }
        below /= 10.0;
    }
}

#[test]
fn fresnel_terms_are_the_textbook_ones() {
    // A mirror's coefficient is its Fresnel term. For real indices the equations of a dielectric hold for metals too.
    let reflectance = |cos: f64, eta: f64| {
        // All of it where there is no refracted ray.
        let cos_t = (1.0 - (1.0 - cos * cos) / (eta * eta)).max(0.0).sqrt();
        let parallel = (eta * cos - cos_t) / (eta * cos + cos_t);
        let across = (cos - eta * cos_t) / (cos + eta * cos_t);
        (parallel * parallel + across * across) / 2.0
    };
    let etas = Vec3::new(1.2, 1.5, 3.0);
    let metal = Bsdf::Conductor { reflectance: Reflectance::Fresnel { eta: etas, k: Vec3::ZERO }, alpha: 0.0 };
    let coat = Bsdf::Plastic { kd: Vec3::ZERO, ks: Vec3::ONE, alpha: 0.0, swapped_indices: false };
    let swapped = Bsdf::Plastic { kd: Vec3::ZERO, ks: Vec3::ONE, alpha: 0.0, swapped_indices: true };
    for i in 1..=1000 {
        let cos = f64::from(i) / 1000.0;
        for (bsdf, etas) in [(&metal, etas), (&coat, Vec3::splat(1.5)), (&swapped, Vec3::splat(1.0 / 1.5))] {
            let material = BuiltMaterial::new(bsdf);
            let (s, wo, _) = surface(&material, cos);
            let found = vec3(once::sample(&s, splat(wo), &once::numbers(i, 0)).dirac_f).as_dvec3();
            for k in 0..3 {
                let expected = reflectance(cos, etas[k].into());
                assert!(
                    (found[k] - expected).abs() < 3e-5,
                    "cos {cos}, eta {}: {}, expected {expected}",
                    etas[k],
                    found[k]
                );
            }
        }
    }
}
