//! A place for programs to run in that knows nothing of the person at this machine, and is gone afterwards.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::needs;

/// No window and no settings of the person here, and the same graphics, Mesa's software drivers, everywhere.
pub fn isolate(command: &mut Command, scratch: &Scratch) -> Result<(), String> {
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    for folder in ["XDG_RUNTIME_DIR", "XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_STATE_HOME"] {
        command.env(folder, scratch.folder(folder)?);
    }
    if cfg!(target_os = "linux") {
        command.env("WGPU_BACKEND", "vulkan").env("LIBGL_ALWAYS_SOFTWARE", "1");
        if let Some(driver) = needs::software_vulkan_driver() {
            command.env("VK_DRIVER_FILES", &driver).env("VK_ICD_FILENAMES", &driver);
        }
    }
    Ok(())
}

/// A folder of our own under the system's temporary one, removed at the end.
pub struct Scratch(PathBuf);

impl Scratch {
    /// Creates it, empty.
    pub fn new() -> Result<Self, String> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("mislab-xtask-{}-{count}", std::process::id()));
        let made = Self(path);
        made.make(&made.0)?;
        Ok(made)
    }

    /// Creates a folder in it that only this user may enter, as `XDG_RUNTIME_DIR` must be.
    pub fn folder(&self, name: &str) -> Result<PathBuf, String> {
        let path = self.0.join(name);
        self.make(&path)?;
        Ok(path)
    }

    fn make(&self, path: &Path) -> Result<(), String> {
        let mut builder = std::fs::DirBuilder::new();
        #[cfg(unix)]
        std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
        builder.create(path).map_err(|error| format!("cannot create {}: {error}", path.display()))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // Nothing depends on its going: the system empties its temporary folder.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
