//! One light of the built scene.

use glam::Vec3;

use crate::bsdf::BuiltMaterial;
use crate::geometry::shape::{Ball, Facet};

/// Where a light is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightShape {
    /// Sampled over the cone it fills; from inside, over all directions.
    Ball(Ball),
    /// Sampled over its area.
    Facet(Facet),
}

/// A surface that emits, on its outer side.
#[derive(Clone, Copy, Debug)]
pub struct BuiltLight {
    /// The surface.
    pub shape: LightShape,
    /// Emitted radiance.
    pub radiance: Vec3,
    /// What it reflects.
    pub material: BuiltMaterial,
}
