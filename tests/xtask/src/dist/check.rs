//! `cargo xtask dist --check`: each archive, unpacked into an empty folder, runs for somebody who has nothing else, and renders what
//! the others render.

use super::platform::Platform;
use super::unpacked::{STRATEGIES, Unpacked, picture};
use super::{Release, windows};
use crate::isolated::Scratch;
use crate::run::output;

/// What vector levels that round differently may differ by in the mean, of itself (tests/README.md).
const MEANS: f64 = 2e-5;

/// Checks the archives of the platforms.
///
/// # Errors
/// The first thing that is wrong.
pub fn run(release: &Release, platforms: &[&'static Platform]) -> Result<(), String> {
    let scratch = Scratch::new()?;
    let mut all = Vec::new();
    for platform in platforms {
        let unpacked = Unpacked::new(release, platform, &scratch)?;
        unpacked.check_names(&release.commit)?;
        unpacked.check_own_paths()?;
        if platform.is_linux() {
            unpacked.check_library()?;
        }
        if platform.is_windows() {
            windows::check(&unpacked)?;
        }
        unpacked.check_file_names()?;
        for strategy in STRATEGIES {
            unpacked.render(strategy)?;
        }
        all.push(unpacked);
    }
    match all.iter().find(|unpacked| unpacked.is_own()) {
        Some(own) => {
            for other in all.iter().filter(|other| !other.is_own()) {
                STRATEGIES.iter().try_for_each(|strategy| compare(own, other, strategy))?;
            }
        }
        None => eprintln!("xtask: nothing to compare with: name the target of this machine, too"),
    }
    for unpacked in &all {
        let file = release.dist.join(format!("{}.png", unpacked.platform.stem(&release.version)));
        match unpacked.photograph(&file) {
            Ok(()) => eprintln!("xtask: {}: look at {}", unpacked.platform.target, file.display()),
            Err(why) if unpacked.is_own() || unpacked.platform.is_windows() => return Err(why),
            // An emulated processor need not be able to draw.
            Err(why) => eprintln!("xtask: {}: no picture of the window: {why}", unpacked.platform.target),
        }
    }
    Ok(())
}

/// Whether two programs have rendered the same picture: all bits on the same processor, else the means.
fn compare(own: &Unpacked, other: &Unpacked, strategy: &str) -> Result<(), String> {
    let file = |unpacked: &Unpacked| unpacked.folder.join(picture(strategy));
    let text = output(own.typed().arg("compare").args([file(other), file(own)]))?;
    let (name, own_name) = (other.platform.target, own.platform.target);
    if text.contains("Every value is the same.") {
        eprintln!("xtask: {name}: {strategy}: every value is that of {own_name}");
        return Ok(());
    }
    let line = text.lines().find(|line| line.starts_with("RGB")).unwrap_or_default();
    let numbers: Vec<f64> = line.split_whitespace().skip(1).filter_map(|word| word.parse().ok()).collect();
    let [mean, expected, ..] = numbers[..] else { return Err(format!("compare says nothing of means:\n{text}")) };
    let difference = (mean / expected - 1.0).abs();
    eprintln!("xtask: {name}: {strategy}: the mean differs by {difference:.1e} of itself from that of {own_name}");
    if other.platform.arch() == own.platform.arch() || difference > MEANS {
        return Err(format!("{name} renders another picture by {strategy} than {own_name}:\n{text}"));
    }
    Ok(())
}
