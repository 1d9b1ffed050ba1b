//! The lights as they are seen from a point.

use std::collections::BTreeMap;

use glam::DVec3;
use mislab_kernel::light::LightShape;

use super::chart::Chart;
use super::direction::Direction;
use super::point::Point;
use super::table::Table;

/// A light as it is seen from a [`Point`], with all of its facets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSeen {
    /// Number of its shape in the scene.
    pub shape: usize,
    /// The direction towards its middle: of a mesh, towards that of the facet that fills the largest solid angle.
    pub middle: Direction,
    /// Solid angle that it fills, in sr, whatever lies before it; 0 where it turns its back.
    pub solid_angle: f64,
    /// Luminance of the reflected radiance that comes from it.
    pub luminance: f64,
}

impl Point<'_> {
    /// All lights that are on, in the order of the scene; `table` is this point's.
    pub fn lights(&self, table: &Table) -> Vec<LightSeen> {
        let mut facets: BTreeMap<usize, Vec<(f64, DVec3, f64)>> = BTreeMap::new();
        let p = self.position();
        for (light, luminance) in self.scene.lights.list.iter().zip(table.by_light()) {
            let (shape, middle) = match &light.shape {
                LightShape::Ball(ball) => (ball.shape, ball.center.as_dvec3()),
                LightShape::Facet(facet) => {
                    let share = if facet.quad { 0.5 } else { 1.0 / 3.0 };
                    (facet.shape, (facet.p0 + (facet.e1 + facet.e2) * share).as_dvec3())
                }
            };
            let solid_angle = Chart::new(light, p).map_or(0.0, |chart| chart.solid_angle());
            facets.entry(shape as usize).or_default().push((solid_angle, middle, *luminance));
        }
        let seen = facets.into_iter().filter_map(|(shape, facets)| {
            let (_, middle, _) = facets.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
            let wi = (*middle - p.as_dvec3()).try_normalize().unwrap_or(DVec3::Z).as_vec3();
            Some(LightSeen {
                shape,
                middle: self.direction(wi),
                solid_angle: facets.iter().map(|facet| facet.0).sum(),
                luminance: facets.iter().map(|facet| facet.2).sum(),
            })
        });
        seen.collect()
    }
}
