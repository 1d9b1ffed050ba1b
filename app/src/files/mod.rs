//! Files, off the UI thread: dialogs, opening, watching, snapshots, preferences. Results come back as events.

pub mod kept;
pub mod opening;
pub mod queue;
pub mod room;
pub mod saving;
pub mod showing;
pub mod watching;

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use eframe::egui;
use mislab_renderer::snapshot::{self, SaveOptions};
use mislab_renderer::{Error, Frame};

use self::opening::{PictureFile, Reading, compared, picture, read};
use self::queue::Queue;
use self::saving::{NotSaved, SaveJob, Saved, write_free};
use self::watching::{Watched, Watcher};
use crate::picture::foreign::Foreign;
use crate::picture::paper::Paper;
use crate::state::paths::{short_name, shortened};
use crate::state::prefs::Prefs;

/// What came of something started here.
#[derive(Debug)]
pub enum FileEvent {
    /// A file was chosen in the dialog.
    Picked(PathBuf),
    /// A picture to compare with was read.
    Compared(Foreign),
    /// A picture to compare with could not be read.
    NotCompared(String),
    /// No dialog came up to choose one.
    NoDialogToCompare,
    /// No dialog came up to choose one to measure against.
    NoDialogForReference,
    /// A folder was chosen in the dialog.
    PickedFolder(PathBuf),
    /// A picture to measure errors against was chosen.
    PickedReference(PathBuf),
    /// No dialog came up: this desktop offers none.
    NoDialog,
    /// A picture to look at was read.
    Picture(Box<PictureFile>),
    /// A file was read, or could not be.
    Read {
        /// What came of it.
        reading: Box<Reading>,
        /// What is different from the last reading of the same file, in words; `None` if there was none.
        changes: Option<String>,
    },
    /// Something that the file read last depends on has changed.
    Changed,
    /// A snapshot was written.
    Saved(Saved),
    /// A snapshot could not be written.
    NotSaved(NotSaved),
    /// A figure was written.
    Exported(PathBuf),
    /// A figure for the clipboard was made.
    Figure(Arc<egui::ColorImage>),
    /// Something of the table was written.
    TableSaved(String),
    /// Something of the table, or a figure, could not be written.
    TableNotSaved(String),
    /// Something could not even be started.
    Broken(String),
}

/// An event, and from which reading or from the queue.
struct Message {
    event: FileEvent,
    from: Origin,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Origin {
    Dialog,
    /// The how-manieth reading: only the last one counts.
    Reading(u64),
    Queue,
}

/// A dialog that is gone within this time was never there: a missing portal answers like "cancelled".
const NO_DIALOG: Duration = Duration::from_millis(400);

/// Reading takes shorter than this, as a rule, and then is not worth a word.
const NOTICEABLE: Duration = Duration::from_millis(300);

fn read_compared(path: &Path) -> FileEvent {
    match compared(path) {
        Ok(file) => FileEvent::Compared(file),
        Err(why) => FileEvent::NotCompared(why),
    }
}

/// What went wrong, with a long path cut in its middle: the reason stands behind it.
fn short_message(error: &Error) -> String {
    const LONGEST: usize = 60;
    let named = match error {
        Error::Scene(diagnostic) => diagnostic.location.file.to_string(),
        Error::Io { path, .. } | Error::File { path, .. } => path.display().to_string(),
        Error::Invalid(_) => String::new(),
    };
    error.to_string().replacen(&named, &shortened(&named, LONGEST), 1)
}

/// Starts work on files and collects what comes of it.
pub struct Files {
    ctx: egui::Context,
    sender: Sender<Message>,
    receiver: Receiver<Message>,
    queue: Queue,
    /// Names of what is in the queue.
    saving: VecDeque<String>,
    watcher: Watcher,
    readings: u64,
    /// When the last one was begun, if it is not over.
    reading: Option<Instant>,
    /// The last one that is over came to nothing.
    failed: bool,
    /// What it reads, and what that depended on the last time.
    last: Option<(PathBuf, Vec<Watched>)>,
    /// The one before: it goes on being looked after if the last one is only looked at.
    previous: Option<(PathBuf, Vec<Watched>)>,
}

impl Files {
    /// Events wake `ctx`.
    pub fn new(ctx: &egui::Context) -> Self {
        let (sender, receiver) = channel();
        let (watched, wake) = (sender.clone(), ctx.clone());
        let watcher = Watcher::new(move || {
            let _ = watched.send(Message { event: FileEvent::Changed, from: Origin::Dialog });
            wake.request_repaint();
        });
        Self {
            ctx: ctx.clone(),
            sender,
            receiver,
            queue: Queue::new(),
            saving: VecDeque::new(),
            watcher,
            readings: 0,
            reading: None,
            failed: false,
            last: None,
            previous: None,
        }
    }

    /// What has happened since the last call.
    pub fn events(&mut self) -> Vec<FileEvent> {
        let messages: Vec<Message> = self.receiver.try_iter().collect();
        messages.into_iter().filter_map(|message| self.accept(message)).collect()
    }

    /// The same, waiting for the first event up to `most`.
    pub fn events_within(&mut self, most: Duration) -> Vec<FileEvent> {
        let first = self.receiver.recv_timeout(most).ok();
        let mut events: Vec<FileEvent> = first.and_then(|message| self.accept(message)).into_iter().collect();
        events.extend(self.events());
        events
    }

    fn accept(&mut self, Message { event, from }: Message) -> Option<FileEvent> {
        match from {
            Origin::Dialog => {}
            Origin::Reading(number) if number != self.readings => return None,
            Origin::Reading(_) => {
                self.reading = None;
                if let FileEvent::Read { reading, .. } = &event {
                    self.failed = reading.outcome.is_err();
                    self.watcher.watch(&reading.files);
                    self.last = Some((reading.path.clone(), reading.files.clone()));
                } else {
                    self.last = self.previous.take();
                }
            }
            Origin::Queue => drop(self.saving.pop_front()),
        }
        Some(event)
    }

    /// Is anything being saved?
    pub fn is_saving(&self) -> bool {
        !self.saving.is_empty()
    }

    /// What is being done, in words, as soon as somebody might wonder.
    pub fn work(&self) -> Option<String> {
        if let Some(name) = self.saving.front() {
            return Some(format!("Saving {} \u{2026}", shortened(name, 48)));
        }
        let path = self.reading.filter(|since| since.elapsed() >= NOTICEABLE).and_then(|_| self.watched())?;
        Some(format!("Reading {} \u{2026}", short_name(path)))
    }

    /// Finishes all that was to be saved. Returns what could not be.
    pub fn finish(&mut self) -> Vec<String> {
        self.queue.finish();
        let failed = self.events().into_iter().filter_map(|event| match event {
            FileEvent::NotSaved(NotSaved { name, message, .. }) => Some(format!("{name} was not saved: {message}")),
            FileEvent::TableNotSaved(message) | FileEvent::Broken(message) => Some(message),
            FileEvent::Picked(_)
            | FileEvent::PickedFolder(_)
            | FileEvent::PickedReference(_)
            | FileEvent::NoDialog
            | FileEvent::Picture(_)
            | FileEvent::Read { .. }
            | FileEvent::Changed
            | FileEvent::Saved(_)
            | FileEvent::Exported(_)
            | FileEvent::Figure(_)
            | FileEvent::Compared(_)
            | FileEvent::NotCompared(_)
            | FileEvent::NoDialogToCompare
            | FileEvent::NoDialogForReference
            | FileEvent::TableSaved(_) => None,
        });
        failed.collect()
    }

    /// Does some work on a thread of its own.
    fn start(&self, name: &str, from: Origin, work: impl FnOnce() -> Option<FileEvent> + Send + 'static) {
        let (sender, ctx) = (self.sender.clone(), self.ctx.clone());
        let spawned = std::thread::Builder::new().name(name.into()).spawn(move || {
            if let Some(event) = work() {
                // The window may have closed meanwhile; then nobody is interested.
                let _ = sender.send(Message { event, from });
                ctx.request_repaint();
            }
        });
        if let Err(error) = spawned {
            let event = FileEvent::Broken(format!("No thread for files: {error}"));
            let _ = self.sender.send(Message { event, from: Origin::Dialog });
        }
    }

    /// Does some work after all that was to be saved before.
    fn enqueue(&mut self, name: String, work: impl FnOnce() -> FileEvent + Send + 'static) {
        let (sender, ctx) = (self.sender.clone(), self.ctx.clone());
        self.saving.push_back(name.clone());
        self.queue.push(move || {
            let broken = |_| FileEvent::Broken(format!("{name} was not saved: the thread broke down"));
            let event = catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(broken);
            let _ = sender.send(Message { event, from: Origin::Queue });
            ctx.request_repaint();
        });
    }

    /// Asks for a file with the desktop's dialog.
    pub fn pick(&self, folder: Option<PathBuf>) {
        self.start("open dialog", Origin::Dialog, move || {
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

    /// Asks for a picture to compare with, and reads it.
    pub fn pick_to_compare(&self, folder: Option<PathBuf>) {
        self.pick_picture("Compare with a picture", folder, |path| read_compared(&path), FileEvent::NoDialogToCompare);
    }

    /// Asks for a picture to measure errors against.
    pub fn pick_reference(&self) {
        let none = FileEvent::NoDialogForReference;
        self.pick_picture("A converged picture", None, FileEvent::PickedReference, none);
    }

    /// Asks for an EXR file with the desktop's dialog; `none` is said where no dialog comes up.
    fn pick_picture(
        &self,
        title: &'static str,
        folder: Option<PathBuf>,
        chosen: impl FnOnce(PathBuf) -> FileEvent + Send + 'static,
        none: FileEvent,
    ) {
        self.start("picture dialog", Origin::Dialog, move || {
            let started = Instant::now();
            let dialog = rfd::FileDialog::new().set_title(title).add_filter("OpenEXR", &["exr"]);
            let dialog = folder.into_iter().fold(dialog, |dialog, folder| dialog.set_directory(folder));
            match dialog.pick_file() {
                Some(path) => Some(chosen(path)),
                None if started.elapsed() < NO_DIALOG => Some(none),
                None => None,
            }
        });
    }

    /// Reads a picture to compare with.
    pub fn read_to_compare(&self, path: PathBuf) {
        self.start("compare", Origin::Dialog, move || Some(read_compared(&path)));
    }

    /// Asks for the folder of snapshots with the desktop's dialog.
    pub fn pick_folder(&self, folder: PathBuf) {
        self.start("folder dialog", Origin::Dialog, move || {
            let dialog = rfd::FileDialog::new().set_title("Folder of snapshots").set_directory(folder);
            dialog.pick_folder().map(FileEvent::PickedFolder)
        });
    }

    /// Reads a scene or a picture, again if it was the last one. Whatever was being read before is given up.
    pub fn open(&mut self, path: PathBuf) {
        self.readings += 1;
        self.reading = Some(Instant::now());
        self.ctx.request_repaint_after(NOTICEABLE);
        self.previous = self.last.take();
        let before = self.previous.as_ref().filter(|(last, _)| *last == path).map(|(_, files)| files.clone());
        self.last = Some((path.clone(), before.clone().unwrap_or_default()));
        self.start("open", Origin::Reading(self.readings), move || {
            if let Some(file) = picture(&path) {
                return Some(FileEvent::Picture(Box::new(file)));
            }
            let reading = read(path, before.as_deref().unwrap_or_default());
            let changes = before.map(|before| watching::changes(&before, &reading.files));
            Some(FileEvent::Read { reading: Box::new(reading), changes })
        });
    }

    /// The file that is looked after: the last one that was asked for.
    pub fn watched(&self) -> Option<&Path> {
        self.last.as_ref().map(|(path, _)| path.as_path())
    }

    /// Whether what is known of the file at `path` is from before it was changed to something that cannot be read.
    pub fn is_outdated(&self, path: Option<&Path>) -> bool {
        self.failed && path.is_some() && path == self.watched()
    }

    /// Whether a file is being read.
    pub fn is_reading(&self) -> bool {
        self.reading.is_some()
    }

    /// Forgets the file read last: a scene of the program has none.
    pub fn forget(&mut self) {
        self.readings += 1;
        self.reading = None;
        self.failed = false;
        self.last = None;
        self.watcher.watch(&[]);
    }

    /// Writes a snapshot under the next free name.
    pub fn save(&mut self, job: SaveJob) {
        self.enqueue(job.name.clone(), move || match job.run() {
            Ok(saved) => FileEvent::Saved(saved),
            Err(not_saved) => FileEvent::NotSaved(not_saved),
        });
    }

    /// Makes a figure and writes it under the next free name.
    pub fn export(&mut self, paper: Paper, svg: bool, folder: PathBuf, name: String) {
        self.enqueue(name.clone(), move || {
            let encoded = if svg { paper.svg().map(String::into_bytes) } else { paper.png() };
            let extension = if svg { "svg" } else { "png" };
            let written = encoded
                .map_err(|error| Error::Invalid(format!("{name}.{extension}: {error}")))
                .and_then(|bytes| write_free(&folder, &name, &[(extension, bytes)]));
            match written {
                Ok(path) => FileEvent::Exported(path),
                Err(error) => FileEvent::TableNotSaved(short_message(&error)),
            }
        });
    }

    /// Makes a figure for the clipboard.
    pub fn make_figure(&self, paper: Paper) {
        self.start("figure", Origin::Dialog, move || {
            let (size, rgba) = paper.rgba();
            let image = egui::ColorImage::from_rgba_unmultiplied(size.map(|n| n as usize), &rgba);
            Some(FileEvent::Figure(Arc::new(image)))
        });
    }

    /// Puts a figure on the clipboard.
    pub fn copy(&self, image: Arc<egui::ColorImage>) {
        self.ctx.copy_image(Arc::unwrap_or_clone(image));
    }

    /// Writes a text under the next free name.
    pub fn save_text(&mut self, folder: PathBuf, name: String, extension: &'static str, text: String) {
        self.enqueue(name.clone(), move || match write_free(&folder, &name, &[(extension, text.into_bytes())]) {
            Ok(path) => FileEvent::TableSaved(format!("Saved {}", path.display())),
            Err(error) => FileEvent::TableNotSaved(short_message(&error)),
        });
    }

    /// Writes the tutorial's pictures under the tutorial's names, over older ones.
    pub fn save_tutorial(&mut self, folder: PathBuf, pictures: Vec<(&'static str, Arc<Frame>)>) {
        self.enqueue("the tutorial's pictures".into(), move || {
            let saved = pictures.iter().try_for_each(|(name, frame)| {
                snapshot::save(frame, &folder.join(name), &SaveOptions::default()).map(drop)
            });
            let names: Vec<&str> = pictures.iter().map(|(name, _)| *name).collect();
            match saved {
                Ok(()) => FileEvent::TableSaved(format!("Saved {} in {}", names.join(", "), folder.display())),
                Err(error) => FileEvent::TableNotSaved(short_message(&error)),
            }
        });
    }

    /// Writes the preferences, in silence.
    pub fn keep(&self, path: &Path, prefs: &Prefs) {
        let (path, prefs) = (path.to_owned(), prefs.clone());
        self.queue.push(move || kept::write(&path, &prefs));
    }
}
