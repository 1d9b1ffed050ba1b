//! Files as the window sees them: taking over what was read, saving, closing when that is done.

use std::path::{Path, PathBuf};
use std::time::Duration;

use eframe::egui::{self, Context, ViewportCommand};

use super::MisLabApp;
use crate::files::FileEvent;
use crate::files::kept::Due;
use crate::files::opening::{Reading, shipped};
use crate::files::saving::{NotSaved, Obstacle, SaveJob, Saved};
use crate::lab::Lab;
use crate::panel::messages::{OpenError, SaveError};
use crate::panel::open::{OpenSheet, Purpose};
use crate::panel::picture::PictureSheet;
use crate::state::command::Shipped;
use crate::state::destination::Destination;
use crate::state::document::{Document, Opened};
use crate::state::file_name;
use crate::state::history::EditKey;
use crate::state::paths::{short_name, shortened};
use crate::state::view::StoredView;

const NO_DIALOG: &str = "This desktop offers no file dialog: type a path, or drop a file on the window.";
const NO_PICTURE: &str = "This desktop offers no file dialog: type a path.";
/// True until there is a picture.
const NOT_YET: &str = "Not saved: the first picture with these settings is not complete yet";

impl MisLabApp {
    /// Goes on with another scene, or with the same one after its file has changed.
    fn take_over(&mut self, mut opened: Opened, changes: Option<&str>) {
        let Lab { document, history, prefs, destination, swatches, sheets, messages, .. } = &mut self.lab;
        messages.open_error = None;
        sheets.open = None;
        if let Some(path) = &opened.path {
            prefs.remember(path.clone());
        }
        let again = opened.path.is_some() && opened.path == document.opened.path;
        if again && let Some(changes) = changes {
            let name = opened.path.as_deref().map(short_name).unwrap_or_default();
            messages.say(match changes {
                "" => format!("{name} has not changed."),
                changes => {
                    let undo = if document.is_edited() { " Ctrl+Z brings back what was set here." } else { "" };
                    format!("{name} was read again. Changed: {changes}.{undo}")
                }
            });
        }
        if again && opened == *document.opened {
            return;
        }
        if opened.scene == document.opened.scene {
            // Undo keeps every version: a mesh is not to be kept once for each.
            opened.scene = document.opened.scene.clone();
        }
        let after = if again { document.reloaded(opened) } else { Document::new(opened) };
        let before = std::mem::replace(document, after);
        if !self.starting {
            history.record(before, EditKey("opening of a file", 0));
            history.end_gesture();
        }
        self.starting = false;
        if !again {
            *destination = Destination::default();
            messages.save_error = None;
        }
        swatches.clear();
    }

    pub(super) fn take_over_shipped(&mut self, which: Shipped) {
        self.lab.files.forget();
        self.take_over(shipped(which), None);
    }

    /// Reads again what is open, or what could not be opened.
    pub(super) fn reload(&mut self) {
        let Lab { document, files, messages, .. } = &mut self.lab;
        let failed = messages.open_error.as_ref().map(|error| &error.path);
        match failed.or(document.opened.path.as_ref()) {
            Some(path) => files.open(path.clone()),
            None => messages.say("This scene is inside the program: there is no file to read again."),
        }
    }

    /// The name and folder of the next snapshot.
    fn place(&self, spp: u32) -> (String, PathBuf) {
        let Lab { document, destination, .. } = &self.lab;
        (destination.name(document, Some(spp)), destination.folder(document))
    }

    pub(super) fn save(&mut self, ctx: &Context, create: bool) {
        let frame = self.lab.live().current_frame();
        let Some(frame) = frame else {
            let why =
                if self.lab.document.active().is_file() { "Not saved: this picture is from a file" } else { NOT_YET };
            self.lab.messages.complain(why);
            return;
        };
        let place = self.place(frame.spp());
        let Lab { document, prefs, files, messages, .. } = &mut self.lab;
        messages.forget_saved();
        if let Err(why) = file_name::check(&place.0) {
            messages.save_error = Some(SaveError::new(place, why, Obstacle::Other));
            return;
        }
        messages.save_error = None;
        let (name, folder) = place;
        files.save(SaveJob {
            frame,
            view: StoredView { layer: document.active().layer, view: document.view.clone() },
            dark: ctx.theme() == egui::Theme::Dark,
            folder,
            create,
            name,
            png: prefs.png,
        });
    }

    pub(super) fn handle(&mut self, event: FileEvent) {
        let Lab { prefs, destination, files, sheets, messages, .. } = &mut self.lab;
        match event {
            FileEvent::Compared(file) => {
                sheets.open = None;
                self.compare(file);
            }
            FileEvent::NotCompared(why) => messages.complain(format!("Not compared: {why}")),
            FileEvent::NoDialogToCompare => {
                sheets.open = Some(OpenSheet { remark: NO_PICTURE, purpose: Purpose::Compare, ..OpenSheet::default() });
            }
            FileEvent::NoDialogForReference => {
                sheets.open =
                    Some(OpenSheet { remark: NO_PICTURE, purpose: Purpose::Reference, ..OpenSheet::default() });
            }
            FileEvent::Picked(path) => files.open(path),
            FileEvent::PickedFolder(folder) => destination.folder = Some(folder.display().to_string()),
            FileEvent::PickedReference(path) => self.lab.references.use_file(Some(path)),
            FileEvent::NoDialog => {
                sheets.open = Some(OpenSheet { remark: NO_DIALOG, ..OpenSheet::default() });
            }
            FileEvent::Picture(file) => {
                prefs.remember(file.path.clone());
                messages.open_error = None;
                sheets.open = None;
                sheets.picture = Some(PictureSheet::new(*file));
                self.starting = false;
            }
            FileEvent::Read { reading, changes } => {
                let Reading { path, outcome, files: _ } = *reading;
                match outcome {
                    Ok(opened) => self.take_over(*opened, changes.as_deref()),
                    Err(why) => {
                        messages.open_error = Some(OpenError { path, why });
                        self.starting = false;
                    }
                }
            }
            FileEvent::Changed => {
                if let Some(path) = files.watched().map(Path::to_owned) {
                    files.open(path);
                }
            }
            FileEvent::Saved(Saved { path, png, notice }) => {
                let folder = path.parent().unwrap_or(Path::new(".")).display().to_string();
                let with = if png { " and its PNG" } else { "" };
                let notice = notice.map_or(String::new(), |n| format!(" ({n})"));
                let text = format!("Saved {}{with} in {}{notice}", short_name(&path), shortened(&folder, 120));
                prefs.remember(path.clone());
                messages.saved(text, path);
                messages.save_error = None;
            }
            FileEvent::NotSaved(NotSaved { name, folder, obstacle, message }) => {
                messages.save_error = Some(SaveError::new((name, folder), message, obstacle));
                // The reason is on screen, and so is the picture.
                self.closing = false;
            }
            FileEvent::Exported(path) => {
                let folder = path.parent().unwrap_or(Path::new(".")).display().to_string();
                messages.saved(format!("Exported {} to {}", short_name(&path), shortened(&folder, 120)), path);
            }
            FileEvent::Figure(image) => {
                files.copy(image);
                messages.say("The figure is on the clipboard.");
            }
            FileEvent::TableSaved(what) => messages.say(what),
            FileEvent::TableNotSaved(message) => {
                messages.complain(format!("Not saved: {message}"));
                self.closing = false;
            }
            FileEvent::Broken(message) => {
                messages.complain(message);
                self.closing = false;
            }
        }
    }

    /// Opens what was dropped on the window.
    pub(super) fn open_dropped(&mut self, ctx: &Context) {
        let dropped: Vec<PathBuf> = ctx.input(|i| i.raw.dropped_files.iter().map(|f| f.path().to_owned()).collect());
        if let [first, others @ ..] = dropped.as_slice() {
            self.lab.files.open(first.clone());
            if !others.is_empty() {
                let others: Vec<String> = others.iter().map(|path| short_name(path)).collect();
                let others = shortened(&others.join(", "), 120);
                let message = format!("One file at a time: {} is opened, not {others}.", short_name(first));
                self.lab.messages.complain(message);
            }
        }
    }

    /// Watches the file of the document, wherever that came from (undo goes back to another), or one that could not be opened.
    pub(super) fn look_after_files(&mut self, ctx: &Context) {
        if self.lab.live().current_frame().is_some() {
            self.lab.messages.retract(NOT_YET);
        }
        let Lab { document, files, messages, destination, .. } = &mut self.lab;
        let failed = messages.open_error.as_ref().map(|error| error.path.as_path());
        let wanted = failed.or(document.opened.path.as_deref());
        if !files.is_reading() && wanted != files.watched() {
            match wanted {
                Some(path) => files.open(path.to_owned()),
                None => files.forget(),
            }
        }
        // With another name or folder, or once the folder is there, it is no longer true that it cannot be saved.
        if let Some(error) = &messages.save_error {
            // Nothing else may happen in this window until then.
            ctx.request_repaint_after(Duration::from_secs(1));
            let (name, folder) = &error.place;
            let moved = *folder != destination.folder(document);
            let renamed = match &destination.name {
                Some(_) => *name != destination.name(document, Some(0)),
                // The default can always be used.
                None => file_name::check(name).is_err(),
            };
            if moved || renamed || error.may_be_over() {
                messages.save_error = None;
            }
        }
    }

    /// Closing waits for what was to be saved. Asked twice, the window goes, and the saving is finished without it.
    pub(super) fn close_when_saved(&mut self, ctx: &Context) {
        let saving = self.lab.files.is_saving();
        if ctx.input(|i| i.viewport().close_requested()) && saving && !self.closing {
            self.closing = true;
            ctx.send_viewport_cmd(ViewportCommand::CancelClose);
            self.lab.messages.say("The window closes when everything is saved.");
        } else if self.closing && !saving {
            ctx.send_viewport_cmd(ViewportCommand::Close);
        }
    }

    pub(super) fn keep_prefs(&mut self, ctx: &Context) {
        let zoom = ctx.zoom_factor();
        ctx.input(|i| {
            let window = &mut self.lab.prefs.window;
            let viewport = i.viewport();
            window.maximized = viewport.maximized.unwrap_or(window.maximized);
            let fills_screen =
                window.maximized || viewport.fullscreen.unwrap_or(false) || viewport.minimized.unwrap_or(false);
            if let Some(inner) = viewport.inner_rect.filter(|_| !fills_screen) {
                let size = (inner.size() * zoom).round();
                if size.x > 1.0 && size.y > 1.0 {
                    window.size = size.into();
                }
            }
        });
        let Lab { prefs, files, .. } = &self.lab;
        if let Some(kept) = &mut self.kept {
            match kept.due(prefs, false) {
                Due::No => {}
                Due::In(wait) => ctx.request_repaint_after(wait),
                Due::Now => files.keep(&kept.path, prefs),
            }
        }
    }
}
