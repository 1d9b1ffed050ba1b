//! `mislab converge`: how the error of each strategy falls with the samples.

use std::num::NonZeroU32;

use mislab_renderer::black::why_black;
use mislab_renderer::convergence::{Options, converge};
use mislab_renderer::{Request, SamplerSettings, Strategy, snapshot};

use super::args::{ConvergeArgs, Counts};
use super::failure::Failure;
use super::input::Input;
use super::output::{self, Destination};
use super::progress::Bar;
use super::render::request;

pub(super) fn run(args: ConvergeArgs) -> Result<(), Failure> {
    let ConvergeArgs { picture, strategies, at: Counts(at), replicates, reference, by_square, csv, json, how } = args;
    if matches!((&csv, &json), (Some(Destination::StandardOutput), Some(Destination::StandardOutput))) {
        return Err(Failure::Usage("--csv - and --json -: expected at most one of them on standard output".to_owned()));
    }
    for file in csv.iter().chain(&json) {
        file.check()?;
    }
    let input = Input::load(picture.scene.as_deref())?;
    input.warn(how.quiet);
    let request = request(&picture, Request { scene: input.scene.clone(), settings: input.settings.clone() })?;
    let strategies = strategies.into_iter().fold(Vec::new(), |mut all, strategy| {
        if !all.contains(&strategy) {
            all.push(strategy);
        }
        all
    });
    if let Some(why) = why_black_at_once(&request, how.nthreads)? {
        output::message(&format!("{}: warning: {why}", input.source));
    }
    let image = reference.as_deref().map(snapshot::load_image).transpose()?;
    let options = Options { strategies, at, replicates, by_square, reference: image, threads: how.nthreads };
    let found = {
        let bar = Bar::new(how.quiet);
        converge(&request, &options, &mut |step| {
            bar.show_step(step);
            true
        })
    };
    let named = |error: mislab_renderer::Error| match &reference {
        Some(path) => Failure::Run(format!("{}: {error}", path.display())),
        None => error.into(),
    };
    let found = found.map_err(named)?.ok_or_else(|| Failure::Run("stopped".to_owned()))?;

    let on_stdout = [&csv, &json].iter().any(|to| matches!(to, Some(Destination::StandardOutput)));
    if !on_stdout {
        let file = reference.map(|path| path.display().to_string());
        output::print(&found.to_text(file.as_deref()))?;
    }
    if let Some(csv) = &csv {
        csv.write_text(&found.to_csv())?;
    }
    json.map_or(Ok(()), |json| json.write(&found))
}

/// Why every curve will be one of a black picture, also with --quiet; from a few samples of both techniques.
fn why_black_at_once(request: &Request, threads: usize) -> Result<Option<String>, Failure> {
    const SPP: NonZeroU32 = NonZeroU32::new(4).expect("not 0");
    let Request { scene, mut settings } = request.clone();
    settings.estimator.strategy = Strategy::MisAll;
    settings.sampling.spp = Some(SPP);
    settings.sampling.sampler.strata = SamplerSettings::strata_for(SPP.get());
    let frame = mislab_renderer::render(&Request { scene, settings }, threads, &mut |_| true)?;
    Ok(why_black(&frame))
}
