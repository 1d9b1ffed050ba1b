//! The tree over the primitives of a large scene, and the one walk that answers both questions asked of it.
//!
//! A node has sixteen children. Their boxes lie side by side, so that sixteen lanes test either one
//! ray against all children, or sixteen rays against one child; the same goes for the primitives of a
//! leaf. A packet of rays is walked in two ways:
//!
//! - *together*, as long as many rays that point into the same octant are in the same node. One bound
//!   for the whole packet, sixteen children at a time, says which children are worth a look.
//! - *one by one*, as soon as there are few.
//!
//! **What a ray hits is a matter of that ray alone**, whichever rays share its packet and whichever way
//! it is walked. That holds because it is defined without an order: a ray hits a primitive if it
//! passes the box of the primitive's leaf and then [`FacetLanes::intersect`](super::shape::FacetLanes::intersect) says so; the distance
//! counts as no less than where it enters that box; of equal distances the lower number wins. All box
//! tests are monotone: rounding never lets a ray enter a child earlier than its parent, nor the bound
//! of a packet lie above that of a ray. So no box that is passed over holds a primitive that would
//! have won.

mod build;
mod by_obvhs;
mod clusters;
mod curve;
mod moves;
mod walk;

use super::shape::FACET_NUMBERS;
use crate::lanes::Place;
pub(crate) use build::Binary;
pub(crate) use walk::{near_and_far, reciprocal};

/// Walks through a tree, compiled out of line.
pub(crate) struct Walks;
impl Place for Walks {}

/// Children of a node.
pub(crate) const FAN: usize = 16;

/// Most primitives of a leaf. More make rays one by one faster (a sixth at 16) and packets slower.
const LEAF: usize = 8;

/// So many rays of one octant make a packet. 6 is as good; never to make one costs even diffuse rays a tenth.
const TOGETHER: u32 = 10;

/// So few rays in a node go on one by one.
const ALONE: u32 = 2;

/// Levels of nodes that follow the clusters of the builder. What lies deeper is cut into equal shares, so
/// that a tree has at most [`LEVELS`] levels, whatever its shape.
const CLUSTERED: usize = 10;

/// Most levels of nodes: 16^7 is more than all primitives there can be.
pub(crate) const LEVELS: usize = CLUSTERED + 7;

/// Most children waiting: all but one of each level's, and one.
const STACK: usize = LEVELS * (FAN - 1) + 1;

/// Numbers that a ball's leaf holds: centre and square of the radius.
const BALL_NUMBERS: usize = 4;

/// Half of what a ray's passage through a box is widened by at either end: four roundings.
const WIDER: f32 = 4.0 * f32::EPSILON;

/// What the lowest bits of a child say: it is a node; or a leaf of balls, else of facets, and one less than
/// how many. The other bits are the number of its node or first primitive.
pub(crate) const INNER: u32 = 0x20;
/// See [`INNER`].
const BALLS: u32 = 0x10;
/// How many bits that takes.
pub(crate) const KIND_BITS: u32 = 6;

/// Numbers that a leaf is read from: its own, and what lanes beyond the last primitive fall on.
const WINDOW: usize = LEAF * FACET_NUMBERS + FAN;

/// The only child of the first node (see `child_key` in `walk.rs`): where all walks start.
const ROOT: u64 = 0;

/// Sixteen children.
#[derive(Clone)]
#[repr(C, align(64))]
pub(crate) struct Node {
    /// Least x, y, z and largest x, y, z of each child's box; empty where there is no child.
    pub(crate) planes: [[f32; FAN]; 6],
    /// See [`INNER`].
    pub(crate) child: [u32; FAN],
}

impl Node {
    const EMPTY: Self = Self {
        planes: [
            [f32::INFINITY; FAN],
            [f32::INFINITY; FAN],
            [f32::INFINITY; FAN],
            [f32::NEG_INFINITY; FAN],
            [f32::NEG_INFINITY; FAN],
            [f32::NEG_INFINITY; FAN],
        ],
        child: [0; FAN],
    };
}

/// A tree over facets and balls, in whose order it has put them.
pub struct Tree {
    nodes: Vec<Node>,
    /// [`Facet::numbers`](super::shape::Facet::numbers) of each leaf: all first ones, all second ones, ...
    facets: Vec<f32>,
    /// The same for balls.
    balls: Vec<f32>,
    /// Number of facets: balls are numbered after them.
    first_ball: u32,
}
