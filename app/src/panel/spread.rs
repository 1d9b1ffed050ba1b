//! What the layer of variances is about, in words, and what the samples as they are drawn are worth.

use mislab_renderer::study::Replicated;
use mislab_renderer::study::replicates::REPLICATES;
use mislab_renderer::{Frame, SamplerKind};

use crate::look::names::sampler_name;
use crate::panel::number::two_digits;
use crate::picture::variance;
use crate::state::view::VarianceUnit;

/// For the caption of `frame`, in the unit of its layer; `found` is of the same settings, and `None` while it is measured.
pub fn spread_words(frame: &Frame, unit: VarianceUnit, found: Option<Replicated>) -> String {
    let kind = frame.request().settings.sampling.sampler.kind;
    let name = match kind {
        SamplerKind::Independent => return "of independent samples, as these are".to_owned(),
        SamplerKind::Stratified | SamplerKind::Lattice | SamplerKind::PaddedStratified => {
            sampler_name(kind).to_lowercase()
        }
        SamplerKind::Sobol => sampler_name(kind).to_owned(),
        SamplerKind::PaddedSobol => "padded Sobol".to_owned(),
    };
    let Some(found) = found else { return format!("as if independent, these are {name} \u{2026}") };
    let cost = variance::cost(unit, frame);
    let [independent, pattern] = [found.independent, found.pattern].map(|spread| match unit {
        VarianceUnit::OneSample => two_digits(spread.absolute),
        VarianceUnit::Relative | VarianceUnit::PerRay | VarianceUnit::PerSecond => two_digits(cost * spread.relative),
    });
    format!("variance {independent} if independent; {name} {pattern} ({REPLICATES} replicates)")
}
