//! One direction as quadrature sees it.

use glam::Vec3;

use super::luminance;

/// One direction: what quadrature takes its surroundings to be.
#[derive(Clone, Copy)]
pub(super) struct Node {
    /// Solid angle that it stands for; of a mirror's direction 1.
    pub dw: f64,
    /// Luminance of f.
    pub y: f64,
    /// f per channel.
    pub f: Vec3,
    /// Densities p_L and p_B; of a mirror's direction 0 and a probability.
    pub p: [f32; 2],
}

impl Node {
    /// Nothing comes from there.
    pub const DARK: Self = Self { dw: 0.0, y: 0.0, f: Vec3::ZERO, p: [0.0; 2] };

    /// With its luminance.
    pub fn new(dw: f64, f: Vec3, p_light: f32, p_bsdf: f32) -> Self {
        Self { dw, y: luminance(f.as_dvec3()), f, p: [p_light, p_bsdf] }
    }

    /// Logarithm of p_L / p_B.
    pub fn odds(&self) -> f64 {
        (f64::from(self.p[0]) / f64::from(self.p[1])).ln()
    }
}
