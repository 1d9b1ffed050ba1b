//! `cargo xtask test`: every test, in release, with assertions on in our own crates outside the kernel.

use crate::isolated::{Scratch, isolate};
use crate::{cargo, needs};

/// Crates of the workspace whose debug assertions and overflow checks are on under test. Dependencies and the kernel keep the
/// release profile: tests and `cargo run --release` share one build of them, and what is judged is what people get.
const CHECKED: [&str; 3] = ["mislab-renderer", "mislab", "mislab-tests"];

/// Checked in the deep run alone: it asserts nothing itself, and the checks of the standard library within vector code double
/// the minutes that the kernel takes to compile.
const CHECKED_DEEP: [&str; 1] = ["mislab-kernel"];

/// Provides what the tests need and runs them, `deep` with more samples and cases (`tests/src/depth.rs`); `args` replace
/// `--workspace`.
pub fn run(args: &[String], deep: bool) -> Result<(), String> {
    needs::provide(needs::TESTS);
    let scratch = Scratch::new()?;

    let mut test = cargo();
    test.env("MISLAB_DEEP", if deep { "1" } else { "0" });
    test.args(["test", "--release"]);
    let kernel = if deep { &CHECKED_DEEP[..] } else { &[] };
    for package in CHECKED.iter().chain(kernel) {
        for check in ["debug-assertions", "overflow-checks"] {
            test.arg("--config").arg(format!("profile.release.package.{package}.{check}=true"));
        }
    }
    if args.is_empty() {
        test.arg("--workspace");
    } else {
        test.args(args);
    }

    isolate(&mut test, &scratch)?;
    let status = test.status().map_err(|error| format!("cannot start cargo: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("tests failed ({status})")) }
}
