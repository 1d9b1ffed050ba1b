//! **The page.** Reflected radiance of a surface point, one sample at a time.
//!
//! The integral over directions is
//!
//! ```text
//! L = integral of f(wi) dwi,      f(wi) = bsdf(wo, wi) Le(wi) V(wi) cos(wi)
//! ```
//!
//! Two *techniques* draw wi: towards a light, with density `p_L`, and by a lobe of the BSDF, with density `p_B`. They
//! are twins: either makes a [`Draw`], and one function evaluates f and both densities at it. A *strategy* says which
//! techniques are drawn and how densely they cover a direction together:
//!
//! ```text
//! light, bsdf   one technique alone                              f / p_t
//! mis_all       multi-sample model: one sample of each           sum over t of  w_t f / p_t     (Veach 1997, eq. 9.4)
//! mis           one-sample model: t drawn with probability c_t   w_t f / (c_t p_t)              (Veach 1997, eq. 9.15)
//! ```
//!
//! Every one of these is `f / d`. With the density q of the technique that drew wi (p, or c p), the weight w turns q
//! into the effective density `d = q / w`; for the balance heuristic that is the density of the mixture, `q_L + q_B`.
//! (The tutorial's one-sample weights see p alone; c then multiplies d.)
//!
//! A weight belongs to the technique that drew the sample. The weights of a direction sum to one because both techniques
//! evaluate the same two densities.

pub mod heuristic;

use heuristic::{Rivals, Weighted};

use crate::bsdf::{self, Surface};
use crate::lanes::{Lanes, Mask, Real, V3};
use crate::light::Aim;
use crate::request::{Estimator, OneSampleWeights, PerTechnique, Strategy};
use crate::sampler::{Dimension, Numbers};
use crate::world::View;

/// A surface point that camera rays hit, and how the radiance it reflects towards them is estimated.
#[derive(Clone, Copy)]
pub struct Point<'a, L: Lanes> {
    /// What there is to see from it.
    pub view: View<'a, L>,
    /// Strategy, heuristic, weights and c.
    pub estimator: &'a Estimator,
    /// Position, normal and material.
    pub surface: Surface<'a, L>,
    /// Unit vector to the eye.
    pub wo: V3<L>,
    /// The lanes whose camera ray hit this surface; the others contribute nothing.
    pub here: L::M,
}

/// A direction as a technique drew it.
#[derive(Clone, Copy)]
pub(crate) struct Draw<L: Lanes> {
    pub wi: V3<L>,
    /// Where the light technique aimed.
    aim: Aim<L>,
    /// Drawn by the light technique, not by the BSDF technique.
    by_light: L::M,
    /// The technique did not fail.
    pub valid: L::M,
    /// Drawn from a Dirac lobe.
    pub dirac: L::M,
}

/// The integrand and both densities at a drawn direction.
pub(crate) struct Candidate<L: Lanes> {
    /// f(wi); 0 where no light is hit.
    pub f: V3<L>,
    /// p(wi) per solid angle. In a Dirac lobe `bsdf` is a probability instead, and `light` is 0: no light sample hits a
    /// mirror's one direction.
    pub p: PerTechnique<L::F>,
}

/// What one technique adds to one sample. Only where it is `lit`; elsewhere the numbers mean nothing.
#[derive(Clone, Copy)]
pub struct Contribution<L: Lanes> {
    /// `f / d`, that is `w f / p` or `w f / (c p)`, per channel.
    pub value: V3<L>,
    /// MIS weight w of the technique that drew the sample.
    pub weight: L::F,
    /// The technique was drawn and its ray hit a light.
    pub lit: L::M,
}

/// What both techniques add to one sample.
pub type Reflected<L> = PerTechnique<Contribution<L>>;

impl<L: Lanes> Point<'_, L> {
    /// One sample of the reflected radiance, by technique. `None` is no light in any lane.
    #[inline(always)]
    pub fn reflected(&self, u: &Numbers<L>) -> PerTechnique<Option<Contribution<L>>> {
        match self.estimator.strategy {
            Strategy::Light => PerTechnique { light: self.estimate(&self.draw_light(u)), bsdf: None },
            Strategy::Bsdf => PerTechnique { light: None, bsdf: self.estimate(&self.draw_bsdf(u)) },
            Strategy::MisAll => {
                PerTechnique { light: self.estimate(&self.draw_light(u)), bsdf: self.estimate(&self.draw_bsdf(u)) }
            }
            Strategy::Mis => {
                let draw = self.draw_either(u);
                let sample = self.estimate(&draw);
                PerTechnique {
                    light: sample.and_then(|x| x.only(draw.by_light)),
                    bsdf: sample.and_then(|x| x.only(!draw.by_light)),
                }
            }
        }
    }

    /// The light technique: a direction towards one of the lights.
    #[inline(always)]
    fn draw_light(&self, u: &Numbers<L>) -> Draw<L> {
        let l = self.view.l;
        let aim = self.view.scene.lights.sample(l, self.surface.p, u);
        Draw { wi: aim.wi, aim, by_light: l.m(true), valid: aim.valid, dirac: l.m(false) }
    }

    /// The BSDF technique: a direction in the lobe.
    #[inline(always)]
    fn draw_bsdf(&self, u: &Numbers<L>) -> Draw<L> {
        let l = self.view.l;
        let (wi, dirac) = bsdf::sample(l, &self.surface, self.wo, u);
        Draw { wi, aim: Aim::nowhere(l), by_light: l.m(false), valid: l.m(true), dirac }
    }

    /// One of the two: the light technique with probability c.
    #[inline(always)]
    fn draw_either(&self, u: &Numbers<L>) -> Draw<L> {
        let (by_light, u) = choose_technique(self.view.l, self.estimator, u);
        self.draw_where(by_light, &u)
    }

    /// The light technique where true, the BSDF technique elsewhere.
    #[inline(always)]
    pub(crate) fn draw_where(&self, by_light: L::M, u: &Numbers<L>) -> Draw<L> {
        let mut draw = Draw::none(self.view.l, by_light);
        if by_light.any() {
            draw = self.draw_light(u);
        }
        if !by_light.all() {
            draw = Draw::select(by_light, &draw, &self.draw_bsdf(u));
        }
        draw
    }

    /// Follows the secondary ray that was drawn: `f / d`.
    #[inline(always)]
    fn estimate(&self, draw: &Draw<L>) -> Option<Contribution<L>> {
        self.candidate(draw).map(|x| self.contribution(draw, &x))
    }

    /// What a candidate counts for.
    #[inline(always)]
    pub(crate) fn contribution(&self, draw: &Draw<L>, x: &Candidate<L>) -> Contribution<L> {
        let l = self.view.l;
        let c = technique_probs(self.estimator);
        let Estimator { strategy, heuristic, weights, .. } = *self.estimator;
        // How densely each technique draws this direction, as the heuristic sees it: the tutorial leaves out c.
        let q = match weights {
            OneSampleWeights::Veach => PerTechnique { light: x.p.light * c.light, bsdf: x.p.bsdf * c.bsdf },
            OneSampleWeights::Tutorial => x.p,
        };
        let q = Rivals::of(q, draw.by_light);
        let Weighted { w, d } = match strategy {
            Strategy::Light | Strategy::Bsdf => Weighted { w: l.f(1.0), d: q.own },
            Strategy::MisAll | Strategy::Mis => heuristic::weigh(l, heuristic, &q),
        };
        let d = match weights {
            OneSampleWeights::Veach => d,
            OneSampleWeights::Tutorial => d * draw.by_light.select(l.f(c.light), l.f(c.bsdf)),
        };
        // "Not zero" rather than "positive", so that a NaN goes on to the film and is counted there.
        let lit = !q.own.le(l.f(0.0)) & x.f.is_lit(l);
        Contribution { value: x.f / d, weight: w, lit }
    }

    /// The integrand and both densities at a drawn direction. `None` if no lane's ray hits a light.
    #[inline(always)]
    pub(crate) fn candidate(&self, draw: &Draw<L>) -> Option<Candidate<L>> {
        let (l, s) = (self.view.l, &self.surface);
        let light = self.view.light_towards(s.p, draw.wi, draw.by_light.all().then_some(&draw.aim));
        let shines = self.here & draw.valid & light.shines;
        if !shines.any() {
            return None;
        }
        let mut bsdf = bsdf::evaluate(l, s, self.wo, draw.wi);
        let mut p_light = light.pdf;
        if draw.dirac.any() {
            let mirror = bsdf::evaluate_mirror(l, s, self.wo);
            bsdf.f_cos = V3::select(draw.dirac, mirror.f_cos, bsdf.f_cos);
            bsdf.pdf = draw.dirac.select(mirror.pdf, bsdf.pdf);
            p_light = draw.dirac.select(l.f(0.0), p_light);
        }
        let unshadowed = bsdf.f_cos.times(light.radiance);
        let visible = self.view.visible(s, draw.wi, light.t, shines & unshadowed.is_lit(l));
        Some(Candidate { f: unshadowed.or_zero(l, visible), p: PerTechnique { light: p_light, bsdf: bsdf.pdf } })
    }
}

/// Probabilities c of the techniques: those of the one-sample model, else 1.
#[inline(always)]
fn technique_probs(estimator: &Estimator) -> PerTechnique<f32> {
    match estimator.strategy {
        Strategy::Light | Strategy::Bsdf | Strategy::MisAll => PerTechnique { light: 1.0, bsdf: 1.0 },
        Strategy::Mis => PerTechnique { light: estimator.light_prob, bsdf: 1.0 - estimator.light_prob },
    }
}

/// Where the light technique draws the sample of the one-sample model; elsewhere the BSDF technique does.
#[inline(always)]
pub fn drawn_by_light<L: Lanes>(l: L, estimator: &Estimator, technique: L::F) -> L::M {
    technique.lt(l.f(technique_probs(estimator).light))
}

/// That, and the numbers that are left for the direction.
#[inline(always)]
pub(crate) fn choose_technique<L: Lanes>(l: L, estimator: &Estimator, u: &Numbers<L>) -> (L::M, Numbers<L>) {
    let by_light = drawn_by_light(l, estimator, u.get_1d(Dimension::Technique));
    (by_light, u.after_technique(l, by_light, technique_probs(estimator).light))
}

impl<L: Lanes> Draw<L> {
    /// No direction.
    #[inline(always)]
    fn none(l: L, by_light: L::M) -> Self {
        let aim = Aim::nowhere(l);
        Self { wi: aim.wi, aim, by_light, valid: l.m(false), dirac: l.m(false) }
    }

    /// `a` where true, `b` elsewhere.
    #[inline(always)]
    fn select(m: L::M, a: &Self, b: &Self) -> Self {
        Self {
            wi: V3::select(m, a.wi, b.wi),
            aim: a.aim,
            by_light: m,
            valid: m & a.valid | !m & b.valid,
            dirac: m & a.dirac | !m & b.dirac,
        }
    }
}

impl<L: Lanes> Contribution<L> {
    /// No light.
    #[inline(always)]
    pub fn none(l: L) -> Self {
        Self { value: V3::all(l.f(0.0)), weight: l.f(0.0), lit: l.m(false) }
    }

    /// This where it is lit, `other` elsewhere.
    #[inline(always)]
    pub fn or(&self, other: &Self) -> Self {
        Self {
            value: V3::select(self.lit, self.value, other.value),
            weight: self.lit.select(self.weight, other.weight),
            lit: self.lit | other.lit,
        }
    }

    /// This where true. `None` if that is nowhere.
    #[inline(always)]
    fn only(&self, here: L::M) -> Option<Self> {
        here.any().then(|| Self { lit: self.lit & here, ..*self })
    }
}

impl<L: Lanes> Reflected<L> {
    /// No light.
    #[inline(always)]
    pub fn none(l: L) -> Self {
        Self { light: Contribution::none(l), bsdf: Contribution::none(l) }
    }

    /// `sample` where it is lit, this elsewhere.
    #[inline(always)]
    pub fn replaced(mut self, sample: &PerTechnique<Option<Contribution<L>>>) -> Self {
        if let Some(light) = &sample.light {
            self.light = light.or(&self.light);
        }
        if let Some(bsdf) = &sample.bsdf {
            self.bsdf = bsdf.or(&self.bsdf);
        }
        self
    }
}
