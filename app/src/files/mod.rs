//! Files, off the UI thread: dialogs, opening, snapshots. Results come back as events.

pub mod opening;
pub mod png_file;
pub mod saving;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use eframe::egui;
use mislab_renderer::Frame;
use mislab_renderer::snapshot::{self, SaveOptions, write_file};

use self::opening::{PictureFile, picture, read};
use self::saving::{SaveJob, next_free};
use crate::state::document::Opened;

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
    /// A picture to look at was read.
    Picture(Box<PictureFile>),
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
            if let Some(file) = picture(&path) {
                return Some(FileEvent::Picture(Box::new(file)));
            }
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
