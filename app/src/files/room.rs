//! How much room a disk has.

use std::path::Path;

/// Bytes that can still be written into a folder; `None` where the system does not say.
#[cfg(unix)]
pub fn room(folder: &Path) -> Option<u64> {
    let disk = rustix::fs::statvfs(folder).ok()?;
    disk.f_bavail.checked_mul(disk.f_frsize)
}

/// Bytes that can still be written into a folder; `None` where the system does not say.
#[cfg(not(unix))]
pub fn room(_folder: &Path) -> Option<u64> {
    None
}
