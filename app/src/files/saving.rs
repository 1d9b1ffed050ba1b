//! Snapshots: an EXR under a name that is free, perhaps with a PNG beside it under the same name.

use std::ffi::OsStr;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mislab_renderer::snapshot::{Contents, SaveOptions, write_file, write_new_file};
use mislab_renderer::{Error, Frame};

use crate::picture::figure::figure;
use crate::picture::png_file;
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
    /// The folder may be created.
    pub create: bool,
    /// Name without extension.
    pub name: String,
    /// A PNG of the view beside it.
    pub png: bool,
}

/// A snapshot that was written.
#[derive(Debug)]
pub struct Saved {
    /// The EXR.
    pub path: PathBuf,
    /// A PNG lies beside it.
    pub png: bool,
    /// Something to know about it.
    pub notice: Option<String>,
}

/// A snapshot that was not.
#[derive(Debug)]
pub struct NotSaved {
    /// The name asked for.
    pub name: String,
    /// The folder asked for.
    pub folder: PathBuf,
    /// What is in the way.
    pub obstacle: Obstacle,
    /// Why not.
    pub message: String,
}

/// What is in the way of a snapshot, as far as that can be helped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Obstacle {
    /// There is no such folder; it can be created.
    NoFolder,
    /// The disk is full.
    NoRoom {
        /// What the files take.
        bytes: u64,
    },
    /// Something else.
    Other,
}

impl Obstacle {
    /// Of files of so many bytes that could not be written.
    fn to(bytes: u64, error: &Error) -> Self {
        match error {
            Error::Io { source, .. } if source.kind() == ErrorKind::StorageFull => Self::NoRoom { bytes },
            Error::Io { .. } | Error::Scene(_) | Error::File { .. } | Error::Invalid(_) => Self::Other,
        }
    }
}

impl SaveJob {
    /// Writes it under the first name of which neither extension is taken.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn run(self) -> Result<Saved, NotSaved> {
        let (name, folder) = (self.name.clone(), self.folder.clone());
        let not = |obstacle, message| NotSaved { name: name.clone(), folder: folder.clone(), obstacle, message };
        if self.create
            && let Err(error) = fs::create_dir_all(&folder)
        {
            return Err(not(Obstacle::Other, format!("the folder cannot be created: {error}")));
        }
        if !folder.exists() {
            return Err(not(Obstacle::NoFolder, format!("there is no folder {}", folder.display())));
        }
        let (files, notice) = self.encode().map_err(|error| not(Obstacle::Other, super::short_message(&error)))?;
        let bytes = files.iter().map(|(_, bytes)| bytes.len() as u64).sum();
        let path = write_free(&folder, &name, &files)
            .map_err(|error| not(Obstacle::to(bytes, &error), super::short_message(&error)))?;
        Ok(Saved { path, png: files.len() > 1, notice })
    }

    /// The files by extension, and what is to be known about them.
    fn encode(self) -> Result<(Vec<FileBytes>, Option<String>), Error> {
        let Self { frame, view, dark, png, folder: _, create: _, name: _ } = self;
        let options = SaveOptions { view: serde_json::to_string(&view).ok(), ..SaveOptions::default() };
        let png = png
            .then(|| {
                let (width, height, rgba) = figure(&frame, view.layer, &view.view, dark);
                png_file::encode(width, height, &rgba).map_err(|e| Error::Invalid(format!("the PNG: {e}")))
            })
            .transpose()?;
        let contents = Contents::from_frame(&frame);
        // The room of the frame goes to the next one while this one is packed.
        drop(frame);
        let (exr, notice) = contents.encode(&options)?;
        let mut files = vec![("exr", exr)];
        files.extend(png.map(|bytes| ("png", bytes)));
        Ok((files, notice))
    }
}

/// A file by its extension.
type FileBytes = (&'static str, Vec<u8>);

/// Writes files that belong together under one name, `name.ext`, or `name_2.ext`, `name_3.ext` ...: the first one that is
/// free for all of them, also if another program takes names meanwhile. Returns the path of the first.
///
/// # Errors
/// If one cannot be written; then none is there.
pub fn write_free(folder: &Path, name: &str, files: &[(&str, Vec<u8>)]) -> Result<PathBuf, Error> {
    let path = |n: u32, extension: &str| {
        let number = if n == 1 { String::new() } else { format!("_{n}") };
        let dot = if extension.is_empty() { "" } else { "." };
        folder.join(format!("{name}{number}{dot}{extension}"))
    };
    for n in 1..u32::MAX {
        // Before any of them is written: a name that is half taken is common, where PNGs were not wanted at first.
        if files.iter().any(|(extension, _)| fs::symlink_metadata(path(n, extension)).is_ok()) {
            continue;
        }
        let mut written = Vec::new();
        let done: Result<bool, Error> = files.iter().try_fold(true, |all, (extension, bytes)| {
            let path = path(n, extension);
            let new = all && write_new_file(&path, bytes)?;
            if new {
                written.push(path);
            }
            Ok(new)
        });
        match done {
            Ok(true) => return Ok(path(n, files.first().map_or("", |(extension, _)| extension))),
            Ok(false) | Err(_) => {
                for path in written {
                    // Written a moment ago, by us.
                    let _ = fs::remove_file(path);
                }
                done?;
            }
        }
    }
    Err(Error::Invalid(format!("no name like {name} is free")))
}

/// Writes a file, over an older one of that name. One that cannot be replaced, as another program holds it open, costs nobody the
/// picture: it gets the next free name. Returns the name, and why it is another.
///
/// # Errors
/// If no name will do.
pub fn write_over(path: &Path, bytes: Vec<u8>) -> Result<(PathBuf, Option<Error>), Error> {
    let Err(why) = write_file(path, &bytes) else { return Ok((path.to_owned(), None)) };
    // What is not there was not refused for what it is.
    if fs::symlink_metadata(path).is_err() {
        return Err(why);
    }
    let part = |part: Option<&OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    let (stem, extension) = (part(path.file_stem()), part(path.extension()));
    let folder = path.parent().unwrap_or(Path::new(""));
    match write_free(folder, &stem, &[(&extension, bytes)]) {
        Ok(instead) => Ok((instead, Some(why))),
        Err(_) => Err(why),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_replaced_costs_no_picture() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| folder.path().join(name);
        fs::write(path("a.exr"), "old").expect("write");
        let (written, why) = write_over(&path("a.exr"), b"new".to_vec()).expect("can be replaced");
        assert!(written == path("a.exr") && why.is_none());
        assert_eq!(fs::read(path("a.exr")).expect("is there"), b"new");
        // Something in its place that no file replaces, as on Windows a file that another program holds.
        for (name, instead) in [("b.exr", "b_2.exr"), ("numbers", "numbers_2")] {
            fs::create_dir(path(name)).expect("a folder");
            let (written, why) = write_over(&path(name), b"new".to_vec()).expect("has another name");
            assert_eq!(written, path(instead));
            assert!(why.is_some_and(|why| why.to_string().contains(&format!("{name}: cannot save"))));
            assert_eq!(fs::read(path(instead)).expect("is there"), b"new");
        }
        assert!(
            write_over(&path("none").join("c.exr"), Vec::new()).is_err(),
            "no folder is no reason for another name"
        );
    }

    #[test]
    fn names_are_never_taken_twice() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let write = |text: &str, extensions: &[&'static str]| {
            let files: Vec<_> = extensions.iter().map(|e| (*e, text.as_bytes().to_vec())).collect();
            let path = write_free(folder.path(), "veach", &files).expect("can be written");
            path.file_name().expect("a name").to_string_lossy().into_owned()
        };
        let content = |name: &str| fs::read_to_string(folder.path().join(name)).expect("is there");
        assert_eq!(write("a", &["exr"]), "veach.exr");
        assert_eq!(write("b", &["exr", "png"]), "veach_2.exr");
        fs::remove_file(folder.path().join("veach_2.exr")).expect("can be removed");
        assert_eq!(write("c", &["exr", "png"]), "veach_3.exr", "both or neither");
        assert_eq!(write("d", &["exr"]), "veach_2.exr");
        assert_eq!(content("veach.exr") + &content("veach_2.png") + &content("veach_2.exr"), "abd");
    }

    #[test]
    fn saves_of_several_programs_at_once_lose_nothing() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::thread::scope(|scope| {
            for writer in 0..4 {
                let folder = folder.path();
                scope.spawn(move || {
                    for n in 0..10 {
                        let text = format!("{writer} {n}").into_bytes();
                        write_free(folder, "x", &[("exr", text.clone()), ("png", text)]).expect("can be written");
                    }
                });
            }
        });
        let mut texts: Vec<String> = fs::read_dir(folder.path())
            .expect("a folder")
            .map(|entry| fs::read_to_string(entry.expect("an entry").path()).expect("a text"))
            .collect();
        texts.sort();
        let mut expected: Vec<String> =
            (0..4).flat_map(|w| (0..10).flat_map(move |n| [format!("{w} {n}"), format!("{w} {n}")])).collect();
        expected.sort();
        assert_eq!(texts, expected, "every text twice, as EXR and as PNG");
        for entry in fs::read_dir(folder.path()).expect("a folder") {
            let path = entry.expect("an entry").path();
            let other = path.with_extension(if path.extension().is_some_and(|e| e == "exr") { "png" } else { "exr" });
            assert_eq!(fs::read(&path).ok(), fs::read(&other).ok(), "{} belongs to its twin", path.display());
        }
    }
}
