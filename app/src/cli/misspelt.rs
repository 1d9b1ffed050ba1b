//! A first argument that is neither a command nor a file.

use std::ffi::OsString;
use std::path::Path;

use clap::CommandFactory as _;

use super::args::Args;
use super::failure::Failure;

/// The failure that a misspelt command is: it would be taken for a scene, and a window be opened on nothing.
pub(super) fn check(argv: &[OsString]) -> Result<(), Failure> {
    let Some(word) = argv.get(1).and_then(|word| word.to_str()) else { return Ok(()) };
    let commands: Vec<String> = Args::command().get_subcommands().map(|c| c.get_name().to_owned()).collect();
    // clap's own.
    let known = commands.iter().any(|command| command == word) || word == "help";
    let could_be_a_file =
        Path::new(word).extension().is_some() || word.contains(['/', '\\']) || Path::new(word).exists();
    if word.is_empty() || word.starts_with('-') || known || could_be_a_file {
        return Ok(());
    }
    let nearest = commands
        .iter()
        .map(|command| (strsim::damerau_levenshtein(&word.to_lowercase(), command), command))
        .min()
        .filter(|(distance, command)| *distance <= (word.len() / 3).max(1) || command.starts_with(word));
    Err(Failure::Usage(match nearest {
        Some((_, command)) => format!("\"{word}\" is neither a command nor a file, did you mean {command}?"),
        None => {
            format!("\"{word}\" is neither a command nor a file, expected a scene or one of {}", commands.join(", "))
        }
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(line: &str) -> Option<String> {
        let argv: Vec<OsString> = line.split(' ').map(OsString::from).collect();
        match check(&argv) {
            Err(Failure::Usage(message)) => Some(message),
            Err(Failure::Run(message)) => panic!("{line}: {message}"),
            Ok(()) => None,
        }
    }

    #[test]
    fn near_misses_of_commands_are_named() {
        for (line, command) in [
            ("mislab rendr", "render"),
            ("mislab rneder a.pbrt", "render"),
            ("mislab Render", "render"),
            ("mislab tabel", "table"),
            ("mislab comp a.exr b.exr", "compare"),
            ("mislab inof", "info"),
        ] {
            let message = said(line).unwrap_or_else(|| panic!("{line} is accepted"));
            assert!(message.ends_with(&format!("did you mean {command}?")), "{line}: {message}");
        }
        assert!(said("mislab veach").is_some_and(|m| m.contains("expected a scene or one of render, table")));
        for line in [
            "mislab",
            "mislab render",
            "mislab help",
            "mislab --version",
            "mislab a.pbrt",
            "mislab ./rendr",
            "mislab src",
        ] {
            assert_eq!(said(line), None, "{line}");
        }
    }
}
