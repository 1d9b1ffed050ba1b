//! What a slice shows over the angle: the integrand, the densities, and what samples are worth.

use mislab_renderer::inspect::Direction;
use mislab_renderer::{Estimator, Strategy};

use super::place::luminance;

/// A curve of the slice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Curve {
    /// The integrand.
    F,
    /// Density of the light technique.
    PLight,
    /// Density of the BSDF technique.
    PBsdf,
    /// The density of both together, as the strategy draws.
    Mixture,
    /// What a light sample in that direction is worth.
    ByLight,
    /// What a BSDF sample in that direction is worth.
    ByBsdf,
}

impl Curve {
    /// All of them, in the order of the legend.
    pub const ALL: [Self; 6] = [Self::F, Self::PLight, Self::PBsdf, Self::Mixture, Self::ByLight, Self::ByBsdf];

    /// In the legend.
    pub fn name(self, estimator: &Estimator) -> String {
        let c = estimator.light_prob;
        match self {
            Self::F => "f".to_owned(),
            Self::PLight => "p_L".to_owned(),
            Self::PBsdf => "p_B".to_owned(),
            Self::Mixture => match estimator.strategy {
                Strategy::Light => "drawn: p_L".to_owned(),
                Strategy::Bsdf => "drawn: p_B".to_owned(),
                Strategy::MisAll => "p_L + p_B".to_owned(),
                Strategy::Mis => format!("{c:.2} p_L + {:.2} p_B", 1.0 - c),
            },
            Self::ByLight => "f / d of a light sample".to_owned(),
            Self::ByBsdf => "f / d of a BSDF sample".to_owned(),
        }
    }

    /// What it is.
    pub fn hint(self) -> &'static str {
        match self {
            Self::F => "f = bsdf \u{d7} L_e \u{d7} visible \u{d7} cos: what is integrated, as luminance per steradian.",
            Self::PLight => {
                "Density of the light technique over all lights, per steradian. The same for every strategy."
            }
            Self::PBsdf => "Density of the BSDF technique, per steradian: the lobe.",
            Self::Mixture => {
                "How many samples the strategy draws there, per steradian and sample: both techniques together."
            }
            Self::ByLight => {
                "w_L f / (c p_L): what a light sample in that direction adds. With the balance heuristic it is \
                              f over the mixture, whichever technique drew it."
            }
            Self::ByBsdf => "w_B f / (c p_B): what a BSDF sample in that direction adds.",
        }
    }

    /// The number at a direction.
    pub fn value(self, seen: &Direction, estimator: &Estimator) -> f64 {
        let p = [seen.p_light, seen.p_bsdf].map(f64::from);
        let c = f64::from(estimator.light_prob);
        match self {
            Self::F => luminance(seen.f),
            Self::PLight => p[0],
            Self::PBsdf => p[1],
            Self::Mixture => match estimator.strategy {
                Strategy::Light => p[0],
                Strategy::Bsdf => p[1],
                Strategy::MisAll => p[0] + p[1],
                Strategy::Mis => c * p[0] + (1.0 - c) * p[1],
            },
            Self::ByLight => luminance(seen.weighted(estimator)[0].value),
            Self::ByBsdf => luminance(seen.weighted(estimator)[1].value),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::circle::{Circle, Sight, along};
    use super::super::place::Facts;
    use super::super::tables::tests::place;
    use super::*;

    /// The curves are what the library says, and with the balance heuristic a sample is worth f over the mixture.
    #[test]
    fn with_the_balance_heuristic_a_sample_is_worth_f_over_the_mixture() {
        let place = place();
        let facts = Facts::of(&place);
        let surface = facts.surface().expect("a plate");
        let light = surface.highlight().expect("lights");
        let circle = Circle::new(surface, light.centre, 0.0);
        let point = place.point().expect("a plate");
        let sights = along(&point, &circle, [-0.2, 0.2], 201, &[]);
        let mut lit = 0;
        for strategy in [Strategy::MisAll, Strategy::Mis] {
            let estimator = Estimator { strategy, light_prob: 0.3, ..Estimator::default() };
            for Sight { seen, .. } in &sights {
                let of = |curve: Curve| curve.value(seen, &estimator);
                assert_eq!([of(Curve::PLight), of(Curve::PBsdf)], [seen.p_light, seen.p_bsdf].map(f64::from));
                if of(Curve::F) > 0.0 {
                    lit += 1;
                    let expected = of(Curve::F) / of(Curve::Mixture);
                    for by in [Curve::ByLight, Curve::ByBsdf] {
                        assert!((of(by) - expected).abs() < 1e-5 * expected, "{strategy:?}, {by:?}");
                    }
                }
            }
        }
        assert!(lit > 20, "the light is on the circle");
    }
}
