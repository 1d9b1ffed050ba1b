//! What the program says of itself: the commit it was built from and for which platform, and what Windows shows of it.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed=MISLAB_COMMIT");
    println!("cargo:rustc-env=MISLAB_COMMIT={}", commit().unwrap_or_else(|| "unknown commit".into()));
    println!("cargo:rustc-env=MISLAB_PLATFORM={}", var("TARGET"));
    if var("CARGO_CFG_TARGET_OS") == "windows" {
        windows();
    }
}

fn var(name: &str) -> String {
    std::env::var(name).unwrap_or_default()
}

/// Of the checkout; archives of the source say it by the environment variable `MISLAB_COMMIT`.
fn commit() -> Option<String> {
    if let Ok(commit) = std::env::var("MISLAB_COMMIT") {
        return Some(commit);
    }
    // Written at every commit and checkout.
    let log = git(&["rev-parse", "--git-path", "logs/HEAD"])?;
    if Path::new(&log).exists() {
        println!("cargo:rerun-if-changed={log}");
    }
    git(&["rev-parse", "--short=10", "HEAD"])
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}

/// Icon, version and manifest of every program of the crate: sharp on any screen, paths of any length.
fn windows() {
    println!("cargo:rerun-if-changed=../assets/mislab.ico");
    println!("cargo:rerun-if-changed=../assets/mislab.manifest");
    let mut resource = winresource::WindowsResource::new();
    resource
        .set_icon("../assets/mislab.ico")
        .set_manifest_file("../assets/mislab.manifest")
        .set("ProductName", "MIS Lab")
        .set("FileDescription", "MIS Lab")
        .set("LegalCopyright", "MIT or Apache-2.0");
    if let Err(why) = resource.compile() {
        // The program runs without; a missing compiler of resources is no reason not to build it.
        println!("cargo:warning=no icon and no manifest: {why}");
    }
}
