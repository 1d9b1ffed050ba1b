//! Archives that depend on what is in them, and on nothing else: names in order, one time, no owner.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::platform::Platform;
use crate::run::{output, succeed};

/// Packs a folder into an archive beside it, of its name; all files are of that time.
///
/// # Errors
/// If a program that packs is missing or fails.
pub fn pack(platform: &Platform, folder: &Path, time: u64) -> Result<PathBuf, String> {
    let Some(beside) = folder.parent() else {
        return Err(format!("{} is not a folder to pack", folder.display()));
    };
    let mut archive = folder.as_os_str().to_owned();
    archive.push(format!(".{}", platform.ending()));
    let archive = PathBuf::from(archive);
    let _ = std::fs::remove_file(&archive);
    let all = names(folder)?;
    for name in &all {
        let runs = platform.places().iter().any(|place| folder.join(place) == beside.join(name));
        settle(&beside.join(name), runs, time).map_err(|error| format!("{}: {error}", name.display()))?;
    }
    match platform.ending() {
        "zip" => {
            // Times in a zip are local ones.
            let mut zip = Command::new("zip");
            succeed(zip.env("TZ", "UTC").current_dir(beside).args(["-q", "-X", "-9"]).arg(&archive).args(&all))?;
        }
        _ => {
            let owner = if cfg!(target_os = "macos") {
                ["--uid=0", "--gid=0", "--uname=", "--gname="]
            } else {
                ["--owner=0", "--group=0", "--numeric-owner", "--no-recursion"]
            };
            let mut tar = Command::new("tar");
            tar.current_dir(beside).args(["--format=ustar", "--use-compress-program=gzip -9n"]).args(owner);
            succeed(tar.arg("-cf").arg(&archive).args(&all))?;
        }
    }
    Ok(archive)
}

/// Time and rights of a file, whatever this machine gave it.
fn settle(file: &Path, runs: bool, time: u64) -> std::io::Result<()> {
    let open = std::fs::File::options().write(true).open(file)?;
    open.set_modified(std::time::SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(time))?;
    #[cfg(unix)]
    {
        let mode = if runs { 0o755 } else { 0o644 };
        open.set_permissions(std::os::unix::fs::PermissionsExt::from_mode(mode))?;
    }
    #[cfg(not(unix))]
    let _ = runs;
    Ok(())
}

/// The files in a folder, in order, as seen from the folder above.
fn names(folder: &Path) -> Result<Vec<PathBuf>, String> {
    fn visit(folder: &Path, as_seen: &Path, found: &mut Vec<PathBuf>) -> std::io::Result<()> {
        for entry in std::fs::read_dir(folder)? {
            let entry = entry?;
            let name = as_seen.join(entry.file_name());
            if entry.file_type()?.is_dir() {
                visit(&entry.path(), &name, found)?;
            } else {
                found.push(name);
            }
        }
        Ok(())
    }
    let mut found = Vec::new();
    let own = Path::new(folder.file_name().unwrap_or_default());
    visit(folder, own, &mut found).map_err(|error| format!("{}: {error}", folder.display()))?;
    found.sort();
    Ok(found)
}

/// Writes the checksums of all archives in a folder.
///
/// # Errors
/// If a program is missing or a file cannot be read.
pub fn sums(dist: &Path) -> Result<(), String> {
    let mut archives: Vec<String> = std::fs::read_dir(dist)
        .map_err(|error| format!("{}: {error}", dist.display()))?
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .filter(|name| name.ends_with(".tar.gz") || name.ends_with(".zip"))
        .collect();
    archives.sort();
    let program: &[&str] = if cfg!(target_os = "macos") { &["shasum", "-a", "256"] } else { &["sha256sum"] };
    let text = output(Command::new(program[0]).args(&program[1..]).args(&archives).current_dir(dist))?;
    std::fs::write(dist.join("SHA256SUMS"), text).map_err(|error| format!("SHA256SUMS: {error}"))
}
