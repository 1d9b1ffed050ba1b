//! The study's window: one point of one pixel, in plain numbers.
//!
//! The renderer's own functions, asked on one lane: [`Inspector::at_pixel`] finds the surface [`Point`] that a camera ray
//! hits; [`Point::direction`] what the estimator sees in one direction there (f, both densities, and by
//! [`Direction::weighted`] the weights of any estimator); [`Point::tabulate`] the same for all directions of all
//! lights, from which [`Table::moments`] has mean and variance of any estimator *exactly*, that is by quadrature
//! instead of sampling, [`Table::best_c`] the c of least variance and [`Table::curve`] all others. [`Point::sketch`] is a
//! rough table in a hundredth of the time, from which [`best_map()`] has the best c of every pixel. [`replay()`] draws one
//! sample of one pixel again, to the bit, [`fireflies()`] finds the brightest outliers of a picture by it, and
//! [`points`] shows the pattern that samples follow.
//!
//! Nothing here is fast lane code, and no lanes show: floats in, floats out. Lengths are in scene units, densities per
//! solid angle (1/sr), colours linear Rec. 709.

mod best;
mod best_map;
mod cell;
mod chart;
mod curves;
mod direction;
mod fireflies;
mod lights;
mod many;
mod moments;
mod node;
mod pattern;
mod point;
mod quadrature;
mod replay;
mod rule;
mod sketch;

mod suspects;
mod table;
mod weights;

pub use best::{AtC, Best, least};
pub use best_map::{BestMap, best_map};
pub use curves::PixelCurve;
pub use direction::{Direction, LightHit};
pub use fireflies::{Fireflies, Outlier, Search, fireflies};
pub use lights::LightSeen;
pub use many::Pixels;
use mislab_kernel::film::LUMINANCE;
use mislab_kernel::lanes::{Single, V3};
pub use mislab_kernel::request::Technique;
pub use mislab_kernel::tile::replay::{Drawn, Ray, Replayed};
pub use moments::{Moments, Sampled};
pub use pattern::points;
pub use point::{Inspector, Point, Seen};
pub use quadrature::Accuracy;
pub use replay::replay;
pub use suspects::{Suspect, suspects_of_frame, suspects_of_layers};
pub use table::Table;
pub use weights::{Weighted, weighted};

/// A vector on one lane as a plain one.
fn plain(v: V3<Single>) -> glam::Vec3 {
    glam::Vec3::new(v.x, v.y, v.z)
}

/// Luminance of a colour, in f64.
fn luminance(c: glam::DVec3) -> f64 {
    glam::DVec3::from_array(LUMINANCE.map(f64::from)).dot(c)
}
