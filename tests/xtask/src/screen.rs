//! A virtual screen with one window of the program on it. Linux only.

use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::run::{Running, output, succeed};

/// A virtual screen, there until dropped.
pub struct Screen {
    display: String,
    size: [u32; 2],
    _server: Running,
}

impl Screen {
    /// A screen of so many pixels.
    ///
    /// # Errors
    /// If Xvfb is missing or does not start.
    pub fn new([width, height]: [u32; 2]) -> Result<Self, String> {
        let mut command = Command::new("Xvfb");
        let size = format!("{width}x{height}x24");
        // It chooses a free display and says which.
        command.args(["-displayfd", "1", "-screen", "0", &size, "-nolisten", "tcp", "-noreset"]);
        let mut server = Running::start(command.stdout(Stdio::piped()).stderr(Stdio::null()))?;
        let mut number = String::new();
        let stdout = server.0.stdout.take().ok_or("Xvfb has no output")?;
        BufReader::new(stdout).read_line(&mut number).map_err(|error| format!("Xvfb: {error}"))?;
        Ok(Self { display: format!(":{}", number.trim()), size: [width, height], _server: server })
    }

    /// Its name, for `DISPLAY`.
    pub fn display(&self) -> &str {
        &self.display
    }

    /// Waits for the window of the program, makes it fill the screen, and saves what is there after a while.
    ///
    /// # Errors
    /// If no window comes within a minute, or the picture cannot be saved.
    pub fn photograph(&self, after: Duration, file: &Path) -> Result<(), String> {
        let search = ["search", "--onlyvisible", "--name", "MIS Lab"];
        let deadline = Instant::now() + Duration::from_secs(60);
        while output(self.on("xdotool").args(search)).is_err() {
            if Instant::now() > deadline {
                return Err("no window came within a minute".into());
            }
            std::thread::sleep(Duration::from_millis(200));
        }
        let [width, height] = self.size.map(|n| n.to_string());
        succeed(self.on("xdotool").args(search).args(["windowmove", "0", "0"]))?;
        succeed(self.on("xdotool").args(search).args(["windowsize", &width, &height]))?;
        std::thread::sleep(after);
        let strip = ["-window", "root", "-strip", "-define", "png:compression-level=9"];
        succeed(self.on("import").args(strip).arg(file))
    }

    fn on(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.env("DISPLAY", &self.display);
        command
    }
}
