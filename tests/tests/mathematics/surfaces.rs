//! BSDFs, their densities and their samples, direction by direction.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};
use mislab_kernel::bsdf::{BuiltMaterial, Surface};
use mislab_kernel::lanes::Single;
use mislab_kernel::sampler::{Dimension, Numbers};
use mislab_kernel::warp;
use mislab_renderer::{Bsdf, Reflectance};
use mislab_tests::charts::frame;
use mislab_tests::light_scenes::random;
use mislab_tests::lobes::Lobes;

use crate::once::{self, d, v3};
use crate::warps::origin_of_visible_normal;

fn gold() -> Reflectance {
    Reflectance::Fresnel { eta: Vec3::new(0.14, 0.37, 1.44), k: Vec3::new(3.98, 2.39, 1.6) }
}

/// Materials of all kinds, with lobes of this width.
fn materials(alpha: f32) -> Vec<Bsdf> {
    let (kd, ks) = (Vec3::new(0.2, 0.5, 0.7), Vec3::new(0.9, 0.4, 0.1));
    let aluminium = Reflectance::Fresnel { eta: Vec3::new(1.66, 0.88, 0.52), k: Vec3::new(9.22, 6.27, 4.84) };
    vec![
        Bsdf::Matte { kd },
        Bsdf::Matte { kd: Vec3::ZERO },
        Bsdf::Conductor { reflectance: Reflectance::Constant(ks), alpha },
        Bsdf::Conductor { reflectance: gold(), alpha },
        Bsdf::Conductor { reflectance: aluminium, alpha },
        Bsdf::Plastic { kd, ks, alpha, swapped_indices: false },
        Bsdf::Plastic { kd: Vec3::ZERO, ks, alpha, swapped_indices: false },
        Bsdf::Plastic { kd, ks: Vec3::ZERO, alpha, swapped_indices: false },
    ]
}

/// 1e-3 is the narrowest lobe that is not a mirror.
const ALPHAS: [f32; 6] = [0.0, 1e-3, 0.02, 0.1, 0.4, 1.0];

/// A normal that is no axis of anything.
const NORMAL: DVec3 = DVec3::new(-0.48, 0.64, 0.6);

/// A direction at this cosine to the normal.
fn direction(cos: f64, turn: f64) -> DVec3 {
    let (sin_phi, cos_phi) = (TAU * turn).sin_cos();
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    frame(NORMAL) * DVec3::new(sin * cos_phi, sin * sin_phi, cos)
}

fn numbers(i: u32) -> Numbers<Single> {
    once::numbers(0x5eed, i)
}

#[test]
fn lobes_that_a_material_has() {
    let (none, some) = (Vec3::ZERO, Vec3::new(0.0, 0.0, 0.1));
    for (bsdf, diffuse, specular) in [
        (Bsdf::Matte { kd: none }, false, false),
        (Bsdf::Matte { kd: some }, true, false),
        (Bsdf::Conductor { reflectance: Reflectance::Constant(none), alpha: 0.1 }, false, false),
        (Bsdf::Conductor { reflectance: Reflectance::Constant(some), alpha: 0.1 }, false, true),
        (Bsdf::Conductor { reflectance: gold(), alpha: 0.1 }, false, true),
        (Bsdf::Plastic { kd: none, ks: none, alpha: 0.1, swapped_indices: false }, false, false),
        (Bsdf::Plastic { kd: some, ks: none, alpha: 0.1, swapped_indices: false }, true, false),
        (Bsdf::Plastic { kd: none, ks: some, alpha: 0.1, swapped_indices: false }, false, true),
        (Bsdf::Plastic { kd: some, ks: some, alpha: 0.1, swapped_indices: false }, true, true),
    ] {
        let material = BuiltMaterial::new(&bsdf);
        assert_eq!(material.has_two_lobes(), diffuse && specular, "{bsdf:?}");
        assert_eq!(material.scatters(), diffuse || specular, "{bsdf:?}");
    }
    assert!(!BuiltMaterial::BLACK.scatters() && !BuiltMaterial::BLACK.has_two_lobes());
}

#[test]
fn bsdfs_and_densities_are_the_textbook_ones() {
    for alpha in ALPHAS {
        for bsdf in materials(alpha) {
            let (material, lobes) = (BuiltMaterial::new(&bsdf), Lobes::new(Some(&bsdf)));
            let s = Surface { p: v3(DVec3::ZERO), n: v3(NORMAL), material: &material };
            for i in 0..400 {
                let r = |k| f64::from(random(i, k));
                let wo = direction(0.03 + 0.97 * r(0), r(1));
                // Every other direction lies in the lobe: the half vector about as far from the normal as it is wide.
                let tan = 1.5 * f64::from(alpha) * r(2);
                let h = frame(NORMAL) * DVec3::new(tan * (TAU * r(3)).cos(), tan * (TAU * r(3)).sin(), 1.0).normalize();
                let mirrored = h * (2.0 * wo.dot(h)) - wo;
                let wi = if i % 2 == 0 { mirrored } else { direction(0.03 + 0.97 * r(2), r(3)) };
                // What the renderer is given is rounded: so is what the formulas are asked for.
                let (wo, wi) = (wo.as_vec3().as_dvec3(), wi.as_vec3().as_dvec3());
                let n = NORMAL.as_vec3().as_dvec3();
                if n.dot(wi).abs() < 1e-3 {
                    continue;
                }
                let found = once::evaluate(&s, v3(wo), v3(wi));
                let (f_cos, pdf) = lobes.evaluate(n, wo, wi);
                // The half vector is rounded to 1e-7, which is that much over alpha of the lobe's width.
                let tolerance = 2e-5 + 1e-6 / f64::from(alpha).max(1e-3);
                let near = |a: f32, b: f64| (f64::from(a) - b).abs() <= tolerance * b;
                let right =
                    near(found.f_cos.x, f_cos.x) && near(found.f_cos.y, f_cos.y) && near(found.f_cos.z, f_cos.z);
                let what = || format!("{bsdf:?}, wo {wo}, wi {wi}");
                assert!(right, "{}: {}, expected {f_cos}", what(), d(found.f_cos));
                // A surface that scatters nothing has no density to speak of.
                assert!(
                    near(found.pdf, pdf) || !material.scatters(),
                    "{}: density {}, expected {pdf}",
                    what(),
                    found.pdf
                );
            }
        }
    }
}

#[test]
fn nothing_comes_from_below() {
    for alpha in ALPHAS {
        for bsdf in materials(alpha) {
            let material = BuiltMaterial::new(&bsdf);
            let s = Surface { p: v3(DVec3::ZERO), n: v3(NORMAL), material: &material };
            for i in 0..100 {
                let r = |k| f64::from(random(i, k));
                let (above, below) = (direction(0.01 + 0.99 * r(0), r(1)), direction(-0.01 - 0.99 * r(2), r(3)));
                for (wo, wi) in [(above, below), (below, above), (below, -above)] {
                    let found = once::evaluate(&s, v3(wo), v3(wi));
                    assert_eq!((found.pdf, d(found.f_cos)), (0.0, DVec3::ZERO), "{bsdf:?}, wo {wo}, wi {wi}");
                }
            }
        }
    }
}

/// What is asked of a sample: which lobe it came from, and that the two random numbers can be found again from it.
#[test]
fn samples_are_those_of_their_lobe() {
    for alpha in ALPHAS {
        for bsdf in materials(alpha) {
            let (material, lobes) = (BuiltMaterial::new(&bsdf), Lobes::new(Some(&bsdf)));
            if !material.scatters() {
                continue;
            }
            let s = Surface { p: v3(DVec3::ZERO), n: v3(NORMAL), material: &material };
            let (t, b) = warp::frame(Single, s.n);
            let mut specular = 0u32;
            const COUNT: u32 = 1000;
            for i in 0..COUNT {
                let wo = direction(0.03 + 0.97 * f64::from(random(i, 0)), f64::from(random(i, 1)));
                let random = numbers(i);
                let drawn = once::sample(&s, v3(wo), &random);
                let u = random.get_2d(Dimension::Bsdf).map(f64::from);
                let local = |w: DVec3| DVec3::new(d(t).dot(w), d(b).dot(w), NORMAL.dot(w));
                let (wi, wo) = (local(d(drawn.wi)), local(wo));
                let what = || format!("{bsdf:?}, sample {i}, wo {wo}, wi {wi}");
                assert!((wi.length() - 1.0).abs() < 1e-6, "{}", what());
                assert_eq!(f64::from(drawn.dirac_pmf), lobes.specular_prob(), "{}", what());
                let (sin, cos) = (TAU * u[1]).sin_cos();
                let turned = |w: DVec3, tolerance: f64| {
                    (w.x * sin - w.y * cos).abs() < tolerance && w.x * cos + w.y * sin > -tolerance
                };
                let is_diffuse =
                    (wi.truncate().length_squared() - u[0]).abs() < 2e-6 && wi.z >= 0.0 && turned(wi, 2e-6);
                if lobes.is_mirror() {
                    let mirrored = DVec3::new(-wo.x, -wo.y, wo.z);
                    assert!(drawn.dirac == ((wi - mirrored).length() < 1e-6), "{}", what());
                    assert!(drawn.dirac || is_diffuse && lobes.specular_prob() < 1.0, "{}", what());
                    let f = lobes.mirror(wo.z);
                    assert!((d(drawn.dirac_f) - f).length() < 1e-5, "{}: {}, expected {f}", what(), d(drawn.dirac_f));
                    specular += u32::from(drawn.dirac);
                } else {
                    assert!(!drawn.dirac, "{}", what());
                    let (origin, cap) = origin_of_visible_normal(wo + wi, wo, alpha.into());
                    let tolerance = 2e-5 + 2e-6 / f64::from(alpha).max(1e-3);
                    let is_specular = (origin - u[0]).abs() < tolerance && turned(cap, tolerance);
                    assert!(
                        is_specular && lobes.specular_prob() > 0.0 || is_diffuse && lobes.specular_prob() < 1.0,
                        "{}",
                        what()
                    );
                    specular += u32::from(!is_diffuse);
                }
            }
            // Binomial: four standard deviations.
            let (n, p) = (f64::from(COUNT), lobes.specular_prob());
            let off = f64::from(specular) - n * p;
            assert!(
                off.abs() <= 4.0 * (n * p * (1.0 - p)).sqrt() + 1.0,
                "{bsdf:?}: {specular} of {COUNT} samples are specular"
            );
        }
    }
}

#[test]
fn metals_reflect_as_complex_numbers_say() {
    for (eta, k) in [(0.14f32, 3.98f32), (0.37, 2.39), (1.44, 1.6), (2.5, 0.3), (0.2, 0.3), (9.0, 12.0), (1.0, 300.0)] {
        let (etas, ks) = (Vec3::new(eta, 1.5 * eta, 1.2), Vec3::new(k, 2.0, k));
        let bsdf = Bsdf::Conductor { reflectance: Reflectance::Fresnel { eta: etas, k: ks }, alpha: 0.0 };
        let (material, lobes) = (BuiltMaterial::new(&bsdf), Lobes::new(Some(&bsdf)));
        let s = Surface { p: v3(DVec3::ZERO), n: v3(NORMAL), material: &material };
        for i in 1..=200 {
            let cos = f64::from(i) / 200.0;
            let wo = direction(cos, 0.3);
            let found = d(once::sample(&s, v3(wo), &numbers(i)).dirac_f);
            let expected = lobes.mirror(cos);
            assert!((found - expected).abs().max_element() < 3e-5, "{bsdf:?}, cos {cos}: {found}, expected {expected}");
        }
    }
}

/// Metals that lose less than a millionth at normal incidence, and absorb within 1e-4 wavelengths, reflect all.
#[test]
fn metals_that_reflect_nearly_all_reflect_all() {
    for (eta, k) in [
        (1.0f32, 1e4f32),
        (20.0, 1e4),
        (24.9, 1e4),
        (25.000_163, 1e4),
        (25.1, 1e4),
        (30.0, 1e4),
        (60.0, 1e4),
        (1e4, 1e4),
        (1e6, 1e4),
        (1e7, 1e4),
        (1e7, 9.99e3),
        (1.5, 9.99e3),
        (1.5, 1e5),
        (2000.0, 1e5),
        (3000.0, 1e5),
        (1.5, 1e9),
    ] {
        let (e, a) = (f64::from(eta), f64::from(k));
        let lost = 4.0 * e / ((e + 1.0).powi(2) + a * a);
        // Where the reflectance is least, near grazing, the difference is plain.
        let cos = 1.0 / e.hypot(a);
        for channel in 0..3 {
            // The other channels reflect all.
            let (mut etas, mut ks) = (Vec3::ONE, Vec3::splat(1e6));
            (etas[channel], ks[channel]) = (eta, k);
            let bsdf = Bsdf::Conductor { reflectance: Reflectance::Fresnel { eta: etas, k: ks }, alpha: 0.0 };
            let material = BuiltMaterial::new(&bsdf);
            let s = Surface { p: v3(DVec3::ZERO), n: v3(NORMAL), material: &material };
            let found = d(once::sample(&s, v3(direction(cos, 0.3)), &numbers(0)).dirac_f);
            assert_eq!(found == DVec3::ONE, k >= 1e4 && lost < 1e-6, "eta {eta}, k {k}, {lost:e} lost: {found}");
        }
    }
}
