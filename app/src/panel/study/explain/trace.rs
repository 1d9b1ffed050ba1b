//! What is seen along a part of a great circle: coarse at once, then fine, worked out beside the pictures.

use std::sync::Arc;

use super::circle::{Circle, Sight, along};
use super::place::Place;
use crate::picture::background::{Background, Effort};
use eframe::egui::Context;

/// Angles asked about.
const COUNTS: [usize; 2] = [96, 768];

/// A part of a circle.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The circle.
    pub circle: Circle,
    /// From where to where, in radians.
    pub range: [f64; 2],
    /// Where something may jump.
    pub edges: Vec<f64>,
}

/// What was seen along it.
pub struct Trace {
    about: About,
    /// From one end to the other.
    pub sights: Vec<Sight>,
}

#[derive(Clone)]
struct About {
    place: Place,
    part: Part,
    count: usize,
}

impl About {
    fn is_same_part(&self, other: &Self) -> bool {
        self.place.is_same(&other.place) && self.part == other.part
    }
}

impl PartialEq for About {
    fn eq(&self, other: &Self) -> bool {
        self.is_same_part(other) && self.count == other.count
    }
}

impl Trace {
    /// Whether nothing finer will come.
    pub fn is_fine(&self) -> bool {
        self.about.count == COUNTS[1]
    }
}

/// Works it out.
pub struct TraceJob(Background<About, Arc<Trace>>);

impl Default for TraceJob {
    fn default() -> Self {
        Self(Background::new("slice"))
    }
}

impl TraceJob {
    /// What is known of it so far; at least the coarse one, which takes no time. `None` where nothing reflects.
    pub fn of(&mut self, ctx: &Context, place: &Place, part: Part) -> Option<Arc<Trace>> {
        let mut about = About { place: place.clone(), part, count: COUNTS[0] };
        let known = self.0.known().filter(|trace| trace.about.is_same_part(&about)).cloned();
        if let Some(trace) = known {
            if trace.is_fine() {
                return Some(trace);
            }
            about.count = COUNTS[1];
        }
        let look = |about: &About| {
            let Part { circle, range, edges } = &about.part;
            let sights = along(&about.place.point()?, circle, *range, about.count, edges);
            Some(Arc::new(Trace { about: about.clone(), sights }))
        };
        let found = if about.count == COUNTS[0] {
            self.0.at_once(about, look)
        } else {
            self.0.of(ctx, about, Effort::Aside, move |about, goes_on| if goes_on() { look(about) } else { None })
        };
        found.or_else(|| self.0.known().cloned())
    }

    /// Gives up what is being worked out.
    pub fn rest(&mut self) {
        self.0.rest();
    }
}
