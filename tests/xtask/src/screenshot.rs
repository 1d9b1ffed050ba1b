//! `cargo xtask screenshot`: the picture in the README, made by the program itself on a virtual screen. Linux only.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use crate::isolated::{Scratch, isolate};
use crate::run::{Running, succeed};
use crate::screen::Screen;
use crate::{cargo, needs};

const SIZE: [u32; 2] = [1440, 900];
/// Time for the noise to go, drawing and rendering both on the CPU.
const CONVERGED: Duration = Duration::from_secs(25);
const FILE: &str = "assets/screenshot.png";

/// Builds the app, shows it on a virtual screen and saves [`FILE`].
pub fn run() -> Result<(), String> {
    needs::provide(needs::TESTS);
    let scratch = Scratch::new()?;
    succeed(cargo().args(["build", "--release", "--package", "mislab"]))?;
    let screen = Screen::new(SIZE)?;
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| "target".into(), PathBuf::from);
    let program =
        std::path::absolute(target.join("release/mislab")).map_err(|error| format!("release/mislab: {error}"))?;
    let mut app = Command::new(program);
    isolate(&mut app, &scratch)?;
    // The window shows the folder it was started in: not one of the person here.
    let _app = Running::start(app.env("DISPLAY", screen.display()).current_dir(std::env::temp_dir()))?;
    screen.photograph(CONVERGED, Path::new(FILE))?;
    eprintln!("xtask: saved {FILE}");
    Ok(())
}
