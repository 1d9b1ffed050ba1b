//! What a double click on Windows starts, "MIS Lab.exe": the program beside it in `bin`, without a console window.
//!
//! A program of Windows has a console or none, which is decided when it is linked. `mislab.exe` has one, so that commands can
//! be typed and waited for; this one has none, and starts that one without. Elsewhere programs know no such difference.

#![cfg_attr(windows, windows_subsystem = "windows")]

use std::process::{Command, ExitCode, Stdio};

/// Most letters of a message.
const LONGEST: usize = 1000;

fn main() -> ExitCode {
    let Err(why) = run() else { return ExitCode::SUCCESS };
    // Nobody sees what a program without a console prints.
    rfd::MessageDialog::new().set_level(rfd::MessageLevel::Error).set_title("MIS Lab").set_description(why).show();
    ExitCode::FAILURE
}

/// Runs the program to its end; an error is what it said.
fn run() -> Result<(), String> {
    let own = std::env::current_exe().map_err(|error| error.to_string())?;
    let program = own.with_file_name("bin").join(if cfg!(windows) { "mislab.exe" } else { "mislab" });
    if !program.is_file() {
        // Out of a zip the file manager starts what was clicked, alone.
        let missing = program.display();
        return Err(format!("There is no {missing}.\n\nUnpack the whole archive, and start MIS Lab in that folder."));
    }
    let mut command = Command::new(program);
    command.args(std::env::args_os().skip(1)).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    #[cfg(windows)]
    std::os::windows::process::CommandExt::creation_flags(&mut command, CREATE_NO_WINDOW);
    let done = command.output().map_err(|error| error.to_string())?;
    if done.status.success() {
        return Ok(());
    }
    Err(String::from_utf8_lossy(&done.stderr).chars().take(LONGEST).collect())
}

/// Of `CreateProcess`: the console of the new program has no window.
#[cfg(windows)]
const CREATE_NO_WINDOW: u32 = 0x0800_0000;
