//! What to render, as plain data: a scene and settings.

use std::num::NonZeroU32;
use std::sync::Arc;

use crate::scene::Scene;
use crate::settings::Settings;

/// What to render. The same request gives the same picture, bit for bit.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// The scene, with every edit applied.
    pub scene: Arc<Scene>,
    /// Strategy, samples and image.
    pub settings: Settings,
}

impl Request {
    /// True if `other` asks for the same samples, perhaps for more or fewer of them.
    pub fn same_samples(&self, other: &Self) -> bool {
        let settings = Settings { spp: other.settings.spp, ..self.settings.clone() };
        // A scene is compared by its numbers only if it is not the very same one.
        settings == other.settings && (Arc::ptr_eq(&self.scene, &other.scene) || self.scene == other.scene)
    }

    /// Samples per pixel to stop at; `None` goes on until stopped.
    pub(crate) fn target(&self) -> Option<u32> {
        self.settings.spp.map(NonZeroU32::get)
    }
}
