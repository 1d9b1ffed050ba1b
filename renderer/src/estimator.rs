//! **The page.** Reflected radiance of a surface point, one sample at a time.
//!
//! The integral over directions is
//!
//! ```text
//! L = integral of f(w) dw,      f(w) = bsdf(wo, w) Le(w) V(w) cos(w)
//! ```
//!
//! There are two *techniques* to draw w: towards a light, with density `p_L`, and by the lobe of the
//! BSDF, with density `p_B`. They are twins: each returns a [`Draw`], and one function makes of
//! either a [`Candidate`], the direction's integrand and both densities. A *strategy* says which
//! techniques are drawn and how they are weighted:
//!
//! ```text
//! light, bsdf   one technique alone        f / p_t
//! mis_all       multi-sample model         sum over t of  w_t f / p_t              (Veach 9.4)
//! mis           one-sample model           w_t f / (c_t p_t), t drawn with c_t     (Veach 9.15)
//! ```
//!
//! A weight belongs to the technique that drew the sample. The weights of a direction sum to one
//! because both techniques ask the same functions for the densities.

use std::hint::black_box;

use crate::bsdf::{self, Surface};
use crate::build::BuiltScene;
use crate::lanes::{Lanes, Mask, Real, V3};
use crate::mis;
use crate::patch::Candidates;
use crate::sampler::{Dimension, Numbers};
use crate::settings::{OneSampleWeights, Settings, Strategy};

/// A direction as a technique drew it.
#[derive(Clone, Copy)]
struct Draw<L: Lanes> {
    wi: V3<L>,
    /// False where the technique failed to draw one.
    valid: L::M,
    /// True where it was drawn from a Dirac lobe, with probability `dirac_pmf`; `dirac_f` is the
    /// factor of the delta.
    dirac: L::M,
    dirac_f: V3<L>,
    dirac_pmf: L::F,
}

/// A direction's integrand and both its densities, whichever technique drew it.
struct Candidate<L: Lanes> {
    /// f(wi); 0 where the technique failed.
    f: V3<L>,
    /// Densities of wi.
    p: Densities<L>,
}

/// Densities of the two techniques at one direction, per solid angle. On a Dirac draw `bsdf` is a
/// probability instead, and `light` is 0: no light sample ever meets the one direction of a mirror.
#[derive(Clone, Copy)]
struct Densities<L: Lanes> {
    light: L::F,
    bsdf: L::F,
}

/// What one technique adds to one sample.
#[derive(Clone, Copy)]
pub struct Contribution<L: Lanes> {
    /// `w f / (n p)` or `w f / (c p)`, per channel.
    pub value: V3<L>,
    /// MIS weight w of the technique that drew the sample; 0 where `carries` is false.
    pub weight: L::F,
    /// True where the technique was drawn and met a light.
    pub carries: L::M,
}

impl<L: Lanes> Contribution<L> {
    /// This where true, nothing elsewhere.
    #[inline(always)]
    fn only(self, l: L, drawn: L::M) -> Self {
        let zero = l.f(0.0);
        Self {
            value: V3::select(drawn, self.value, V3::all(zero)),
            weight: drawn.select(self.weight, zero),
            carries: drawn & self.carries,
        }
    }

    /// `a` where true, `b` elsewhere.
    #[inline(always)]
    fn select(m: L::M, a: &Self, b: &Self) -> Self {
        Self {
            value: V3::select(m, a.value, b.value),
            weight: m.select(a.weight, b.weight),
            carries: (m & a.carries) | (!m & b.carries),
        }
    }
}

/// Both techniques' part of one sample.
#[derive(Clone, Copy)]
pub struct Reflected<L: Lanes> {
    /// From directions drawn by the light technique.
    pub light: Contribution<L>,
    /// From directions drawn by the BSDF technique.
    pub bsdf: Contribution<L>,
}

impl<L: Lanes> Reflected<L> {
    /// No light.
    #[inline(always)]
    pub fn nothing(l: L) -> Self {
        let nothing = Contribution { value: V3::all(l.f(0.0)), weight: l.f(0.0), carries: l.m(false) };
        Self { light: nothing, bsdf: nothing }
    }

    /// `a` where true, `b` elsewhere.
    #[inline(always)]
    pub fn select(m: L::M, a: &Self, b: &Self) -> Self {
        Self { light: Contribution::select(m, &a.light, &b.light), bsdf: Contribution::select(m, &a.bsdf, &b.bsdf) }
    }
}

/// One sample of the radiance that `s` reflects towards `wo`, by the strategy of `settings`.
#[inline(always)]
pub fn reflected_radiance<L: Lanes>(
    l: L,
    scene: &BuiltScene,
    settings: &Settings,
    s: &Surface<'_, L>,
    wo: V3<L>,
    random: &Numbers<L>,
    near: &Candidates,
) -> Reflected<L> {
    let one = l.f(1.0);
    let mut reflected = Reflected::nothing(l);

    for ray in 0..settings.strategy.rays_per_sample() {
        // Else the compiler works out every warp of these numbers before the loop, used or not.
        let random = black_box(random);
        // Which technique draws this ray (in which lanes), and with what probability c each does.
        let (by_light, c_light, c_bsdf) = match settings.strategy {
            Strategy::Light => (l.m(true), one, one),
            Strategy::Bsdf => (l.m(false), one, one),
            Strategy::MisAll => (l.m(ray == 0), one, one),
            Strategy::Mis => {
                let c = l.f(settings.light_prob);
                (random.get_1d(Dimension::Technique).lt(c), c, one - c)
            }
        };
        let draw = draw(l, scene, s, wo, by_light, random);
        let x = candidate(l, scene, s, wo, &draw, near);

        // The heuristic sees n p (multi-sample) or c p (one-sample); the tutorial leaves out c.
        let (a_light, a_bsdf) = match settings.weights {
            OneSampleWeights::Veach => (c_light * x.p.light, c_bsdf * x.p.bsdf),
            OneSampleWeights::Tutorial => (x.p.light, x.p.bsdf),
        };
        // Everything that follows is about the technique that drew the direction.
        let (a, other) = (by_light.select(a_light, a_bsdf), by_light.select(a_bsdf, a_light));
        let (p, c) = (by_light.select(x.p.light, x.p.bsdf), by_light.select(c_light, c_bsdf));
        let weight = match settings.strategy {
            Strategy::Light | Strategy::Bsdf => one,
            Strategy::MisAll | Strategy::Mis => mis::weight(l, settings.heuristic, a, other, by_light),
        };
        let sample = contribution(l, &x, weight, c, p);
        // A technique draws at most one of the rays.
        if by_light.any() {
            reflected.light = sample.only(l, by_light);
        }
        if !by_light.all() {
            reflected.bsdf = sample.only(l, !by_light);
        }
    }
    reflected
}

/// A direction, by the light technique where `by_light`, by the BSDF technique elsewhere.
#[inline(always)]
fn draw<L: Lanes>(
    l: L,
    scene: &BuiltScene,
    s: &Surface<'_, L>,
    wo: V3<L>,
    by_light: L::M,
    random: &Numbers<L>,
) -> Draw<L> {
    let nothing = l.f(0.0);
    let mut draw =
        Draw { wi: s.n, valid: l.m(false), dirac: l.m(false), dirac_f: V3::all(nothing), dirac_pmf: nothing };
    if by_light.any() {
        draw = light_technique(l, scene, s, random);
    }
    if !by_light.all() {
        draw = select(by_light, &draw, &bsdf_technique(l, s, wo, random));
    }
    draw
}

/// A direction towards a light.
#[inline(always)]
fn light_technique<L: Lanes>(l: L, scene: &BuiltScene, s: &Surface<'_, L>, random: &Numbers<L>) -> Draw<L> {
    let (wi, valid) = scene.lights.sample(l, s.p, random);
    Draw { wi, valid, dirac: l.m(false), dirac_f: V3::all(l.f(0.0)), dirac_pmf: l.f(0.0) }
}

/// A direction by the lobe of the BSDF.
#[inline(always)]
fn bsdf_technique<L: Lanes>(l: L, s: &Surface<'_, L>, wo: V3<L>, random: &Numbers<L>) -> Draw<L> {
    let drawn = bsdf::sample(l, s, wo, random);
    Draw { wi: drawn.wi, valid: l.m(true), dirac: drawn.dirac, dirac_f: drawn.dirac_f, dirac_pmf: drawn.dirac_pmf }
}

/// The integrand and both densities at a drawn direction: one secondary ray.
#[inline(always)]
fn candidate<L: Lanes>(
    l: L,
    scene: &BuiltScene,
    s: &Surface<'_, L>,
    wo: V3<L>,
    draw: &Draw<L>,
    near: &Candidates,
) -> Candidate<L> {
    let zero = l.f(0.0);
    let sight = scene.lights.look(l, s.p, draw.wi, l.f(scene.epsilon), near.may_be_blocked());
    let smooth = bsdf::evaluate(l, s, wo, draw.wi);
    let bsdf_cos = V3::select(draw.dirac, draw.dirac_f, smooth.f_cos);
    let p =
        Densities { light: draw.dirac.select(zero, sight.pdf), bsdf: draw.dirac.select(draw.dirac_pmf, smooth.pdf) };
    let unshadowed = bsdf_cos.times(sight.radiance);
    // "Not zero" rather than "positive", so that a NaN goes on to the film and is counted there.
    let lit = draw.valid & !(unshadowed.x + unshadowed.y + unshadowed.z).le(zero);
    // Most BSDF samples meet no light: then nothing needs to be asked about visibility.
    let visible =
        if near.may_be_blocked() && lit.any() { lit & scene.visible(l, s, draw.wi, sight.t, lit, near) } else { lit };
    Candidate { f: V3::select(visible, unshadowed, V3::all(zero)), p }
}

/// `w f / (c p)`: `c` is the probability of the technique (one-sample model) or, with one sample of
/// each, 1. Lanes where nothing was met are selected away, since 0 times NaN is NaN.
#[inline(always)]
fn contribution<L: Lanes>(l: L, x: &Candidate<L>, weight: L::F, c: L::F, p: L::F) -> Contribution<L> {
    let zero = l.f(0.0);
    let carries = !p.le(zero) & !(x.f.x + x.f.y + x.f.z).le(zero);
    let value = x.f * (weight / (c * p));
    Contribution { value: V3::select(carries, value, V3::all(zero)), weight: carries.select(weight, zero), carries }
}

/// `a` where true, `b` elsewhere.
#[inline(always)]
fn select<L: Lanes>(m: L::M, a: &Draw<L>, b: &Draw<L>) -> Draw<L> {
    Draw {
        wi: V3::select(m, a.wi, b.wi),
        valid: (m & a.valid) | (!m & b.valid),
        dirac: (m & a.dirac) | (!m & b.dirac),
        dirac_f: V3::select(m, a.dirac_f, b.dirac_f),
        dirac_pmf: m.select(a.dirac_pmf, b.dirac_pmf),
    }
}
