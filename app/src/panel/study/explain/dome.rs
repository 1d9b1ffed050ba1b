//! The directions of a pixel as a disc: what is seen in each, coarse at once, then fine, worked out beside the pictures.

use std::sync::Arc;

use eframe::egui::Context;
use glam::{DVec3, Vec3};
use mislab_renderer::inspect::Direction;

use super::place::{Place, Surface};
use crate::picture::background::{Background, Effort};

/// Directions along a side.
const SIDES: [usize; 2] = [40, 160];

/// A disc of directions: the distance from its middle is the angle from an axis, to scale (azimuthal equidistant).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    axis: DVec3,
    up: DVec3,
    /// The angle at its rim, in radians.
    pub reach: f64,
}

impl Disc {
    /// The whole hemisphere about the normal.
    pub fn hemisphere(surface: &Surface) -> Self {
        Self::about(surface.normal, surface.mirrored, std::f64::consts::FRAC_PI_2)
    }

    /// So far about the mirror direction; the normal lies upwards.
    pub fn peak(surface: &Surface, reach: f64) -> Self {
        Self::about(surface.mirrored, surface.normal, reach)
    }

    fn about(axis: Vec3, towards: Vec3, reach: f64) -> Self {
        let axis = axis.as_dvec3().normalize_or(DVec3::Z);
        let up = towards.as_dvec3() - axis * axis.dot(towards.as_dvec3());
        let up = if up.length() > 1e-6 { up.normalize() } else { axis.any_orthonormal_vector() };
        Self { axis, up, reach }
    }

    /// The direction at a place of the disc, both coordinates from -1 to 1, the second upwards; `None` outside.
    pub fn direction(&self, [x, y]: [f64; 2]) -> Option<Vec3> {
        let radius = x.hypot(y);
        let angle = radius * self.reach;
        let aside = if radius > 0.0 { (self.right() * x + self.up * y) / radius } else { DVec3::ZERO };
        (radius <= 1.0).then(|| (self.axis * angle.cos() + aside * angle.sin()).as_vec3().normalize())
    }

    /// Where a direction is; beyond 1 outside.
    pub fn place(&self, direction: Vec3) -> [f64; 2] {
        let direction = direction.as_dvec3();
        let across = [direction.dot(self.right()), direction.dot(self.up)];
        let sine = across[0].hypot(across[1]);
        let angle = sine.atan2(direction.dot(self.axis));
        if sine > 0.0 { across.map(|v| v / sine * angle / self.reach) } else { [0.0, angle / self.reach] }
    }

    fn right(&self) -> DVec3 {
        self.axis.cross(self.up)
    }
}

/// What is seen in the directions of a disc.
pub struct Dome {
    about: About,
    /// Row by row from the top, in each from the left; `None` outside the disc or below the surface.
    pub seen: Vec<Option<Direction>>,
}

#[derive(Clone)]
struct About {
    place: Place,
    normal: Vec3,
    disc: Disc,
    side: usize,
}

impl PartialEq for About {
    fn eq(&self, other: &Self) -> bool {
        self.place.is_same(&other.place) && (self.disc, self.side) == (other.disc, other.side)
    }
}

impl Dome {
    /// Directions along a side.
    pub fn side(&self) -> usize {
        self.about.side
    }

    /// The disc.
    pub fn disc(&self) -> Disc {
        self.about.disc
    }

    /// Whether nothing finer will come.
    pub fn is_fine(&self) -> bool {
        self.about.side == SIDES[1]
    }

    fn new(about: &About, goes_on: &mut dyn FnMut() -> bool) -> Option<Self> {
        let point = about.place.point()?;
        let mut seen = Vec::with_capacity(about.side * about.side);
        let middle = |i: usize| (2.0 * i as f64 + 1.0) / about.side as f64 - 1.0;
        for row in 0..about.side {
            if !goes_on() {
                return None;
            }
            seen.extend((0..about.side).map(|column| {
                let wi = about.disc.direction([middle(column), -middle(row)])?;
                (wi.dot(about.normal) > 0.0).then(|| point.direction(wi))
            }));
        }
        Some(Self { about: about.clone(), seen })
    }
}

/// Works it out.
pub struct DomeJob(Background<About, Arc<Dome>>);

impl Default for DomeJob {
    fn default() -> Self {
        Self(Background::new("hemisphere"))
    }
}

impl DomeJob {
    /// What is known so far; at least the coarse one. `None` where nothing reflects.
    pub fn of(&mut self, ctx: &Context, place: &Place, normal: Vec3, disc: Disc) -> Option<Arc<Dome>> {
        let mut about = About { place: place.clone(), normal, disc, side: SIDES[0] };
        let same = |dome: &&Arc<Dome>| dome.about.place.is_same(place) && dome.about.disc == disc;
        if let Some(dome) = self.0.known().filter(same) {
            if dome.is_fine() {
                return Some(dome.clone());
            }
            about.side = SIDES[1];
        }
        let found = if about.side == SIDES[0] {
            self.0.at_once(about, |about| Dome::new(about, &mut || true).map(Arc::new))
        } else {
            self.0.of(ctx, about, Effort::Aside, |about, goes_on| Dome::new(about, goes_on).map(Arc::new))
        };
        found.or_else(|| self.0.known().cloned())
    }

    /// Gives up what is being worked out.
    pub fn rest(&mut self) {
        self.0.rest();
    }
}

#[cfg(test)]
mod tests {
    use super::super::place::{Facts, angle};
    use super::super::tables::tests::place;
    use super::*;

    #[test]
    fn places_and_directions_there_and_back() {
        let facts = Facts::of(&place());
        let surface = facts.surface().expect("a plate");
        for disc in [Disc::hemisphere(surface), Disc::peak(surface, 0.1)] {
            for at in [[0.0, 0.0], [0.5, -0.3], [-0.7, 0.6], [0.0, 0.999]] {
                let wi = disc.direction(at).expect("inside");
                let back = disc.place(wi);
                assert!((back[0] - at[0]).abs() < 1e-4 && (back[1] - at[1]).abs() < 1e-4, "{back:?}, {at:?}");
            }
            assert_eq!(disc.direction([0.8, 0.8]), None);
        }
        let disc = Disc::peak(surface, 0.1);
        let rim = disc.direction([1.0, 0.0]).expect("the rim");
        assert!((angle(rim, surface.mirrored) - 0.1).abs() < 1e-6, "angles are to scale");
        assert!(disc.place(surface.normal)[1] > 0.0, "the normal lies upwards");
    }

    /// The middle of a cell is what the library says of that direction.
    #[test]
    fn cells_are_what_is_seen_in_their_middles() {
        let place = place();
        let facts = Facts::of(&place);
        let surface = facts.surface().expect("a plate");
        let about = About { place: place.clone(), normal: surface.normal, disc: Disc::peak(surface, 0.2), side: 20 };
        let dome = Dome::new(&about, &mut || true).expect("wanted");
        let point = place.point().expect("a plate");
        let wi = about.disc.direction([0.25, 0.35]).expect("inside");
        // Column 12 of 20 lies from 0.2 to 0.3, row 6 from 0.3 to 0.4.
        assert_eq!(dome.seen[6 * 20 + 12].expect("above the surface"), point.direction(wi));
        assert_eq!(dome.seen[0], None, "the corner is no direction");
    }
}
