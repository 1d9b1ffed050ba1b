//! What differs by platform: how the programs are built, what they are called, how they are packed.

use std::process::Command;

use super::tools;
use crate::cargo;

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

    /// Programs are run by Windows.
    pub fn is_windows(&self) -> bool {
        self.system == System::Windows
    }

    /// The processor's name.
    pub fn arch(&self) -> &'static str {
        self.target.split('-').next().unwrap_or_default()
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

    /// What is double-clicked, in the archive.
    pub fn double_clicked(&self) -> &'static str {
        match self.system {
            System::Linux | System::Mac => "mislab",
            System::Windows => "MIS Lab.exe",
        }
    }

    /// What is typed, in the archive.
    pub fn program(&self) -> &'static str {
        match self.system {
            System::Linux | System::Mac => "mislab",
            System::Windows => "bin/mislab.exe",
        }
    }

    /// Flags of the compiler that make the same programs of the same commit: mingw's linker notes the time otherwise.
    pub fn flags(&self) -> &'static [&'static str] {
        match self.system {
            System::Linux | System::Mac => &[],
            System::Windows => &["-Clink-arg=-Wl,--no-insert-timestamp"],
        }
    }

    /// Cargo with its command and target.
    ///
    /// # Errors
    /// If the compiler's library or the linker is missing and cannot be installed.
    pub fn build_command(&self) -> Result<Command, String> {
        tools::provide_target(self.target)?;
        Ok(match self.system {
            System::Linux => {
                let mut command = tools::cargo_zigbuild()?;
                command.args(["zigbuild", "--target", &format!("{}.{GLIBC}", self.target)]);
                command
            }
            System::Windows | System::Mac => {
                let mut command = cargo();
                command.args(["build", "--target", self.target]);
                command
            }
        })
    }
}
