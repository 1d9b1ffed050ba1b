//! `cargo xtask dist --check`: each archive, unpacked into an empty folder, runs for somebody who has nothing else, and renders what
//! the others render.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use super::platform::{GLIBC, Platform};
use crate::isolated::{Scratch, isolate};
use crate::run::{Running, output, succeed};
use crate::screen::Screen;

/// The scene's picture in small, by each strategy.
const STRATEGIES: [&str; 4] = ["light", "bsdf", "mis_all", "mis"];
/// What vector levels that round differently may differ by in the mean, of itself (tests/README.md).
const MEANS: f64 = 2e-5;
/// Time for a window to draw, perhaps all on one core.
const DRAWN: Duration = Duration::from_secs(12);

/// Checks the archives of the platforms.
///
/// # Errors
/// The first thing that is wrong.
pub fn run(dist: &Path, platforms: &[&Platform], version: &str) -> Result<(), String> {
    let scratch = Scratch::new()?;
    let mut first: Option<Unpacked> = None;
    for platform in platforms {
        let unpacked = Unpacked::new(dist, platform, version, &scratch)?;
        unpacked.check_names(platform)?;
        if platform.is_linux() {
            unpacked.check_library()?;
        }
        for strategy in STRATEGIES {
            unpacked.render(strategy)?;
        }
        match &first {
            // The first is this machine's own.
            None => {
                unpacked.photograph(&dist.join(format!("{}.png", platform.stem(version))))?;
                first = Some(unpacked);
            }
            Some(first) => {
                for strategy in STRATEGIES {
                    compare(first, &unpacked, strategy)?;
                }
                if let Err(why) = unpacked.photograph(&dist.join(format!("{}.png", platform.stem(version)))) {
                    // Emulators need not be able to draw.
                    eprintln!("xtask: {}: no picture of the window: {why}", platform.target);
                }
            }
        }
    }
    Ok(())
}

/// An archive, unpacked.
struct Unpacked {
    folder: PathBuf,
    home: PathBuf,
    program: PathBuf,
    target: &'static str,
}

impl Unpacked {
    fn new(dist: &Path, platform: &Platform, version: &str, scratch: &Scratch) -> Result<Self, String> {
        let stem = platform.stem(version);
        let place = scratch.folder(&format!("unpacked-{}", platform.target))?;
        let archive = dist.join(format!("{stem}.{}", platform.ending()));
        let mut unpack = match platform.ending() {
            "zip" => Command::new("unzip"),
            _ => Command::new("tar"),
        };
        unpack.current_dir(&place).args(if platform.ending() == "zip" { ["-q"] } else { ["-xzf"] }).arg(&archive);
        succeed(&mut unpack)?;
        let folder = place.join(stem);
        let program = folder.join(platform.program());
        let unpacked = Self {
            folder,
            home: scratch.folder(&format!("home-{}", platform.target))?,
            program,
            target: platform.target,
        };
        if unpacked.is_windows() {
            stand_in_for_system_library(&unpacked.program)?;
        }
        Ok(unpacked)
    }

    fn is_windows(&self) -> bool {
        self.target.contains("windows")
    }

    /// Is for this machine itself.
    fn is_own(&self) -> bool {
        !self.is_windows() && self.target.starts_with(std::env::consts::ARCH)
    }

    /// The program, in whatever runs it here, with an empty home and the archive's folder as the current one.
    fn command(&self) -> Result<Command, String> {
        let mut command = if self.is_windows() {
            let mut wine = Command::new("/usr/lib/wine/wine64");
            wine.arg(&self.program);
            wine
        } else if self.is_own() {
            Command::new(&self.program)
        } else {
            let arch = self.target.split('-').next().unwrap_or_default();
            let mut qemu = Command::new(format!("qemu-{arch}"));
            qemu.args(["-L", &format!("/usr/{arch}-linux-gnu")]).arg(&self.program);
            qemu
        };
        command.env_clear().env("PATH", std::env::var_os("PATH").unwrap_or_default());
        command.env("HOME", &self.home).env("WINEPREFIX", self.home.join("wine")).env("WINEDEBUG", "-all");
        command.env("USERPROFILE", &self.home).current_dir(&self.folder).stdin(Stdio::null());
        Ok(command)
    }

    fn check_names(&self, platform: &Platform) -> Result<(), String> {
        let version = output(self.command()?.arg("--version"))?;
        eprintln!("xtask: {}: {}", platform.target, version.trim());
        if !version.contains(platform.target) {
            return Err(format!("--version does not name {}: {version}", platform.target));
        }
        for name in ["START.txt", "scenes/veach_mis.pbrt", "licences/LIBRARIES.txt"] {
            if !self.folder.join(name).is_file() {
                return Err(format!("{name} is not in the archive of {}", platform.target));
            }
        }
        Ok(())
    }

    /// No symbol of a newer C library than promised.
    fn check_library(&self) -> Result<(), String> {
        let symbols = output(Command::new("readelf").args(["--version-info", "--wide"]).arg(&self.program))?;
        let numbers = |version: &str| version.split('.').map(|n| n.parse().unwrap_or(0)).collect::<Vec<u32>>();
        let needed = symbols.split("Name: GLIBC_").skip(1).filter_map(|rest| rest.split_whitespace().next());
        let newest = needed.max_by_key(|version| numbers(version)).unwrap_or("0");
        eprintln!("xtask: {}: needs glibc {newest}", self.target);
        if numbers(newest) > numbers(GLIBC) {
            return Err(format!("{} needs glibc {newest}, more than {GLIBC}", self.target));
        }
        Ok(())
    }

    fn render(&self, strategy: &str) -> Result<(), String> {
        let mut command = self.command()?;
        command.args(["render", "scenes/veach_mis.pbrt", "--strategy", strategy, "--quiet"]);
        succeed(command.args(["--size", "200x200", "--spp", "16", "--seed", "7", "--outfile", &picture(strategy)]))
    }

    /// The window, as somebody sees it who double-clicks.
    fn photograph(&self, file: &Path) -> Result<(), String> {
        let screen = Screen::new([1280, 720])?;
        let mut command = self.command()?;
        let scratch = Scratch::new()?;
        isolate(&mut command, &scratch)?;
        let _program =
            Running::start(command.env("DISPLAY", screen.display()).stdout(Stdio::null()).stderr(Stdio::null()))?;
        screen.photograph(DRAWN, file)?;
        eprintln!("xtask: {}: look at {}", self.target, file.display());
        Ok(())
    }
}

fn picture(strategy: &str) -> String {
    format!("{strategy}.exr")
}

/// Whether two programs have rendered the same picture: all bits on the same processor, else the means.
fn compare(own: &Unpacked, other: &Unpacked, strategy: &str) -> Result<(), String> {
    let [a, b] = [other, own].map(|unpacked| unpacked.folder.join(picture(strategy)));
    let text = output(own.command()?.arg("compare").arg(a).arg(b))?;
    if text.contains("Every value is the same.") {
        eprintln!("xtask: {}: {strategy}: every value is that of {}", other.target, own.target);
        return Ok(());
    }
    let line = text.lines().find(|line| line.starts_with("RGB")).unwrap_or_default();
    let numbers: Vec<f64> = line.split_whitespace().skip(1).filter_map(|word| word.parse().ok()).collect();
    let [mean, expected, ..] = numbers[..] else { return Err(format!("compare says nothing of means:\n{text}")) };
    let same_processor = other.is_windows();
    eprintln!("xtask: {}: {strategy}: mean {mean} instead of {expected}", other.target);
    if same_processor || (mean / expected - 1.0).abs() > MEANS {
        return Err(format!("{} renders another picture by {strategy} than {}:\n{text}", other.target, own.target));
    }
    Ok(())
}

/// Wine 8 has no `bcryptprimitives.dll`, of which Rust's programs want one function, random bytes for hash tables. Windows has it.
fn stand_in_for_system_library(program: &Path) -> Result<(), String> {
    let Some(folder) = program.parent() else { return Ok(()) };
    let source = folder.join("stand_in.c");
    let text = "#include <stdlib.h>\n\
        __declspec(dllexport) int ProcessPrng(unsigned char *p, size_t n) { while (n--) *p++ = (unsigned char)rand(); return 1; }\n";
    std::fs::write(&source, text).map_err(|error| format!("{}: {error}", source.display()))?;
    let mut compile = Command::new("x86_64-w64-mingw32-gcc");
    succeed(compile.args(["-shared", "-O1", "-o"]).arg(folder.join("bcryptprimitives.dll")).arg(&source))
}
