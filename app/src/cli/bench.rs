//! `mislab bench`: how fast this machine renders.

use std::fmt::Write as _;
use std::sync::Arc;

use mislab_renderer::benchmark::{self, Report};
use mislab_renderer::{SamplerKind, pbrt};

use super::args::BenchArgs;
use super::failure::Failure;
use super::output;

pub(super) fn run(args: &BenchArgs) -> Result<(), Failure> {
    if let Some(json) = &args.numbers.json {
        json.check()?;
    }
    let scene = Arc::new(pbrt::embedded_scene().scene);
    let report = benchmark::run(&scene, args.seconds, &mut |step| {
        if !args.numbers.quiet {
            output::message(&format!("measuring: {step}"));
        }
    })?;
    output::report(args.numbers.json.as_ref(), &report, &text(&report))
}

fn text(report: &Report) -> String {
    let mut text = format!("Mpaths/s per core  {:>8}  {:>8}  {:>6}\n", report.simd, "one lane", "ratio");
    for (name, rates) in &report.strategies {
        let _ = writeln!(text, "{name:17}  {:8.1}  {:8.2}  {:6.1}", rates.simd, rates.scalar, rates.ratio);
    }
    let _ = writeln!(text, "{} threads against one: {:.2} times as fast", report.threads.count, report.threads.speedup);
    for (what, latency) in [
        ("change to first frame", &report.first_frame_ms),
        ("change of a running pass to a tiny picture", &report.cancel_ms),
    ] {
        let _ = writeln!(text, "{what}: {:.1} ms, 99 of 100 below {:.1} ms", latency.p50, latency.p99);
    }
    let _ = writeln!(text, "layers: {:.0} % over the bare picture", report.layers_cost * 100.0);
    let samplers = SamplerKind::ALL.map(SamplerKind::name);
    let _ = writeln!(text, "1 / (relMSE x s)   {}", samplers.map(|name| format!("{name:>17}")).join("  "));
    for (strategy, by_sampler) in &report.efficiency {
        let cells = samplers.map(|name| by_sampler.get(name).map_or_else(String::new, |value| format!("{value:.0}")));
        let _ = writeln!(text, "{strategy:17}  {}", cells.map(|cell| format!("{cell:>17}")).join("  "));
    }
    text
}
