//! Chores of the project: `cargo xtask test`, `cargo xtask screenshot`, `cargo xtask dist`. No dependencies, so that it starts at once.

mod dist;
mod isolated;
mod needs;
mod run;
mod screen;
mod screenshot;
mod testing;

use std::process::{Command, ExitCode};

const USAGE: &str = "\
cargo xtask test [--deep] [ARGS]
                          install or name what the tests need, then run them all; --deep with many
                          more samples and cases; ARGS go to `cargo test` in place of --workspace,
                          e.g. -p mislab --test cli
cargo xtask screenshot    build the app, show it on a virtual screen and save assets/screenshot.png
cargo xtask dist [--check] [--target T]...
                          archives to download, in target/dist: for Linux on x86-64 and aarch64 and for
                          Windows, or for the targets named; --check unpacks and runs each";

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let done = match args.split_first() {
        Some((command, rest)) if command == "test" => match rest.split_first() {
            Some((deep, rest)) if deep == "--deep" => testing::run(rest, true),
            _ => testing::run(rest, false),
        },
        Some((command, [])) if command == "screenshot" => screenshot::run(),
        Some((command, rest)) if command == "dist" => dist::run(rest),
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

/// The cargo that runs this.
fn cargo() -> Command {
    Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}
