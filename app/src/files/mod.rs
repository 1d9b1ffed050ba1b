//! Files, off the UI thread: dialogs, opening, snapshots. Results come back as events.

pub mod png_file;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use eframe::egui;
use mislab_renderer::snapshot::{self, SaveOptions, write_file};
use mislab_renderer::{Error, Frame, pbrt};

use crate::files::png_file;
use crate::picture::viewport::render_to_rgba8;
use crate::state::command::Shipped;
use crate::state::document::Opened;
use crate::state::view::ViewState;

/// What came of something started here.
#[derive(Debug)]
pub enum FileEvent {
    /// A file was chosen in the dialog.
    Picked(PathBuf),
    /// A folder was chosen in the dialog.
    PickedFolder(PathBuf),
    /// No dialog came up: this desktop offers none.
    NoDialog,
    /// A file was read.
    Opened(Box<Opened>),
    /// A file could not be read.
    OpenFailed {
        /// Which.
        path: PathBuf,
        /// Why, with line and column for a scene.
        message: String,
    },
    /// A snapshot was written.
    Saved {
        /// The EXR.
        path: PathBuf,
        /// Something to know about it.
        notice: Option<String>,
    },
    /// A snapshot could not be written.
    SaveFailed(String),
    /// Something of the table was written.
    TableSaved(String),
    /// Something of the table could not be written.
    TableNotSaved(String),
}

/// A dialog that is gone within this time was never there: a missing portal answers like "cancelled".
const NO_DIALOG: Duration = Duration::from_millis(400);

/// Starts work on files and collects what comes of it.
pub struct Files {
    ctx: egui::Context,
    sender: Sender<FileEvent>,
    receiver: Receiver<FileEvent>,
}

impl Files {
    /// Events wake `ctx`.
    pub fn new(ctx: &egui::Context) -> Self {
        let (sender, receiver) = channel();
        Self { ctx: ctx.clone(), sender, receiver }
    }

    /// What has happened since the last call.
    pub fn events(&self) -> Vec<FileEvent> {
        self.receiver.try_iter().collect()
    }

    fn start(&self, name: &str, work: impl FnOnce() -> Option<FileEvent> + Send + 'static) {
        let (sender, ctx) = (self.sender.clone(), self.ctx.clone());
        let spawned = std::thread::Builder::new().name(name.into()).spawn(move || {
            if let Some(event) = work() {
                // The window may have closed meanwhile; then nobody is interested.
                let _ = sender.send(event);
                ctx.request_repaint();
            }
        });
        if let Err(error) = spawned {
            let _ = self.sender.send(FileEvent::SaveFailed(format!("no thread for files: {error}")));
        }
    }

    /// Asks for a file with the desktop's dialog.
    pub fn pick(&self, folder: Option<PathBuf>) {
        self.start("open dialog", move || {
            let started = Instant::now();
            let mut dialog = rfd::FileDialog::new()
                .set_title("Open a scene or a snapshot")
                .add_filter("Scenes and snapshots", &["pbrt", "exr"])
                .add_filter("All files", &["*"]);
            if let Some(folder) = folder {
                dialog = dialog.set_directory(folder);
            }
            match dialog.pick_file() {
                Some(path) => Some(FileEvent::Picked(path)),
                None if started.elapsed() < NO_DIALOG => Some(FileEvent::NoDialog),
                None => None,
            }
        });
    }

    /// Asks for the folder of snapshots with the desktop's dialog.
    pub fn pick_folder(&self, folder: PathBuf) {
        self.start("folder dialog", move || {
            let dialog = rfd::FileDialog::new().set_title("Folder of snapshots").set_directory(folder);
            dialog.pick_folder().map(FileEvent::PickedFolder)
        });
    }

    /// Reads a scene or a snapshot.
    pub fn open(&self, path: PathBuf) {
        self.start("open", move || {
            Some(match read(&path) {
                Ok(opened) => FileEvent::Opened(Box::new(opened)),
                Err(error) => FileEvent::OpenFailed { path, message: error.to_string() },
            })
        });
    }

    /// Writes a snapshot under the next free name.
    pub fn save(&self, job: SaveJob) {
        self.start("save", move || {
            Some(match job.run() {
                Ok((path, notice)) => FileEvent::Saved { path, notice },
                Err(error) => FileEvent::SaveFailed(error.to_string()),
            })
        });
    }

    /// Writes a text under the next free name.
    pub fn save_text(&self, folder: PathBuf, stem: String, extension: &'static str, text: String) {
        self.start("save text", move || {
            let path = next_free(&folder, &stem, &[extension]);
            Some(match write_file(&path, text.as_bytes()) {
                Ok(()) => FileEvent::TableSaved(format!("Saved {}", path.display())),
                Err(error) => FileEvent::TableNotSaved(error.to_string()),
            })
        });
    }

    /// Writes the tutorial's pictures under the tutorial's names, over older ones.
    pub fn save_tutorial(&self, folder: PathBuf, pictures: Vec<(&'static str, Arc<Frame>)>) {
        self.start("save tutorial", move || {
            let saved = pictures.iter().try_for_each(|(name, frame)| {
                snapshot::save(frame, &folder.join(name), &SaveOptions::default()).map(drop)
            });
            let names: Vec<&str> = pictures.iter().map(|(name, _)| *name).collect();
            Some(match saved {
                Ok(()) => FileEvent::TableSaved(format!("Saved {} in {}", names.join(", "), folder.display())),
                Err(error) => FileEvent::TableNotSaved(error.to_string()),
            })
        });
    }
}

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
    let view = restored.view.as_deref().and_then(|text| serde_json::from_str::<ViewState>(text).ok());
    let stem = path.file_stem().map_or_else(|| "mislab".into(), |s| s.to_string_lossy().into_owned());
    Ok(Opened {
        title: stem.clone(),
        scene: request.scene,
        settings: request.settings,
        view: view.unwrap_or_default(),
        warnings: Vec::new(),
        path: Some(path.to_owned()),
        snapshot_stem: stem,
    })
}

/// A snapshot to be written.
pub struct SaveJob {
    /// The picture.
    pub frame: Arc<Frame>,
    /// How it is looked at.
    pub view: ViewState,
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
    fn run(self) -> Result<(PathBuf, Option<String>), Error> {
        let Self { frame, view, dark, folder, stem, png } = self;
        let extensions: &[&str] = if png { &["exr", "png"] } else { &["exr"] };
        let path = next_free(&folder, &stem, extensions);
        let options = SaveOptions { view: serde_json::to_string(&view).ok(), ..SaveOptions::default() };
        let saved = snapshot::save(&frame, &path, &options)?;
        if png {
            let (width, height, rgba) = render_to_rgba8(&frame, &view, dark);
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
