//! What differs by platform: how the programs are built, what they are called, how they are packed.

use std::process::{Command, Stdio};

use crate::cargo;
use crate::run::{output, succeed};

/// A platform that there is an archive for.
pub struct Platform {
    /// The compiler's name of it.
    pub target: &'static str,
    /// Its name in file names.
    name: &'static str,
    system: System,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum System {
    /// Linked by zig against the C library of [`GLIBC`].
    Linux,
    /// Linked by mingw-w64.
    Windows,
    /// On a Mac only.
    Mac,
}

/// The C library that Linux programs are linked against, of 2018 (Debian 10, Ubuntu 18.10, RHEL 8): newer ones run them.
pub const GLIBC: &str = "2.28";

/// All of them.
pub const PLATFORMS: &[Platform] = &[
    Platform { target: "x86_64-unknown-linux-gnu", name: "linux-x86_64", system: System::Linux },
    Platform { target: "aarch64-unknown-linux-gnu", name: "linux-aarch64", system: System::Linux },
    Platform { target: "x86_64-pc-windows-gnu", name: "windows-x86_64", system: System::Windows },
    Platform { target: "aarch64-apple-darwin", name: "macos-aarch64", system: System::Mac },
    Platform { target: "x86_64-apple-darwin", name: "macos-x86_64", system: System::Mac },
];

impl Platform {
    /// The platform of a target.
    ///
    /// # Errors
    /// If there is none.
    pub fn named(target: &str) -> Result<&'static Self, String> {
        PLATFORMS.iter().find(|platform| platform.target == target).ok_or_else(|| {
            let known: Vec<&str> = PLATFORMS.iter().map(|platform| platform.target).collect();
            format!("no archive for the target {target}, but for {}", known.join(", "))
        })
    }

    /// Built if no target is named: what this machine can build.
    pub fn is_default(&self) -> bool {
        (self.system == System::Mac) == cfg!(target_os = "macos")
    }

    /// Programs are run by Linux.
    pub fn is_linux(&self) -> bool {
        self.system == System::Linux
    }

    /// Name of the archive and of the folder in it.
    pub fn stem(&self, version: &str) -> String {
        format!("mislab-{version}-{}", self.name)
    }

    /// End of the archive's name.
    pub fn ending(&self) -> &'static str {
        match self.system {
            System::Linux | System::Mac => "tar.gz",
            System::Windows => "zip",
        }
    }

    /// Files that the compiler makes.
    pub fn programs(&self) -> &'static [&'static str] {
        match self.system {
            System::Linux | System::Mac => &["mislab"],
            System::Windows => &["mislab-window.exe", "mislab.exe"],
        }
    }

    /// Where they lie in the archive: what is double-clicked on top, and on Windows what is typed below.
    pub fn places(&self) -> &'static [&'static str] {
        match self.system {
            System::Linux | System::Mac => &["mislab"],
            System::Windows => &["MIS Lab.exe", "bin/mislab.exe"],
        }
    }

    /// What is typed, in the archive.
    pub fn program(&self) -> &'static str {
        match self.system {
            System::Linux | System::Mac => "mislab",
            System::Windows => "bin/mislab.exe",
        }
    }

    /// Cargo's command and target.
    pub fn build_command(&self) -> [String; 3] {
        let (command, target) = match self.system {
            System::Linux => ("zigbuild", format!("{}.{GLIBC}", self.target)),
            System::Windows | System::Mac => ("build", self.target.to_owned()),
        };
        [command.to_owned(), "--target".to_owned(), target]
    }

    /// Compiler's libraries and linker.
    ///
    /// # Errors
    /// If they are missing and cannot be installed.
    pub fn provide(&self) -> Result<(), String> {
        succeed(Command::new("rustup").args(["target", "add", self.target]))?;
        if self.system == System::Linux {
            provide_cargo("cargo-zigbuild", None)?;
            provide_zig()?;
        }
        Ok(())
    }
}

/// One of cargo's commands, and the feature that it has for that, if any.
///
/// # Errors
/// If it is missing and cannot be installed.
pub fn provide_cargo(name: &str, feature: Option<&str>) -> Result<(), String> {
    let mut there = Command::new(name);
    let there = there.arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    if there.is_ok_and(|status| status.success()) {
        return Ok(());
    }
    eprintln!("xtask: cargo install {name}");
    let features = feature.map(|feature| ["--features", feature]);
    succeed(cargo().args(["install", "--locked", name]).args(features.iter().flatten()))
}

/// zig as a linker, from Python's packages.
fn provide_zig() -> Result<(), String> {
    let there = |command: &mut Command| output(command).is_ok();
    if there(Command::new("zig").arg("version")) || there(Command::new("python3").args(["-m", "ziglang", "version"])) {
        return Ok(());
    }
    eprintln!("xtask: pip install ziglang");
    succeed(Command::new("python3").args(["-m", "pip", "install", "--quiet", "--break-system-packages", "ziglang"]))
}
