//! Snapshots: an EXR under a name that is free, perhaps with a PNG beside it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use mislab_renderer::snapshot::{self, SaveOptions, write_file};
use mislab_renderer::{Error, Frame};

use crate::files::png_file;
use crate::picture::still::render_to_rgba8;
use crate::state::view::StoredView;

/// A snapshot to be written.
pub struct SaveJob {
    /// The picture.
    pub frame: Arc<Frame>,
    /// How it is looked at.
    pub view: StoredView,
    /// Dark theme (false colours differ).
    pub dark: bool,
    /// Where to.
    pub folder: PathBuf,
    /// Name without extension.
    pub stem: String,
    /// A PNG of the view beside it.
    pub png: bool,
}

impl SaveJob {
    /// Writes it; returns where, and something to know about it.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn run(self) -> Result<(PathBuf, Option<String>), Error> {
        let Self { frame, view, dark, folder, stem, png } = self;
        let extensions: &[&str] = if png { &["exr", "png"] } else { &["exr"] };
        let path = next_free(&folder, &stem, extensions);
        let options = SaveOptions { view: serde_json::to_string(&view).ok(), ..SaveOptions::default() };
        let saved = snapshot::save(&frame, &path, &options)?;
        if png {
            let (width, height, rgba) = render_to_rgba8(&frame, view.layer, &view.view, dark);
            let path = path.with_extension("png");
            let bytes = png_file::encode(width, height, &rgba).map_err(|e| Error::file(&path, e.to_string()))?;
            write_file(&path, &bytes)?;
        }
        Ok((path, saved.notice))
    }
}

/// `stem.ext`, or `stem_2.ext`, `stem_3.ext` ...: the first name of which none of the extensions is taken.
pub fn next_free(folder: &Path, stem: &str, extensions: &[&str]) -> PathBuf {
    let stem = stem.strip_suffix(".exr").unwrap_or(stem);
    let name = |n: u32| if n == 1 { stem.to_owned() } else { format!("{stem}_{n}") };
    let free = |n: &u32| extensions.iter().all(|e| !folder.join(format!("{}.{e}", name(*n))).exists());
    let n = (1..=u32::MAX).find(free).unwrap_or(u32::MAX);
    folder.join(format!("{}.{}", name(n), extensions[0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_never_taken_twice() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let free = |extensions: &[&str]| {
            let path = next_free(folder.path(), "veach", extensions);
            path.file_name().expect("a name").to_string_lossy().into_owned()
        };
        assert_eq!(free(&["exr"]), "veach.exr");
        std::fs::write(folder.path().join("veach.exr"), "").expect("write");
        assert_eq!(free(&["exr", "png"]), "veach_2.exr");
        std::fs::write(folder.path().join("veach_2.png"), "").expect("write");
        assert_eq!(free(&["exr", "png"]), "veach_3.exr");
        assert_eq!(free(&["exr"]), "veach_2.exr");
    }
}
