//! `mislab info FILE.exr`: what a picture says about itself: pixels, channels, and the settings it was made with.

use std::fmt::Write as _;
use std::path::Path;

use mislab_renderer::snapshot::{self, Info, Part, shown};

use super::args::InfoArgs;
use super::failure::Failure;
use super::output;

pub(super) fn run(args: &InfoArgs) -> Result<(), Failure> {
    let info = snapshot::info(&args.file)?;
    output::print(&text(&args.file, &info))?;
    // All that is known has been shown, also of a picture of our own whose state cannot be used.
    info.restored.map(drop).map_err(Failure::from)
}

fn text(file: &Path, info: &Info) -> String {
    let origin = match &info.restored {
        Ok(None) => "not written by MIS Lab".to_owned(),
        Ok(Some(restored)) => format!("written by {}", restored.software),
        Err(_) => "written by MIS Lab".to_owned(),
    };
    let mut text = match info.parts.len() {
        1 => format!("{}: {origin}\n", file.display()),
        n => format!("{}: {n} parts, {origin}\n", file.display()),
    };
    for (i, part) in info.parts.iter().enumerate() {
        if info.parts.len() > 1 {
            let name = part.name.as_deref().unwrap_or("without a name");
            let _ = writeln!(text, "\npart {} of {}: {}", i + 1, info.parts.len(), shown(name));
        }
        text.push_str(&part_text(part));
    }
    text
}

fn part_text(part: &Part) -> String {
    let Part { name: _, window, display, deep, channels, attributes } = part;
    let mut text = String::from("\n");
    for (name, window) in [("dataWindow", window), ("displayWindow", display)] {
        let _ = writeln!(text, "{name:<13}  {window}");
    }
    if *deep {
        text.push_str("deep: many samples a pixel\n");
    }
    let _ = writeln!(text, "\n{}", counted(channels.len(), "channel"));
    let widest = channels.iter().map(|channel| shown(&channel.name).chars().count()).max().unwrap_or(0);
    for channel in channels {
        let sampling = match channel.sampling {
            [1, 1] => String::new(),
            [x, y] => format!(", one for every {x} x {y} pixels"),
        };
        let _ = writeln!(text, "{:<widest$}  {}{sampling}", shown(&channel.name), channel.kind);
    }
    // What has been said above is left out.
    let said = ["channels", "dataWindow", "displayWindow"];
    let rest: Vec<_> = attributes.iter().filter(|(name, _)| !said.contains(&name.as_str())).collect();
    let _ = writeln!(text, "\n{}", counted(rest.len(), "attribute"));
    let widest = rest.iter().map(|(name, _)| shown(name).chars().count()).max().unwrap_or(0);
    for (name, value) in rest {
        let _ = writeln!(text, "{:<widest$}  {}", shown(name), shown(value));
    }
    text
}

/// "1 channel", "3 channels".
fn counted(n: usize, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") }
}
