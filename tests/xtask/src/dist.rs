//! `cargo xtask dist`: archives to download, with all that a class needs who has no compiler.

mod archive;
mod check;
mod platform;

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::run::{output, succeed};
use crate::{cargo, needs};
use platform::{PLATFORMS, Platform};

/// Where archives, and what they are made of, lie.
const DIST: &str = "target/dist";
/// Most bytes of an archive.
const LARGEST: u64 = 20_000_000;

/// Makes the archives; with `--check` proves that they work.
///
/// # Errors
/// If something that is needed is missing, or a program does not build, or not run.
pub fn run(args: &[String]) -> Result<(), String> {
    let (mut check, mut named) = (false, Vec::new());
    let mut args = args.iter();
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--check" => check = true,
            "--target" => named.push(Platform::named(args.next().ok_or("--target needs the name of one")?)?),
            other => return Err(format!("{other} is not an option of dist: --check or --target")),
        }
    }
    if named.is_empty() {
        named = PLATFORMS.iter().filter(|platform| platform.is_default()).collect();
    }
    needs::provide(needs::TESTS);
    needs::provide(needs::DIST);
    let dist = std::path::absolute(DIST).map_err(|error| format!("{DIST}: {error}"))?;
    let release = Release::of(&dist)?;
    let licences = licences(&dist)?;
    for platform in &named {
        let programs = build(platform)?;
        let folder = release.lay_out(platform, &programs, &licences)?;
        let archive = archive::pack(platform, &folder, release.time)?;
        let bytes = std::fs::metadata(&archive).map_err(|error| error.to_string())?.len();
        eprintln!("xtask: {} ({:.1} MB)", archive.display(), bytes as f64 / 1e6);
        if bytes > LARGEST {
            return Err(format!("{} has more than {} MB", archive.display(), LARGEST / 1_000_000));
        }
    }
    archive::sums(&dist)?;
    if check { check::run(&dist, &named, &release.version) } else { Ok(()) }
}

/// What all archives have in common.
struct Release {
    dist: PathBuf,
    version: String,
    /// Of the commit, in seconds since 1970: every file in an archive is as old as that, so that archives depend on the
    /// commit alone.
    time: u64,
}

impl Release {
    fn of(dist: &Path) -> Result<Self, String> {
        let time = output(Command::new("git").args(["log", "-1", "--format=%ct"]))?;
        let time = time.trim().parse().map_err(|_| format!("git says {time:?} for the time of the commit"))?;
        Ok(Self { dist: dist.to_owned(), version: env!("CARGO_PKG_VERSION").into(), time })
    }

    /// Puts the files of an archive into a folder of its name.
    fn lay_out(&self, platform: &Platform, programs: &[PathBuf], licences: &Path) -> Result<PathBuf, String> {
        let folder = self.dist.join(platform.stem(&self.version));
        let _ = std::fs::remove_dir_all(&folder);
        let put = |from: &Path, to: &str| {
            let to = folder.join(to);
            let made = to.parent().map_or(Ok(()), std::fs::create_dir_all);
            let copied = made.and_then(|()| std::fs::copy(from, &to));
            copied.map(drop).map_err(|error| format!("{} to {}: {error}", from.display(), to.display()))
        };
        for (program, place) in programs.iter().zip(platform.places()) {
            put(program, place)?;
        }
        for (from, to) in [
            ("assets/dist/START.txt", "START.txt"),
            ("assets/veach_mis.pbrt", "scenes/veach_mis.pbrt"),
            ("assets/veach_mis_plastic.pbrt", "scenes/veach_mis_plastic.pbrt"),
            ("LICENSE-MIT", "licences/LICENSE-MIT.txt"),
            ("LICENSE-APACHE", "licences/LICENSE-APACHE.txt"),
            ("assets/fonts/LICENSE-Roboto.txt", "licences/LICENSE-Roboto.txt"),
        ] {
            put(Path::new(from), to)?;
        }
        put(licences, "licences/LIBRARIES.txt")?;
        if platform.is_linux() {
            put(Path::new("assets/mislab.svg"), "mislab.svg")?;
            put(Path::new("assets/dist/mislab.desktop"), "mislab.desktop")?;
        }
        Ok(folder)
    }
}

/// The programs of a platform, in the order of [`Platform::places`].
fn build(platform: &Platform) -> Result<Vec<PathBuf>, String> {
    platform.provide()?;
    let mut command = cargo();
    command.args(platform.build_command());
    command.args(["--release", "--locked", "--package", "mislab", "--config", "profile.release.strip=\"symbols\""]);
    succeed(&mut command)?;
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| "target".into(), PathBuf::from);
    Ok(platform.programs().iter().map(|name| target.join(platform.target).join("release").join(name)).collect())
}

/// The licences of all libraries, collected by cargo-about.
fn licences(dist: &Path) -> Result<PathBuf, String> {
    platform::provide_cargo("cargo-about", Some("cli"))?;
    std::fs::create_dir_all(dist).map_err(|error| format!("{}: {error}", dist.display()))?;
    let file = dist.join("LIBRARIES.txt");
    let mut command = cargo();
    command.args(["about", "generate", "--locked", "--fail", "--manifest-path", "app/Cargo.toml"]);
    command.args(["--config", "assets/dist/about.toml", "--output-file"]).arg(&file).arg("assets/dist/about.hbs");
    succeed(&mut command)?;
    Ok(file)
}
