//! `cargo xtask screenshot`: the picture in the README, made by the program itself on a virtual screen. Linux only.

use std::io::{BufRead as _, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use crate::isolated::{Scratch, isolate};
use crate::{cargo, needs};

const WIDTH: u32 = 1440;
const HEIGHT: u32 = 900;
/// Time for the window to appear and for the noise to go, drawing and rendering both on the CPU.
const CONVERGED: Duration = Duration::from_secs(25);
const FILE: &str = "assets/screenshot.png";

/// Builds the app, shows it on a virtual screen and saves [`FILE`].
pub fn run() -> Result<(), String> {
    needs::provide();
    let scratch = Scratch::new()?;
    succeed(cargo().args(["build", "--release", "--package", "mislab"]))?;

    let mut screen = Command::new("Xvfb");
    let size = format!("{WIDTH}x{HEIGHT}x24");
    // It chooses a free display and says which.
    screen.args(["-displayfd", "1", "-screen", "0", &size, "-nolisten", "tcp"]);
    let mut screen = Running::start(screen.stdout(Stdio::piped()).stderr(Stdio::null()))?;
    let mut number = String::new();
    let stdout = screen.0.stdout.take().ok_or("Xvfb has no output")?;
    BufReader::new(stdout).read_line(&mut number).map_err(|error| format!("Xvfb: {error}"))?;
    let display = format!(":{}", number.trim());

    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| "target".into(), PathBuf::from);
    let program =
        std::path::absolute(target.join("release/mislab")).map_err(|error| format!("release/mislab: {error}"))?;
    let mut app = Command::new(program);
    isolate(&mut app, &scratch)?;
    // The window shows the folder it was started in: not one of the person here.
    let _app = Running::start(app.env("DISPLAY", &display).current_dir(std::env::temp_dir()))?;
    let on_screen = |program: &str| {
        let mut command = Command::new(program);
        command.env("DISPLAY", &display);
        command
    };
    succeed(on_screen("xdotool").args([
        "search",
        "--sync",
        "--onlyvisible",
        "--name",
        "MIS Lab",
        "windowmove",
        "0",
        "0",
    ]))?;
    let (width, height) = (WIDTH.to_string(), HEIGHT.to_string());
    succeed(on_screen("xdotool").args(["search", "--name", "MIS Lab", "windowsize", &width, &height]))?;
    std::thread::sleep(CONVERGED);
    succeed(on_screen("import").args(["-window", "root", "-strip", "-define", "png:compression-level=9", FILE]))?;
    eprintln!("xtask: saved {FILE}");
    Ok(())
}

/// A program that ends with its owner.
struct Running(Child);

impl Running {
    fn start(command: &mut Command) -> Result<Self, String> {
        command.spawn().map(Self).map_err(|error| format!("cannot start {}: {error}", command.get_program().display()))
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn succeed(command: &mut Command) -> Result<(), String> {
    let name = command.get_program().display().to_string();
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("{name} failed ({status})")),
        Err(error) => Err(format!("cannot start {name}: {error}")),
    }
}
