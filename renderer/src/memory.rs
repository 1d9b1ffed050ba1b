//! How much memory a picture takes, and whether that much is there: refused before it is asked for, because a program that asks
//! for more than there is is ended, with everything in it.

use std::fs;
use std::path::{Path, PathBuf};

use mislab_kernel::request::{Geometry, Request, Strategy};

use crate::layer::Channel;

/// Bytes that a picture takes, by what for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Need {
    /// The sums of all samples.
    pub film: u64,
    /// The same again, unless there is one pass only: a frame keeps its sums while the next pass goes on.
    pub copies: u64,
    /// The tree over the primitives, and what it is built from.
    pub scene: u64,
    /// All layers as numbers, and the file they become or come from.
    pub file: u64,
}

/// For a triangle or sphere: its numbers, its box and its part of both trees while they are built.
const PRIMITIVE: u64 = 500;

impl Need {
    /// From the start to the saved file.
    pub fn of(request: &Request) -> Self {
        let pixels = request.settings.pixel_bounds().area() as u64;
        // Four bytes each: see `Frame::bytes`. A light may be seen anywhere.
        let techniques = match request.settings.estimator.strategy {
            Strategy::Light | Strategy::Bsdf => 1,
            Strategy::MisAll | Strategy::Mis => 2,
        };
        let film = pixels * 4 * (2 + 9 * techniques + 6);
        let primitives = request.scene.shapes.iter().map(|shape| match &shape.geometry {
            Geometry::Sphere { .. } => 1,
            Geometry::Mesh { triangles, .. } => triangles.len() as u64,
        });
        let copies = if request.settings.sampling.target() == Some(1) { 0 } else { film };
        let scene = primitives.sum::<u64>() * PRIMITIVE;
        // What is packed takes less than the copies give back by then. Measured, the peak is 0.7 to 0.9 of the total.
        Self { film, copies, scene, file: layers(pixels) }
    }

    /// Of saving so many pixels that have been rendered: all layers, and the file, which is mostly below half of that.
    pub fn of_saving(pixels: u64) -> Self {
        Self::of_file(layers(pixels) + layers(pixels) / 2)
    }

    /// Of a file alone.
    pub fn of_file(file: u64) -> Self {
        Self { film: 0, copies: 0, scene: 0, file }
    }

    /// Everything.
    pub fn total(&self) -> u64 {
        self.film + self.copies + self.scene + self.file
    }

    /// What a picture on screen keeps.
    pub fn kept(&self) -> u64 {
        self.film + self.copies + self.scene
    }
}

/// All layers as numbers.
fn layers(pixels: u64) -> u64 {
    pixels * 4 * Channel::ALL.len() as u64
}

/// Whether a need can be met, `held` of it by memory that is given back for it; an error says what is missing and what helps.
///
/// # Errors
/// If less is free, or the system refuses it.
pub fn check(need: &Need, held: u64) -> Result<(), String> {
    check_with(need, held, free())
}

fn check_with(need: &Need, held: u64, free: Option<u64>) -> Result<(), String> {
    let total = need.total();
    let there = free.map(|free| free.saturating_add(held));
    if there.is_none_or(|there| total <= there) && can_be_had(total.saturating_sub(held)) {
        return Ok(());
    }
    let parts = [("film", need.film), ("copies", need.copies), ("scene", need.scene), ("file", need.file)];
    let parts: Vec<_> = parts.iter().filter(|(_, n)| *n > 0).map(|(name, n)| format!("{name} {}", size(*n))).collect();
    let there = there.map_or_else(|| "the system has less".to_owned(), |there| format!("{} are free", size(there)));
    let remedy = "a smaller image takes less, or parts of it one by one (a crop window)";
    Err(format!("this picture takes about {} of memory ({}), {there}: {remedy}", size(total), parts.join(", ")))
}

/// Asks for it and gives it back untouched: where memory is promised only if it is there, that is an answer.
fn can_be_had(bytes: u64) -> bool {
    usize::try_from(bytes).is_ok_and(|bytes| Vec::<u8>::new().try_reserve_exact(bytes).is_ok())
}

/// "1.3 GB", "20 MB".
fn size(bytes: u64) -> String {
    let mega = bytes as f64 * 1e-6;
    if mega < 999.5 { format!("{:.0} MB", mega.ceil()) } else { format!("{:.1} GB", mega * 1e-3) }
}

/// Bytes that this program can still have; `None` where the system does not say. The least of what the machine has, what the
/// program's group of processes may have, and its limits of address space.
fn free() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    // What would be slow on a disk is there all the same.
    let memory = |text: &str| Some(kilobytes(text, "MemAvailable:")? + kilobytes(text, "SwapFree:").unwrap_or(0));
    let machine = fs::read_to_string("/proc/meminfo").ok().and_then(|text| memory(&text));
    let limits = fs::read_to_string("/proc/self/limits").unwrap_or_default();
    let left = |limit: &str, used: &str| Some(limit_of(&limits, limit)?.saturating_sub(kilobytes(&status, used)?));
    let groups = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let all =
        [machine, left("Max address space", "VmSize:"), left("Max data size", "VmData:"), free_of_groups(&groups)];
    all.into_iter().flatten().min()
}

/// The number after a word, of kilobytes, in bytes.
fn kilobytes(text: &str, word: &str) -> Option<u64> {
    let rest = text.lines().find_map(|line| line.strip_prefix(word))?;
    rest.split_whitespace().next()?.parse::<u64>().ok()?.checked_mul(1024)
}

/// The soft limit of that name; `None` if there is none.
fn limit_of(limits: &str, name: &str) -> Option<u64> {
    limits.lines().find_map(|line| line.strip_prefix(name))?.split_whitespace().next()?.parse().ok()
}

/// The least that any of the groups of processes which this one is in may still have. What the system holds of files for them
/// is given up when memory is wanted.
fn free_of_groups(groups: &str) -> Option<u64> {
    let read = |folder: &Path, name: &str| fs::read_to_string(folder.join(name)).ok();
    let number = |folder: &Path, name: &str| read(folder, name)?.trim().parse::<u64>().ok();
    let of = |folder: &Path, [limit, used, stat, files]: [&str; 4]| {
        let files = read(folder, stat)?.lines().find_map(|line| line.strip_prefix(files)?.trim().parse::<u64>().ok());
        let used = number(folder, used)?.saturating_sub(files.unwrap_or(0));
        Some(number(folder, limit)?.saturating_sub(used))
    };
    let folders = |root: &str, group: &str| -> Vec<PathBuf> {
        let within = Path::new(group.trim_start_matches('/'));
        within.ancestors().map(|group| Path::new(root).join(group)).collect()
    };
    let free = groups.lines().filter_map(|line| {
        let (controllers, group) = line.split_once(':')?.1.split_once(':')?;
        match controllers {
            "" => {
                let names = ["memory.max", "memory.current", "memory.stat", "file "];
                folders("/sys/fs/cgroup", group).iter().filter_map(|folder| of(folder, names)).min()
            }
            _ if controllers.split(',').any(|c| c == "memory") => {
                let names = ["memory.limit_in_bytes", "memory.usage_in_bytes", "memory.stat", "total_cache "];
                folders("/sys/fs/cgroup/memory", group).iter().filter_map(|folder| of(folder, names)).min()
            }
            _ => None,
        }
    });
    free.min()
}

#[cfg(test)]
mod tests {
    use std::num::NonZeroU32;
    use std::sync::Arc;

    use super::*;
    use crate::pbrt::embedded_scene;

    fn request(resolution: [u32; 2], strategy: Strategy) -> Request {
        let file = embedded_scene();
        let mut settings = file.settings;
        settings.image.resolution = resolution;
        settings.estimator.strategy = strategy;
        Request { scene: Arc::new(file.scene), settings }
    }

    #[test]
    fn needs_follow_pixels_techniques_and_primitives() {
        let one = Need::of(&request([1000, 1000], Strategy::Light));
        assert_eq!((one.film, one.copies, one.file), (68_000_000, 68_000_000, 52_000_000));
        assert!(one.scene < 100_000, "{one:?}");
        let both = Need::of(&request([1000, 1000], Strategy::MisAll));
        assert_eq!(both.film, 104_000_000);
        assert_eq!(Need::of_saving(1_000_000).total(), 78_000_000);
        let mut single = request([1000, 1000], Strategy::MisAll);
        single.settings.sampling.spp = NonZeroU32::new(1);
        assert_eq!((Need::of(&single).film, Need::of(&single).copies), (104_000_000, 0));
        let mut crop = request([1000, 1000], Strategy::MisAll);
        crop.settings.image.crop = [0.0, 0.5, 0.0, 0.5];
        assert_eq!(Need::of(&crop).film, 26_000_000);
    }

    #[test]
    fn what_is_not_there_is_refused_with_both_numbers_and_a_remedy() {
        let need = Need { film: 3_000_000_000, copies: 3_000_000_000, scene: 0, file: 500_000_000 };
        assert_eq!(check_with(&need, 0, Some(6_500_000_000)), Ok(()));
        let error = check_with(&need, 0, Some(1_000_000_000)).expect_err("too little");
        for part in ["6.5 GB", "film 3.0 GB", "file 500 MB", "1.0 GB are free", "smaller", "crop window"] {
            assert!(error.contains(part), "no {part:?} in {error}");
        }
        assert_eq!(check_with(&need, 6_000_000_000, Some(500_000_000)), Ok(()), "what it had before is its own");
        // More than any address: also where the system does not say what it has.
        let endless = Need { film: u64::MAX / 2, ..Need::of_saving(0) };
        assert!(check_with(&endless, 0, None).is_err());
    }

    #[test]
    fn what_the_system_says_is_understood() {
        let status = "Name:\tmislab\nVmSize:\t  2048 kB\nVmData:\t 1 kB\n";
        assert_eq!(kilobytes(status, "VmSize:"), Some(2_097_152));
        let limits = "Limit                     Soft Limit           Hard Limit           Units\n\
                      Max data size             unlimited            unlimited            bytes\n\
                      Max address space         1073741824           unlimited            bytes\n";
        assert_eq!(limit_of(limits, "Max address space"), Some(1 << 30));
        assert_eq!(limit_of(limits, "Max data size"), None);
        if cfg!(target_os = "linux") {
            assert!(free().is_some_and(|free| free > 1 << 20), "{:?}", free());
        }
    }
}
