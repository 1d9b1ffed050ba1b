//! What the estimator sees in one direction.

use glam::Vec3;
use mislab_kernel::bsdf;
use mislab_kernel::lanes::{Single, V3, fused};
use mislab_kernel::light::LightShape;
use mislab_kernel::request::Estimator;
use mislab_kernel::world::View;

use super::plain;
use super::point::Point;
use super::weights::{Weighted, weighted};

/// One direction at a [`Point`]: the integrand and both densities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// Unit direction away from the surface.
    pub wi: Vec3,
    /// `f = bsdf(wo, wi) Le V cos`, per channel. Of a mirror's direction: its integral over the Dirac delta.
    pub f: Vec3,
    /// `Le`, per channel: the radiance that the light in front sends back, were nothing else in the way. 0 without one.
    pub radiance: Vec3,
    /// `V`: a light is hit that shines this way, and nothing opaque lies before it.
    pub visible: bool,
    /// `p_L`, density of the light technique, per solid angle; in a mirror's direction 0, since no light sample ever
    /// hits it.
    pub p_light: f32,
    /// `p_B`, density of the BSDF technique, per solid angle. Of a mirror's direction: its probability.
    pub p_bsdf: f32,
    /// True if this is the direction of a mirror, drawn from its Dirac delta ([`Point::mirror`]).
    pub dirac: bool,
    /// The light in front, whichever way it faces.
    pub hit: Option<LightHit>,
}

/// A light that a ray hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightHit {
    /// Its index in the list of lights of the built scene (sphere lights first; each facet of a mesh is a light).
    pub light: usize,
    /// Number of its shape in the scene.
    pub shape: usize,
    /// Distance to its surface.
    pub distance: f32,
}

/// The numbers of a [`Direction`] that quadrature asks for.
#[derive(Clone, Copy)]
pub(super) struct Integrand {
    pub f: Vec3,
    pub p_light: f32,
    pub p_bsdf: f32,
    radiance: Vec3,
    visible: bool,
    distance: f32,
}

impl Point<'_> {
    /// The integrand and both densities in direction `wi`, of length 1. A mirror's delta is left out: no given direction
    /// hits it.
    pub fn direction(&self, wi: Vec3) -> Direction {
        self.describe(wi, self.integrand(wi, false), false)
    }

    /// The one direction of a mirror, with what its Dirac delta is worth. `None` without a mirror.
    pub fn mirror(&self) -> Option<Direction> {
        self.is_mirror().then(|| {
            let wi = self.mirrored();
            self.describe(wi, self.integrand(wi, true), true)
        })
    }

    /// The direction that a mirror in its place would reflect towards the viewer.
    pub fn mirrored(&self) -> Vec3 {
        let (n, wo) = (self.surface.n, self.wo);
        plain(n * (n.dot(wo) * 2.0) - wo)
    }

    fn describe(&self, wi: Vec3, x: Integrand, dirac: bool) -> Direction {
        let Integrand { f, p_light, p_bsdf, radiance, visible, distance } = x;
        let hit = distance.is_finite().then(|| {
            let light = self.light_in_front(wi);
            let shape = match &self.scene.lights.list[light].shape {
                LightShape::Ball(ball) => ball.shape,
                LightShape::Facet(facet) => facet.shape,
            };
            LightHit { light, shape: shape as usize, distance }
        });
        Direction { wi, f, radiance, visible, p_light, p_bsdf, dirac, hit }
    }

    /// Index of the light in front; if there is none, any.
    #[inline(never)]
    pub(super) fn light_in_front(&self, wi: Vec3) -> usize {
        fused(
            #[inline(always)]
            || self.scene.lights.first_hit(Single, self.surface.p, V3::splat(Single, wi), self.scene.epsilon),
        )
        .0 as usize
    }

    /// One secondary ray on one lane, with the estimator's functions.
    #[inline(never)]
    pub(super) fn integrand(&self, wi: Vec3, dirac: bool) -> Integrand {
        fused(
            #[inline(always)]
            || self.follow(wi, dirac),
        )
    }

    #[inline(always)]
    fn follow(&self, wi: Vec3, dirac: bool) -> Integrand {
        let Self { scene, surface, wo, near, .. } = self;
        let w = V3::splat(Single, wi);
        let sight = scene.lights.look(Single, surface.p, w, scene.epsilon, true);
        let value =
            if dirac { bsdf::evaluate_mirror(Single, surface, *wo) } else { bsdf::evaluate(Single, surface, *wo, w) };
        let radiance = if sight.shines { plain(sight.radiance) } else { Vec3::ZERO };
        let view = View { l: Single, scene, culled: near };
        let visible = view.visible(surface, w, sight.t, sight.shines);
        Integrand {
            f: if visible { plain(value.f_cos) * radiance } else { Vec3::ZERO },
            p_light: if dirac { 0.0 } else { sight.pdf },
            p_bsdf: value.pdf,
            radiance,
            visible,
            distance: sight.t,
        }
    }
}

impl Direction {
    /// Weight and contribution of a sample in this direction by either technique, light and BSDF.
    pub fn weighted(&self, estimator: &Estimator) -> [Weighted; 2] {
        weighted(self.f, [self.p_light, self.p_bsdf], estimator)
    }
}
