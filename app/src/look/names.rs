//! What strategies, heuristics and samplers are called on screen.

use mislab_renderer::{Heuristic, Lockstep, OneSampleWeights, SamplerKind, Strategy};

/// What goes on a strategy's button.
pub fn strategy_name(strategy: Strategy) -> &'static str {
    match strategy {
        Strategy::Light => "Light",
        Strategy::Bsdf => "BSDF",
        Strategy::MisAll => "MIS, both",
        Strategy::Mis => "MIS, one",
    }
}

/// What a strategy does, in a sentence.
pub fn strategy_description(strategy: Strategy) -> &'static str {
    match strategy {
        Strategy::Light => "One direction per camera ray, drawn from the lights.",
        Strategy::Bsdf => "One direction per camera ray, drawn from the BSDF.",
        Strategy::MisAll => "One direction from each technique: two rays per camera ray, weighted and added.",
        Strategy::Mis => "One direction from either technique: lights with probability c, else the BSDF.",
    }
}

/// A heuristic on screen.
pub fn heuristic_name(heuristic: Heuristic) -> &'static str {
    match heuristic {
        Heuristic::Balance => "Balance",
        Heuristic::Power => "Power",
        Heuristic::Cutoff => "Cutoff",
        Heuristic::Maximum => "Maximum",
    }
}

/// One-sample weights on screen.
pub fn weights_name(weights: OneSampleWeights) -> &'static str {
    match weights {
        OneSampleWeights::Veach => "Veach, with c",
        OneSampleWeights::Tutorial => "Tutorial",
    }
}

/// What pictures have alike, on screen.
pub fn equal_name(equal: Lockstep) -> &'static str {
    match equal {
        Lockstep::Spp => "samples",
        Lockstep::Rays => "rays",
        Lockstep::CpuSeconds => "seconds",
    }
}

/// A sampler on screen.
pub fn sampler_name(kind: SamplerKind) -> &'static str {
    match kind {
        SamplerKind::Stratified => "Stratified",
        SamplerKind::Lattice => "Lattice",
        SamplerKind::Sobol => "Sobol",
        SamplerKind::Independent => "Random",
        SamplerKind::PaddedStratified => "Padded strata",
        SamplerKind::PaddedSobol => "Padded Sobol",
    }
}
