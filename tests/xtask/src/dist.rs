//! `cargo xtask dist`: archives to download, with all that a class needs who has no compiler.

mod archive;
mod check;
mod platform;
mod tools;
mod unpacked;
mod windows;

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::needs;
use crate::run::{output, succeed};
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
    needs::provide(needs::DIST);
    if check {
        if !cfg!(target_os = "linux") {
            return Err("--check runs programs for other systems, which only Linux can".into());
        }
        needs::provide(needs::TESTS);
        needs::provide(needs::DIST_CHECK);
    }
    let dist = std::path::absolute(DIST).map_err(|error| format!("{DIST}: {error}"))?;
    let release = Release::of(&dist)?;
    let licences = licences(&dist)?;
    for platform in &named {
        let programs = build(platform, &release)?;
        let folder = release.lay_out(platform, &programs, &licences)?;
        let archive = archive::pack(platform, &folder, release.time)?;
        let bytes = std::fs::metadata(&archive).map_err(|error| error.to_string())?.len();
        eprintln!("xtask: {} ({:.1} MB)", archive.display(), bytes as f64 / 1e6);
        if bytes > LARGEST {
            return Err(format!("{} has more than {} MB", archive.display(), LARGEST / 1_000_000));
        }
    }
    archive::sums(&dist)?;
    if check { check::run(&release, &named) } else { Ok(()) }
}

/// What all archives have in common.
struct Release {
    dist: PathBuf,
    version: String,
    /// What the programs say they were built from.
    commit: String,
    /// Of the commit, in seconds since 1970: every file in an archive is as old as that, so that archives depend on the
    /// commit alone.
    time: u64,
}

impl Release {
    fn of(dist: &Path) -> Result<Self, String> {
        let time = output(Command::new("git").args(["log", "-1", "--format=%ct"]))?;
        let time = time.trim().parse().map_err(|_| format!("git says {time:?} for the time of the commit"))?;
        let commit = output(Command::new("git").args(["rev-parse", "--short=10", "HEAD"]))?;
        let changes = output(Command::new("git").args(["status", "--porcelain", "--untracked-files=no"]))?;
        let commit = format!("{}{}", commit.trim(), if changes.is_empty() { "" } else { " and changes" });
        Ok(Self { dist: dist.to_owned(), version: env!("CARGO_PKG_VERSION").into(), commit, time })
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
fn build(platform: &Platform, release: &Release) -> Result<Vec<PathBuf>, String> {
    let mut command = platform.build_command()?;
    command.args(["--release", "--locked", "--package", "mislab", "--config", "profile.release.strip=\"symbols\""]);
    command.args(["--config", &configuration(platform)?]);
    // In one piece, whatever was compiled before.
    command.env("CARGO_INCREMENTAL", "0").env("MISLAB_COMMIT", &release.commit);
    succeed(&mut command)?;
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| "target".into(), PathBuf::from);
    let built = target.join(platform.target).join("release");
    Ok(platform.programs().iter().map(|name| built.join(name)).collect())
}

/// Folders of this machine that the compiler would write into programs, for panics to name: of libraries, of what is generated
/// for them, of the standard library.
fn own_paths() -> Result<[PathBuf; 3], String> {
    let absolute = |path: PathBuf| std::path::absolute(&path).map_err(|error| format!("{}: {error}", path.display()));
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| Some(std::env::home_dir()?.join(".cargo"))).ok_or("there is no home folder")?;
    let compiler = output(Command::new("rustc").args(["--print", "sysroot"]))?;
    Ok([absolute(home)?, absolute(".".into())?, PathBuf::from(compiler.trim())])
}

/// Cargo's configuration for programs that depend on the commit alone and do not name this machine's folders.
fn configuration(platform: &Platform) -> Result<String, String> {
    let [home, here, compiler] = own_paths()?;
    let renamed = [(home, "cargo"), (here, "mislab"), (compiler, "rust")];
    let renamed = renamed.map(|(from, to)| format!("--remap-path-prefix={}={to}", from.display()));
    let flags = renamed.iter().map(String::as_str).chain(platform.flags().iter().copied());
    let flags: Vec<String> = flags.map(|flag| format!("{flag:?}")).collect();
    Ok(format!("build.rustflags=[{}]", flags.join(",")))
}

/// The licences of all libraries, collected by cargo-about, which takes minutes: it reads every file of each. Made again when it
/// is older than what it comes from.
fn licences(dist: &Path) -> Result<PathBuf, String> {
    const SOURCES: [&str; 3] = ["Cargo.lock", "assets/dist/about.toml", "assets/dist/about.hbs"];
    let file = dist.join("LIBRARIES.txt");
    let time = |file: &Path| std::fs::metadata(file).and_then(|found| found.modified()).ok();
    if time(&file).is_some_and(|made| SOURCES.iter().all(|source| time(Path::new(source)).is_some_and(|t| t < made))) {
        return Ok(file);
    }
    let mut command = tools::cargo_about()?;
    std::fs::create_dir_all(dist).map_err(|error| format!("{}: {error}", dist.display()))?;
    eprintln!("xtask: licences of the libraries");
    command.args(["about", "generate", "--locked", "--fail", "--manifest-path", "app/Cargo.toml"]);
    command.args(["--config", SOURCES[1], "--output-file"]).arg(&file).arg(SOURCES[2]);
    succeed(&mut command)?;
    Ok(file)
}
