//! Surfaces: what the BSDF and its sampling density are, and how to draw from it.
//!
//! One description serves all materials: a Lambert lobe `kd`, a specular lobe `ks` times a Fresnel
//! term, either of them absent. The specular lobe is a GGX distribution of width alpha or, below
//! [`MIRROR_ALPHA`], a perfect mirror.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use crate::lanes::{Lanes, Mask, Real, V3};
use crate::sampler::{Dimension, Numbers};
use crate::scene::{Bsdf, Reflectance};
use crate::warp;

/// GGX widths below this are treated as a mirror: f32 cannot resolve the lobe.
pub const MIRROR_ALPHA: f32 = 1e-3;

/// Index of refraction of plastic's coat (pbrt-v3).
const PLASTIC_IOR: f32 = 1.5;

/// The material of one surface, in the form that lanes are filled from.
#[derive(Clone, Copy, Debug)]
pub struct Material {
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
    Dielectric,
    Conductor { eta: Vec3, k: Vec3 },
}

impl Material {
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
            Bsdf::Plastic { kd, ks, alpha } => Self { kd, ks, alpha, fresnel: Fresnel::Dielectric, ..Self::BLACK },
        };
        Self { has_diffuse: built.kd != Vec3::ZERO, has_specular: built.ks != Vec3::ZERO, ..built }
    }

    /// True for a diffuse and a specular lobe, of which a sample chooses one.
    pub fn has_two_lobes(&self) -> bool {
        self.has_diffuse && self.has_specular
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

/// The surface points that a packet of camera rays met, with their materials.
#[derive(Clone, Copy)]
pub struct Surface<L: Lanes> {
    /// Position.
    pub p: V3<L>,
    /// Unit normal on the viewer's side.
    pub n: V3<L>,
    kd: V3<L>,
    ks: V3<L>,
    alpha: L::F,
    eta: V3<L>,
    k: V3<L>,
    conductor: L::M,
    dielectric: L::M,
    diffuse: L::M,
    specular: L::M,
}

impl<L: Lanes> Surface<L> {
    /// The same material at every lane.
    #[inline(always)]
    pub fn new(l: L, p: V3<L>, n: V3<L>, material: &Material) -> Self {
        let (eta, k) = match material.fresnel {
            Fresnel::Conductor { eta, k } => (eta, k),
            Fresnel::One | Fresnel::Dielectric => (Vec3::ONE, Vec3::ZERO),
        };
        Self {
            p,
            n,
            kd: V3::splat(l, material.kd),
            ks: V3::splat(l, material.ks),
            alpha: l.f(material.alpha),
            eta: V3::splat(l, eta),
            k: V3::splat(l, k),
            conductor: l.m(matches!(material.fresnel, Fresnel::Conductor { .. })),
            dielectric: l.m(material.fresnel == Fresnel::Dielectric),
            diffuse: l.m(material.has_diffuse),
            specular: l.m(material.has_specular),
        }
    }

    /// `a` where true, `b` elsewhere.
    #[inline(always)]
    pub fn select(m: L::M, a: Self, b: Self) -> Self {
        Self {
            p: V3::select(m, a.p, b.p),
            n: V3::select(m, a.n, b.n),
            kd: V3::select(m, a.kd, b.kd),
            ks: V3::select(m, a.ks, b.ks),
            alpha: m.select(a.alpha, b.alpha),
            eta: V3::select(m, a.eta, b.eta),
            k: V3::select(m, a.k, b.k),
            conductor: (m & a.conductor) | (!m & b.conductor),
            dielectric: (m & a.dielectric) | (!m & b.dielectric),
            diffuse: (m & a.diffuse) | (!m & b.diffuse),
            specular: (m & a.specular) | (!m & b.specular),
        }
    }

    /// True where anything is reflected at all.
    #[inline(always)]
    pub fn scatters(&self) -> L::M {
        self.diffuse | self.specular
    }

    /// True where the specular lobe is a Dirac delta.
    #[inline(always)]
    fn dirac(&self, l: L) -> L::M {
        self.specular & self.alpha.lt(l.f(MIRROR_ALPHA))
    }

    /// Probability that a BSDF sample is drawn from the specular lobe: 1, 0 or, with both, 1/2.
    #[inline(always)]
    fn specular_prob(&self, l: L) -> L::F {
        let both = (self.diffuse & self.specular).select(l.f(0.5), l.f(1.0));
        self.specular.select(both, l.f(0.0))
    }

    /// Fresnel reflectance at `cos` between the half vector and either direction.
    #[inline(always)]
    fn fresnel(&self, l: L, cos: L::F) -> V3<L> {
        let mut f = V3::all(l.f(1.0));
        if self.dielectric.any() {
            f = V3::select(self.dielectric, V3::all(fresnel_dielectric(l, cos)), f);
        }
        if self.conductor.any() {
            let metal = V3 {
                x: fresnel_conductor(l, cos, self.eta.x, self.k.x),
                y: fresnel_conductor(l, cos, self.eta.y, self.k.y),
                z: fresnel_conductor(l, cos, self.eta.z, self.k.z),
            };
            f = V3::select(self.conductor, metal, f);
        }
        f
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
/// from Dirac lobes, which no given direction meets.
///
/// GGX with Smith's height-correlated masking (Heitz 2014, eq. 99) and visible normals
/// (Heitz 2018): `f cos = D F G2 / (4 cos_o)`, `p = D G1 / (4 cos_o)`. With
/// `s = sqrt(alpha^2 + (1 - alpha^2) cos^2)`, `G1 = 2 cos_o / (cos_o + s_o)` and
/// `G2 = 2 cos_o cos_i / (s_o cos_i + s_i cos_o)`.
#[inline(always)]
pub fn evaluate<L: Lanes>(l: L, s: &Surface<L>, wo: V3<L>, wi: V3<L>) -> BsdfValue<L> {
    let zero = l.f(0.0);
    let cos_o = s.n.dot(wo);
    let cos_i = s.n.dot(wi);
    let above = cos_i.gt(zero) & cos_o.gt(zero);
    let specular_prob = s.specular_prob(l);
    let mut f_cos = V3::all(zero);
    let mut pdf = zero;

    if s.diffuse.any() {
        let cos = s.diffuse.select(cos_i, zero);
        f_cos = s.kd * (cos * FRAC_1_PI);
        pdf = (l.f(1.0) - specular_prob) * warp::cosine_hemisphere_pdf(l, cos);
    }

    let glossy = s.specular & !s.dirac(l);
    if glossy.any() {
        let h = wo + wi;
        let h2 = h.dot(h);
        // sin^2 of the half vector from the cross product: 1 - cos^2 would lose narrow lobes.
        let across = s.n.cross(h);
        let n_h = s.n.dot(h);
        let alpha2 = s.alpha * s.alpha;
        let shape = across.dot(across) + alpha2 * n_h * n_h;
        let half_d = alpha2 * h2 * h2 / (shape * shape) * (0.5 * FRAC_1_PI);
        let s_o = smith(l, alpha2, cos_o);
        let s_i = smith(l, alpha2, cos_i);
        let lobe = half_d * cos_i / (s_o * cos_i + s_i * cos_o);
        let lobe_pdf = half_d / (cos_o + s_o);
        // cos between half vector and wo: (wo.wo + wo.wi) / |h| = |h| / 2 for unit vectors.
        let cos_h = h2.sqrt() * 0.5;
        let reflected = s.ks.times(s.fresnel(l, cos_h)) * lobe;
        f_cos = V3::select(glossy, f_cos + reflected, f_cos);
        pdf = glossy.select(specular_prob.mul_add(lobe_pdf, pdf), pdf);
    }
    BsdfValue { f_cos: V3::select(above, f_cos, V3::all(zero)), pdf: above.select(pdf, zero) }
}

/// A direction drawn from the BSDF.
pub struct BsdfSample<L: Lanes> {
    /// The direction; of unit length, perhaps below the surface (then nothing is reflected).
    pub wi: V3<L>,
    /// True where it was drawn from a Dirac lobe.
    pub dirac: L::M,
    /// There: the coefficient of the delta in `bsdf cos`, i.e. the mirror's reflectance.
    pub dirac_f: V3<L>,
    /// There: the probability of having chosen the Dirac lobe.
    pub dirac_pmf: L::F,
}

/// Draws a direction, with the density of [`evaluate`] or, on Dirac lobes, the mirror direction.
#[inline(always)]
pub fn sample<L: Lanes>(l: L, s: &Surface<L>, wo: V3<L>, random: &Numbers<L>) -> BsdfSample<L> {
    let u = random.get_2d(Dimension::Bsdf);
    let specular_prob = s.specular_prob(l);
    let mut from_specular = s.specular;
    if (s.diffuse & s.specular).any() {
        from_specular = random.get_1d(Dimension::Lobe).lt(specular_prob);
    }
    let dirac = from_specular & s.dirac(l);
    let glossy = from_specular & !dirac;
    let cos_o = s.n.dot(wo);
    let mut wi = s.n;
    let mut dirac_f = V3::all(l.f(0.0));

    if !(dirac.all()) {
        let (t, b) = warp::frame(l, s.n);
        let mut local = V3::all(l.f(0.0));
        if !glossy.all() {
            local = warp::square_to_cosine_hemisphere(l, u);
        }
        if glossy.any() {
            let wo_local = V3 { x: t.dot(wo), y: b.dot(wo), z: cos_o };
            let h = warp::square_to_visible_normal(l, u, wo_local, s.alpha);
            let mirrored = h * (wo_local.dot(h) * 2.0 / h.dot(h)) - wo_local;
            local = V3::select(glossy, mirrored, local);
        }
        wi = t.scale_add(local.x, b.scale_add(local.y, s.n * local.z)).renormalize(l);
    }
    if dirac.any() {
        let mirrored = s.n * (cos_o * 2.0) - wo;
        wi = V3::select(dirac, mirrored, wi);
        dirac_f = V3::select(dirac, s.ks.times(s.fresnel(l, cos_o)), dirac_f);
    }
    BsdfSample { wi, dirac, dirac_f, dirac_pmf: specular_prob }
}

/// `sqrt(alpha^2 + (1 - alpha^2) cos^2)`: Smith's Lambda is `(s / cos - 1) / 2`.
#[inline(always)]
fn smith<L: Lanes>(l: L, alpha2: L::F, cos: L::F) -> L::F {
    ((l.f(1.0) - alpha2) * cos).mul_add(cos, alpha2).max(l.f(0.0)).sqrt()
}

/// Unpolarised Fresnel reflectance from air into a dielectric of index 1.5.
#[inline(always)]
fn fresnel_dielectric<L: Lanes>(l: L, cos: L::F) -> L::F {
    let one = l.f(1.0);
    let cos = cos.min(one).max(l.f(0.0));
    let sin2_t = (one - cos * cos) * (1.0 / (PLASTIC_IOR * PLASTIC_IOR));
    let cos_t = (one - sin2_t).max(l.f(0.0)).sqrt();
    let parallel = (cos * PLASTIC_IOR - cos_t) / (cos * PLASTIC_IOR + cos_t);
    let perpendicular = (cos - cos_t * PLASTIC_IOR) / (cos + cos_t * PLASTIC_IOR);
    (parallel * parallel + perpendicular * perpendicular) * 0.5
}

/// Unpolarised Fresnel reflectance of a metal with index `eta + i k`, from the complex Fresnel
/// equations with `a^2 + b^2 = sqrt((eta^2 - k^2 - sin^2)^2 + 4 eta^2 k^2)`.
#[inline(always)]
fn fresnel_conductor<L: Lanes>(l: L, cos: L::F, eta: L::F, k: L::F) -> L::F {
    let one = l.f(1.0);
    let cos = cos.min(one).max(l.f(0.0));
    let cos2 = cos * cos;
    let sin2 = one - cos2;
    let t0 = eta * eta - k * k - sin2;
    let a2b2 = (t0 * t0 + eta * eta * k * k * 4.0).max(l.f(0.0)).sqrt();
    let a = ((a2b2 + t0) * 0.5).max(l.f(0.0)).sqrt();
    let t1 = a2b2 + cos2;
    let t2 = a * cos * 2.0;
    let perpendicular = (t1 - t2) / (t1 + t2);
    let t3 = cos2 * a2b2 + sin2 * sin2;
    let t4 = t2 * sin2;
    let parallel = perpendicular * (t3 - t4) / (t3 + t4);
    (parallel + perpendicular) * 0.5
}
