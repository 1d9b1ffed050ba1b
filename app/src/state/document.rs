//! What the window edits: scene, settings and view.

use std::path::PathBuf;
use std::sync::Arc;

use mislab_renderer::pbrt::SceneFile;
use mislab_renderer::{Diagnostic, Estimator, Geometry, ImageSettings, Layer, Request, Sampling, Scene, Settings};

use super::view::ViewState;

/// Where a scene came from and how it was there: what resets go back to.
#[derive(Clone, Debug, PartialEq)]
pub struct Opened {
    /// The scene as the file says it.
    pub scene: Arc<Scene>,
    /// The settings as the file says them.
    pub settings: Settings,
    /// The layer as the file says it; the picture for a scene file.
    pub layer: Layer,
    /// The view as the file says it; the default view for a scene file.
    pub view: ViewState,
    /// What the reader did not understand.
    pub warnings: Vec<Diagnostic>,
    /// The file, `None` for a scene shipped inside the program.
    pub path: Option<PathBuf>,
    /// Name for titles.
    pub title: String,
}

impl Opened {
    /// What a scene file says, with the default view.
    pub fn from_scene_file(file: SceneFile, path: Option<PathBuf>) -> Self {
        Self {
            title: file.scene.name.clone(),
            scene: Arc::new(file.scene),
            settings: file.settings,
            layer: Layer::Picture,
            view: ViewState::default(),
            warnings: file.warnings,
            path,
        }
    }
}

/// One picture of the document: what it has to itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slot {
    /// How the radiance is estimated.
    pub estimator: Estimator,
    /// Which image of the frame is shown.
    pub layer: Layer,
}

/// Everything a control sets. Pictures differ in their [`Slot`]s and share the rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    /// Where it came from.
    pub opened: Arc<Opened>,
    /// The scene with every edit applied.
    pub scene: Arc<Scene>,
    /// Samples and their random numbers.
    pub sampling: Sampling,
    /// Image size and crop.
    pub image: ImageSettings,
    /// How the pictures are looked at; never reaches the renderer.
    pub view: ViewState,
    /// The pictures, at least one.
    slots: Vec<Slot>,
    /// Index of the one that controls are about.
    active: usize,
}

impl Document {
    /// A file as it was opened, without edits.
    pub fn new(opened: Opened) -> Self {
        let Settings { estimator, sampling, image } = opened.settings;
        Self {
            scene: opened.scene.clone(),
            sampling,
            image,
            view: opened.view.clone(),
            slots: vec![Slot { estimator, layer: opened.layer }],
            active: 0,
            opened: Arc::new(opened),
        }
    }

    /// The same document after its file has changed: what the file says, looked at as before.
    pub fn reloaded(&self, opened: Opened) -> Self {
        let layer = self.active().layer;
        let mut document = Self { view: self.view.clone(), ..Self::new(opened) };
        document.active_mut().layer = layer;
        document
    }

    /// The pictures, in their order on screen.
    pub fn slots(&self) -> &[Slot] {
        &self.slots
    }

    /// Which of [`Self::slots`] controls are about.
    pub fn active_index(&self) -> usize {
        self.active
    }

    /// The picture that controls are about.
    pub fn active(&self) -> &Slot {
        &self.slots[self.active]
    }

    /// The same, for editing.
    pub fn active_mut(&mut self) -> &mut Slot {
        &mut self.slots[self.active]
    }

    /// Everything but the scene that decides the bits of a picture.
    pub fn settings(&self, slot: &Slot) -> Settings {
        Settings { estimator: slot.estimator, sampling: self.sampling, image: self.image }
    }

    /// What the renderer should be working on for a picture.
    pub fn request(&self, slot: &Slot) -> Request {
        Request { scene: self.scene.clone(), settings: self.settings(slot) }
    }

    /// Scene and settings back to the file's; the view stays.
    pub fn reset_scene(&mut self) {
        let Settings { estimator, sampling, image } = self.opened.settings;
        self.scene = self.opened.scene.clone();
        self.sampling = sampling;
        self.image = image;
        self.active_mut().estimator = estimator;
    }

    /// Whether [`Self::reset_scene`] would change anything.
    pub fn is_edited(&self) -> bool {
        self.scene != self.opened.scene || self.settings(self.active()) != self.opened.settings
    }

    /// The GGX width of a material in the file.
    pub fn original_alpha(&self, material: usize) -> Option<f32> {
        self.opened.scene.materials.get(material)?.bsdf.alpha()
    }

    /// The radius of a sphere in `scene`.
    pub fn radius(scene: &Scene, shape: usize) -> Option<f32> {
        match scene.shapes.get(shape)?.geometry {
            Geometry::Sphere { radius, .. } => Some(radius),
            Geometry::Mesh { .. } => None,
        }
    }
}
