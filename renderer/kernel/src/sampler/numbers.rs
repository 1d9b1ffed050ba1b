//! The random numbers of one sample, and choices made by them.

use super::dimension::Dimension;
use super::unit::BELOW_ONE;
use crate::lanes::{Lanes, Mask, Real, Uint};

/// The random numbers of one sample, by dimension.
///
/// Where they are *nested*, one number u chooses in turn the technique, the light or the lobe, and what each choice leaves
/// of it is the first number of the direction: a choice cuts the unit interval in parts, and where u lies in its
/// part is uniform again (Shirley, Wang and Zimmerman 1996). So a pattern that fills the unit square evenly gives every
/// technique, light and lobe an even share of itself. Elsewhere a choice has a dimension of its own.
#[derive(Clone, Copy)]
pub struct Numbers<L: Lanes> {
    by_dimension: [[L::F; 2]; Dimension::ALL.len()],
    nested: bool,
}

impl<L: Lanes> Numbers<L> {
    /// Nothing but zeros.
    #[inline(always)]
    pub(super) fn nothing(l: L, nested: bool) -> Self {
        Self { by_dimension: [[l.f(0.0); 2]; Dimension::ALL.len()], nested }
    }

    /// One number in [0, 1).
    #[inline(always)]
    pub fn get_1d(&self, dimension: Dimension) -> L::F {
        let dimension = match dimension {
            Dimension::LightChoice if self.nested => Dimension::Light,
            Dimension::Lobe if self.nested => Dimension::Bsdf,
            own => own,
        };
        self.by_dimension[dimension as usize][0]
    }

    /// A point in the unit square [0, 1)^2.
    #[inline(always)]
    pub fn get_2d(&self, dimension: Dimension) -> [L::F; 2] {
        self.by_dimension[dimension as usize]
    }

    /// Puts the numbers of a dimension.
    #[inline(always)]
    pub(super) fn set(&mut self, dimension: Dimension, numbers: [L::F; 2]) {
        self.by_dimension[dimension as usize] = numbers;
    }

    /// Puts the one number of a dimension.
    #[inline(always)]
    pub(super) fn set_1d(&mut self, dimension: Dimension, number: L::F) {
        self.by_dimension[dimension as usize][0] = number;
    }

    /// Puts the number that says which technique.
    #[inline(always)]
    pub fn set_technique(&mut self, number: L::F) {
        self.set_1d(Dimension::Technique, number);
    }

    /// What is left once the technique is chosen: light where its number is less than c, `by_light`.
    #[inline(always)]
    #[must_use]
    pub fn after_technique(mut self, l: L, by_light: L::M, c: f32) -> Self {
        if self.nested {
            let [u, v] = self.get_2d(Dimension::Technique);
            let rest = [rest_of_two(l, u, by_light, c), v];
            self.set(Dimension::Light, rest);
            self.set(Dimension::Bsdf, rest);
        }
        self
    }

    /// One of n lights, each with probability 1 / n, and the two numbers for a direction towards it.
    #[inline(always)]
    pub fn choose_light(&self, l: L, n: usize) -> (L::U, [L::F; 2]) {
        let z = self.get_1d(Dimension::LightChoice) * n as f32;
        let (drawn, last) = (z.to_uint(), l.u(n as u32 - 1));
        // Rounding may make z = n.
        let light = drawn.lt(last).select_u(drawn, last);
        let [mut u, v] = self.get_2d(Dimension::Light);
        if self.nested {
            u = (z - light.to_real()).min(l.f(BELOW_ONE));
        }
        (light, [u, v])
    }

    /// The specular one of two lobes, with probability `specular_prob`, where true; and the two numbers for a direction in
    /// the lobe.
    #[inline(always)]
    pub fn choose_lobe(&self, l: L, specular_prob: f32) -> (L::M, [L::F; 2]) {
        let number = self.get_1d(Dimension::Lobe);
        let from_specular = number.lt(l.f(specular_prob));
        let [mut u, v] = self.get_2d(Dimension::Bsdf);
        if self.nested {
            u = rest_of_two(l, u, from_specular, specular_prob);
        }
        (from_specular, [u, v])
    }
}

/// Where u lies in its part of the unit interval, cut in two at p, in [0, 1): `u / p` in the `first` part,
/// `(u - p) / (1 - p)` in the other one. A part of length 0 has no u.
#[inline(always)]
fn rest_of_two<L: Lanes>(l: L, u: L::F, first: L::M, p: f32) -> L::F {
    let start = first.select(l.f(0.0), l.f(p));
    let scales = (1.0 / p.max(f32::MIN_POSITIVE), 1.0 / (1.0 - p).max(f32::MIN_POSITIVE));
    let scale = first.select(l.f(scales.0), l.f(scales.1));
    ((u - start) * scale).min(l.f(BELOW_ONE))
}
