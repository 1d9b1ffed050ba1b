//! What can be opened: scene files, snapshots, the scenes in the program.

use std::path::Path;

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
