//! The maps from the unit square, inverted: a map with a density is uniform in its own distribution functions, so that
//! each point of the square has to be found again from the direction that it went to.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use mislab_kernel::lanes::{Single, V3};
use mislab_kernel::warp;

use crate::once::d;

/// Points of the unit square, corners and edges among them.
fn square() -> impl Iterator<Item = [f32; 2]> {
    let side = |i: u32| (i as f32 / 40.0).min(1.0 - f32::EPSILON / 2.0);
    (0..=40).flat_map(move |i| (0..=40).map(move |j| [side(i), side(j)]))
}

/// Fails unless the direction's azimuth is the turn `u`, to 1e-6 of the direction's length across the pole.
pub fn assert_turn(at: DVec3, u: f32, what: impl Fn() -> String) {
    let across = at.truncate();
    let (sin, cos) = (TAU * f64::from(u)).sin_cos();
    let off = (across.x * sin - across.y * cos).abs();
    let along = across.x * cos + across.y * sin;
    assert!(off <= 1e-6 * across.length() && along >= 0.0, "{}: {at} has another azimuth than {u} turns", what());
}

#[test]
fn cosine_weighted_directions() {
    for u in square() {
        let w = d(warp::square_to_cosine_hemisphere(Single, u));
        // Probability of a smaller angle: sin^2.
        let found = w.truncate().length_squared();
        assert!((found - f64::from(u[0])).abs() < 1e-6 && (w.length() - 1.0).abs() < 1e-6 && w.z >= 0.0, "{u:?}: {w}");
        assert_turn(w, u[1], || format!("{u:?}"));
    }
    for i in -100..=100 {
        let cos = i as f32 / 100.0;
        let expected = f64::from(cos).max(0.0) / PI;
        let found = f64::from(warp::cosine_hemisphere_pdf(Single, cos));
        assert!((found - expected).abs() < 1e-7, "cos {cos}: {found}, expected {expected}");
    }
}

#[test]
fn directions_in_cones() {
    for one_minus_cos in [1e-14f32, 1e-8, 1e-3, 0.3, 1.0, 1.7, 2.0] {
        for u in square() {
            let w = d(warp::square_to_cone(Single, u, one_minus_cos));
            // Probability of a smaller angle: (1 - cos) / (1 - cos of the rim). From sin^2 = (1 - cos)(1 + cos)
            // where the cosine is rounded to 1.
            let h = f64::from(u[0]) * f64::from(one_minus_cos);
            let sin2 = h * (2.0 - h);
            assert!((w.truncate().length_squared() - sin2).abs() <= 2e-6 * sin2 + 1e-30, "{u:?}, {one_minus_cos}: {w}");
            assert!((w.z - (1.0 - h)).abs() < 2e-7, "{u:?}, {one_minus_cos}: {w}");
            assert_turn(w, u[1], || format!("{u:?}, {one_minus_cos}"));
        }
        // Uniform: one over the solid angle.
        let found = f64::from(warp::cone_pdf::<Single>(1.0 / one_minus_cos));
        let solid_angle = TAU * f64::from(one_minus_cos);
        assert!((found * solid_angle - 1.0).abs() < 3e-7, "1 - cos {one_minus_cos}: {found}");
    }
}

#[test]
fn triangles_are_covered_evenly() {
    // The centres of n x n cells go to the centres of cells of the triangle: two to each, one on the diagonal.
    let n = 64;
    let mut count = vec![0; n * n];
    for i in 0..n {
        for j in 0..n {
            let at = |k: usize| (k as f32 + 0.5) / n as f32;
            let [b1, b2] = warp::square_to_triangle(Single, [at(i), at(j)]);
            assert!(b1 >= 0.0 && b2 >= 0.0 && b1 + b2 <= 1.0, "{b1} and {b2} lie outside");
            count[(b1 * n as f32) as usize * n + (b2 * n as f32) as usize] += 1;
        }
    }
    for i in 0..n {
        for j in 0..n {
            let expected = match (i + j).cmp(&(n - 1)) {
                std::cmp::Ordering::Less => 2,
                std::cmp::Ordering::Equal => 1,
                std::cmp::Ordering::Greater => 0,
            };
            assert_eq!(count[i * n + j], expected, "cell {i}, {j}");
        }
    }
}

/// Where a visible normal `h` (of any length) of the viewer `wo` came from: 1 - z of the direction in which it mirrors
/// the viewer, as a share of the spherical cap's 1 + z of the viewer, after the stretch that makes the surface a
/// hemisphere; and that direction (Dupuy and Benyoub 2023).
pub fn origin_of_visible_normal(h: DVec3, wo: DVec3, alpha: f64) -> (f64, DVec3) {
    let h = DVec3::new(h.x / alpha, h.y / alpha, h.z).normalize();
    let wo = DVec3::new(wo.x * alpha, wo.y * alpha, wo.z).normalize();
    let cap = h * (2.0 * wo.dot(h)) - wo;
    ((1.0 - cap.z) / (1.0 + wo.z), cap)
}

#[test]
fn visible_normals() {
    for alpha in [1e-3f32, 0.02, 0.3, 1.0] {
        for wo in [DVec3::Z, DVec3::new(0.6, 0.0, 0.8), DVec3::new(-0.3, 0.8, 0.2), DVec3::new(0.1, -0.99, 0.01)] {
            let wo = wo.normalize();
            let w = wo.as_vec3();
            // Normals are rounded to 1e-7, and the stretch magnifies what is across.
            let tolerance = 2e-6 + 1e-7 / f64::from(alpha);
            // At u0 = 1 the normal is the difference of two equal vectors.
            for u in square().filter(|u| u[0] < 0.99) {
                let h = d(warp::square_to_visible_normal(Single, u, V3 { x: w.x, y: w.y, z: w.z }, alpha));
                let (found, cap) = origin_of_visible_normal(h, wo, alpha.into());
                assert!((found - f64::from(u[0])).abs() < 2e-6, "alpha {alpha}, {wo}, {u:?}: {found}");
                let (sin, cos) = (TAU * f64::from(u[1])).sin_cos();
                assert!((cap.x * sin - cap.y * cos).abs() < tolerance, "alpha {alpha}, {wo}, {u:?}: {cap}");
                assert!(cap.x * cos + cap.y * sin > -tolerance, "alpha {alpha}, {wo}, {u:?}: {cap}");
            }
        }
    }
}
