//! `mislab compare A.exr B.exr`: how far two pictures are apart.

use std::fmt::Write as _;
use std::path::Path;

use mislab_renderer::metrics::{self, Comparison, Difference};
use mislab_renderer::snapshot;
use serde::Serialize;

use super::args::CompareArgs;
use super::failure::Failure;
use super::output;

/// The object of `--json`.
#[derive(Serialize)]
struct Report<'a> {
    a: String,
    b: String,
    identical: bool,
    #[serde(flatten)]
    comparison: &'a Comparison,
}

pub(super) fn run(args: &CompareArgs) -> Result<(), Failure> {
    if let Some(json) = &args.json {
        json.check()?;
    }
    let (a, b) = (snapshot::load_image(&args.a)?, snapshot::load_image(&args.b)?);
    let compare = if args.resample { metrics::compare_resampled } else { metrics::compare };
    let comparison = compare(&a, &b)
        .map_err(|error| Failure::Run(format!("{}, {}: {error}", args.a.display(), args.b.display())))?;
    let on_stdout = matches!(args.json, Some(output::Destination::StandardOutput));
    if !on_stdout {
        output::print(&text(&args.a, &args.b, &comparison))?;
    }
    let Some(json) = &args.json else { return Ok(()) };
    json.write(&Report {
        a: args.a.display().to_string(),
        b: args.b.display().to_string(),
        identical: comparison.is_identical(),
        comparison: &comparison,
    })
}

/// For people: one line per layer, then per channel.
fn text(a: &Path, b: &Path, comparison: &Comparison) -> String {
    let mut text = format!("A: {}\nB: {} (the reference)\npixels: {}", a.display(), b.display(), comparison.window);
    if let Some([width, height]) = comparison.resampled {
        let [a, b] = [comparison.window_a, comparison.window_b];
        let _ =
            write!(text, ", of a grid of {width} x {height}: means over areas of A's {a} and B's {b}, with less noise");
    } else {
        for (which, window) in [("A", comparison.window_a), ("B", comparison.window_b)] {
            if window != comparison.window {
                let _ = write!(text, ", a part of {which}'s {window}");
            }
        }
    }
    text.push('\n');
    if comparison.is_identical() {
        let whole = comparison.window_a == comparison.window_b;
        let _ = writeln!(text, "Every value{} is the same.", if whole { "" } else { " of these pixels" });
    }
    let _ = writeln!(
        text,
        "\n{:<16} {:>12} {:>12} {:>12} {:>12} {:>12}  {:<12} {:>9}  undefined",
        "", "mean A", "mean B", "MSE", "relMSE", "max |A-B|", "at", "values"
    );
    for difference in comparison.layers.iter().chain(&comparison.channels) {
        text.push_str(&line(difference));
    }
    for (which, names) in [("A", &comparison.only_in_a), ("B", &comparison.only_in_b)] {
        if !names.is_empty() {
            let _ = writeln!(text, "\nonly in {which}: {}", names.join(", "));
        }
    }
    text
}

fn line(difference: &Difference) -> String {
    let Difference {
        name,
        mean_a,
        mean_b,
        mse,
        rel_mse,
        maximum,
        compared,
        both_undefined,
        undefined_in_a,
        undefined_in_b,
        undefined_differently,
    } = difference;
    let number = |value: &Option<f64>| value.map_or_else(|| "-".to_owned(), |v| format!("{v:.5e}"));
    let counts = [
        (undefined_in_a, "in A only"),
        (undefined_in_b, "in B only"),
        (both_undefined, "in both"),
        (undefined_differently, "in both, not alike"),
    ];
    let undefined = counts.iter().filter(|(n, _)| **n > 0).map(|(n, where_)| format!("{n} {where_}"));
    let line = format!(
        "{name:<16} {:>12} {:>12} {:>12} {:>12} {:>12}  {:<12} {compared:>9}  {}",
        number(mean_a),
        number(mean_b),
        number(mse),
        number(rel_mse),
        number(&maximum.map(|m| m.value)),
        maximum.map_or_else(|| "-".to_owned(), |m| format!("{}, {}", m.x, m.y)),
        undefined.collect::<Vec<_>>().join(", "),
    );
    line.trim_end().to_owned() + "\n"
}
