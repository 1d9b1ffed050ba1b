//! `mislab render`: what a picture takes of the memory.

use std::process::{Command, Stdio};

use mislab_renderer::memory::Need;
use mislab_renderer::{Request, Strategy, pbrt};

use crate::place::{Place, Ran};

/// What is foreseen is what is taken, on the safe side: the peak of the whole process less what it takes for a tiny picture.
#[test]
#[cfg(target_os = "linux")]
fn the_memory_of_a_picture_is_foreseen() {
    let place = Place::new();
    let peak = |line: &str| {
        let mut child = place.command(line).stderr(Stdio::null()).spawn().expect("the program starts");
        let status = format!("/proc/{}/status", child.id());
        let mut peak = 0;
        while child.try_wait().expect("it can be asked").is_none() {
            let text = std::fs::read_to_string(&status).unwrap_or_default();
            let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
            let kilobytes = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<u64>().ok());
            peak = kilobytes.unwrap_or(0).max(peak);
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        peak * 1024
    };
    let nothing = peak("render --size 8x8 --spp 2 --quiet --outfile small.exr");
    for strategy in [Strategy::Light, Strategy::MisAll] {
        let name = strategy.name();
        let taken = peak(&format!("render --size 900x900 --spp 2 --strategy {name} --quiet --outfile {name}.exr"));
        let taken = taken.saturating_sub(nothing);
        let file = pbrt::embedded_scene();
        let mut settings = file.settings;
        settings.image.resolution = [900, 900];
        settings.estimator.strategy = strategy;
        settings.sampling.spp = std::num::NonZeroU32::new(2);
        let foreseen = Need::of(&Request { scene: std::sync::Arc::new(file.scene), settings }).total();
        let share = taken as f64 / foreseen as f64;
        assert!((0.7..1.0).contains(&share), "{name}: {taken} bytes of {foreseen} foreseen");
    }
}

/// With less memory than the picture takes there is a message, and no core dump.
#[test]
#[cfg(target_os = "linux")]
fn a_picture_too_large_for_the_memory_is_refused_in_words() {
    let place = Place::new();
    let program = env!("CARGO_BIN_EXE_mislab");
    let run = |line: &str| {
        // Kilobytes of address space.
        let script = format!("ulimit -v 1500000; exec {program} {line}");
        let mut command = Command::new("sh");
        command.args(["-c", &script]).current_dir(place.0.path()).stdin(Stdio::null());
        Ran::new(line, command.output().expect("a shell"))
    };
    let big = run("render --size 5000x5000 --spp 1 --nthreads 1 --outfile a.exr");
    big.expect_code(1).expect_err(&["takes about 3.9 GB", "film 2.6 GB", " are free", "crop window"]);
    assert!(place.files().is_empty());
    run("render --size 64x64 --spp 1 --nthreads 1 --quiet --outfile b.exr").expect_code(0);
    run("render --size 5000x5000 --cropwindow 0 0.1 0 0.1 --spp 1 --nthreads 1 --quiet --outfile c.exr").expect_code(0);
}
