//! Every action of the user, as data: panels, keys and the palette all say what they want in these.

use std::num::NonZeroU32;
use std::path::PathBuf;
use std::sync::Arc;

use eframe::egui::ThemePreference;
use mislab_renderer::{Heuristic, Layer, OneSampleWeights, SamplerKind, SamplerSettings, Strategy};

use crate::state::document::{Document, EditKey};
use crate::state::view::{ToneMap, ViewState};

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

/// One action.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Which strategy.
    SetStrategy(Strategy),
    /// c, the probability of the light technique.
    SetLightProb(f32),
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

    /// Which image of the frame.
    SetLayer(Layer),
    /// Exposure in stops.
    SetExposure(f32),
    /// Added after exposure.
    SetOffset(f32),
    /// More or less exposure, in stops.
    NudgeExposure(f32),
    /// More or less offset.
    NudgeOffset(f32),
    /// The next layer (or the previous).
    CycleLayer(isize),
    /// Tone map.
    SetToneMap(ToneMap),
    /// Ends of the colour bar of the variance, as log10.
    SetVarianceRange([f32; 2]),
    /// Exposure, offset, tone map back to the defaults.
    ResetView,
    /// Sets the exposure from the picture, once, in plain sight.
    Normalise,
    /// Whole picture in the window.
    Fit,
    /// One image pixel per screen pixel.
    ActualSize,

    /// Holds or goes on.
    TogglePause,
    /// One pass, holding.
    Step,
    /// Passes per second, `None` for full speed.
    SetRate(Option<f32>),
    /// Again from the first sample.
    Restart,

    /// One step back.
    Undo,
    /// One step forward.
    Redo,

    /// Asks for a file to open.
    Open,
    /// Asks for a path to open, without a dialog of the desktop.
    OpenTyped,
    /// Opens a scene or a snapshot.
    OpenPath(PathBuf),
    /// Opens a scene shipped in the program.
    OpenShipped(Shipped),
    /// Saves a snapshot under the next free name.
    Save,
    /// Asks for the folder of snapshots.
    ChooseFolder,
    /// Copies the picture as it is shown.
    CopyPicture,
    /// Copies the values under the cursor.
    CopyValues,

    /// Shows or hides the side panels (the projector view).
    TogglePanels,
    /// Shows or hides the panel on the right.
    ToggleInspector,
    /// No fades, or fades again.
    ToggleMotion,
    /// Full screen and back.
    ToggleFullScreen,
    /// Light, dark or as the system.
    SetTheme(ThemePreference),
    /// Makes everything larger or smaller by that factor; `None` is back to 100 %.
    ZoomInterface(Option<f32>),
    /// The sheet of keys.
    ToggleHelp,
    /// The list of all commands.
    TogglePalette,
    /// The tutorial's table.
    ToggleTable,
}

/// Scenes inside the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shipped {
    /// The tutorial's scene.
    Veach,
    /// The public plastic version with an overhead light.
    VeachPlastic,
}

impl Shipped {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Veach, Self::VeachPlastic];

    /// Name in menus.
    pub fn name(self) -> &'static str {
        match self {
            Self::Veach => "Veach's plates (the tutorial)",
            Self::VeachPlastic => "Veach's plates in plastic, five lights",
        }
    }
}

impl Command {
    /// What a step of undo over this command is about; `None` for what is not undone.
    pub fn edit_key(&self) -> Option<EditKey> {
        Some(match *self {
            Self::SetStrategy(_) => EditKey("strategy", 0),
            Self::SetLightProb(_) => EditKey("c", 0),
            Self::SetHeuristic(_) => EditKey("heuristic", 0),
            Self::SetWeights(_) => EditKey("weights", 0),
            Self::SetSampler(_) => EditKey("sampler", 0),
            Self::SetJitter(_) => EditKey("jitter", 0),
            Self::SetSpp(_) => EditKey("spp", 0),
            Self::SetSeed(_) => EditKey("seed", 0),
            Self::SetAlpha(material, _) => EditKey("alpha", material),
            Self::SetLightRadius(shape, _) => EditKey("radius", shape),
            Self::SetLightOn(shape, _) => EditKey("light on", shape),
            Self::ResetScene => EditKey("reset scene", 0),
            Self::SetLayer(_) => EditKey("layer", 0),
            Self::SetExposure(_) => EditKey("exposure", 0),
            Self::SetOffset(_) => EditKey("offset", 0),
            Self::NudgeExposure(_) => EditKey("exposure", 1),
            Self::NudgeOffset(_) => EditKey("offset", 1),
            Self::CycleLayer(_) => EditKey("layer", 1),
            Self::SetToneMap(_) => EditKey("tone map", 0),
            Self::SetVarianceRange(_) => EditKey("variance range", 0),
            Self::ResetView => EditKey("reset view", 0),
            _ => return None,
        })
    }

    /// Carries out a command that changes the document and nothing else; the others leave it alone.
    pub fn edit(&self, document: &mut Document) {
        let Document { opened, scene, settings, view } = document;
        match *self {
            Self::SetStrategy(strategy) => settings.estimator.strategy = strategy,
            Self::SetLightProb(c) => settings.estimator.light_prob = c.clamp(0.0, 1.0),
            Self::SetHeuristic(heuristic) => settings.estimator.heuristic = heuristic,
            Self::SetWeights(weights) => settings.estimator.weights = weights,
            Self::SetSampler(kind) => {
                settings.sampling.sampler.kind = kind;
                fit_strata(&mut settings.sampling.sampler, settings.sampling.spp);
            }
            Self::SetJitter(jitter) => settings.sampling.sampler.jitter = jitter,
            Self::SetSpp(target) => {
                settings.sampling.spp = match target {
                    SppTarget::Passes(n) => Some(n),
                    SppTarget::Endless => None,
                };
                fit_strata(&mut settings.sampling.sampler, settings.sampling.spp);
            }
            Self::SetSeed(seed) => settings.sampling.seed = seed,
            Self::SetAlpha(material, alpha) => {
                let scene = Arc::make_mut(scene);
                if let Some(a) = scene.materials.get_mut(material).and_then(|m| m.bsdf.alpha_mut()) {
                    *a = alpha.clamp(0.0, 1.0);
                }
            }
            Self::SetLightRadius(shape, radius) if shape < scene.shapes.len() && radius > 0.0 => {
                Arc::make_mut(scene).set_light_radius(&opened.scene, shape, radius);
            }
            Self::SetLightOn(shape, on) => {
                let scene = Arc::make_mut(scene);
                if let Some(light) = scene.shapes.get_mut(shape).and_then(|s| s.light.as_mut()) {
                    light.on = on;
                }
            }
            Self::ResetScene => {
                *scene = opened.scene.clone();
                *settings = opened.settings.clone();
            }
            Self::SetLayer(layer) => view.layer = layer,
            Self::SetExposure(ev) => view.exposure_ev = ev,
            Self::SetOffset(offset) => view.offset = offset,
            Self::NudgeExposure(stops) => {
                view.exposure_ev = (view.exposure_ev + stops).clamp(-ViewState::MAX_EV, ViewState::MAX_EV);
            }
            Self::NudgeOffset(step) => view.offset = ((view.offset + step) * 100.0).round() / 100.0,
            Self::CycleLayer(step) => {
                let at = Layer::ALL.iter().position(|l| *l == view.layer).unwrap_or(0);
                view.layer = Layer::ALL[(at as isize + step).rem_euclid(Layer::ALL.len() as isize) as usize];
            }
            Self::SetToneMap(tone_map) => view.tone_map = tone_map,
            Self::SetVarianceRange(range) => view.variance_range = range,
            Self::ResetView => view.reset_display(),
            _ => {}
        }
    }
}

/// A stratified pattern has as many strata as the picture has samples, so that the whole of it is
/// used; other samplers keep theirs, which has no effect on them.
fn fit_strata(sampler: &mut SamplerSettings, spp: Option<NonZeroU32>) {
    let (SamplerKind::Stratified, Some(spp)) = (sampler.kind, spp) else { return };
    if u64::from(sampler.strata[0]) * u64::from(sampler.strata[1]) != u64::from(spp.get()) {
        sampler.strata = SamplerSettings::strata_for(spp.get());
    }
}
