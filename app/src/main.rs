//! The program `mislab`: see [`mislab::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    mislab::cli::main()
}
