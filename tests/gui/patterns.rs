//! The samplers whose one number is for all choices, in the window.

use std::num::NonZeroU32;

use mislab::state::edit::{Edit, SppTarget};
use mislab_renderer::{SamplerKind, SamplerSettings};

use crate::lab::Lab;

#[test]
fn lattices_are_chosen_like_other_samplers() {
    let mut lab = Lab::new();
    for (label, kind, strata) in [
        ("Sampler: Lattice", SamplerKind::Lattice, false),
        ("Sampler: Padded strata", SamplerKind::PaddedStratified, true),
        ("Sampler: Stratified", SamplerKind::Stratified, true),
        ("Sampler: Lattice", SamplerKind::Lattice, false),
    ] {
        lab.click(label);
        let sampler = lab.document().sampling().sampler;
        assert_eq!(sampler.kind, kind, "{label}");
        // The box does nothing where there are no strata.
        lab.click("jitter");
        assert_eq!(lab.document().sampling().sampler.jitter, sampler.jitter != strata, "{label}");
        if strata {
            lab.click("jitter");
        }
    }
}

/// A lattice of strata has as many of them as the picture has samples.
#[test]
fn strata_of_a_lattice_follow_the_number_of_samples() {
    let mut lab = Lab::new();
    lab.click("Sampler: Stratified");
    lab.apply(Edit::SetSpp(SppTarget::Passes(NonZeroU32::new(256).expect("not zero"))));
    assert_eq!(lab.document().sampling().sampler.strata, SamplerSettings::strata_for(256));
}
