//! Files opened to be read: regular ones only. A pipe would be waited for without an end, and a device never ends.

use std::fs::{File, Metadata};
use std::path::Path;

use crate::error::Error;

/// Opens a regular file, and says what it is by its name before it is opened.
///
/// # Errors
/// [`Error::Io`] if it is not there or may not be read, [`Error::File`] if it is a folder, a pipe or a device; `expected`
/// completes "expected ...".
pub(crate) fn open(path: &Path, expected: &str) -> Result<(File, Metadata), Error> {
    let io = |e| Error::io(path, "read", e);
    let metadata = std::fs::metadata(path).map_err(io)?;
    if !metadata.is_file() {
        let kind = if metadata.is_dir() { "a folder" } else { "not a regular file" };
        return Err(Error::file(path, format!("{kind}, expected {expected}")));
    }
    Ok((File::open(path).map_err(io)?, metadata))
}
