//! The table as text.

use std::fmt::Write;

use super::{Cell, LightSize, LobeWidth, Table, TableRow};

/// See [`Table::to_markdown`].
pub(super) fn markdown(table: &Table) -> String {
    let mut out = String::from(
        "| File | Strategy | Samples | Image | Time (s) | Light | BSDF broad | BSDF sharp |\n\
         |---|---|---|---|---:|---|---|---|\n",
    );
    for row in &table.rows {
        let TableRow {
            run,
            resolution: [w, h],
            render_seconds,
            cells: [small_broad, small_sharp, large_broad, large_sharp],
            ..
        } = row;
        let ([nx, ny], file, strategy) = (run.strata, run.file, run.strategy.name());
        let square = |cell: &Cell| {
            let value = cell.rel_mse.zip(cell.standard_error).map_or("no pixels".into(), |(v, e)| with_error(v, e));
            if cell.cross { format!("**× {value}**") } else { value }
        };
        let _ = writeln!(
            out,
            "| {file} | {strategy} | {nx}x{ny} | {w} x {h} | {render_seconds:.2} | small | {} | {} |\n\
             | | | | | | large | {} | {} |",
            square(small_broad),
            square(small_sharp),
            square(large_broad),
            square(large_sharp)
        );
    }
    let threads = table.rows.first().map_or(0, |row| row.threads);
    let own = table.rows.iter().flat_map(|r| &r.cells).filter_map(|c| c.reference_rel_mse).fold(0.0, f64::max);
    let _ = write!(
        out,
        "\nNumbers are relMSE ± standard error over {} renders with different seeds; smaller is better. × marks the best file \
         of a square and every file that a rank test cannot tell from it ({} % significance over the whole table).\n\
         A pixel belongs to the light that contributes most to it in the reference. Light small: {}; large: {}. BSDF broad: \
         {}; sharp: {}.\n\
         Reference: {} camera rays per pixel and light, its own relMSE at most {own:.1e}. Times: {threads} threads; compare \
         them at the same image size only.\n",
        table.replicates,
        table.significance * 100.0,
        table.small.join(", "),
        table.large.join(", "),
        table.broad.join(", "),
        table.sharp.join(", "),
        table.reference_spp,
    );
    out
}

/// See [`Table::to_csv`].
pub(super) fn csv(table: &Table) -> String {
    let mut out = String::from(
        "file,strategy,xsamples,ysamples,width,height,spp,threads,paths,render_seconds,cpu_seconds,light,bsdf,pixels,rel_mse,\
         standard_error,reference_rel_mse,cross\n",
    );
    for row in &table.rows {
        for cell in &row.cells {
            let number = |value: Option<f64>| value.map_or(String::new(), |v| v.to_string());
            let (light, bsdf) = (light_name(cell.light), bsdf_name(cell.bsdf));
            let _ = writeln!(
                out,
                "{},{},{},{},{},{},{},{},{},{},{},{light},{bsdf},{},{},{},{},{}",
                row.run.file,
                row.run.strategy.name(),
                row.run.strata[0],
                row.run.strata[1],
                row.resolution[0],
                row.resolution[1],
                row.spp,
                row.threads,
                row.paths,
                row.render_seconds,
                row.cpu_seconds,
                cell.pixels,
                number(cell.rel_mse),
                number(cell.standard_error),
                number(cell.reference_rel_mse),
                cell.cross
            );
        }
    }
    out
}

/// A measured value and its standard error: "0.0123 ± 0.0004", or "(1.23 ± 0.04)e-7": digits down to the second of the
/// error, the same on the command line, in files and in the window. Without an error (NaN) six significant digits of
/// the value.
pub fn with_error(value: f64, error: f64) -> String {
    /// More decimals than this nobody reads.
    const MOST: i32 = 6;
    if value == 0.0 && error == 0.0 {
        return "0 ± 0".to_owned();
    }
    let exponent = |v: f64| if v == 0.0 { 0 } else { v.abs().log10().floor() as i32 };
    let scale = if (-3..=3).contains(&exponent(value)) { 0 } else { exponent(value) };
    let factor = 10_f64.powi(-scale);
    let last_digit = if error > 0.0 { 1 - exponent(error * factor) } else { MOST - 1 - exponent(value * factor) };
    let decimals = last_digit.clamp(0, MOST) as usize;
    let number = format!("{:.decimals$}", value * factor);
    let error = match error * factor {
        e if e.is_nan() => String::new(),
        0.0 => " ± 0".into(),
        // An error that would be written as zero is none the less one.
        e if last_digit > MOST => format!(" ± {e:.0e}"),
        e => format!(" ± {e:.decimals$}"),
    };
    let text = format!("{number}{error}");
    if scale == 0 { text } else { format!("({text})e{scale}") }
}

/// As it stands in the table's head.
pub(crate) fn light_name(light: LightSize) -> &'static str {
    match light {
        LightSize::Small => "small",
        LightSize::Large => "large",
    }
}

/// As it stands in the table's head.
pub(crate) fn bsdf_name(bsdf: LobeWidth) -> &'static str {
    match bsdf {
        LobeWidth::Broad => "broad",
        LobeWidth::Sharp => "sharp",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_never_written_as_zero() {
        assert_eq!(with_error(0.02471, 0.00021), "0.02471 ± 0.00021");
        assert_eq!(with_error(22.61, 4.9), "22.6 ± 4.9");
        assert_eq!(with_error(7.695e-4, 6.0e-6), "(7.695 ± 0.060)e-4");
        assert_eq!(with_error(0.992_702_1, 1.2e-9), "0.992702 ± 1e-9");
        assert_eq!(with_error(0.992_702_1, 0.0), "0.992702 ± 0");
        assert_eq!(with_error(0.25, f64::NAN), "0.250000");
        assert_eq!(with_error(0.0, 0.0), "0 ± 0");
        assert_eq!(with_error(0.0, 0.02), "0.000 ± 0.020");
    }
}
