//! Bytes onto the disk, so that a file is complete or not there at all.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use tempfile::{NamedTempFile, PersistError};

use crate::error::Error;
use crate::platform;

/// How long a file is waited for that another program holds: what looks through new files holds each for a moment.
const PATIENCE: Duration = Duration::from_secs(1);

/// See [`super::write_file`].
pub(super) fn write_file(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    // A link stays a link: its target is replaced.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    // Nothing but a plain file can be replaced by renaming: a pipe or /dev/null takes the bytes as they come.
    if fs::metadata(&target).is_ok_and(|m| !m.is_file() && !m.is_dir()) {
        return fs::write(&target, bytes).map_err(|e| failed(path, e));
    }
    let file = beside(&target, bytes).map_err(|e| failed(path, e))?;
    named(file, |file| file.persist(&target)).map_err(|e| {
        let read_only = fs::metadata(&target).is_ok_and(|m| m.permissions().readonly());
        if platform::is_held(&e.error) && !read_only {
            Error::file(path, "cannot save: another program holds it open")
        } else {
            failed(path, e.error)
        }
    })?;
    Ok(())
}

/// See [`super::write_new_file`].
pub(super) fn write_new_file(path: &Path, bytes: &[u8]) -> Result<bool, Error> {
    // A link to nowhere takes the name too.
    if fs::symlink_metadata(path).is_ok() {
        return Ok(false);
    }
    let file = beside(path, bytes).map_err(|e| failed(path, e))?;
    let refused = match named(file, |file| file.persist_noclobber(path)) {
        Ok(_) => return Ok(true),
        Err(refused) => refused,
    };
    if refused.error.kind() == ErrorKind::AlreadyExists {
        return Ok(false);
    }
    // Some file systems (memory sticks, shares) cannot rename to a free name only: an empty file holds it meanwhile.
    match File::create_new(path) {
        Ok(_) => {}
        Err(error) if error.kind() == ErrorKind::AlreadyExists => return Ok(false),
        Err(error) => return Err(failed(path, error)),
    }
    named(refused.file, |file| file.persist(path)).map_err(|e| {
        // Ours, and empty; what matters is why the picture is not in it.
        let _ = fs::remove_file(path);
        failed(path, e.error)
    })?;
    Ok(true)
}

/// All bytes, safe on the disk, in a file beside `target` that goes unless it is renamed.
fn beside(target: &Path, bytes: &[u8]) -> io::Result<NamedTempFile> {
    let folder = match target.parent() {
        Some(folder) if folder.as_os_str().is_empty() => PathBuf::from("."),
        Some(folder) => folder.to_owned(),
        None => PathBuf::from("/"),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".mislab-").suffix(".tmp");
    // Opened here and written to as a plain file: errors of the library's own would name this file, which nobody knows.
    let mut file = builder.make_in(folder, |path| platform::new_file().open(path))?;
    file.as_file_mut().write_all(bytes)?;
    file.as_file().sync_all()?;
    Ok(file)
}

/// Gives a file its name, patiently.
fn named(
    mut file: NamedTempFile,
    rename: impl Fn(NamedTempFile) -> Result<File, PersistError>,
) -> Result<File, PersistError> {
    let deadline = Instant::now() + PATIENCE;
    loop {
        match rename(file) {
            Err(refused) if platform::is_held(&refused.error) && Instant::now() < deadline => file = refused.file,
            done => return done,
        }
        std::thread::sleep(PATIENCE / 20);
    }
}

/// Why `path` could not be saved, with the folder named if it is the folder that is missing.
fn failed(path: &Path, error: io::Error) -> Error {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    match folder {
        Some(folder) if error.kind() == ErrorKind::NotFound && !folder.exists() => {
            Error::file(path, format!("cannot save: there is no folder {}", folder.display()))
        }
        _ => Error::io(path, "save", error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_new_file_never_replaces_another() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.exr");
        assert!(write_new_file(&path, b"first").expect("can be written"));
        assert!(!write_new_file(&path, b"second").expect("is refused, not failed"));
        assert_eq!(fs::read(&path).expect("is there"), b"first");
        write_file(&path, b"third").expect("can be replaced");
        assert_eq!(fs::read(&path).expect("is there"), b"third");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1, "nothing is left beside it");
    }

    #[test]
    fn messages_name_the_file_and_no_other() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("none").join("a.exr");
        let errors = [write_file(&path, b"x").err(), write_new_file(&path, b"x").err()];
        for error in errors {
            let text = error.expect("there is no such folder").to_string();
            assert!(text.contains("a.exr: cannot save: there is no folder") && !text.contains(".mislab-"), "{text}");
        }
        // A file in place of the folder is another reason.
        let blocked = folder.path().join("file");
        fs::write(&blocked, "").expect("write");
        let text = write_file(&blocked.join("a.exr"), b"x").expect_err("no folder").to_string();
        assert!(text.contains("a.exr: cannot save") && !text.contains(".mislab-"), "{text}");
    }
}
