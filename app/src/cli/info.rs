//! `mislab info FILE.exr`: the settings a picture was made with.

use std::fmt::Write as _;

use mislab_renderer::snapshot;

use super::args::InfoArgs;
use super::failure::Failure;
use super::output;

/// Longer values are for programs: only their length is shown.
const LONGEST_SHOWN: usize = 400;

pub(super) fn run(args: &InfoArgs) -> Result<(), Failure> {
    let info = snapshot::info(&args.file)?;
    let widest = info.attributes.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    let mut text = String::new();
    for (name, value) in &info.attributes {
        let shown =
            if value.len() > LONGEST_SHOWN { format!("({} bytes)", value.len()) } else { value.replace('\n', "\\n") };
        let _ = writeln!(text, "{name:widest$}  {shown}");
    }
    output::print(&text)?;
    // All that is known has been shown; a picture of another program has no settings of ours.
    info.restored.map(|_| ()).map_err(Failure::from)
}
