//! What can be opened: scene files, snapshots, the scenes in the program.

use std::path::{Path, PathBuf};

use mislab_renderer::snapshot::{self, Image, Part, Restored};
use mislab_renderer::{Error, pbrt};

use crate::state::command::Shipped;
use crate::state::document::Opened;
use crate::state::view::StoredView;

/// A scene shipped inside the program.
pub fn shipped(which: Shipped) -> Opened {
    let file = match which {
        Shipped::Veach => pbrt::embedded_scene(),
        Shipped::VeachPlastic => pbrt::embedded_plastic_scene(),
    };
    Opened::from_scene_file(file, None)
}

/// What a file turned out to be.
#[derive(Debug)]
pub enum Found {
    /// Something to render.
    Scene(Box<Opened>),
    /// A picture to look at.
    Picture(Box<PictureFile>),
}

/// An EXR file that cannot be rendered again, because another program wrote it or its state cannot be used.
#[derive(Debug)]
pub struct PictureFile {
    /// The file.
    pub path: PathBuf,
    /// Why it is only to be looked at.
    pub remark: String,
    /// What it says about itself.
    pub parts: Vec<Part>,
    /// Its pixels, or why they cannot be shown.
    pub image: Result<Image, String>,
}

/// Reads a scene or, by its extension, a picture.
///
/// # Errors
/// As [`pbrt::load`] and [`snapshot::info`].
pub fn read(path: &Path) -> Result<Found, Error> {
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
        let opened = Opened::from_scene_file(pbrt::load(path)?, Some(path.to_owned()));
        return Ok(Found::Scene(Box::new(opened)));
    }
    let info = snapshot::info(path)?;
    let remark = match info.restored {
        Ok(Some(restored)) => return Ok(Found::Scene(Box::new(from_snapshot(path, restored)))),
        Ok(None) => "Made by another program: it can be looked at, but not rendered again.".to_owned(),
        Err(error) => format!("It can be looked at, but not rendered again: {error}"),
    };
    let image = snapshot::load_image(path).map_err(|error| error.to_string());
    Ok(Found::Picture(Box::new(PictureFile { path: path.to_owned(), remark, parts: info.parts, image })))
}

fn from_snapshot(path: &Path, restored: Restored) -> Opened {
    let request = restored.picture_request();
    let stored = restored.view.as_deref().and_then(|text| serde_json::from_str::<StoredView>(text).ok());
    let StoredView { layer, view } = stored.unwrap_or_default();
    let stem = path.file_stem().map_or_else(|| "mislab".into(), |s| s.to_string_lossy().into_owned());
    Opened {
        title: stem.clone(),
        scene: request.scene,
        settings: request.settings,
        layer,
        view,
        warnings: Vec::new(),
        path: Some(path.to_owned()),
        snapshot_stem: stem,
    }
}
