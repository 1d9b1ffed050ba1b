//! What to render, as plain data: the scene and the settings.

pub mod scene;
pub mod settings;
mod technique;

use std::sync::Arc;

pub use scene::{Bsdf, Camera, Geometry, Light, Material, Reflectance, Scene, Shape};
pub use settings::{
    Estimator, Heuristic, ImageSettings, OneSampleWeights, PixelRect, SamplerKind, SamplerSettings, Sampling, Settings,
    Strategy,
};
pub use technique::{PerTechnique, Technique};

/// What to render.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// The scene, with every edit applied.
    pub scene: Arc<Scene>,
    /// Estimator, samples and image.
    pub settings: Settings,
}

impl Request {
    /// True if `other` asks for the same samples, perhaps for more or fewer of them.
    pub fn same_samples(&self, other: &Self) -> bool {
        let sampling = Sampling { spp: other.settings.sampling.spp, ..self.settings.sampling };
        let settings = Settings { sampling, ..self.settings.clone() };
        settings == other.settings && (Arc::ptr_eq(&self.scene, &other.scene) || self.scene == other.scene)
    }
}

/// A scene or setting that cannot be rendered: the value found and what was expected, in one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Invalid(pub String);

impl std::fmt::Display for Invalid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Invalid {}
