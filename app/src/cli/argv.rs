//! pbrt-v3's habit of long options with one dash: `-outfile a.exr` is read as `--outfile a.exr`.

use std::collections::BTreeSet;
use std::ffi::OsString;

use clap::CommandFactory as _;

use super::args::Args;

/// Gives a second dash to every argument that is a known long option with one. Negative numbers, `-` and everything
/// after `--` stay as they are.
pub(super) fn with_double_dashes(argv: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let known = long_options();
    let mut rest_is_literal = false;
    argv.map(|arg| {
        rest_is_literal |= arg == "--";
        let option = arg.to_str().and_then(|text| text.strip_prefix('-'));
        let name = option.map(|text| text.split_once('=').map_or(text, |(name, _)| name));
        if !rest_is_literal && name.is_some_and(|name| known.contains(name)) {
            let mut doubled = OsString::from("-");
            doubled.push(arg);
            doubled
        } else {
            arg
        }
    })
    .collect()
}

/// The names of all long options of all commands.
fn long_options() -> BTreeSet<String> {
    let command = Args::command();
    let of_commands = command.get_subcommands().flat_map(clap::Command::get_arguments);
    let mut names: BTreeSet<String> =
        of_commands.chain(command.get_arguments()).filter_map(|arg| arg.get_long().map(str::to_owned)).collect();
    // clap adds these by itself.
    names.extend(["help".to_owned(), "version".to_owned()]);
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rewritten(line: &str) -> String {
        let args = with_double_dashes(line.split(' ').map(OsString::from));
        args.iter().map(|arg| arg.to_string_lossy().into_owned()).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn pbrt_spellings_are_understood() {
        assert_eq!(
            rewritten("mislab render -outfile a.exr -nthreads=2 -quick -quiet --spp 4"),
            "mislab render --outfile a.exr --nthreads=2 --quick --quiet --spp 4"
        );
    }

    #[test]
    fn everything_else_stays() {
        for line in ["mislab render -5 -0.5 -1e3 - -h -V -x a-outfile", "mislab render -- -quick"] {
            assert_eq!(rewritten(line), line);
        }
    }
}
