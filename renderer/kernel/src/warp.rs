//! Maps from the unit square to directions, each beside its density.

use std::f32::consts::{FRAC_1_PI, PI, TAU};

use crate::lanes::{Lanes, Mask, Real, Uint, V3};

/// Sine and cosine of `2 pi u` for u in [0, 1], absolute error below 2e-7.
///
/// u is reduced to an eighth of a turn around the nearest quarter; Taylor polynomials of degree
/// 9 and 8 are exact to f32 there.
#[inline(always)]
pub fn sin_cos_turns<L: Lanes>(l: L, u: L::F) -> (L::F, L::F) {
    let quarter = (u * 4.0).round();
    let x = (u - quarter * 0.25) * TAU;
    let x2 = x * x;
    let sin = x
        * (x2.mul_add(
            x2.mul_add(
                x2.mul_add(x2.mul_add(l.f(1.0 / 362_880.0), l.f(-1.0 / 5040.0)), l.f(1.0 / 120.0)),
                l.f(-1.0 / 6.0),
            ),
            l.f(1.0),
        ));
    let cos = x2.mul_add(
        x2.mul_add(x2.mul_add(x2.mul_add(l.f(1.0 / 40_320.0), l.f(-1.0 / 720.0)), l.f(1.0 / 24.0)), l.f(-0.5)),
        l.f(1.0),
    );
    let q = quarter.to_uint();
    let odd = (q & l.u(1)).eq(l.u(1));
    let sin_negative = (q & l.u(2)).eq(l.u(2));
    let cos_negative = ((q + l.u(1)) & l.u(2)).eq(l.u(2));
    let s = odd.select(cos, sin);
    let c = odd.select(sin, cos);
    (sin_negative.select(-s, s), cos_negative.select(-c, c))
}

/// Two unit vectors that complete the unit vector `n` to a right-handed frame (Duff et al. 2017).
#[inline(always)]
pub fn frame<L: Lanes>(l: L, n: V3<L>) -> (V3<L>, V3<L>) {
    let sign = n.z.ge(l.f(0.0)).select(l.f(1.0), l.f(-1.0));
    let a = l.f(-1.0) / (sign + n.z);
    let b = n.x * n.y * a;
    let t = V3 { x: (sign * n.x * n.x).mul_add(a, l.f(1.0)), y: sign * b, z: -(sign * n.x) };
    let s = V3 { x: b, y: (n.y * n.y).mul_add(a, sign), z: -n.y };
    (t, s)
}

/// Cosine-weighted direction around +z (Malley's method); density [`cosine_hemisphere_pdf`].
#[inline(always)]
pub fn square_to_cosine_hemisphere<L: Lanes>(l: L, u: [L::F; 2]) -> V3<L> {
    let (sin, cos) = sin_cos_turns(l, u[1]);
    let r = u[0].sqrt();
    V3 { x: r * cos, y: r * sin, z: (l.f(1.0) - u[0]).max(l.f(0.0)).sqrt() }
}

/// `cos / pi` above the surface, 0 below; per solid angle.
#[inline(always)]
pub fn cosine_hemisphere_pdf<L: Lanes>(l: L, cos: L::F) -> L::F {
    cos.max(l.f(0.0)) * FRAC_1_PI
}

/// Uniform direction in the cone around +z whose rim is at `1 - cos = one_minus_cos`;
/// density [`cone_pdf`]. Worked in `1 - cos`, which f32 keeps exact for the smallest cones.
#[inline(always)]
pub fn square_to_cone<L: Lanes>(l: L, u: [L::F; 2], one_minus_cos: L::F) -> V3<L> {
    let (sin, cos) = sin_cos_turns(l, u[1]);
    let h = u[0] * one_minus_cos;
    let r = (h * (l.f(2.0) - h)).max(l.f(0.0)).sqrt();
    V3 { x: r * cos, y: r * sin, z: l.f(1.0) - h }
}

/// `1 / (2 pi (1 - cos))` inside the cone, per solid angle, from `1 / (1 - cos)`. The caller decides
/// what is inside.
#[inline(always)]
pub fn cone_pdf<L: Lanes>(inverse_one_minus_cos: L::F) -> L::F {
    inverse_one_minus_cos * (1.0 / (2.0 * PI))
}

/// Density of directions that are uniform over the whole sphere, per solid angle.
pub const SPHERE_PDF: f32 = 1.0 / (4.0 * PI);

/// `1 / (1 - cos)` of the rim of the cone that a sphere fills, from `x = (distance / radius)^2 >= 1`.
///
/// Since `sin^2 = 1 / x`, it is `(1 + cos) / sin^2 = x + sqrt(x (x - 1))`: no cancellation for the
/// smallest lights, and no division. From 32 radii on, `2 x - 1/2` is the same to 6e-8, has no root
/// and does not overflow.
#[inline(always)]
pub fn inverse_one_minus_cos_of_sphere<L: Lanes>(l: L, x: L::F) -> L::F {
    let far = x.gt(l.f(1024.0));
    let mut inverse = x * 2.0 - 0.5;
    if !far.all() {
        let near = x + (x * (x - 1.0)).max(l.f(0.0)).sqrt();
        inverse = far.select(inverse, near);
    }
    inverse
}

/// Barycentric coordinates (b1, b2), uniform over a triangle: the square folded along its diagonal.
#[inline(always)]
pub fn square_to_triangle<L: Lanes>(l: L, u: [L::F; 2]) -> [L::F; 2] {
    let beyond = (u[0] + u[1]).gt(l.f(1.0));
    [beyond.select(l.f(1.0) - u[0], u[0]), beyond.select(l.f(1.0) - u[1], u[1])]
}

/// A visible GGX normal around +z for the direction `wo` (z > 0) and width `alpha`, by spherical
/// caps (Dupuy and Benyoub 2023); density `D_v(h)`, see [`crate::bsdf`]. Not of unit length.
#[inline(always)]
pub fn square_to_visible_normal<L: Lanes>(l: L, u: [L::F; 2], wo: V3<L>, alpha: L::F) -> V3<L> {
    let stretched = V3 { x: wo.x * alpha, y: wo.y * alpha, z: wo.z }.normalize(l);
    let (sin, cos) = sin_cos_turns(l, u[1]);
    // z is uniform in (-wo.z, 1]; 1 - z^2 = (1 - z)(1 + z), with 1 - z = u0 (1 + wo.z).
    let one_minus_z = u[0] * (stretched.z + 1.0);
    let r = (one_minus_z * (l.f(2.0) - one_minus_z)).max(l.f(0.0)).sqrt();
    let cap = V3 { x: r * cos, y: r * sin, z: l.f(1.0) - one_minus_z };
    let h = cap + stretched;
    V3 { x: h.x * alpha, y: h.y * alpha, z: h.z }
}
