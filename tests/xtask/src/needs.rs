//! What the tests need from the operating system, how to see whether it is there, and how to get it.
//!
//! Only Linux needs anything: window and graphics libraries are opened at run time there, and the GUI tests run on a
//! virtual screen and a software graphics driver so that they see the same pixels on every machine.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Debian's name of a package and what it is for.
pub type Package = (&'static str, &'static str);

/// What the tests need.
pub const TESTS: &[Package] = &[
    ("libvulkan1", "Vulkan loader"),
    ("mesa-vulkan-drivers", "software Vulkan driver"),
    ("libegl1", "OpenGL without Vulkan"),
    ("libgl1-mesa-dri", "software OpenGL driver"),
    ("libxkbcommon-x11-0", "keyboard of a window"),
    ("libx11-xcb1", "window on X11"),
    ("libxcursor1", "mouse pointer of a window"),
    ("libxi6", "mouse and keyboard of a window"),
    ("libdbus-1-3", "file dialogs"),
    ("xvfb", "virtual screen"),
    ("xdotool", "mouse and keyboard for the virtual screen"),
    ("imagemagick", "pictures of the virtual screen"),
    ("openexr", "OpenEXR's own tools, to read what we write"),
];

/// Programs that stand for the packages above where there is no dpkg to ask.
const PROGRAMS: &[Package] = &[
    ("Xvfb", "virtual screen"),
    ("xdotool", "mouse and keyboard for the virtual screen"),
    ("import", "ImageMagick: pictures of the virtual screen"),
    ("exrheader", "OpenEXR's own tools, to read what we write"),
];

/// What making archives to download needs.
pub const DIST: &[Package] = &[
    ("gcc-mingw-w64-x86-64", "linker for Windows"),
    ("zip", "archive for Windows"),
    ("python3-pip", "to get zig, the linker for old and other Linux systems"),
];

/// What checking them needs besides what the tests need.
pub const DIST_CHECK: &[Package] = &[
    ("wine64", "to run the Windows program"),
    ("qemu-user", "to run the program for aarch64"),
    ("libc6-arm64-cross", "C library of the program for aarch64"),
    ("libgcc-s1-arm64-cross", "C library of the program for aarch64"),
    ("unzip", "archive for Windows"),
    ("binutils", "to see which C library a program needs"),
];

/// Installs what is missing if that can be done without asking; otherwise says what is missing and how to get it.
/// Never the end: the tests that do not need it still run, and those that do say so.
pub fn provide(packages: &[Package]) {
    if !cfg!(target_os = "linux") {
        return;
    }
    if !has_program("dpkg-query") {
        for (program, purpose) in PROGRAMS.iter().filter(|(program, _)| !has_program(program)) {
            eprintln!("xtask: {program} is missing ({purpose}); install it with your package manager");
        }
        if software_vulkan_driver().is_none() {
            eprintln!(
                "xtask: Mesa's software Vulkan driver (lavapipe) is missing; install it with your package manager"
            );
        }
        return;
    }
    let missing: Vec<Package> = packages.iter().copied().filter(|(package, _)| !is_installed(package)).collect();
    if missing.is_empty() {
        return;
    }
    for (package, purpose) in &missing {
        eprintln!("xtask: package {package} is missing ({purpose})");
    }
    let names: Vec<&str> = missing.iter().map(|(package, _)| *package).collect();
    if !(is_root() && apt_get(&["update", "-qq"]) && {
        let install = ["install", "-y", "-qq", "--no-install-recommends"];
        apt_get(&[&install[..], &names[..]].concat())
    }) {
        eprintln!("xtask: to install: sudo apt-get update && sudo apt-get install {}", names.join(" "));
    }
}

/// The description file of Mesa's software Vulkan driver.
pub fn software_vulkan_driver() -> Option<PathBuf> {
    ["/usr/share/vulkan/icd.d", "/usr/local/share/vulkan/icd.d", "/etc/vulkan/icd.d"].into_iter().find_map(|folder| {
        let mut files: Vec<PathBuf> =
            std::fs::read_dir(folder).ok()?.filter_map(|entry| Some(entry.ok()?.path())).collect();
        files.sort();
        // A 64-bit machine may also have the 32-bit driver, `lvp_icd.i686.json`.
        files.into_iter().find(|file| {
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            name.starts_with("lvp_icd") && !name.contains("i686")
        })
    })
}

fn has_program(name: &str) -> bool {
    std::env::var_os("PATH")
        .is_some_and(|path| std::env::split_paths(&path).any(|folder| Path::new(&folder).join(name).is_file()))
}

fn is_installed(package: &str) -> bool {
    let query = Command::new("dpkg-query").args(["-W", "-f", "${db:Status-Status}", package]).output();
    // Packages of several architectures give one word each.
    query.is_ok_and(|out| out.status.success() && out.stdout.starts_with(b"installed"))
}

fn is_root() -> bool {
    Command::new("id").arg("-u").output().is_ok_and(|out| out.stdout.trim_ascii() == b"0")
}

fn apt_get(args: &[&str]) -> bool {
    eprintln!("xtask: apt-get {}", args.join(" "));
    let status =
        Command::new("apt-get").args(args).env("DEBIAN_FRONTEND", "noninteractive").stdin(Stdio::null()).status();
    status.is_ok_and(|status| status.success())
}
