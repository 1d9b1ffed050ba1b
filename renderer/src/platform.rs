//! What differs by operating system about files. About windows it is `app/src/launch/`; all else is the same everywhere.

use std::fs::{Metadata, OpenOptions};
use std::io;
use std::path::PathBuf;

/// How a file is made that others may read: with the rights of any new file, the umask applied.
pub(crate) fn new_file() -> OpenOptions {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o666);
    options
}

/// Tells a file from another that was put in its place under the same name; always 0 where the system does not say.
pub fn identity(metadata: &Metadata) -> u64 {
    #[cfg(unix)]
    {
        std::os::unix::fs::MetadataExt::ino(metadata)
    }
    #[cfg(not(unix))]
    {
        // The same whatever the file: then its time and size must tell.
        let _ = metadata;
        0
    }
}

/// Whether a file could not be replaced, moved or removed because a program holds it open, as Windows lets programs do. The
/// error is the one for missing rights, too.
pub(crate) fn is_held(error: &io::Error) -> bool {
    const ACCESS_DENIED: i32 = 5;
    const SHARING_VIOLATION: i32 = 32;
    const USER_MAPPED_FILE: i32 = 1224;
    cfg!(windows) && matches!(error.raw_os_error(), Some(ACCESS_DENIED | SHARING_VIOLATION | USER_MAPPED_FILE))
}

/// The path in an address `file://PATH`; of `file:///C:/scene.pbrt` on Windows without the third slash.
pub fn path_of_address(path: &str) -> PathBuf {
    let drive = path.strip_prefix('/').filter(|rest| cfg!(windows) && rest.get(1..2) == Some(":"));
    PathBuf::from(drive.unwrap_or(path))
}
