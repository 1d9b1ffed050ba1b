//! What a double click on Windows starts, "MIS Lab.exe": the program beside it in `bin`, without a console window.
//!
//! A program of Windows has a console or none, which is decided when it is linked. `mislab.exe` has one, so that commands can
//! be typed and waited for; this one has none, and starts that one without. Elsewhere programs know no such difference.

#![cfg_attr(windows, windows_subsystem = "windows")]

use std::process::{Command, ExitCode};

fn main() -> ExitCode {
    let Ok(own) = std::env::current_exe() else { return ExitCode::FAILURE };
    let program = own.with_file_name("bin").join(if cfg!(windows) { "mislab.exe" } else { "mislab" });
    let mut command = Command::new(program);
    command.args(std::env::args_os().skip(1));
    #[cfg(windows)]
    std::os::windows::process::CommandExt::creation_flags(&mut command, CREATE_NO_WINDOW);
    match command.status() {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        Ok(_) | Err(_) => ExitCode::FAILURE,
    }
}

/// Of `CreateProcess`: the console of the new program has no window.
#[cfg(windows)]
const CREATE_NO_WINDOW: u32 = 0x0800_0000;
