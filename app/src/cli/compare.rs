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
    let comparison = metrics::compare(&a, &b)
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
    let mut text = format!("A: {}\nB: {} (the reference)\npixels: {}\n", a.display(), b.display(), comparison.window);
    if comparison.is_identical() {
        text.push_str("Every value is the same.\n");
    }
    let _ = writeln!(
        text,
        "\n{:<16} {:>12} {:>12} {:>12} {:>12} {:>12}  {:<12} undefined",
        "", "mean A", "mean B", "MSE", "relMSE", "max |A-B|", "at"
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
    let Difference { name, mean_a, mean_b, mse, rel_mse, maximum, compared: _, both_undefined, undefined_mismatch } =
        difference;
    let number = |value: &Option<f64>| value.map_or_else(|| "-".to_owned(), |v| format!("{v:.5e}"));
    let undefined = match (both_undefined, undefined_mismatch) {
        (0, 0) => String::new(),
        (both, 0) => format!("{both} in both"),
        (both, one) => format!("{both} in both, {one} in one only"),
    };
    let line = format!(
        "{name:<16} {:>12} {:>12} {:>12} {:>12} {:>12}  {:<12} {undefined}",
        number(mean_a),
        number(mean_b),
        number(mse),
        number(rel_mse),
        number(&maximum.map(|m| m.value)),
        maximum.map_or_else(|| "-".to_owned(), |m| format!("{}, {}", m.x, m.y)),
    );
    line.trim_end().to_owned() + "\n"
}
