//! Every change of the document, as data: what a control sets. One step of undo is one of these.

use std::num::NonZeroU32;
use std::sync::Arc;

use mislab_renderer::{Estimator, Heuristic, Layer, Lockstep, OneSampleWeights, SamplerKind, Strategy};

use super::arrangement::Arrangement;
use super::document::{Counted, Document, fit_strata};
use super::history::EditKey;
use super::view::{ToneMap, VarianceUnit, ViewState};
use crate::look::versus::Versus;

/// Where a picture stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SppTarget {
    /// After so many samples per pixel.
    Passes(NonZeroU32),
    /// Never by itself.
    Endless,
}

impl SppTarget {
    /// So many, at least one.
    pub fn passes(n: u32) -> Self {
        Self::Passes(NonZeroU32::new(n).unwrap_or(NonZeroU32::MIN))
    }

    /// The choices offered: the tutorial's two, and the powers of two.
    pub fn choices() -> Vec<Self> {
        let mut passes: Vec<u32> = (0..=16).map(|e| 1 << e).chain([36]).collect();
        passes.sort_unstable();
        passes.into_iter().map(Self::passes).chain([Self::Endless]).collect()
    }
}

/// One change. Estimator, sampler and layer are those of the active slot; all else is shared.
#[derive(Clone, Debug, PartialEq)]
pub enum Edit {
    /// Which strategy.
    SetStrategy(Strategy),
    /// Strategy, c, heuristic and weights at once.
    SetEstimator(Estimator),
    /// c, the probability of the light technique.
    SetLightProb(f32),
    /// More or less c, in whole steps of that size.
    NudgeLightProb(f32),
    /// How two techniques are weighted.
    SetHeuristic(Heuristic),
    /// Whether c takes part in one-sample weights.
    SetWeights(OneSampleWeights),
    /// The sampling pattern.
    SetSampler(SamplerKind),
    /// Random position in each stratum.
    SetJitter(bool),
    /// Where to stop.
    SetSpp(SppTarget),
    /// What that number counts in a picture that stands alone.
    SetCounted(Counted),
    /// Seed of every random number.
    SetSeed(u32),
    /// GGX width of a material by index.
    SetAlpha(usize, f32),
    /// Radius of the sphere light with that shape index, at constant power.
    SetLightRadius(usize, f32),
    /// Turns the light with that shape index on or off.
    SetLightOn(usize, bool),
    /// Scene and settings back to the file's.
    ResetScene,

    /// How many pictures, and where.
    Arrange(Arrangement),
    /// What several pictures have alike.
    SetEqual(Lockstep),
    /// The layer of the active picture in all of them.
    ShareLayer,

    /// Which image of the frame.
    SetLayer(Layer),
    /// The next layer (or the previous).
    CycleLayer(isize),
    /// Exposure in stops.
    SetExposure(f32),
    /// Added after exposure.
    SetOffset(f32),
    /// More or less exposure, in stops.
    NudgeExposure(f32),
    /// More or less offset.
    NudgeOffset(f32),
    /// Tone map.
    SetToneMap(ToneMap),
    /// Whether clipped pixels are marked.
    SetMarkClipped(bool),
    /// Ends of the colour bar of the variance, as log10.
    SetVarianceRange([f32; 2]),
    /// What of two pictures is shown.
    SetVersus(Versus),
    /// What the variance is counted in, with the usual range of that.
    SetVarianceUnit(VarianceUnit),
    /// Exposure, offset, tone map back to the defaults.
    ResetView,
}

impl Edit {
    /// What a step of undo over it is about: edits alike in this, in one gesture, make one step.
    pub fn key(&self) -> EditKey {
        match *self {
            Self::SetStrategy(_) => EditKey("strategy", 0),
            Self::SetEstimator(_) => EditKey("estimator", 0),
            Self::SetLightProb(_) => EditKey("c", 0),
            Self::NudgeLightProb(_) => EditKey("c", 1),
            Self::SetHeuristic(_) => EditKey("heuristic", 0),
            Self::SetWeights(_) => EditKey("weights", 0),
            Self::SetSampler(_) => EditKey("sampler", 0),
            Self::SetJitter(_) => EditKey("jitter", 0),
            Self::SetSpp(_) => EditKey("samples per pixel", 0),
            Self::SetCounted(_) => EditKey("samples or rays", 0),
            Self::SetSeed(_) => EditKey("seed", 0),
            Self::SetAlpha(material, _) => EditKey("roughness", material),
            Self::SetLightRadius(shape, _) => EditKey("radius", shape),
            Self::SetLightOn(shape, _) => EditKey("switch", shape),
            Self::ResetScene => EditKey("reset to the file", 0),
            Self::Arrange(_) => EditKey("layout", 0),
            Self::SetEqual(_) => EditKey("what is equal", 0),
            Self::ShareLayer => EditKey("layer of all pictures", 0),
            Self::SetLayer(_) => EditKey("layer", 0),
            Self::CycleLayer(_) => EditKey("layer", 1),
            Self::SetExposure(_) => EditKey("exposure", 0),
            Self::SetOffset(_) => EditKey("offset", 0),
            Self::NudgeExposure(_) => EditKey("exposure", 1),
            Self::NudgeOffset(_) => EditKey("offset", 1),
            Self::SetToneMap(_) => EditKey("tone map", 0),
            Self::SetMarkClipped(_) => EditKey("marks of clipped pixels", 0),
            Self::SetVarianceRange(_) => EditKey("variance range", 0),
            Self::SetVersus(_) => EditKey("what is compared", 0),
            Self::SetVarianceUnit(_) => EditKey("unit of the variance", 0),
            Self::ResetView => EditKey("reset of the view", 0),
        }
    }

    /// Whether it is about how a picture is made, of which a file knows nothing.
    pub fn is_about_making(&self) -> bool {
        match self {
            Self::SetStrategy(_)
            | Self::SetEstimator(_)
            | Self::SetLightProb(_)
            | Self::NudgeLightProb(_)
            | Self::SetHeuristic(_)
            | Self::SetWeights(_)
            | Self::SetSampler(_)
            | Self::SetJitter(_) => true,
            Self::SetSpp(_)
            | Self::SetSeed(_)
            | Self::SetAlpha(..)
            | Self::SetLightRadius(..)
            | Self::SetLightOn(..)
            | Self::ResetScene
            | Self::Arrange(_)
            | Self::SetEqual(_)
            | Self::ShareLayer
            | Self::SetLayer(_)
            | Self::CycleLayer(_)
            | Self::SetExposure(_)
            | Self::SetOffset(_)
            | Self::NudgeExposure(_)
            | Self::NudgeOffset(_)
            | Self::SetToneMap(_)
            | Self::SetMarkClipped(_)
            | Self::SetVarianceRange(_)
            | Self::SetVarianceUnit(_)
            | Self::SetCounted(_)
            | Self::SetVersus(_)
            | Self::ResetView => false,
        }
    }

    /// Carries it out. What is out of range or meant for something else changes nothing.
    pub fn apply(&self, document: &mut Document) {
        let before = *document.active();
        if before.is_file() && self.is_about_making() {
            return;
        }
        self.change(document);
        let slot = document.active_mut();
        if before.kept.is_some()
            && !before.is_file()
            && (slot.estimator, slot.sampler) != (before.estimator, before.sampler)
        {
            // A frame that was kept cannot be changed: the picture is rendered again.
            slot.kept = None;
        }
    }

    fn change(&self, document: &mut Document) {
        match *self {
            Self::SetStrategy(strategy) => document.active_mut().estimator.strategy = strategy,
            Self::SetEstimator(estimator) => document.active_mut().estimator = estimator,
            Self::SetLightProb(c) => document.active_mut().estimator.light_prob = c.clamp(0.0, 1.0),
            // Nothing else has a c.
            Self::NudgeLightProb(_) if document.active().estimator.strategy != Strategy::Mis => {}
            Self::NudgeLightProb(step) => {
                let c = &mut document.active_mut().estimator.light_prob;
                // From step to step, whatever a slider left: five up and five down end where they began.
                let there = (f64::from(*c) / f64::from(step) + 1.0).round() * f64::from(step);
                *c = ((there * 100.0).round() / 100.0).clamp(0.0, 1.0) as f32;
            }
            Self::SetHeuristic(heuristic) => document.active_mut().estimator.heuristic = heuristic,
            Self::SetWeights(weights) => document.active_mut().estimator.weights = weights,
            Self::SetSampler(kind) => {
                let spp = document.spp;
                let sampler = &mut document.active_mut().sampler;
                sampler.kind = kind;
                fit_strata(sampler, spp);
            }
            Self::SetJitter(jitter) => document.active_mut().sampler.jitter = jitter,
            Self::SetSpp(target) => {
                document.set_spp(match target {
                    SppTarget::Passes(n) => Some(n),
                    SppTarget::Endless => None,
                });
            }
            Self::SetCounted(counted) => document.counted = counted,
            Self::SetSeed(seed) => document.seed = seed,
            Self::SetAlpha(material, alpha) => {
                let scene = Arc::make_mut(&mut document.scene);
                if let Some(a) = scene.materials.get_mut(material).and_then(|m| m.bsdf.alpha_mut()) {
                    *a = alpha.clamp(0.0, 1.0);
                }
            }
            Self::SetLightRadius(shape, radius) => {
                if shape < document.scene.shapes.len() && radius > 0.0 {
                    Arc::make_mut(&mut document.scene).set_light_radius(&document.opened.scene, shape, radius);
                }
            }
            Self::SetLightOn(shape, on) => {
                let scene = Arc::make_mut(&mut document.scene);
                if let Some(light) = scene.shapes.get_mut(shape).and_then(|s| s.light.as_mut()) {
                    light.on = on;
                }
            }
            Self::ResetScene => document.reset_scene(),
            Self::Arrange(arrangement) => document.arrange(arrangement),
            Self::SetEqual(equal) => document.equal = equal,
            Self::ShareLayer => document.share_layer(document.active().layer),
            Self::SetLayer(layer) => document.active_mut().layer = layer,
            Self::CycleLayer(step) => {
                let layer = &mut document.active_mut().layer;
                let at = Layer::ALL.iter().position(|l| l == layer).unwrap_or(0);
                *layer = Layer::ALL[(at as isize + step).rem_euclid(Layer::ALL.len() as isize) as usize];
            }
            Self::SetExposure(ev) => document.view.exposure_ev = ev,
            Self::SetOffset(offset) => document.view.offset = offset,
            Self::NudgeExposure(stops) => {
                let ev = &mut document.view.exposure_ev;
                *ev = (*ev + stops).clamp(-ViewState::MAX_EV, ViewState::MAX_EV);
            }
            Self::NudgeOffset(step) => {
                let offset = &mut document.view.offset;
                *offset = ((*offset + step) * 100.0).round() / 100.0;
            }
            Self::SetToneMap(tone_map) => document.view.tone_map = tone_map,
            Self::SetMarkClipped(on) => document.view.mark_clipped = on,
            Self::SetVarianceRange(range) => document.view.variance_range = range,
            Self::SetVersus(versus) => document.view.versus = versus,
            Self::SetVarianceUnit(unit) if unit == document.view.variance_unit => {}
            Self::SetVarianceUnit(unit) => {
                document.view.variance_unit = unit;
                document.view.variance_range = unit.default_range();
            }
            Self::ResetView => document.view.reset_display(),
        }
    }
}
