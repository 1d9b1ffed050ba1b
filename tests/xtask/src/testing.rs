//! `cargo xtask test`: every test, in release, with our own crates' assertions on.

use crate::isolated::{Scratch, isolate};
use crate::{cargo, needs};

/// Crates of the workspace whose debug assertions and overflow checks are on under test. Dependencies keep the release
/// profile, so that tests and `cargo run --release` share one build of them.
const CHECKED: [&str; 4] = ["mislab-kernel", "mislab-renderer", "mislab", "mislab-tests"];

/// Provides what the tests need and runs them, `deep` with more samples and cases (`tests/src/depth.rs`); `args` replace
/// `--workspace`.
pub fn run(args: &[String], deep: bool) -> Result<(), String> {
    needs::provide();
    let scratch = Scratch::new()?;

    let mut test = cargo();
    test.env("MISLAB_DEEP", if deep { "1" } else { "0" });
    test.args(["test", "--release"]);
    for package in CHECKED {
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
