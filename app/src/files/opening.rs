//! What can be opened: scene files, snapshots, the scenes in the program.

use std::path::{Path, PathBuf};

use mislab_renderer::snapshot::{Image, Part};
use mislab_renderer::{Error, pbrt, snapshot};

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

/// Reads a scene or, by its extension, a snapshot.
///
/// # Errors
/// As [`pbrt::load`] and [`snapshot::restore`].
pub fn read(path: &Path) -> Result<Opened, Error> {
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
        return Ok(Opened::from_scene_file(pbrt::load(path)?, Some(path.to_owned())));
    }
    let restored = snapshot::restore(path)?;
    let request = restored.picture_request();
    let stored = restored.view.as_deref().and_then(|text| serde_json::from_str::<StoredView>(text).ok());
    let StoredView { layer, view } = stored.unwrap_or_default();
    let stem = path.file_stem().map_or_else(|| "mislab".into(), |s| s.to_string_lossy().into_owned());
    Ok(Opened {
        title: stem.clone(),
        scene: request.scene,
        settings: request.settings,
        layer,
        view,
        warnings: Vec::new(),
        path: Some(path.to_owned()),
        snapshot_stem: stem,
    })
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

/// A file that is only to be looked at; `None` if it is none of these.
pub fn picture(path: &Path) -> Option<PictureFile> {
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
        return None;
    }
    let info = snapshot::info(path).ok()?;
    let remark = match info.restored {
        Ok(Some(_)) => return None,
        Ok(None) => "Made by another program: it can be looked at, but not rendered again.".to_owned(),
        Err(error) => format!("It can be looked at, but not rendered again: {error}"),
    };
    let image = snapshot::load_image(path).map_err(|error| error.to_string());
    Some(PictureFile { path: path.to_owned(), remark, parts: info.parts, image })
}
