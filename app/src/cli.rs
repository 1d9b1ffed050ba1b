//! The command line: `mislab [SCENE]` for the window, `render`, `table`, `converge`, `compare`, `info`, `bench`,
//! `inspect`, `replay` and `fireflies` without one.
//!
//! What was asked for goes to standard output and nothing else does; messages, warnings and progress go to standard
//! error. Exit code 0: done; 1: it failed; 2: the arguments cannot be used.

#![warn(
    clippy::print_stdout,
    reason = "`println!` panics when the reader of a pipe goes away: `mislab info FILE | head -1`"
)]

mod args;
mod argv;
mod bench;
mod compare;
mod converge;
mod failure;
mod fireflies;
mod info;
mod input;
mod inspect;
mod misspelt;
mod output;
mod progress;
mod render;
mod replay;
mod table;
mod version;

use std::process::ExitCode;

use clap::Parser as _;

use self::args::{Args, Command};
use self::failure::Failure;
use crate::launch::{NoWindow, run_app};

/// Runs the program with the arguments of this process.
pub fn main() -> ExitCode {
    let argv = argv::with_double_dashes(std::env::args_os());
    let done = misspelt::check(&argv).and_then(|()| match Args::try_parse_from(argv) {
        Ok(args) => run(args),
        // Help and version come this way too, to standard output and with code 0.
        Err(message) => message.exit(),
    });
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Run(message)) => {
            output::message(&message);
            ExitCode::from(1)
        }
        Err(Failure::Usage(message)) => {
            output::message(&format!("error: {message}\n\nFor more information, try '--help'."));
            ExitCode::from(2)
        }
    }
}

fn run(args: Args) -> Result<(), Failure> {
    match args.command {
        Some(Command::Render(args)) => render::run(args),
        Some(Command::Table(args)) => table::run(args),
        Some(Command::Converge(args)) => converge::run(args),
        Some(Command::Compare(args)) => compare::run(&args),
        Some(Command::Info(args)) => info::run(&args),
        Some(Command::Bench(args)) => bench::run(&args),
        Some(Command::Inspect(args)) => inspect::run(&args),
        Some(Command::Replay(args)) => replay::run(&args),
        Some(Command::Fireflies(args)) => fireflies::run(&args),
        None => match run_app(args.scene.clone()) {
            Ok(()) => Ok(()),
            Err(NoWindow { reason }) => table::instead_of_window(args.scene, &reason),
        },
    }
}
