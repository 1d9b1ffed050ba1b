//! The archive for Windows, in wine: what is asked of no other.

use std::path::Path;
use std::process::Command;

use super::unpacked::{Unpacked, read};
use crate::run::succeed;

/// Where Debian's package puts it.
pub const WINE: &str = "/usr/lib/wine/wine64";

/// A Windows of its own in that home, which asks for nothing.
pub fn settle(command: &mut Command, home: &Path) {
    command.env("WINEPREFIX", home.join("wine")).env("WINEDEBUG", "-all");
    // Else a window asks whether to download libraries of .NET and for HTML.
    command.env("WINEDLLOVERRIDES", "mscoree,mshtml=");
}

/// Wine 8 has no `bcryptprimitives.dll`, of which Rust's programs want one function, random bytes for hash tables. Windows has it.
///
/// # Errors
/// If it cannot be compiled.
pub fn stand_in_for_system_library(unpacked: &Unpacked) -> Result<(), String> {
    let source = unpacked.folder.join("stand_in.c");
    let text = "#include <stdlib.h>\n\
        __declspec(dllexport) int ProcessPrng(unsigned char *p, size_t n) { while (n--) *p++ = (unsigned char)rand(); return 1; }\n";
    std::fs::write(&source, text).map_err(|error| format!("{}: {error}", source.display()))?;
    for place in unpacked.platform.places() {
        let library = unpacked.folder.join(place).with_file_name("bcryptprimitives.dll");
        let mut compile = Command::new("x86_64-w64-mingw32-gcc");
        succeed(compile.args(["-shared", "-O1", "-o"]).arg(library).arg(&source))?;
    }
    Ok(())
}

/// Programs with icon, version and manifest, one without and one with a console; a picture is not lost to a program that holds
/// its file.
///
/// # Errors
/// The first thing that is not so.
pub fn check(unpacked: &Unpacked) -> Result<(), String> {
    for place in unpacked.platform.places() {
        let subsystem = if *place == unpacked.platform.double_clicked() { WITH_WINDOWS } else { WITH_CONSOLE };
        let bytes = read(&unpacked.folder.join(place))?;
        check_program(&bytes, subsystem).map_err(|what| format!("{place}: {what}"))?;
    }
    check_held_file(unpacked)
}

/// Of the header of a program.
const WITH_WINDOWS: u16 = 2;
const WITH_CONSOLE: u16 = 3;

fn check_program(bytes: &[u8], subsystem: u16) -> Result<(), String> {
    let number = |at: usize| bytes.get(at..at + 2).map_or(0, |b| u16::from_le_bytes([b[0], b[1]]));
    let header = usize::from(number(0x3c));
    let time = [number(header + 8), number(header + 10)];
    if time != [0, 0] {
        return Err("the time of linking is in it, which makes every archive another".into());
    }
    if number(header + 0x5c) != subsystem {
        return Err(format!("the subsystem is {}, not {subsystem}", number(header + 0x5c)));
    }
    let wide = |text: &str| text.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>();
    for (what, text) in [
        ("manifest", b"PerMonitorV2".to_vec()),
        ("manifest", b"longPathAware".to_vec()),
        ("version", wide("FileDescription")),
        ("icon", icon()?),
    ] {
        if !bytes.windows(text.len()).any(|window| window == text) {
            return Err(format!("it has no {what}"));
        }
    }
    Ok(())
}

/// The first picture of the icon.
fn icon() -> Result<Vec<u8>, String> {
    let file = Path::new("assets/mislab.ico");
    let bytes = read(file)?;
    let number =
        |at: usize| bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map_or(0, u32::from_le_bytes) as usize;
    // After six bytes its description: eight bytes, then length and place.
    let (length, place) = (number(14), number(18));
    bytes.get(place..place + length).map(<[u8]>::to_vec).ok_or_else(|| format!("{}: no icon", file.display()))
}

/// The command interpreter holds the file that it puts standard output into, for others to read and write but not to replace.
fn check_held_file(unpacked: &Unpacked) -> Result<(), String> {
    let render = r"bin\mislab.exe render scenes\veach_mis.pbrt --size 20x20 --spp 1 --outfile held.exr >> held.exr";
    let mut command = unpacked.settled(WINE);
    command.args(["cmd", "/c", render]);
    let done = command.output().map_err(|error| format!("{WINE}: {error}"))?;
    let said = String::from_utf8_lossy(&done.stderr);
    let instead = unpacked.folder.join("held_2.exr");
    if !done.status.success() || !instead.is_file() || !said.contains("held_2.exr") {
        return Err(format!("a picture whose file another program holds: {said}"));
    }
    Ok(())
}
