//! An archive as somebody has it who has downloaded it: unpacked into an empty folder, run with an empty home.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use super::platform::{GLIBC, Platform};
use super::{Release, own_paths, windows};
use crate::isolated::{Scratch, isolate};
use crate::run::{Running, output, succeed};
use crate::screen::Screen;

/// Names of the strategies.
pub const STRATEGIES: [&str; 4] = ["light", "bsdf", "mis_all", "mis"];
/// Time for a window to draw, perhaps all on one core.
const DRAWN: Duration = Duration::from_secs(20);
/// A window with a picture in it has more colours than that, grey as the picture is: an empty one has a handful.
const COLOURS: usize = 300;

/// An archive, unpacked.
pub struct Unpacked {
    /// What it is for.
    pub platform: &'static Platform,
    /// What was in it.
    pub folder: PathBuf,
    home: PathBuf,
}

impl Unpacked {
    /// Unpacks it.
    ///
    /// # Errors
    /// If that fails.
    pub fn new(release: &Release, platform: &'static Platform, scratch: &Scratch) -> Result<Self, String> {
        let stem = platform.stem(&release.version);
        let place = scratch.folder(&format!("unpacked-{}", platform.target))?;
        let archive = release.dist.join(format!("{stem}.{}", platform.ending()));
        let mut unpack = match platform.ending() {
            "zip" => Command::new("unzip"),
            _ => Command::new("tar"),
        };
        unpack.current_dir(&place).args(if platform.ending() == "zip" { ["-q"] } else { ["-xzf"] }).arg(&archive);
        succeed(&mut unpack)?;
        let home = scratch.folder(&format!("home-{}", platform.target))?;
        let unpacked = Self { platform, folder: place.join(stem), home };
        if platform.is_windows() {
            windows::stand_in_for_system_library(&unpacked)?;
        }
        Ok(unpacked)
    }

    /// Is for this machine itself.
    pub fn is_own(&self) -> bool {
        self.platform.is_linux() && self.platform.arch() == std::env::consts::ARCH
    }

    /// A program of the archive, in whatever runs it here.
    pub fn command(&self, program: &str) -> Command {
        let path = self.folder.join(program);
        if self.platform.is_windows() {
            let mut wine = self.settled(windows::WINE);
            wine.arg(path);
            wine
        } else if self.is_own() {
            self.settled(path)
        } else {
            let arch = self.platform.arch();
            let mut qemu = self.settled(format!("qemu-{arch}"));
            qemu.args(["-L", &format!("/usr/{arch}-linux-gnu")]).arg(path);
            qemu
        }
    }

    /// A program of this machine, with an empty home and the archive's folder as the current one.
    pub fn settled(&self, program: impl AsRef<OsStr>) -> Command {
        let mut command = Command::new(program);
        command.env_clear().env("PATH", std::env::var_os("PATH").unwrap_or_default());
        // wine reads names of files as the locale says.
        command.env("LC_ALL", "C.UTF-8").env("HOME", &self.home);
        if self.platform.is_windows() {
            windows::settle(&mut command, &self.home);
        }
        command.current_dir(&self.folder).stdin(Stdio::null());
        command
    }

    /// What is typed in a terminal.
    pub fn typed(&self) -> Command {
        self.command(self.platform.program())
    }

    /// The program says what it is, and nothing is missing.
    ///
    /// # Errors
    /// If something is.
    pub fn check_names(&self, commit: &str) -> Result<(), String> {
        let target = self.platform.target;
        let version = output(self.typed().arg("--version"))?;
        eprintln!("xtask: {target}: {}", version.trim());
        if !version.contains(target) || !version.contains(commit) {
            return Err(format!("--version does not name {target} and {commit}: {version}"));
        }
        for name in ["START.txt", "scenes/veach_mis.pbrt", "licences/LIBRARIES.txt"] {
            if !self.folder.join(name).is_file() {
                return Err(format!("{name} is not in the archive of {target}"));
            }
        }
        Ok(())
    }

    /// Programs do not say where they were built.
    ///
    /// # Errors
    /// If they do.
    pub fn check_own_paths(&self) -> Result<(), String> {
        let paths = own_paths()?;
        for place in self.platform.places() {
            let bytes = read(&self.folder.join(place))?;
            for path in &paths {
                let path = path.as_os_str().as_encoded_bytes();
                if bytes.windows(path.len()).any(|window| window == path) {
                    let path = String::from_utf8_lossy(path);
                    return Err(format!("{place} of {} names {path}", self.platform.target));
                }
            }
        }
        Ok(())
    }

    /// No symbol of a newer C library than promised.
    ///
    /// # Errors
    /// If there is one.
    pub fn check_library(&self) -> Result<(), String> {
        let program = self.folder.join(self.platform.program());
        let symbols = output(Command::new("readelf").args(["--version-info", "--wide"]).arg(program))?;
        let numbers = |version: &str| version.split('.').map(|n| n.parse().unwrap_or(0)).collect::<Vec<u32>>();
        let needed = symbols.split("Name: GLIBC_").skip(1).filter_map(|rest| rest.split_whitespace().next());
        let newest = needed.max_by_key(|version| numbers(version)).unwrap_or("0");
        eprintln!("xtask: {}: needs glibc {newest}", self.platform.target);
        if numbers(newest) > numbers(GLIBC) {
            return Err(format!("{} needs glibc {newest}, more than {GLIBC}", self.platform.target));
        }
        Ok(())
    }

    /// Folders and files with blanks and letters beyond ASCII, and a mesh that a scene names in the way of Windows.
    ///
    /// # Errors
    /// If a file is not found, or the picture is not where it should be.
    pub fn check_file_names(&self) -> Result<(), String> {
        let folder = self.folder.join("Übung 1 – λ");
        let write = |name: &str, text: &str| {
            let file = folder.join(name);
            let made = file.parent().map_or(Ok(()), std::fs::create_dir_all);
            made.and_then(|()| std::fs::write(&file, text)).map_err(|error| format!("{}: {error}", file.display()))
        };
        write("mesh/part.ply", PART)?;
        write("Szene ä.pbrt", SCENE)?;
        let mut command = self.typed();
        command.args(["render", "Szene ä.pbrt", "--outfile", "Bild ß.exr", "--spp", "1"]).current_dir(&folder);
        let output = command.output().map_err(|error| format!("cannot start {}: {error}", self.platform.target))?;
        let said = String::from_utf8_lossy(&output.stderr);
        if !output.status.success() || !folder.join("Bild ß.exr").is_file() || !said.contains("is read as") {
            return Err(format!("{}: a scene with a mesh by \"mesh\\part.ply\": {said}", self.platform.target));
        }
        Ok(())
    }

    /// A small picture of the scene.
    ///
    /// # Errors
    /// If it is not rendered.
    pub fn render(&self, strategy: &str) -> Result<(), String> {
        let mut command = self.typed();
        command.args(["render", "scenes/veach_mis.pbrt", "--strategy", strategy, "--quiet"]);
        succeed(command.args(["--size", "200x200", "--spp", "16", "--seed", "7", "--outfile", &picture(strategy)]))
    }

    /// The window, as somebody sees it who double-clicks.
    ///
    /// # Errors
    /// If none comes, or an empty one.
    pub fn photograph(&self, file: &Path) -> Result<(), String> {
        let screen = Screen::new([1280, 720])?;
        let mut command = self.command(self.platform.double_clicked());
        let scratch = Scratch::new()?;
        isolate(&mut command, &scratch)?;
        // By what the program chooses itself.
        command.env_remove("WGPU_BACKEND").env("DISPLAY", screen.display());
        let _program = Running::start(command.stdout(Stdio::null()).stderr(Stdio::null()))?;
        screen.photograph(DRAWN, file)?;
        let colours = output(Command::new("identify").args(["-format", "%k"]).arg(file))?;
        match colours.trim().parse::<usize>() {
            Ok(colours) if colours > COLOURS => Ok(()),
            _ => Err(format!("the window stays empty ({colours} colours in {})", file.display())),
        }
    }
}

/// The name of a picture.
pub fn picture(strategy: &str) -> String {
    format!("{strategy}.exr")
}

/// A file as it is.
///
/// # Errors
/// If it cannot be read.
pub fn read(file: &Path) -> Result<Vec<u8>, String> {
    std::fs::read(file).map_err(|error| format!("{}: {error}", file.display()))
}

/// A triangle.
const PART: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

/// A triangle under a light.
const SCENE: &str = "LookAt 0 0 5  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" [30]\n\
    Film \"image\" \"integer xresolution\" [16] \"integer yresolution\" [16] \"string filename\" [\"teil.exr\"]\n\
    Integrator \"veachMIS\" \"string MISstrategy\" [\"mis_all\"]\nWorldBegin\n\
    Shape \"plymesh\" \"string filename\" [\"mesh\\part.ply\"]\n\
    AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [5 5 5]\nTranslate 0 0 4\n\
    Shape \"sphere\" \"float radius\" [0.1]\nAttributeEnd\nWorldEnd\n";
