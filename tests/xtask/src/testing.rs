//! `cargo xtask test`: every test, in release, with our own crates' assertions on.

use std::process::Command;

use crate::needs;

/// Crates of the workspace whose debug assertions and overflow checks are on under test. Dependencies keep the release
/// profile, so that tests and `cargo run --release` share one build of them.
const CHECKED: [&str; 3] = ["mislab-renderer", "mislab", "mislab-tests"];

/// Provides what the tests need and runs them; `args` replace `--workspace`.
pub fn run(args: &[String]) -> Result<(), String> {
    needs::provide();
    let scratch = Scratch::new()?;

    let mut test = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    test.args(["test", "--release"]);
    for package in CHECKED {
        for check in ["debug-assertions", "overflow-checks"] {
            test.arg("--config").arg(format!("profile.release.package.{package}.{check}=true"));
        }
    }
    if args.is_empty() {
        test.arg("--workspace");
    } else {
        test.args(args);
    }

    // No window of the person at this machine, no settings of theirs, and the same graphics everywhere.
    test.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    for folder in ["XDG_RUNTIME_DIR", "XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_STATE_HOME"] {
        test.env(folder, scratch.folder(folder)?);
    }
    if cfg!(target_os = "linux") {
        test.env("WGPU_BACKEND", "vulkan").env("LIBGL_ALWAYS_SOFTWARE", "1");
        if let Some(driver) = needs::software_vulkan_driver() {
            test.env("VK_DRIVER_FILES", &driver).env("VK_ICD_FILENAMES", &driver);
        }
    }

    let status = test.status().map_err(|error| format!("cannot start cargo: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("tests failed ({status})")) }
}

/// A folder of our own under the system's temporary one, removed at the end.
pub struct Scratch(std::path::PathBuf);

impl Scratch {
    /// Creates it, empty.
    pub fn new() -> Result<Self, String> {
        let path = std::env::temp_dir().join(format!("mislab-xtask-{}", std::process::id()));
        let made = Self(path);
        made.make(&made.0)?;
        Ok(made)
    }

    /// Creates a folder in it that only this user may enter, as `XDG_RUNTIME_DIR` must be.
    pub fn folder(&self, name: &str) -> Result<std::path::PathBuf, String> {
        let path = self.0.join(name);
        self.make(&path)?;
        Ok(path)
    }

    fn make(&self, path: &std::path::Path) -> Result<(), String> {
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
