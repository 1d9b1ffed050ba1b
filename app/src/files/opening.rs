//! What can be opened: scene files, snapshots, the scenes in the program.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use mislab_renderer::snapshot::{Image, Part};
use mislab_renderer::{Error, pbrt, snapshot};

use crate::files::watching::{Watched, stamp};
use crate::picture::foreign::Foreign;
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

/// A file that was read, or why not.
#[derive(Debug)]
pub struct Reading {
    /// The file.
    pub path: PathBuf,
    /// What it says.
    pub outcome: Result<Box<Opened>, Unreadable>,
    /// What the outcome depends on, the file itself first; empty for a snapshot, which nobody edits.
    pub files: Vec<Watched>,
}

/// Why a file could not be opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unreadable {
    /// What was found and what was expected, with line and column for a scene.
    pub message: String,
    /// The line it is about.
    pub line: Option<String>,
}

/// Reads a scene or, by its extension, a snapshot. `before`: what the last reading of it depended on.
pub fn read(path: PathBuf, before: &[Watched]) -> Reading {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
        let outcome = restore(&path).map(Box::new).map_err(|error| unreadable(&error, &[]));
        return Reading { path, outcome, files: Vec::new() };
    }
    // From before the reading, lest a change in between goes unnoticed.
    let first = stamp(&path);
    let stamps: Vec<_> = before.iter().map(|file| (file.path.clone(), stamp(&file.path))).collect();
    let (outcome, files) = pbrt::load_with_files(&path);
    let stamp_of = |file: &Path| {
        let known = stamps.iter().find(|(path, _)| path == file).map(|(_, stamp)| *stamp);
        if file == path { first } else { known.unwrap_or_else(|| stamp(file)) }
    };
    let files: Vec<Watched> = files
        .into_iter()
        .map(|file| {
            let stamp = stamp_of(&file);
            Watched::new(file, stamp, before)
        })
        .collect();
    let outcome = outcome
        .map(|file| Box::new(Opened::from_scene_file(file, Some(path.clone()))))
        .map_err(|error| unreadable(&error, &files));
    Reading { path, outcome, files }
}

fn restore(path: &Path) -> Result<Opened, Error> {
    let restored = snapshot::restore(path)?;
    let request = restored.picture_request();
    let stored = restored.view.as_deref().and_then(|text| serde_json::from_str::<StoredView>(text).ok());
    let StoredView { layer, view } = stored.unwrap_or_default();
    Ok(Opened {
        title: path.file_stem().map_or_else(|| "mislab".into(), |s| s.to_string_lossy().into_owned()),
        scene: request.scene,
        settings: request.settings,
        layer,
        view,
        warnings: Vec::new(),
        path: Some(path.to_owned()),
    })
}

fn unreadable(error: &Error, files: &[Watched]) -> Unreadable {
    const LONGEST: usize = 100;
    let line = match error {
        Error::Scene(diagnostic) => {
            let place = &diagnostic.location;
            let file = files.iter().find(|file| file.path.display().to_string() == *place.file);
            let text: Option<&Arc<str>> = file.and_then(|file| file.text.as_ref());
            let line = text.and_then(|text| text.lines().nth(place.line.saturating_sub(1) as usize));
            line.map(|line| format!("{} | {}", place.line, crate::state::paths::shortened(line.trim(), LONGEST)))
        }
        Error::Io { .. } | Error::File { .. } | Error::Invalid(_) => None,
    };
    Unreadable { message: super::short_message(error), line }
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

/// A picture to compare with, whoever has made it.
///
/// # Errors
/// If it cannot be read, in words.
pub fn compared(path: &Path) -> Result<Foreign, String> {
    let image = snapshot::load_image(path).map_err(|error| super::short_message(&error))?;
    Foreign::new(path, image, None)
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
