//! Surfaces: what the BSDF and its sampling density are, and how to draw from it.
//!
//! One description serves all materials: a Lambert lobe `kd`, a specular lobe `ks` times a Fresnel
//! term, either of them absent. The specular lobe is a GGX distribution of width alpha or, below
//! [`MIRROR_ALPHA`], a perfect mirror.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use crate::lanes::{Lanes, Mask, Real, Single, V3};
use crate::request::scene::{Bsdf, Reflectance};
use crate::sampler::{Dimension, Numbers};
use crate::warp;

/// GGX widths below this are treated as a mirror: f32 cannot resolve the lobe.
pub const MIRROR_ALPHA: f32 = 1e-3;

/// Index of refraction of plastic's coat (pbrt-v3).
const PLASTIC_IOR: f32 = 1.5;

/// The material of one surface, in the form that lanes are filled from.
#[derive(Clone, Copy, Debug)]
pub struct BuiltMaterial {
    kd: Vec3,
    ks: Vec3,
    alpha: f32,
    fresnel: Fresnel,
    has_diffuse: bool,
    has_specular: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Fresnel {
    One,
    /// From air into plastic.
    Dielectric,
    /// From plastic into air, see [`Bsdf::Plastic`].
    InsideDielectric,
    Conductor {
        eta: Vec3,
        k: Vec3,
    },
}

impl BuiltMaterial {
    /// Absorbs everything.
    pub const BLACK: Self = Self {
        kd: Vec3::ZERO,
        ks: Vec3::ZERO,
        alpha: 1.0,
        fresnel: Fresnel::One,
        has_diffuse: false,
        has_specular: false,
    };

    /// Translates a scene's material.
    pub fn new(bsdf: &Bsdf) -> Self {
        let built = match *bsdf {
            Bsdf::Matte { kd } => Self { kd, ..Self::BLACK },
            Bsdf::Conductor { ref reflectance, alpha } => match *reflectance {
                Reflectance::Constant(ks) => Self { ks, alpha, ..Self::BLACK },
                Reflectance::Fresnel { eta, k } if reflects_all(eta, k) => Self { ks: Vec3::ONE, alpha, ..Self::BLACK },
                Reflectance::Fresnel { eta, k } => {
                    Self { ks: Vec3::ONE, alpha, fresnel: Fresnel::Conductor { eta, k }, ..Self::BLACK }
                }
            },
            Bsdf::Plastic { kd, ks, alpha, swapped_indices } => {
                let fresnel = if swapped_indices { Fresnel::InsideDielectric } else { Fresnel::Dielectric };
                Self { kd, ks, alpha, fresnel, ..Self::BLACK }
            }
        };
        Self { has_diffuse: built.kd != Vec3::ZERO, has_specular: built.ks != Vec3::ZERO, ..built }
    }

    /// True for a diffuse and a specular lobe, of which a sample chooses one.
    pub fn has_two_lobes(&self) -> bool {
        self.has_diffuse && self.has_specular
    }

    /// What it reflects at normal incidence, per channel: `kd + ks F`.
    pub fn at_normal_incidence(&self) -> Vec3 {
        let V3 { x, y, z } = self.specular(Single, 4.0);
        self.kd + Vec3::new(x, y, z)
    }

    /// All its numbers: kd, ks, alpha, the kind of Fresnel term, eta and k. Two materials with the same ones are the same.
    pub fn numbers(&self) -> [f32; 14] {
        let Self { kd, ks, alpha, fresnel, has_diffuse: _, has_specular: _ } = self;
        let (kind, eta, k) = match *fresnel {
            Fresnel::One => (0.0, Vec3::ZERO, Vec3::ZERO),
            Fresnel::Dielectric => (1.0, Vec3::ZERO, Vec3::ZERO),
            Fresnel::InsideDielectric => (2.0, Vec3::ZERO, Vec3::ZERO),
            Fresnel::Conductor { eta, k } => (3.0, eta, k),
        };
        [kd.x, kd.y, kd.z, ks.x, ks.y, ks.z, *alpha, kind, eta.x, eta.y, eta.z, k.x, k.y, k.z]
    }

    /// False for a surface that scatters nothing.
    pub fn scatters(&self) -> bool {
        self.has_diffuse || self.has_specular
    }
}

/// True for a metal whose Fresnel reflectance is 1 to 1e-6 at every angle that matters: its least
/// value is near grazing, at `cos = 1 / |eta + i k|`, far below what a pixel shows, if k is huge.
fn reflects_all(eta: Vec3, k: Vec3) -> bool {
    let normal = |eta: f32, k: f32| {
        let (eta, k) = (f64::from(eta), f64::from(k));
        4.0 * eta / ((eta + 1.0).powi(2) + k * k)
    };
    (0..3).all(|c| k[c] >= 1e4 && normal(eta[c], k[c]) < 1e-6)
}

/// Points of one surface that a packet of camera rays hit.
#[derive(Clone, Copy)]
pub struct Surface<'a, L: Lanes> {
    /// Position.
    pub p: V3<L>,
    /// Unit normal on the viewer's side.
    pub n: V3<L>,
    /// What it is made of, the same in all lanes.
    pub material: &'a BuiltMaterial,
}

impl<'a, L: Lanes> Surface<'a, L> {
    /// Points with these normals, on either side, met by rays in directions `dir`. Both sides of a surface scatter alike.
    #[inline(always)]
    pub fn new(l: L, p: V3<L>, n: V3<L>, dir: V3<L>, material: &'a BuiltMaterial) -> Self {
        let n = V3::select(n.dot(dir).gt(l.f(0.0)), -n, n);
        Self { p, n, material }
    }
}

impl BuiltMaterial {
    /// GGX width of the specular lobe; `None` without one.
    pub fn alpha(&self) -> Option<f32> {
        self.has_specular.then_some(self.alpha)
    }

    /// True where the specular lobe is a Dirac delta.
    #[inline(always)]
    pub fn is_dirac(&self) -> bool {
        self.has_specular && self.alpha < MIRROR_ALPHA
    }

    /// Probability that a BSDF sample is drawn from the specular lobe: 1, 0 or, with both, 1/2.
    #[inline(always)]
    fn specular_prob(&self) -> f32 {
        match (self.has_specular, self.has_diffuse) {
            (true, true) => 0.5,
            (true, false) => 1.0,
            (false, _) => 0.0,
        }
    }

    /// Colour of the specular lobe times the Fresnel reflectance, from twice the cosine between the half
    /// vector and either direction, squared.
    #[inline(always)]
    fn specular<L: Lanes>(&self, l: L, four_cos2: L::F) -> V3<L> {
        let ks = V3::splat(l, self.ks);
        match self.fresnel {
            Fresnel::One => ks,
            Fresnel::Dielectric => ks * fresnel_dielectric(l, four_cos2.sqrt() * 0.5, PLASTIC_IOR),
            Fresnel::InsideDielectric => ks * fresnel_dielectric(l, four_cos2.sqrt() * 0.5, 1.0 / PLASTIC_IOR),
            Fresnel::Conductor { eta, k } => {
                let cos = four_cos2.sqrt() * 0.5;
                ks.times(V3 {
                    x: fresnel_conductor(l, cos, eta.x, k.x),
                    y: fresnel_conductor(l, cos, eta.y, k.y),
                    z: fresnel_conductor(l, cos, eta.z, k.z),
                })
            }
        }
    }
}

/// The smooth part of a BSDF at one pair of directions.
pub struct BsdfValue<L: Lanes> {
    /// `bsdf(wo, wi) cos(wi)` in 1/sr, without Dirac lobes.
    pub f_cos: V3<L>,
    /// Density of [`sample`] at `wi`, per solid angle, without Dirac lobes.
    pub pdf: L::F,
}

/// BSDF times cosine and density of the BSDF technique at `wi`; both 0 below the surface, and 0
/// from Dirac lobes, which no given direction hits.
///
/// GGX with Smith's height-correlated masking (Heitz 2014, eq. 99) and visible normals
/// (Heitz 2018): `f cos = D F G2 / (4 cos_o)`, `p = D G1 / (4 cos_o)`. With
/// `s = sqrt(alpha^2 + (1 - alpha^2) cos^2)`, `G1 = 2 cos_o / (cos_o + s_o)` and
/// `G2 = 2 cos_o cos_i / (s_o cos_i + s_i cos_o)`.
#[inline(always)]
pub fn evaluate<L: Lanes>(l: L, s: &Surface<'_, L>, wo: V3<L>, wi: V3<L>) -> BsdfValue<L> {
    let zero = l.f(0.0);
    let m = s.material;
    let cos_o = s.n.dot(wo);
    let cos_i = s.n.dot(wi);
    let above = cos_i.gt(zero) & cos_o.gt(zero);
    let specular_prob = m.specular_prob();
    let mut f_cos = V3::all(zero);
    let mut pdf = zero;

    if m.has_diffuse {
        f_cos = V3::splat(l, m.kd) * (cos_i * FRAC_1_PI);
        pdf = warp::cosine_hemisphere_pdf(l, cos_i) * (1.0 - specular_prob);
    }
    if m.has_specular && !m.is_dirac() {
        let h = wo + wi;
        let h2 = h.dot(h);
        // sin^2 of the half vector from the cross product: 1 - cos^2 would lose narrow lobes.
        let across = s.n.cross(h);
        let n_h = s.n.dot(h);
        let alpha2 = m.alpha * m.alpha;
        let shape = across.dot(across) + n_h * n_h * alpha2;
        let s_o = smith(l, alpha2, cos_o);
        let s_i = smith(l, alpha2, cos_i);
        let (masking, one_sided) = (s_o * cos_i + s_i * cos_o, cos_o + s_o);
        // One division for all quotients.
        let both = masking * one_sided;
        let inverse = l.f(1.0) / (shape * both);
        let narrow = h2 * (inverse * both);
        let half_d = narrow * narrow * (0.5 * FRAC_1_PI * alpha2);
        let common = half_d * (inverse * shape);
        let lobe = common * one_sided * cos_i;
        let lobe_pdf = common * masking;
        // cos between half vector and wo: (wo.wo + wo.wi) / |h| = |h| / 2 for unit vectors.
        f_cos = f_cos + m.specular(l, h2) * lobe;
        pdf = pdf + lobe_pdf * specular_prob;
    }
    BsdfValue { f_cos: V3::select(above, f_cos, V3::all(zero)), pdf: above.select(pdf, zero) }
}

/// The mirror's one direction, which only [`sample`] draws: in place of `bsdf cos` the factor of its delta, in place of
/// a density the probability of having chosen that lobe.
#[inline(always)]
pub fn evaluate_mirror<L: Lanes>(l: L, s: &Surface<'_, L>, wo: V3<L>) -> BsdfValue<L> {
    let cos_o = s.n.dot(wo);
    BsdfValue { f_cos: s.material.specular(l, cos_o * cos_o * 4.0), pdf: l.f(s.material.specular_prob()) }
}

/// Draws a direction, of unit length and perhaps below the surface (then nothing is reflected), with the density of
/// [`evaluate`]; or a mirror's direction, see [`evaluate_mirror`], where the mask says so.
#[inline(always)]
pub fn sample<L: Lanes>(l: L, s: &Surface<'_, L>, wo: V3<L>, random: &Numbers<L>) -> (V3<L>, L::M) {
    let m = s.material;
    let (from_specular, u) = choose_lobe(l, m, random);
    let cos_o = s.n.dot(wo);
    let (mut wi, mut dirac) = (s.n, l.m(false));

    if m.has_diffuse || !m.is_dirac() {
        let (t, b) = warp::frame(l, s.n);
        let mut local = V3::all(l.f(0.0));
        if m.has_diffuse {
            local = warp::square_to_cosine_hemisphere(l, u);
        }
        if m.has_specular && !m.is_dirac() {
            let wo_local = V3 { x: t.dot(wo), y: b.dot(wo), z: cos_o };
            let h = warp::square_to_visible_normal(l, u, wo_local, l.f(m.alpha));
            let mirrored = h * (wo_local.dot(h) * 2.0 / h.dot(h)) - wo_local;
            local = V3::select(from_specular, mirrored, local);
        }
        wi = t.scale_add(local.x, b.scale_add(local.y, s.n * local.z)).renormalize(l);
    }
    if m.is_dirac() {
        dirac = from_specular;
        wi = V3::select(dirac, s.n * (cos_o * 2.0) - wo, wi);
    }
    (wi, dirac)
}

/// Which lobe of those that the material has, the specular one where true; and the numbers for a direction in it.
#[inline(always)]
pub(crate) fn choose_lobe<L: Lanes>(l: L, m: &BuiltMaterial, random: &Numbers<L>) -> (L::M, [L::F; 2]) {
    if m.has_two_lobes() {
        return random.choose_lobe(l, m.specular_prob());
    }
    (l.m(m.has_specular), random.get_2d(Dimension::Bsdf))
}

/// `sqrt(alpha^2 + (1 - alpha^2) cos^2)`: Smith's Lambda is `(s / cos - 1) / 2`.
#[inline(always)]
fn smith<L: Lanes>(l: L, alpha2: f32, cos: L::F) -> L::F {
    (cos * (1.0 - alpha2)).mul_add(cos, l.f(alpha2)).max(l.f(0.0)).sqrt()
}

/// Unpolarised Fresnel reflectance of a dielectric whose index is `ior` times that of where the light comes from; 1 where
/// all of it is reflected (then cos_t is 0).
#[inline(always)]
fn fresnel_dielectric<L: Lanes>(l: L, cos: L::F, ior: f32) -> L::F {
    let one = l.f(1.0);
    let cos = cos.min(one).max(l.f(f32::MIN_POSITIVE));
    let sin2_t = (one - cos * cos) * (1.0 / (ior * ior));
    let cos_t = (one - sin2_t).max(l.f(0.0)).sqrt();
    let parallel = (cos * ior - cos_t) / (cos * ior + cos_t);
    let perpendicular = (cos - cos_t * ior) / (cos + cos_t * ior);
    (parallel * parallel + perpendicular * perpendicular) * 0.5
}

/// Unpolarised Fresnel reflectance of a metal with index `eta + i k`, from the complex Fresnel
/// equations with `a^2 + b^2 = sqrt((eta^2 - k^2 - sin^2)^2 + 4 eta^2 k^2)`.
#[inline(always)]
fn fresnel_conductor<L: Lanes>(l: L, cos: L::F, eta: f32, k: f32) -> L::F {
    let one = l.f(1.0);
    let cos = cos.min(one).max(l.f(0.0));
    let cos2 = cos * cos;
    let sin2 = one - cos2;
    let t0 = l.f(eta * eta - k * k) - sin2;
    let a2b2 = (t0 * t0 + 4.0 * (eta * eta * k * k)).max(l.f(0.0)).sqrt();
    let a = ((a2b2 + t0) * 0.5).max(l.f(0.0)).sqrt();
    let t1 = a2b2 + cos2;
    let t2 = a * cos * 2.0;
    let perpendicular = (t1 - t2) / (t1 + t2);
    let t3 = cos2 * a2b2 + sin2 * sin2;
    let t4 = t2 * sin2;
    let parallel = perpendicular * (t3 - t4) / (t3 + t4);
    (parallel + perpendicular) * 0.5
}
