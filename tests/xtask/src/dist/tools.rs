//! What archives are made with: in versions that stand here, so that the same commit gives the same bytes, and in a folder of
//! their own under `target/`, so that nothing else on the machine changes.

use std::path::PathBuf;
use std::process::Command;

use crate::cargo;
use crate::run::{output, succeed};

/// Collects the licences of libraries.
const CARGO_ABOUT: &str = "0.9.3";
/// Lets cargo link with zig; PyPI has it built.
const CARGO_ZIGBUILD: &str = "0.24.1";
/// A linker that knows the symbols of old C libraries.
const ZIGLANG: &str = "0.17.1";

/// The compiler's library for a target.
///
/// # Errors
/// If it is missing and rustup cannot bring it.
pub fn provide_target(target: &str) -> Result<(), String> {
    // What `rustup target add` prints is of no interest where it succeeds.
    output(Command::new("rustup").args(["target", "add", target])).map(drop).map_err(|why| {
        format!("Rust's library for {target} is missing; `rustup target add {target}` should bring it: {why}")
    })
}

/// cargo with cargo-about.
///
/// # Errors
/// If it is missing and cannot be installed.
pub fn cargo_about() -> Result<Command, String> {
    let folder = folder("about")?;
    if !folder.join("bin/cargo-about").is_file() {
        eprintln!("xtask: cargo install cargo-about {CARGO_ABOUT}");
        let mut install = cargo();
        install.args(["install", "--quiet", "--locked", "--features", "cli", "--version", CARGO_ABOUT, "--root"]);
        succeed(install.arg(&folder).arg("cargo-about"))?;
    }
    with_path(cargo(), folder.join("bin"))
}

/// cargo with cargo-zigbuild, and with zig.
///
/// # Errors
/// If they are missing and cannot be installed.
pub fn cargo_zigbuild() -> Result<Command, String> {
    let folder = folder("zig")?;
    if !folder.join("bin/cargo-zigbuild").is_file() {
        eprintln!("xtask: pip install cargo-zigbuild {CARGO_ZIGBUILD} and ziglang {ZIGLANG}");
        let mut install = Command::new("python3");
        install.args(["-m", "pip", "install", "--quiet", "--root-user-action=ignore", "--target"]).arg(&folder);
        let packages = [format!("cargo-zigbuild=={CARGO_ZIGBUILD}"), format!("ziglang=={ZIGLANG}")];
        succeed(install.args(packages))?;
    }
    let mut command = with_path(cargo(), folder.join("bin"))?;
    command.env("PYTHONPATH", folder);
    Ok(command)
}

/// Where a tool lies.
fn folder(tool: &str) -> Result<PathBuf, String> {
    let folder = PathBuf::from("target/tools").join(tool);
    std::path::absolute(&folder).map_err(|error| format!("{}: {error}", folder.display()))
}

/// With a folder before all others that programs are looked for in.
fn with_path(mut command: Command, first: PathBuf) -> Result<Command, String> {
    let others = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths(std::iter::once(first).chain(std::env::split_paths(&others)));
    command.env("PATH", path.map_err(|error| format!("PATH: {error}"))?);
    Ok(command)
}
