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

/// "0.0123 ± 0.0004", or "(1.23 ± 0.04)e-7": digits down to the second of the error.
pub(super) fn with_error(value: f64, error: f64) -> String {
    let exponent = |v: f64| if v == 0.0 { 0 } else { v.abs().log10().floor() as i32 };
    let scale = if (-3..=3).contains(&exponent(value)) { 0 } else { exponent(value) };
    let factor = 10_f64.powi(-scale);
    let decimals = if error > 0.0 { (1 - exponent(error * factor)).clamp(0, 6) as usize } else { 4 };
    let text = format!("{:.decimals$} ± {:.decimals$}", value * factor, error * factor);
    if scale == 0 { text } else { format!("({text})e{scale}") }
}
