//! What the window edits: scene, settings and view, with undo over all of it.

use std::path::PathBuf;
use std::sync::Arc;

use mislab_renderer::pbrt::SceneFile;
use mislab_renderer::{Diagnostic, Geometry, PixelRect, Request, Scene, Settings};

use crate::state::view::ViewState;

/// Where a scene came from and how it was there: what resets go back to.
#[derive(Clone, Debug, PartialEq)]
pub struct Opened {
    /// The scene as the file says it.
    pub scene: Arc<Scene>,
    /// The settings as the file says them.
    pub settings: Settings,
    /// The view as the file says it; the default view for a scene file.
    pub view: ViewState,
    /// What the reader did not understand.
    pub warnings: Vec<Diagnostic>,
    /// The file, `None` for a scene shipped inside the program.
    pub path: Option<PathBuf>,
    /// Name for titles.
    pub title: String,
    /// Name that snapshots start from, without extension.
    pub snapshot_stem: String,
}

impl Opened {
    /// What a scene file says, with the default view.
    pub fn from_scene_file(file: SceneFile, path: Option<PathBuf>) -> Self {
        let stem = PathBuf::from(&file.film_filename).file_stem().map(|s| s.to_string_lossy().into_owned());
        Self {
            title: file.scene.name.clone(),
            scene: Arc::new(file.scene),
            settings: file.settings,
            view: ViewState::default(),
            warnings: file.warnings,
            path,
            snapshot_stem: stem.filter(|s| !s.is_empty()).unwrap_or_else(|| "mislab".into()),
        }
    }
}

/// Everything a control sets: one step of undo is one of these.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    /// Where it came from.
    pub opened: Arc<Opened>,
    /// The scene with every edit applied.
    pub scene: Arc<Scene>,
    /// Strategy, samples, image.
    pub settings: Settings,
    /// How it is looked at; never reaches the renderer.
    pub view: ViewState,
}

impl Document {
    /// A file as it was opened, without edits.
    pub fn new(opened: Opened) -> Self {
        Self {
            scene: opened.scene.clone(),
            settings: opened.settings.clone(),
            view: opened.view.clone(),
            opened: Arc::new(opened),
        }
    }

    /// What the renderer should be working on.
    pub fn request(&self) -> Request {
        Request { scene: self.scene.clone(), settings: self.settings.clone() }
    }

    /// The GGX width of a material, if it has one.
    pub fn alpha(&self, material: usize) -> Option<f32> {
        self.scene.materials.get(material)?.bsdf.alpha()
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

    /// Pixels of the picture.
    pub fn bounds(&self) -> PixelRect {
        self.settings.pixel_bounds()
    }
}

/// What a step of undo is about: edits of one control in one gesture make one step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EditKey(pub &'static str, pub usize);

/// Undo and redo.
#[derive(Debug, Default)]
pub struct History {
    undo: Vec<Document>,
    redo: Vec<Document>,
    gesture: Option<EditKey>,
}

impl History {
    /// Steps kept; a document is a few pointers and numbers.
    const DEPTH: usize = 500;

    /// Remembers `before`, unless the same gesture has already done so.
    pub fn record(&mut self, before: Document, key: EditKey) {
        self.redo.clear();
        if self.gesture == Some(key) {
            return;
        }
        self.gesture = Some(key);
        if self.undo.len() == Self::DEPTH {
            self.undo.remove(0);
        }
        self.undo.push(before);
    }

    /// The mouse button is up: the next edit is a step of its own.
    pub fn end_gesture(&mut self) {
        self.gesture = None;
    }

    /// Is there anything to undo?
    pub fn can_undo(&self) -> bool {
        !self.undo.is_empty()
    }

    /// Is there anything to redo?
    pub fn can_redo(&self) -> bool {
        !self.redo.is_empty()
    }

    /// Goes one step back. Where one looks (zoom and pan) stays.
    pub fn undo(&mut self, document: &mut Document) {
        if let Some(previous) = self.undo.pop() {
            self.redo.push(swap(document, previous));
        }
        self.gesture = None;
    }

    /// Takes one undo back.
    pub fn redo(&mut self, document: &mut Document) {
        if let Some(next) = self.redo.pop() {
            self.undo.push(swap(document, next));
        }
        self.gesture = None;
    }
}

fn swap(document: &mut Document, mut other: Document) -> Document {
    other.view.placement = document.view.placement;
    std::mem::replace(document, other)
}
