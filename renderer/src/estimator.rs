//! **The page.** Reflected radiance of a surface point, one sample at a time.
//!
//! The integral over directions is
//!
//! ```text
//! L = integral of f(w) dw,      f(w) = bsdf(wo, w) Le(w) V(w) cos(w)
//! ```
//!
//! There are two *techniques* to draw w: towards a light, with density `p_L`, and by the lobe of the
//! BSDF, with density `p_B`. They are twins: either direction is a [`Draw`], and one function makes of
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

use crate::bsdf::{self, BsdfValue, Surface};
use crate::build::BuiltScene;
use crate::lanes::{Lanes, Mask, Real, V3};
use crate::light::Aim;
use crate::mis;
use crate::patch::Candidates;
use crate::sampler::{Dimension, Numbers};
use crate::settings::{OneSampleWeights, Settings, Strategy};

/// A direction as a technique drew it.
#[derive(Clone, Copy)]
pub(crate) struct Draw<L: Lanes> {
    pub(crate) wi: V3<L>,
    /// Where the light technique aimed.
    aim: Aim<L>,
    /// True where the light technique drew it, false where the BSDF technique did.
    by_light: L::M,
    /// False where the technique failed to draw one.
    pub(crate) valid: L::M,
    /// True where it was drawn from a Dirac lobe.
    pub(crate) dirac: L::M,
}

/// A direction's integrand and both its densities, whichever technique drew it.
pub(crate) struct Candidate<L: Lanes> {
    /// f(wi); 0 where the technique failed.
    pub(crate) f: V3<L>,
    /// Densities of wi.
    pub(crate) p: Densities<L>,
}

/// Densities of the two techniques at one direction, per solid angle. On a Dirac draw `bsdf` is a
/// probability instead, and `light` is 0: no light sample ever meets the one direction of a mirror.
#[derive(Clone, Copy)]
pub(crate) struct Densities<L: Lanes> {
    pub(crate) light: L::F,
    pub(crate) bsdf: L::F,
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
    /// `a` where true, `b` elsewhere.
    #[inline(always)]
    pub fn select(m: L::M, a: &Self, b: &Self) -> Self {
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
}

/// Probabilities c of the techniques, light and BSDF: those of the one-sample model, else 1.
#[inline(always)]
fn technique_probs(settings: &Settings) -> (f32, f32) {
    match settings.strategy {
        Strategy::Light | Strategy::Bsdf | Strategy::MisAll => (1.0, 1.0),
        Strategy::Mis => (settings.light_prob, 1.0 - settings.light_prob),
    }
}

/// True where the light technique draws the sample of the one-sample model, false where the BSDF technique does.
#[inline(always)]
pub fn drawn_by_light<L: Lanes>(l: L, settings: &Settings, technique: L::F) -> L::M {
    technique.lt(l.f(technique_probs(settings).0))
}

/// One sample of the radiance that `s` reflects towards `wo`, by the strategy of `settings`, put into `reflected` where
/// true.
#[inline(always)]
pub fn reflected_radiance<L: Lanes>(
    l: L,
    scene: &BuiltScene,
    settings: &Settings,
    (here, s, wo): (L::M, &Surface<'_, L>, V3<L>),
    random: &Numbers<L>,
    near: &Candidates,
    reflected: &mut Reflected<L>,
) {
    let by_light = match settings.strategy {
        Strategy::Light | Strategy::MisAll => l.m(true),
        Strategy::Bsdf => l.m(false),
        Strategy::Mis => drawn_by_light(l, settings, random.get_1d(Dimension::Technique)),
    };
    let draw = draw(l, scene, s, wo, random, by_light);
    follow(l, scene, settings, (here, s, wo), &draw, near, reflected);
    if settings.strategy == Strategy::MisAll {
        let draw = self::draw(l, scene, s, wo, random, l.m(false));
        follow(l, scene, settings, (here, s, wo), &draw, near, reflected);
    }
}

/// Draws the direction of a secondary ray from the surface `s`: by the light technique where true, by the BSDF technique
/// elsewhere.
#[inline(always)]
pub(crate) fn draw<L: Lanes>(
    l: L,
    scene: &BuiltScene,
    s: &Surface<'_, L>,
    wo: V3<L>,
    random: &Numbers<L>,
    by_light: L::M,
) -> Draw<L> {
    let aim = if by_light.any() { scene.lights.sample(l, s.p, random) } else { Aim::nowhere(l) };
    let mut draw = Draw { wi: aim.wi, aim, by_light, valid: aim.valid, dirac: l.m(false) };
    if !by_light.all() {
        let (wi, dirac) = bsdf::sample(l, s, wo, random);
        draw.wi = V3::select(by_light, draw.wi, wi);
        draw.valid = draw.valid | !by_light;
        draw.dirac = dirac & !by_light;
    }
    draw
}

/// Follows the ray that was drawn and puts its part into `reflected`.
#[inline(always)]
fn follow<L: Lanes>(
    l: L,
    scene: &BuiltScene,
    settings: &Settings,
    (here, s, wo): (L::M, &Surface<'_, L>, V3<L>),
    draw: &Draw<L>,
    near: &Candidates,
    reflected: &mut Reflected<L>,
) {
    let one = l.f(1.0);
    let Some(x) = candidate(l, scene, s, wo, draw, near) else { return };
    let (c_light, c_bsdf) = technique_probs(settings);

    // The heuristic sees n p (multi-sample) or c p (one-sample); the tutorial leaves out c.
    let (a_light, a_bsdf) = match settings.weights {
        OneSampleWeights::Veach => (x.p.light * c_light, x.p.bsdf * c_bsdf),
        OneSampleWeights::Tutorial => (x.p.light, x.p.bsdf),
    };
    // Everything that follows is about the technique that drew the direction.
    let by_light = draw.by_light;
    let (a, other) = (by_light.select(a_light, a_bsdf), by_light.select(a_bsdf, a_light));
    let (weight, w_over_a) = match settings.strategy {
        Strategy::Light | Strategy::Bsdf => (one, one / a),
        Strategy::MisAll | Strategy::Mis => mis::weight(l, settings.heuristic, a, other, by_light),
    };
    let w_over_cp = match settings.weights {
        OneSampleWeights::Veach => w_over_a,
        OneSampleWeights::Tutorial => w_over_a * by_light.select(l.f(1.0 / c_light), l.f(1.0 / c_bsdf)),
    };
    let sample = contribution(l, &x, weight, w_over_cp, a);
    // A technique draws at most one of the rays.
    let (light, bsdf) = (here & by_light, here & !by_light);
    if light.any() {
        reflected.light = Contribution::select(light, &sample, &reflected.light);
    }
    if bsdf.any() {
        reflected.bsdf = Contribution::select(bsdf, &sample, &reflected.bsdf);
    }
}

/// The integrand and both densities at a drawn direction: one secondary ray. `None` if no lane's meets a light.
#[inline(always)]
pub(crate) fn candidate<L: Lanes>(
    l: L,
    scene: &BuiltScene,
    s: &Surface<'_, L>,
    wo: V3<L>,
    draw: &Draw<L>,
    near: &Candidates,
) -> Option<Candidate<L>> {
    let zero = l.f(0.0);
    let sight = if near.lights_apart && draw.by_light.all() {
        scene.lights.look_at(l, &draw.aim, near.may_be_blocked())
    } else {
        scene.lights.look(l, s.p, draw.wi, l.f(scene.epsilon), near.may_be_blocked())
    };
    let shines = draw.valid & sight.shines;
    if !shines.any() {
        return None;
    }
    let BsdfValue { mut f_cos, mut pdf } = bsdf::evaluate(l, s, wo, draw.wi);
    let mut p_light = sight.pdf;
    if draw.dirac.any() {
        let mirror = bsdf::evaluate_mirror(l, s, wo);
        f_cos = V3::select(draw.dirac, mirror.f_cos, f_cos);
        pdf = draw.dirac.select(mirror.pdf, pdf);
        p_light = draw.dirac.select(zero, p_light);
    }
    let p = Densities { light: p_light, bsdf: pdf };
    let unshadowed = f_cos.times(sight.radiance);
    // "Not zero" rather than "positive", so that a NaN goes on to the film and is counted there.
    let lit = shines & !(unshadowed.x + unshadowed.y + unshadowed.z).le(zero);
    let visible =
        if near.may_be_blocked() && lit.any() { lit & scene.visible(l, s, draw.wi, sight.t, lit, near) } else { lit };
    Some(Candidate { f: V3::select(visible, unshadowed, V3::all(zero)), p })
}

/// `w f / (c p)`: `c` is the probability of the technique (one-sample model) or, with one sample of each, 1. Lanes
/// where nothing was met are selected away, since 0 times NaN is NaN; `a` is 0 where the density is.
#[inline(always)]
fn contribution<L: Lanes>(l: L, x: &Candidate<L>, weight: L::F, w_over_cp: L::F, a: L::F) -> Contribution<L> {
    let zero = l.f(0.0);
    let carries = !a.le(zero) & !(x.f.x + x.f.y + x.f.z).le(zero);
    Contribution {
        value: V3::select(carries, x.f * w_over_cp, V3::all(zero)),
        weight: carries.select(weight, zero),
        carries,
    }
}
