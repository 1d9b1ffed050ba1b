//! The oracle's BSDFs: Lambert and GGX or mirror lobes, in their textbook form.

use std::f64::consts::PI;

use glam::DVec3;
use mislab_kernel::request::scene::{self, Reflectance};

/// GGX widths below this are mirrors, by the renderer's documentation.
const MIRROR_ALPHA: f64 = 1e-3;

/// Scattering of a surface: Lambert and GGX or mirror lobes.
#[derive(Debug)]
pub struct Lobes {
    kd: DVec3,
    ks: DVec3,
    alpha: f64,
    fresnel: Fresnel,
    /// Probability that a BSDF sample is drawn from the specular lobe.
    specular_prob: f64,
}

#[derive(Debug)]
enum Fresnel {
    One,
    Dielectric { index: f64 },
    Metal { eta: DVec3, k: DVec3 },
}

impl Lobes {
    /// Those of a material; without one, none.
    pub fn new(material: Option<&scene::Bsdf>) -> Self {
        let none = Self { kd: DVec3::ZERO, ks: DVec3::ZERO, alpha: 1.0, fresnel: Fresnel::One, specular_prob: 0.0 };
        match material {
            None => none,
            Some(scene::Bsdf::Matte { kd }) => Self { kd: kd.as_dvec3(), ..none },
            Some(scene::Bsdf::Conductor { reflectance, alpha }) => {
                let (ks, fresnel) = match reflectance {
                    Reflectance::Constant(r) => (r.as_dvec3(), Fresnel::One),
                    Reflectance::Fresnel { eta, k } => {
                        (DVec3::ONE, Fresnel::Metal { eta: eta.as_dvec3(), k: k.as_dvec3() })
                    }
                };
                Self { ks, alpha: f64::from(*alpha), fresnel, specular_prob: 1.0, ..none }
            }
            Some(scene::Bsdf::Plastic { kd, ks, alpha, swapped_indices }) => {
                let (kd, ks) = (kd.as_dvec3(), ks.as_dvec3());
                let specular_prob = match (kd == DVec3::ZERO, ks == DVec3::ZERO) {
                    (false, false) => 0.5,
                    (true, false) => 1.0,
                    _ => 0.0,
                };
                let index = if *swapped_indices { 1.0 / 1.5 } else { 1.5 };
                Self { kd, ks, alpha: f64::from(*alpha), fresnel: Fresnel::Dielectric { index }, specular_prob }
            }
        }
    }

    /// True where the specular lobe is a delta.
    pub fn is_mirror(&self) -> bool {
        self.specular_prob > 0.0 && self.alpha < MIRROR_ALPHA
    }

    /// True where the specular lobe is so narrow that a coarse grid of directions could miss it.
    pub fn is_narrow(&self) -> bool {
        self.specular_prob > 0.0 && self.alpha < 0.015
    }

    /// What the delta of a mirror carries, per channel, at this cosine of incidence.
    pub fn mirror(&self, cos: f64) -> DVec3 {
        self.ks * self.fresnel(cos)
    }

    /// Probability that a BSDF sample is drawn from the specular lobe: 1, 0 or, with both, 1/2.
    pub fn specular_prob(&self) -> f64 {
        self.specular_prob
    }

    fn fresnel(&self, cos: f64) -> DVec3 {
        match self.fresnel {
            Fresnel::One => DVec3::ONE,
            Fresnel::Dielectric { index } => DVec3::splat(fresnel_complex(cos, index, 0.0)),
            Fresnel::Metal { eta, k } => DVec3::new(
                fresnel_complex(cos, eta.x, k.x),
                fresnel_complex(cos, eta.y, k.y),
                fresnel_complex(cos, eta.z, k.z),
            ),
        }
    }

    /// BSDF times cosine, and the density of the BSDF technique, per solid angle; without a mirror's delta.
    pub fn evaluate(&self, n: DVec3, wo: DVec3, wi: DVec3) -> (DVec3, f64) {
        let (cos_o, cos_i) = (n.dot(wo), n.dot(wi));
        if cos_o <= 0.0 || cos_i <= 0.0 {
            return (DVec3::ZERO, 0.0);
        }
        let mut bsdf = self.kd / PI;
        let mut pdf = (1.0 - self.specular_prob) * cos_i / PI;
        if self.specular_prob > 0.0 && !self.is_mirror() {
            let a2 = self.alpha * self.alpha;
            let h = (wo + wi).normalize();
            let cos_h = n.dot(h);
            let tan2 = |cos: f64| 1.0 / (cos * cos) - 1.0;
            // Trowbridge-Reitz, and Smith's Lambda (Heitz 2014, eqs. 71, 72).
            let d =
                1.0 / (PI * a2 * cos_h.powi(4) * (1.0 + n.cross(h).length_squared() / (cos_h * cos_h * a2)).powi(2));
            let lambda = |cos: f64| ((1.0 + a2 * tan2(cos)).sqrt() - 1.0) / 2.0;
            let g1 = 1.0 / (1.0 + lambda(cos_o));
            let g2 = 1.0 / (1.0 + lambda(cos_o) + lambda(cos_i));
            bsdf += self.ks * self.fresnel(wo.dot(h)) * (d * g2 / (4.0 * cos_o * cos_i));
            // Visible normals: D_v(h) = G1 max(0, wo.h) D / cos_o, and dh = dw / (4 wo.h).
            let visible_normals = g1 * wo.dot(h) * d / cos_o;
            pdf += self.specular_prob * visible_normals / (4.0 * wo.dot(h));
        }
        (bsdf * cos_i, pdf)
    }
}

/// Unpolarised Fresnel reflectance for an index `eta + i k`, in complex numbers throughout.
fn fresnel_complex(cos: f64, eta: f64, k: f64) -> f64 {
    type C = (f64, f64);
    let mul = |a: C, b: C| (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0);
    let div = |a: C, b: C| {
        let d = b.0 * b.0 + b.1 * b.1;
        ((a.0 * b.0 + a.1 * b.1) / d, (a.1 * b.0 - a.0 * b.1) / d)
    };
    let sqrt = |a: C| {
        let m = a.0.hypot(a.1);
        let re = ((m + a.0) / 2.0).max(0.0).sqrt();
        let im = ((m - a.0) / 2.0).max(0.0).sqrt();
        (re, if a.1 < 0.0 { -im } else { im })
    };
    let n = (eta, k);
    let sin2 = 1.0 - cos * cos;
    let s2 = div((sin2, 0.0), mul(n, n));
    // Cosine inside, by Snell's law.
    let cos_t = sqrt((1.0 - s2.0, -s2.1));
    let ratio = |a: C, b: C| {
        let q = div((a.0 - b.0, a.1 - b.1), (a.0 + b.0, a.1 + b.1));
        q.0 * q.0 + q.1 * q.1
    };
    let perpendicular = ratio((cos, 0.0), mul(n, cos_t));
    let parallel = ratio(mul(n, (cos, 0.0)), cos_t);
    (perpendicular + parallel) / 2.0
}
