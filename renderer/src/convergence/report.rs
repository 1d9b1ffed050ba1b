//! Curves as text and for spreadsheets.

use std::fmt::Write as _;

use super::{Convergence, Curve, CurvePoint};
use crate::table::report::{bsdf_name, light_name, with_error};

/// See [`Convergence::to_text`].
pub(super) fn text(all: &Convergence, file: Option<&str>) -> String {
    let mut out = String::new();
    let Convergence { scene, width, height, replicates, reference, curves } = all;
    let _ = writeln!(
        out,
        "relMSE ± standard error over {replicates} renders with different seeds, {scene}, {width} x {height}"
    );
    columns(&mut out, curves, |curve| (&curve.points, curve.slope, curve.slope_interval));
    let squares = curves.first().and_then(|curve| curve.squares.as_deref()).unwrap_or_default();
    for (i, square) in squares.iter().enumerate() {
        let (light, bsdf) = (light_name(square.light), bsdf_name(square.bsdf));
        let _ = writeln!(out, "\nlight {light}, BSDF {bsdf}: {} pixels", square.pixels);
        columns(&mut out, curves, |curve| {
            let square = &curve.squares.as_deref().unwrap_or_default()[i];
            (&square.points, square.slope, square.slope_interval)
        });
    }
    let spp = reference.spp.map_or("unknown".to_owned(), |spp| spp.to_string());
    let per_light = if squares.is_empty() { "" } else { " and light" };
    let _ = match reference.rel_mse {
        Some(own) => writeln!(
            out,
            "\nReference: {spp} camera rays per pixel{per_light}, its own relMSE {own:.1e}, which does not count."
        ),
        None => {
            let file = file.unwrap_or("a file");
            writeln!(out, "\nReference: {file} ({spp} spp), taken as exact: its own noise counts as error.")
        }
    };
    let in_square = |curve: &Curve| curve.squares.iter().flatten().any(|square| square.heavy_tailed);
    let heavy: Vec<_> = curves.iter().filter(|c| c.heavy_tailed || in_square(c)).map(|curve| curve.strategy).collect();
    if !heavy.is_empty() {
        let _ = writeln!(
            out,
            "{}: rare bright samples make the error; where one render carries most of it, the true error and slope can lie \
             outside the interval.",
            heavy.join(", ")
        );
    }
    for curve in curves {
        if let Some(bias) = curve.bias {
            let _ = writeln!(out, "{}: {bias}", curve.strategy);
        }
    }
    out
}

/// A line for each spp, a column for each curve, the slopes below.
fn columns<'a>(
    out: &mut String,
    curves: &'a [Curve],
    of: impl Fn(&'a Curve) -> (&'a Vec<CurvePoint>, Option<f64>, Option<[f64; 2]>),
) {
    const WIDTH: usize = 26;
    let _ = write!(out, "{:>6}", "spp");
    for curve in curves {
        let _ = write!(out, "  {:>WIDTH$}", curve.strategy);
    }
    out.push('\n');
    let count = curves.first().map_or(0, |curve| of(curve).0.len());
    for i in 0..count {
        let _ = write!(out, "{:>6}", of(&curves[0]).0[i].spp);
        for curve in curves {
            let point = &of(curve).0[i];
            let text =
                point.rel_mse.zip(point.standard_error).map_or("no pixels".to_owned(), |(v, e)| with_error(v, e));
            let _ = write!(out, "  {text:>WIDTH$}");
        }
        out.push('\n');
    }
    let _ = write!(out, "{:>6}", "slope");
    for curve in curves {
        let (_, slope, interval) = of(curve);
        let text =
            slope.zip(interval).map_or("-".to_owned(), |(s, [low, high])| format!("{s:.2} ({low:.2} to {high:.2})"));
        let _ = write!(out, "  {text:>WIDTH$}");
    }
    out.push('\n');
}

/// See [`Convergence::to_csv`].
pub(super) fn csv(all: &Convergence) -> String {
    let mut out = String::from(
        "strategy,heuristic,weights,light_prob,sampler,light,bsdf,spp,rays,cpu_seconds,rel_mse,standard_error\n",
    );
    for curve in &all.curves {
        lines(&mut out, curve, ["", ""], &curve.points);
        for square in curve.squares.iter().flatten() {
            lines(&mut out, curve, [light_name(square.light), bsdf_name(square.bsdf)], &square.points);
        }
    }
    out
}

fn lines(out: &mut String, curve: &Curve, [light, bsdf]: [&str; 2], points: &[CurvePoint]) {
    let Curve { strategy, heuristic, weights, light_prob, sampler, .. } = curve;
    let number = |value: Option<f64>| value.map_or(String::new(), |v| v.to_string());
    for CurvePoint { spp, rays, cpu_seconds, rel_mse, standard_error } in points {
        let [error, uncertainty] = [rel_mse, standard_error].map(|v| number(*v));
        let _ = writeln!(
            out,
            "{strategy},{heuristic},{weights},{light_prob},{sampler},{light},{bsdf},{spp},{rays},{cpu_seconds},{error},{uncertainty}"
        );
    }
}
