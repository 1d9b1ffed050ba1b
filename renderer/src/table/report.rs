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
            let value = quality(cell);
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

/// See [`Cell::quality`].
pub(super) fn quality(cell: &Cell) -> String {
    cell.rel_mse.zip(cell.standard_error).map_or("no pixels".into(), |(value, error)| with_error(value, error))
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
            let light = match cell.light {
                LightSize::Small => "small",
                LightSize::Large => "large",
            };
            let bsdf = match cell.bsdf {
                LobeWidth::Broad => "broad",
                LobeWidth::Sharp => "sharp",
            };
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

/// "0.0123 ± 0.0004", or "(1.23 ± 0.04)e-7": digits down to the second of the error. An error that no digit shows is given
/// by its size, "0.992702 ± 2e-9": it is small, not 0.
fn with_error(value: f64, error: f64) -> String {
    const MOST_DECIMALS: i32 = 6;
    let exponent = |v: f64| if v == 0.0 { 0 } else { v.abs().log10().floor() as i32 };
    let scale = if (-3..=3).contains(&exponent(value)) { 0 } else { exponent(value) };
    let factor = 10_f64.powi(-scale);
    let (value, error) = (value * factor, error * factor);
    let text = if error == 0.0 {
        format!("{value:.4} ± 0")
    } else if error < 10_f64.powi(-MOST_DECIMALS) {
        format!("{value:.*} ± {error:.0e}", MOST_DECIMALS as usize)
    } else {
        let decimals = (1 - exponent(error)).clamp(0, MOST_DECIMALS) as usize;
        format!("{value:.decimals$} ± {error:.decimals$}")
    };
    if scale == 0 { text } else { format!("({text})e{scale}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_show_what_is_known_of_them() {
        for (value, error, text) in [
            (7.695e-4, 6.0e-6, "(7.695 ± 0.060)e-4"),
            (0.014_019_2, 0.000_035_8, "0.014019 ± 0.000036"),
            (22.07, 0.483, "22.07 ± 0.48"),
            (22_071.0, 483.0, "(2.207 ± 0.048)e4"),
            (13.3, 1.8, "13.3 ± 1.8"),
            (130.0, 18.0, "130 ± 18"),
            (0.992_702_1, 2.3e-9, "0.992702 ± 2e-9"),
            (0.992_702_1, 0.0, "0.9927 ± 0"),
            (0.0, 0.0, "0.0000 ± 0"),
            (-1.2e-5, 3.1e-5, "(-1.2 ± 3.1)e-5"),
        ] {
            assert_eq!(with_error(value, error), text);
        }
    }
}
