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
//! **What a ray meets is a matter of that ray alone**, whichever rays share its packet and whichever way
//! it is walked. That holds because it is defined without an order: a ray meets a primitive if it
//! passes the box of the primitive's leaf and then [`FacetLanes::intersect`] says so; the distance
//! counts as no less than where it enters that box; of equal distances the lower number wins. All box
//! tests are monotone: rounding never lets a ray enter a child earlier than its parent, nor the bound
//! of a packet lie above that of a ray. So no box that is passed over holds a primitive that would
//! have won.

use std::cell::Cell;

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

use crate::geometry::Nearest;
use crate::lanes::{Lanes, Mask, Real, Uint, V3};
use crate::shape::{Ball, BallLanes, FACET_NUMBERS, Facet, FacetLanes};

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

/// The only child of the first node (see [`child_key`]): where all walks start.
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
    /// [`Facet::numbers`] of each leaf: all first ones, all second ones, ...
    facets: Vec<f32>,
    /// The same for balls.
    balls: Vec<f32>,
    /// Number of facets: balls are numbered after them.
    first_ball: u32,
}

// ---------------------------------------------------------------------------------------------
// Building

/// Primitives that are to become a child.
#[derive(Clone, Copy)]
struct Part {
    /// Where they are in the order of the binary tree.
    first: usize,
    count: usize,
    /// Node of the binary tree; `None` where that is not followed.
    node: Option<u32>,
    bounds: Aabb,
}

/// The binary tree that the tree is made from.
pub(crate) struct Binary<'a> {
    tree: Bvh2,
    boxes: &'a [Aabb],
    /// Most primitives of a leaf.
    leaf: usize,
    /// Primitives in the order of the leaves.
    order: Vec<u32>,
    /// First primitive and number of primitives of each node.
    ranges: Vec<[u32; 2]>,
    /// How many balls are among the first primitives.
    balls_before: Vec<u32>,
    /// Nodes with children, each after both of its children.
    upwards: Vec<u32>,
}

/// How the nodes of a [`Binary`] tree are best gathered into nodes of sixteen children.
///
/// Rays that enter a node look at all of its children with one instruction. So what a tree costs is the sum of the surface
/// areas of nodes and leaves, each of which is how likely a ray enters it. The least sum there can be is found from the
/// leaves upwards (Ylitie, Karras and Laine 2017, "Efficient incoherent ray traversal on GPUs through compressed wide
/// BVHs", section 3.1): what a binary node costs if it may take up to j children of the wide node above it, for each j. To
/// cut the largest child again and again instead fills half as many children, and makes twice as many nodes.
struct Gathering {
    /// Index into `shares` of each node of the binary tree; [`WHOLE`] for those that are one child, whatever room there is.
    rows: Vec<u32>,
    /// How many of j + 1 children go to the first of the two nodes below; 0: the node is one child as a whole. In
    /// the place of j = 0: how many if it becomes a node of its own, with all of its [`FAN`] children.
    shares: Vec<[u8; FAN - 1]>,
}

/// See [`Gathering`].
const WHOLE: u32 = u32::MAX;

impl<'a> Binary<'a> {
    /// Over boxes, at least one; those from `first_ball` on are not mixed with others in a leaf.
    pub(crate) fn new(boxes: &'a [Aabb], first_ball: usize, leaf: usize) -> Self {
        let indices = (0..boxes.len() as u32).collect();
        let mut tree = PlocBuilder::with_capacity(boxes.len()).build(
            PlocSearchDistance::High,
            boxes,
            indices,
            SortPrecision::U64,
            0,
        );
        ReinsertionOptimizer::default().run(&mut tree, 0.05, None);
        let mut order = Vec::with_capacity(boxes.len());
        let mut ranges = vec![[0; 2]; tree.nodes.len()];
        let mut upwards = Vec::with_capacity(tree.nodes.len() / 2);
        // Down on the way in, up on the way out: a node is there twice, the second time marked.
        const OUT: u32 = 1 << 31;
        let mut stack = vec![0];
        while let Some(at) = stack.pop() {
            let id = (at & !OUT) as usize;
            let node = tree.nodes[id];
            if at & OUT != 0 {
                ranges[id][1] = order.len() as u32 - ranges[id][0];
                upwards.push(id as u32);
                continue;
            }
            ranges[id] = [order.len() as u32, node.prim_count];
            if node.prim_count > 0 {
                let first = node.first_index as usize;
                order.extend_from_slice(&tree.primitive_indices[first..first + node.prim_count as usize]);
            } else {
                stack.extend([at | OUT, node.first_index + 1, node.first_index]);
            }
        }
        let mut balls_before = Vec::with_capacity(order.len() + 1);
        let mut balls = 0;
        for &id in &order {
            balls_before.push(balls);
            balls += u32::from(id as usize >= first_ball);
        }
        balls_before.push(balls);
        Self { tree, boxes, leaf, order, ranges, balls_before, upwards }
    }

    fn part(&self, node: u32) -> Part {
        let [first, count] = self.ranges[node as usize].map(|v| v as usize);
        Part { first, count, node: Some(node), bounds: self.tree.nodes[node as usize].aabb }
    }

    /// `None` if there are facets and balls.
    fn are_balls(&self, part: &Part) -> Option<bool> {
        let balls = self.balls_before[part.first + part.count] - self.balls_before[part.first];
        if balls == 0 {
            Some(false)
        } else if balls as usize == part.count {
            Some(true)
        } else {
            None
        }
    }

    fn may_be_leaf(&self, part: &Part) -> bool {
        part.count <= self.leaf && self.are_balls(part).is_some()
    }

    /// The two nodes below one that has any.
    fn below(&self, node: u32) -> [u32; 2] {
        let first = self.tree.nodes[node as usize].first_index;
        [first, first + 1]
    }

    /// The best way to gather the nodes.
    fn gather(&self) -> Gathering {
        let mut rows = vec![WHOLE; self.tree.nodes.len()];
        let (mut shares, mut costs) = (Vec::new(), Vec::<[f32; FAN - 1]>::new());
        for &node in &self.upwards {
            let part = self.part(node);
            if self.may_be_leaf(&part) {
                continue;
            }
            let below = self.below(node).map(|node| match rows[node as usize] {
                WHOLE => [self.part(node).bounds.half_area(); FAN - 1],
                row => costs[row as usize],
            });
            // The cheapest of sharing `room` children. More room never costs more, so all of it is given away.
            let cheapest = |room: usize| {
                let mut best = (f32::INFINITY, room / 2);
                for share in 1..room {
                    let cost = below[0][share - 1] + below[1][room - share - 1];
                    if cost < best.0 {
                        best = (cost, share);
                    }
                }
                best
            };
            let (open, share) = cheapest(FAN);
            let whole = part.bounds.half_area() + open;
            let (mut cost, mut best) = ([whole; FAN - 1], [0; FAN - 1]);
            best[0] = share as u8;
            for room in 2..FAN {
                let (shared, share) = cheapest(room);
                if shared < whole {
                    cost[room - 1] = shared;
                    best[room - 1] = share as u8;
                }
            }
            rows[node as usize] = shares.len() as u32;
            shares.push(best);
            costs.push(cost);
        }
        Gathering { rows, shares }
    }

    /// The children of a part: those that are best if the binary tree is followed, else equal shares.
    fn children(&self, part: Part, gathering: &Gathering) -> Vec<Part> {
        if self.may_be_leaf(&part) {
            return vec![part];
        }
        if let Some(node) = part.node
            && let row = gathering.rows[node as usize]
            && row != WHOLE
        {
            let mut children = Vec::with_capacity(FAN);
            let share = usize::from(gathering.shares[row as usize][0]);
            let [a, b] = self.below(node);
            let mut todo = vec![(b, FAN - share), (a, share)];
            while let Some((node, room)) = todo.pop() {
                let row = gathering.rows[node as usize];
                let share = match row {
                    _ if room == 1 => 0,
                    WHOLE => 0,
                    row => usize::from(gathering.shares[row as usize][room - 1]),
                };
                if share == 0 {
                    children.push(self.part(node));
                } else {
                    let [a, b] = self.below(node);
                    todo.extend([(b, room - share), (a, share)]);
                }
            }
            return children;
        }
        // Facets and balls are told apart one by one: few are ever left to this.
        let least = if self.are_balls(&part).is_some() { part.count.div_ceil(self.leaf) } else { part.count };
        let n = least.clamp(2, FAN);
        let ends = (0..=n).map(|i| part.first + part.count * i / n);
        ends.clone()
            .zip(ends.skip(1))
            .map(|(first, end)| {
                let boxes = self.order[first..end].iter().map(|&id| self.boxes[id as usize]);
                let bounds = boxes.fold(Aabb::empty(), |all, one| all.union(&one));
                Part { first, count: end - first, node: None, bounds }
            })
            .collect()
    }

    /// The nodes of sixteen children, the second one on top of all; the first one has that as its only child. `leaf` makes
    /// a child of primitives, by their numbers, that are balls or not.
    pub(crate) fn collapse(&self, mut leaf: impl FnMut(bool, &[u32]) -> u32) -> Vec<Node> {
        let mut nodes = vec![Node::EMPTY, Node::EMPTY];
        nodes[0].child[0] = 1 << KIND_BITS | INNER;
        for axis in 0..3 {
            nodes[0].planes[axis][0] = f32::NEG_INFINITY;
            nodes[0].planes[axis + 3][0] = f32::INFINITY;
        }
        let gathering = self.gather();
        let mut todo = vec![(1, self.part(0), 1)];
        while let Some((at, part, level)) = todo.pop() {
            let follow = level < CLUSTERED;
            let part = Part { node: part.node.filter(|_| follow), ..part };
            let children = self.children(part, &gathering);
            let first_inner = todo.len();
            for (i, child) in children.iter().enumerate() {
                let [min, max] = padded(&child.bounds);
                for axis in 0..3 {
                    nodes[at].planes[axis][i] = min[axis];
                    nodes[at].planes[axis + 3][i] = max[axis];
                }
                match self.are_balls(child).filter(|_| child.count <= self.leaf) {
                    None => {
                        nodes[at].child[i] = (nodes.len() as u32) << KIND_BITS | INNER;
                        todo.push((nodes.len(), *child, level + 1));
                        nodes.push(Node::EMPTY);
                    }
                    Some(balls) => {
                        let ids = &self.order[child.first..child.first + child.count];
                        nodes[at].child[i] = leaf(balls, ids);
                    }
                }
            }
            // The first one next: neighbours in space are neighbours in memory.
            todo[first_inner..].reverse();
        }
        nodes
    }
}

/// Box around a facet.
pub(crate) fn facet_box(facet: &Facet) -> Aabb {
    facet.corners().fold(Aabb::empty(), |mut bounds, p| {
        bounds.extend(p.into());
        bounds
    })
}

/// Box around a ball.
pub(crate) fn ball_box(ball: &Ball) -> Aabb {
    Aabb::new(Vec3A::from(ball.center) - ball.radius, Vec3A::from(ball.center) + ball.radius)
}

/// The corners of a box, moved apart by two roundings of its largest coordinate: hits are computed, too. Boxes
/// within boxes stay so.
fn padded(bounds: &Aabb) -> [Vec3; 2] {
    let (min, max) = (Vec3::from(bounds.min), Vec3::from(bounds.max));
    let pad = 2.0 * f32::EPSILON * min.abs().max(max.abs()).max_element();
    [min - pad, max + pad]
}

impl Tree {
    /// Builds the tree and puts the primitives, at least one, into its order.
    pub fn new(facets: &mut Vec<Facet>, balls: &mut Vec<Ball>) -> Self {
        let boxes: Vec<Aabb> = facets.iter().map(facet_box).chain(balls.iter().map(ball_box)).collect();
        let binary = Binary::new(&boxes, facets.len(), LEAF);
        let (mut facet_numbers, mut ball_numbers) = (Vec::new(), Vec::new());
        facet_numbers.reserve_exact(facets.len() * FACET_NUMBERS + WINDOW);
        ball_numbers.reserve_exact(balls.len() * BALL_NUMBERS + WINDOW);
        let (mut facet_order, mut ball_order) = (Vec::new(), Vec::new());
        let nodes = binary.collapse(|are_balls, ids| {
            let kind = (ids.len() - 1) as u32;
            if are_balls {
                let first = ball_order.len();
                ball_order.extend(ids.iter().map(|&id| balls[id as usize - facets.len()]));
                let leaf: &[Ball] = &ball_order[first..];
                for axis in 0..3 {
                    ball_numbers.extend(leaf.iter().map(|b| b.center[axis]));
                }
                ball_numbers.extend(leaf.iter().map(|b| b.radius * b.radius));
                (first as u32) << KIND_BITS | BALLS | kind
            } else {
                let first = facet_order.len();
                facet_order.extend(ids.iter().map(|&id| facets[id as usize]));
                let leaf: &[Facet] = &facet_order[first..];
                for number in 0..FACET_NUMBERS {
                    facet_numbers.extend(leaf.iter().map(|f| f.numbers()[number]));
                }
                (first as u32) << KIND_BITS | kind
            }
        });
        // Lanes read beyond the last leaf.
        facet_numbers.extend([0.0; WINDOW]);
        ball_numbers.extend([0.0; WINDOW]);
        let first_ball = facets.len() as u32;
        *facets = facet_order;
        *balls = ball_order;
        Self { nodes, facets: facet_numbers, balls: ball_numbers, first_ball }
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }
}

// ---------------------------------------------------------------------------------------------
// Walking

/// Rays, and what they have met so far.
struct Rays<L: Lanes> {
    origin: V3<L>,
    dir: V3<L>,
    inverse: V3<L>,
    best: Nearest<L>,
    /// The same numbers, for walking one by one: origin, direction, inverse.
    numbers: [[f32; FAN]; 9],
}

/// One ray, in all lanes.
struct Ray<L: Lanes> {
    origin: V3<L>,
    dir: V3<L>,
    inverse: V3<L>,
}

/// A number for each child, in one line of the cache: what lanes write there is read back soon.
#[repr(align(64))]
struct Row([f32; FAN]);

/// Children waiting to be looked at, the last one first.
struct Waiting {
    /// Those of a packet: see [`child_key`], of where the first of its rays enters.
    together: [u64; STACK],
    /// Which of its rays.
    lanes: [u32; STACK],
    /// Those of a ray by itself: see [`entry_key`].
    alone: [u64; STACK],
}

impl Default for Waiting {
    fn default() -> Self {
        Self { together: [0; STACK], lanes: [0; STACK], alone: [0; STACK] }
    }
}

thread_local! {
    /// Kept from packet to packet: to clear it would take as long as a ray.
    static WAITING: Cell<Option<Box<Waiting>>> = const { Cell::new(None) };
}

/// Child `i` of a node, and where it is entered (the larger, the farther).
#[inline(always)]
fn child_key(node: usize, i: usize, enters: f32) -> u64 {
    u64::from(enters.to_bits()) << 32 | (node * FAN + i) as u64
}

/// The inverse of [`child_key`].
#[inline(always)]
fn child_of_key(key: u64) -> (usize, usize, f32) {
    let child = key as u32 as usize;
    (child / FAN, child % FAN, f32::from_bits((key >> 32) as u32))
}

/// A child, as [`Node::child`] has it, and where it is entered. A ray by itself needs no more, and what it needs next
/// does not wait for the node above to be read once more: a tenth faster.
#[inline(always)]
fn entry_key(child: u32, enters: f32) -> u64 {
    u64::from(enters.to_bits()) << 32 | u64::from(child)
}

/// The inverse of [`entry_key`].
#[inline(always)]
fn child_of_entry_key(key: u64) -> (u32, f32) {
    (key as u32, f32::from_bits((key >> 32) as u32))
}

/// `1 / d`, with zeros moved off zero so that no test multiplies zero by infinity.
#[inline(always)]
pub(crate) fn reciprocal<L: Lanes>(l: L, d: V3<L>) -> V3<L> {
    let tiny = l.f(1e-20);
    let one = l.f(1.0);
    V3 {
        x: one / d.x.abs().lt(tiny).select(tiny, d.x),
        y: one / d.y.abs().lt(tiny).select(tiny, d.y),
        z: one / d.z.abs().lt(tiny).select(tiny, d.z),
    }
}

/// Where rays enter and leave a box, widened, from the distances along the three axes.
#[inline(always)]
fn passage<L: Lanes>(l: L, near: V3<L>, far: V3<L>) -> (L::F, L::F) {
    let enter = near.x.max(near.y).max(near.z.max(l.f(0.0)));
    let leave = far.x.min(far.y).min(far.z);
    (enter * (1.0 - WIDER), leave * (1.0 + WIDER))
}

impl Tree {
    /// What each ray meets first, nearer than `t_max` or just there; with `ANY` the distance becomes
    /// minus infinity where anything nearer than `t_max` is met. Rays with a negative `t_max` meet nothing.
    #[inline(always)]
    pub fn walk<L: Lanes, const ANY: bool>(&self, l: L, origin: V3<L>, dir: V3<L>, t_max: L::F) -> Nearest<L> {
        let inverse = reciprocal(l, dir);
        let mut numbers = [[0.0; FAN]; 9];
        let [a, b, c, d, e, f, g, h, i] = &mut numbers;
        origin.x.store(a);
        origin.y.store(b);
        origin.z.store(c);
        dir.x.store(d);
        dir.y.store(e);
        dir.z.store(f);
        inverse.x.store(g);
        inverse.y.store(h);
        inverse.z.store(i);
        let mut rays = Rays { origin, dir, inverse, best: Nearest { t: t_max, id: l.u(0) }, numbers };
        let mut waiting = WAITING.take().unwrap_or_default();
        let zero = l.f(0.0);
        let negative = [inverse.x.lt(zero).bits(), inverse.y.lt(zero).bits(), inverse.z.lt(zero).bits()];
        let mut todo = t_max.ge(zero).bits();
        let mut alone = 0;
        while todo != 0 {
            let first = todo.trailing_zeros();
            let mut octant = todo;
            let mut signs = [false; 3];
            for axis in 0..3 {
                signs[axis] = negative[axis] >> first & 1 == 1;
                octant &= if signs[axis] { negative[axis] } else { !negative[axis] };
            }
            todo &= !octant;
            if octant.count_ones() >= TOGETHER {
                self.walk_together::<L, ANY>(l, &mut rays, signs, octant, &mut waiting);
            } else {
                alone |= octant;
            }
        }
        self.walk_alone::<L, ANY>(l, &mut rays, alone, (self.nodes[0].child[0], &[0.0; FAN]), &mut waiting.alone);
        WAITING.set(Some(waiting));
        rays.best
    }

    /// Walks the rays of `lanes`, which point into the octant of these `signs`.
    #[inline(always)]
    fn walk_together<L: Lanes, const ANY: bool>(
        &self,
        l: L,
        rays: &mut Rays<L>,
        signs: [bool; 3],
        lanes: u32,
        waiting: &mut Waiting,
    ) {
        let beam = Beam::new(l, rays, signs, lanes);
        let Rays { origin, inverse, .. } = *rays;
        let (near, far) = beam.planes;
        waiting.together[0] = ROOT;
        waiting.lanes[0] = lanes;
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let (node, i, enters) = child_of_key(waiting.together[depth]);
            let asked = l.mask(waiting.lanes[depth]) & rays.best.t.ge(l.f(enters));
            if !asked.any() {
                continue;
            }
            let planes = &self.nodes[node].planes;
            let from = V3 {
                x: (l.f(planes[near[0]][i]) - origin.x) * inverse.x,
                y: (l.f(planes[near[1]][i]) - origin.y) * inverse.y,
                z: (l.f(planes[near[2]][i]) - origin.z) * inverse.z,
            };
            let to = V3 {
                x: (l.f(planes[far[0]][i]) - origin.x) * inverse.x,
                y: (l.f(planes[far[1]][i]) - origin.y) * inverse.y,
                z: (l.f(planes[far[2]][i]) - origin.z) * inverse.z,
            };
            let (enter, leave) = passage(l, from, to);
            let inside = asked & enter.le(leave.min(rays.best.t));
            let bits = inside.bits();
            if bits == 0 {
                continue;
            }
            let child = self.nodes[node].child[i];
            if bits.count_ones() <= ALONE {
                let mut entered = [0.0; FAN];
                enter.store(&mut entered);
                let start = (child, &entered);
                self.walk_alone::<L, ANY>(l, rays, bits, start, &mut waiting.alone);
            } else if child & INNER != 0 {
                let at = (child >> KIND_BITS) as usize;
                depth = self.push_children(l, at, bits, &beam, waiting, depth);
            } else {
                self.meet_together::<L, ANY>(l, rays, child, inside, enter);
            }
        }
    }

    /// Puts the children that rays of the packet may enter on the stack, the nearest on top; returns the new
    /// depth.
    #[inline(always)]
    fn push_children<L: Lanes>(
        &self,
        l: L,
        at: usize,
        lanes: u32,
        beam: &Beam<L>,
        waiting: &mut Waiting,
        mut depth: usize,
    ) -> usize {
        let (near, far) = beam.planes;
        let planes = &self.nodes[at].planes;
        let mut enters = Row([0.0; FAN]);
        let mut todo = 0;
        let mut k = 0;
        while k < FAN {
            let from = V3 {
                x: least_product(l.load(&planes[near[0]][k..]) - beam.near.x, beam.least.x, beam.largest.x),
                y: least_product(l.load(&planes[near[1]][k..]) - beam.near.y, beam.least.y, beam.largest.y),
                z: least_product(l.load(&planes[near[2]][k..]) - beam.near.z, beam.least.z, beam.largest.z),
            };
            let to = V3 {
                x: largest_product(l.load(&planes[far[0]][k..]) - beam.far.x, beam.least.x, beam.largest.x),
                y: largest_product(l.load(&planes[far[1]][k..]) - beam.far.y, beam.least.y, beam.largest.y),
                z: largest_product(l.load(&planes[far[2]][k..]) - beam.far.z, beam.least.z, beam.largest.z),
            };
            let (enter, leave) = passage(l, from, to);
            enter.store(&mut enters.0[k..]);
            todo |= enter.le(leave).bits() << k;
            k += L::N;
        }
        let bottom = depth;
        while todo != 0 {
            let i = todo.trailing_zeros() as usize;
            todo &= todo - 1;
            insert(&mut waiting.together, bottom, depth, child_key(at, i, enters.0[i]));
            waiting.lanes[depth] = lanes;
            depth += 1;
        }
        depth
    }

    /// Asks the primitives of a leaf for the rays of `inside`, which enter its box at `enter`.
    #[inline(always)]
    fn meet_together<L: Lanes, const ANY: bool>(
        &self,
        l: L,
        rays: &mut Rays<L>,
        child: u32,
        inside: L::M,
        enter: L::F,
    ) {
        let zero = l.f(0.0);
        let (first, n) = leaf(child);
        if child & BALLS == 0 {
            let numbers = window(&self.facets, first as usize * FACET_NUMBERS);
            for i in 0..n {
                let facet = FacetLanes {
                    p0: V3 { x: l.f(numbers[i]), y: l.f(numbers[n + i]), z: l.f(numbers[2 * n + i]) },
                    normal: V3 { x: l.f(numbers[3 * n + i]), y: l.f(numbers[4 * n + i]), z: l.f(numbers[5 * n + i]) },
                    u_axis: V3 { x: l.f(numbers[6 * n + i]), y: l.f(numbers[7 * n + i]), z: l.f(numbers[8 * n + i]) },
                    v_axis: V3 { x: l.f(numbers[9 * n + i]), y: l.f(numbers[10 * n + i]), z: l.f(numbers[11 * n + i]) },
                    triangle: l.f(numbers[12 * n + i]),
                };
                let (t, hit) = facet.intersect(l, rays.origin, rays.dir);
                rays.take::<ANY>(l, t.max(enter), hit & t.gt(zero) & inside, first + i as u32);
            }
        } else {
            let numbers = window(&self.balls, first as usize * BALL_NUMBERS);
            for i in 0..n {
                let center = V3 { x: l.f(numbers[i]), y: l.f(numbers[n + i]), z: l.f(numbers[2 * n + i]) };
                let ball = BallLanes { center, radius2: l.f(numbers[3 * n + i]) };
                let t = ball.nearest(l, rays.origin, rays.dir, zero);
                let hit = t.lt(l.f(f32::INFINITY)) & inside;
                rays.take::<ANY>(l, t.max(enter), hit, self.first_ball + first + i as u32);
            }
        }
    }

    /// Walks the rays of `lanes` one by one, from a child that they enter at given distances.
    #[inline(always)]
    fn walk_alone<L: Lanes, const ANY: bool>(
        &self,
        l: L,
        rays: &mut Rays<L>,
        mut lanes: u32,
        start: (u32, &[f32; FAN]),
        waiting: &mut [u64; STACK],
    ) {
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let mut numbers = [0.0; 9];
            for (number, of_all) in numbers.iter_mut().zip(&rays.numbers) {
                *number = of_all[lane];
            }
            let ray = Ray::new(l, &numbers);
            let few = Ray::new(l.few(), &numbers);
            let planes = near_and_far([numbers[6] < 0.0, numbers[7] < 0.0, numbers[8] < 0.0]);
            let mut best = (rays.best.t.lane(lane), rays.best.id.lane(lane));
            let mut next = entry_key(start.0, start.1[lane]);
            let mut depth = 0;
            'ray: loop {
                let (child, enter) = child_of_entry_key(next);
                if child & INNER == 0 {
                    best = self.meet_alone::<L::Few, ANY>(l.few(), &few, child, enter, best);
                    if ANY && best.0 < 0.0 {
                        break 'ray;
                    }
                } else {
                    let at = (child >> KIND_BITS) as usize;
                    let (mut todo, enters) = self.entered(l, at, &ray, planes, best.0);
                    if todo != 0 {
                        // The nearest one next; the others have to wait.
                        let children = &self.nodes[at].child;
                        let first = todo.trailing_zeros() as usize;
                        next = entry_key(children[first], enters.0[first]);
                        todo &= todo - 1;
                        while todo != 0 {
                            let other = todo.trailing_zeros() as usize;
                            todo &= todo - 1;
                            let key = entry_key(children[other], enters.0[other]);
                            waiting[depth] = key.max(next);
                            next = key.min(next);
                            depth += 1;
                        }
                        continue;
                    }
                }
                loop {
                    if depth == 0 {
                        break 'ray;
                    }
                    depth -= 1;
                    next = waiting[depth];
                    if child_of_entry_key(next).1 <= best.0 {
                        break;
                    }
                }
            }
            let here = l.mask(1 << lane);
            rays.best.t = here.select(l.f(best.0), rays.best.t);
            rays.best.id = here.select_u(l.u(best.1), rays.best.id);
        }
    }

    /// The children (bit i is child i) that a ray enters nearer than `t_max` or just there, and where.
    #[inline(always)]
    fn entered<L: Lanes>(
        &self,
        l: L,
        at: usize,
        ray: &Ray<L>,
        (near, far): ([usize; 3], [usize; 3]),
        t_max: f32,
    ) -> (u32, Row) {
        let planes = &self.nodes[at].planes;
        let mut enters = Row([0.0; FAN]);
        let mut entered = 0;
        let mut k = 0;
        while k < FAN {
            let from = V3 {
                x: (l.load(&planes[near[0]][k..]) - ray.origin.x) * ray.inverse.x,
                y: (l.load(&planes[near[1]][k..]) - ray.origin.y) * ray.inverse.y,
                z: (l.load(&planes[near[2]][k..]) - ray.origin.z) * ray.inverse.z,
            };
            let to = V3 {
                x: (l.load(&planes[far[0]][k..]) - ray.origin.x) * ray.inverse.x,
                y: (l.load(&planes[far[1]][k..]) - ray.origin.y) * ray.inverse.y,
                z: (l.load(&planes[far[2]][k..]) - ray.origin.z) * ray.inverse.z,
            };
            let (enter, leave) = passage(l, from, to);
            enter.store(&mut enters.0[k..]);
            entered |= enter.le(leave.min(l.f(t_max))).bits() << k;
            k += L::N;
        }
        (entered, enters)
    }

    /// Asks the primitives of a leaf for one ray, which enters its box at `enter`.
    #[inline(always)]
    fn meet_alone<L: Lanes, const ANY: bool>(
        &self,
        l: L,
        ray: &Ray<L>,
        child: u32,
        enter: f32,
        mut best: (f32, u32),
    ) -> (f32, u32) {
        let zero = l.f(0.0);
        let infinite = l.f(f32::INFINITY);
        let (first, n) = leaf(child);
        let mut k = 0;
        while k < n {
            let (t, hit, id) = if child & BALLS == 0 {
                let numbers = window(&self.facets, first as usize * FACET_NUMBERS + k);
                let facet = FacetLanes {
                    p0: load(l, numbers, n, 0),
                    normal: load(l, numbers, n, 3),
                    u_axis: load(l, numbers, n, 6),
                    v_axis: load(l, numbers, n, 9),
                    triangle: l.load(&numbers[12 * n..]),
                };
                let (t, hit) = facet.intersect(l, ray.origin, ray.dir);
                (t, hit & t.gt(zero), first)
            } else {
                let numbers = window(&self.balls, first as usize * BALL_NUMBERS + k);
                let ball = BallLanes { center: load(l, numbers, n, 0), radius2: l.load(&numbers[3 * n..]) };
                let t = ball.nearest(l, ray.origin, ray.dir, zero);
                (t, t.lt(infinite), self.first_ball + first)
            };
            let t = t.max(l.f(enter));
            let hit = hit & t.le(l.f(best.0)) & l.iota().lt(l.u((n - k) as u32));
            if hit.any() {
                let t = hit.select(t, infinite);
                let least = t.least();
                let id = id + k as u32 + t.le(l.f(least)).bits().trailing_zeros();
                if ANY {
                    if least < best.0 {
                        return (f32::NEG_INFINITY, 0);
                    }
                } else if least < best.0 || id < best.1 {
                    best = (least, id);
                }
            }
            k += L::N;
        }
        best
    }
}

impl<L: Lanes> Ray<L> {
    /// From origin, direction and inverse.
    #[inline(always)]
    fn new(l: L, numbers: &[f32; 9]) -> Self {
        let [ox, oy, oz, dx, dy, dz, ix, iy, iz] = *numbers;
        Self {
            origin: V3 { x: l.f(ox), y: l.f(oy), z: l.f(oz) },
            dir: V3 { x: l.f(dx), y: l.f(dy), z: l.f(dz) },
            inverse: V3 { x: l.f(ix), y: l.f(iy), z: l.f(iz) },
        }
    }
}

impl<L: Lanes> Rays<L> {
    /// Takes note of primitive `id`, met at distance `t` where `hit`.
    #[inline(always)]
    fn take<const ANY: bool>(&mut self, l: L, t: L::F, hit: L::M, id: u32) {
        let best = &mut self.best;
        if ANY {
            best.t = (hit & t.lt(best.t)).select(l.f(f32::NEG_INFINITY), best.t);
        } else {
            let nearer = hit & t.le(best.t) & (t.lt(best.t) | l.u(id).lt(best.id));
            best.t = nearer.select(t, best.t);
            best.id = nearer.select_u(l.u(id), best.id);
        }
    }
}

/// What holds for all rays of a packet that point into one octant.
struct Beam<L: Lanes> {
    /// See [`near_and_far`].
    planes: ([usize; 3], [usize; 3]),
    /// Along each axis the origin that has come farthest, and the one that lags behind most.
    near: V3<L>,
    far: V3<L>,
    /// Bounds of the inverse directions.
    least: V3<L>,
    largest: V3<L>,
}

impl<L: Lanes> Beam<L> {
    #[inline(always)]
    fn new(l: L, rays: &Rays<L>, signs: [bool; 3], lanes: u32) -> Self {
        let lanes = l.mask(lanes);
        let (origin, inverse) = (rays.origin, rays.inverse);
        let (least_x, largest_x) = range(l, origin.x, lanes);
        let (least_y, largest_y) = range(l, origin.y, lanes);
        let (least_z, largest_z) = range(l, origin.z, lanes);
        let (ix0, ix1) = range(l, inverse.x, lanes);
        let (iy0, iy1) = range(l, inverse.y, lanes);
        let (iz0, iz1) = range(l, inverse.z, lanes);
        Self {
            planes: near_and_far(signs),
            near: V3 {
                x: if signs[0] { least_x } else { largest_x },
                y: if signs[1] { least_y } else { largest_y },
                z: if signs[2] { least_z } else { largest_z },
            },
            far: V3 {
                x: if signs[0] { largest_x } else { least_x },
                y: if signs[1] { largest_y } else { least_y },
                z: if signs[2] { largest_z } else { least_z },
            },
            least: V3 { x: ix0, y: iy0, z: iz0 },
            largest: V3 { x: ix1, y: iy1, z: iz1 },
        }
    }
}

/// Least and largest number of some lanes, in all lanes.
#[inline(always)]
fn range<L: Lanes>(l: L, v: L::F, lanes: L::M) -> (L::F, L::F) {
    let least = lanes.select(v, l.f(f32::INFINITY)).least();
    let largest = lanes.select(v, l.f(f32::NEG_INFINITY)).largest();
    (l.f(least), l.f(largest))
}

/// The least of `x` times numbers from `a` to `b`, which have one sign.
#[inline(always)]
fn least_product<F: Real>(x: F, a: F, b: F) -> F {
    (x * a).min(x * b)
}

/// The largest of them.
#[inline(always)]
fn largest_product<F: Real>(x: F, a: F, b: F) -> F {
    (x * a).max(x * b)
}

/// First primitive of a leaf and how many there are: visibly at most [`LEAF`], which spares checks of indices.
#[inline(always)]
fn leaf(child: u32) -> (u32, usize) {
    (child >> KIND_BITS, child as usize % LEAF + 1)
}

/// Numbers from `at` on.
#[inline(always)]
fn window(numbers: &[f32], at: usize) -> &[f32; WINDOW] {
    numbers[at..].first_chunk().expect("the list goes on for so long after the last leaf")
}

/// Numbers `3 rows` of a leaf of `n` primitives as a vector.
#[inline(always)]
fn load<L: Lanes>(l: L, numbers: &[f32; WINDOW], n: usize, row: usize) -> V3<L> {
    V3 { x: l.load(&numbers[row * n..]), y: l.load(&numbers[(row + 1) * n..]), z: l.load(&numbers[(row + 2) * n..]) }
}

/// Indices of the planes through which rays with these signs of direction enter a box, and leave it.
#[inline(always)]
pub(crate) fn near_and_far(signs: [bool; 3]) -> ([usize; 3], [usize; 3]) {
    let mut near = [0, 1, 2];
    let mut far = [3, 4, 5];
    for axis in 0..3 {
        if signs[axis] {
            near[axis] = axis + 3;
            far[axis] = axis;
        }
    }
    (near, far)
}

/// Puts a child among those from `bottom` to `top`, the farthest first.
#[inline(always)]
fn insert(children: &mut [u64], bottom: usize, top: usize, key: u64) {
    let mut at = top;
    while at > bottom && children[at - 1] < key {
        children[at] = children[at - 1];
        at -= 1;
    }
    children[at] = key;
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes scattered by multiples of the golden ratio and the like, of all sizes.
    fn boxes(n: usize, seed: f32) -> Vec<Aabb> {
        let part = |i: usize, by: f32| (i as f32 * by + seed).fract();
        let corner = |i| Vec3A::new(part(i, 0.618_034), part(i, 0.754_877_7), part(i, 0.569_840_3)) * 4.0;
        let size = |i| Vec3A::new(part(i, 0.8191), part(i, 0.6711), part(i, 0.5497)) * (0.05 + part(i, 0.415) * 2.0);
        (0..n).map(|i| Aabb::new(corner(i), corner(i) + size(i))).collect()
    }

    /// Sum of the areas of all nodes and leaves below a part, and number of levels.
    fn cost(binary: &Binary<'_>, gathering: &Gathering, part: Part) -> (f64, usize) {
        let children = binary.children(part, gathering);
        assert!(children.len() <= FAN);
        let (mut sum, mut levels) = (0.0, 0);
        for child in children {
            sum += f64::from(child.bounds.half_area());
            if !binary.may_be_leaf(&child) {
                let (below, deep) = cost(binary, gathering, child);
                sum += below;
                levels = levels.max(deep);
            }
        }
        (sum, levels + 1)
    }

    /// The least such sum of all ways to give a wide node exactly 1, 2, ... children from one binary node; the first is
    /// that of the node as a whole.
    fn least_costs(binary: &Binary<'_>, node: u32) -> Vec<f64> {
        let part = binary.part(node);
        let area = f64::from(part.bounds.half_area());
        if binary.may_be_leaf(&part) {
            return vec![area];
        }
        let [a, b] = binary.below(node).map(|node| least_costs(binary, node));
        let mut least = vec![f64::INFINITY; FAN.min(a.len() + b.len())];
        for (i, a) in a.iter().enumerate() {
            for (j, b) in b.iter().enumerate().take_while(|(j, _)| i + j + 2 <= FAN) {
                least[i + j + 1] = least[i + j + 1].min(a + b);
            }
        }
        least[0] = area + least[1..].iter().copied().fold(f64::INFINITY, f64::min);
        least
    }

    #[test]
    fn no_other_gathering_costs_less() {
        // Leaves of one box, of up to three, and boxes that must not be mixed.
        let mut heaps = Vec::new();
        for (n, first_ball, leaf) in [(18, 18, 1), (300, 300, 1), (800, 800, 3), (900, 300, 8)] {
            heaps.extend([0.0, 0.1234, 0.2468].map(|seed| (boxes(n, seed), first_ball, leaf)));
        }
        // Room that nobody can use: a place for sixteen blocks, of which there are fifteen, each best left whole.
        let cell = |i| Vec3A::new((i % 4) as f32, (i / 4 % 4) as f32, 0.0) + Vec3A::X * (i / 16 * 100) as f32;
        heaps.push(((0..15 * 16).map(|i| Aabb::new(cell(i), cell(i) + 1.0)).collect(), 15 * 16, 1));
        for (boxes, first_ball, leaf) in heaps {
            let n = boxes.len();
            let binary = Binary::new(&boxes, first_ball, leaf);
            let top = binary.part(0);
            let (found, levels) = cost(&binary, &binary.gather(), top);
            assert!(levels < CLUSTERED, "the binary tree is followed everywhere");
            let least = least_costs(&binary, 0)[0] - f64::from(top.bounds.half_area());
            assert!((found - least).abs() < 1e-5 * least, "{n} boxes, {leaf} to a leaf: {found} and {least}");
        }
    }

    #[test]
    fn a_tree_has_no_more_levels_than_there_is_room_for() {
        // Each box half as large and as far off as the one before: a binary tree over these is a chain.
        let chain = (0..250).map(|i| 2.0f32.powi(i - 125)).map(|s| Aabb::new(Vec3A::splat(s), Vec3A::splat(1.5 * s)));
        let chain: Vec<Aabb> = chain.collect();
        let flat = vec![Aabb::new(Vec3A::ZERO, Vec3A::ONE); 5000];
        for (boxes, first_ball, leaf) in
            [(&chain, 250, 1), (&chain, 100, 8), (&flat, 5000, 1), (&flat, 2500, 8), (&boxes(5000, 0.3), 2000, 8)]
        {
            let nodes = Binary::new(boxes, first_ball, leaf).collapse(|_, _| 0);
            let mut levels = vec![0; nodes.len()];
            for (i, node) in nodes.iter().enumerate() {
                for child in node.child.into_iter().filter(|child| child & INNER != 0) {
                    levels[(child >> KIND_BITS) as usize] = levels[i] + 1;
                }
            }
            let most = levels.into_iter().max().unwrap_or(0);
            assert!(most <= LEVELS, "{most} levels over {} boxes", boxes.len());
        }
        // The chain goes deeper than the binary tree is followed, so that the bound means something.
        let binary = Binary::new(&chain, 250, 1);
        let (_, levels) = cost(&binary, &binary.gather(), binary.part(0));
        assert!(levels > CLUSTERED, "{levels} levels");
    }
}
