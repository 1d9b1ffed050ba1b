//! Building the tree: a binary tree, gathered into nodes of sixteen children.

use glam::Vec3;
use obvhs::aabb::Aabb;

use super::by_obvhs;
use super::clusters::Clusters;
use super::moves::improve;
use super::{BALL_NUMBERS, BALLS, CLUSTERED, FAN, INNER, KIND_BITS, LEAF, Node, Tree, WINDOW};
use crate::geometry::bounds::{ball_box, facet_box};
use crate::geometry::shape::{Ball, FACET_NUMBERS, Facet};
use crate::stop::{Stop, Stopped};

/// Primitives that are to become a child.
#[derive(Clone, Copy)]
pub(super) struct Part {
    /// Where they are in the order of the binary tree.
    first: usize,
    count: usize,
    /// Node of the binary tree; `None` where that is not followed.
    node: Option<u32>,
    bounds: Aabb,
}

/// The binary tree that the tree is made from. Its leaves, one for each primitive, have the primitives' numbers.
pub(crate) struct Binary {
    tree: Clusters,
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
pub(super) struct Gathering {
    /// Index into `shares` of each node of the binary tree; [`WHOLE`] for those that are one child, whatever room there is.
    rows: Vec<u32>,
    /// How many of j + 1 children go to the first of the two nodes below; 0: the node is one child as a whole. In
    /// the place of j = 0: how many if it becomes a node of its own, with all of its [`FAN`] children.
    shares: Vec<[u8; FAN - 1]>,
}

/// See [`Gathering`].
pub(super) const WHOLE: u32 = u32::MAX;

impl Binary {
    /// Over boxes, at least one; those from `first_ball` on are not mixed with others in a leaf.
    pub(crate) fn new(boxes: &[Aabb], first_ball: usize, leaf: usize, stop: Stop<'_>) -> Result<Self, Stopped> {
        let tree = if boxes.len() <= by_obvhs::MOST {
            by_obvhs::build(boxes)
        } else {
            let mut tree = Clusters::new(boxes, stop)?;
            improve(&mut tree, stop)?;
            tree
        };
        let mut order = Vec::with_capacity(boxes.len());
        let mut ranges = vec![[0; 2]; tree.bounds.len()];
        let mut upwards = Vec::with_capacity(boxes.len());
        // Down on the way in, up on the way out: a node is there twice, the second time marked.
        const OUT: u32 = 1 << 31;
        let mut stack = vec![tree.root];
        let mut turn = 0;
        while let Some(at) = stack.pop() {
            stop.check_in_turn(turn)?;
            turn += 1;
            let node = at & !OUT;
            let id = node as usize;
            if at & OUT != 0 {
                ranges[id][1] = order.len() as u32 - ranges[id][0];
                upwards.push(node);
                continue;
            }
            match tree.below(node) {
                None => {
                    ranges[id] = [order.len() as u32, 1];
                    order.push(node);
                }
                Some([first, second]) => {
                    ranges[id] = [order.len() as u32, 0];
                    stack.extend([at | OUT, second, first]);
                }
            }
        }
        let mut balls_before = Vec::with_capacity(order.len() + 1);
        let mut balls = 0;
        for &id in &order {
            balls_before.push(balls);
            balls += u32::from(id as usize >= first_ball);
        }
        balls_before.push(balls);
        Ok(Self { tree, leaf, order, ranges, balls_before, upwards })
    }

    /// The whole tree.
    pub(super) fn whole(&self) -> Part {
        self.part(self.tree.root)
    }

    pub(super) fn part(&self, node: u32) -> Part {
        let [first, count] = self.ranges[node as usize].map(|v| v as usize);
        Part { first, count, node: Some(node), bounds: self.tree.bounds[node as usize] }
    }

    /// `None` if there are facets and balls.
    pub(super) fn are_balls(&self, part: &Part) -> Option<bool> {
        let balls = self.balls_before[part.first + part.count] - self.balls_before[part.first];
        if balls == 0 {
            Some(false)
        } else if balls as usize == part.count {
            Some(true)
        } else {
            None
        }
    }

    pub(super) fn may_be_leaf(&self, part: &Part) -> bool {
        part.count <= self.leaf && self.are_balls(part).is_some()
    }

    /// The two nodes below one that has any.
    pub(super) fn below(&self, node: u32) -> [u32; 2] {
        self.tree.below(node).expect("a node that is no leaf")
    }

    /// The best way to gather the nodes.
    pub(super) fn gather(&self, stop: Stop<'_>) -> Result<Gathering, Stopped> {
        let mut rows = vec![WHOLE; self.tree.bounds.len()];
        let (mut shares, mut costs) = (Vec::new(), Vec::<[f32; FAN - 1]>::new());
        for (turn, &node) in self.upwards.iter().enumerate() {
            stop.check_in_turn(turn)?;
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
        Ok(Gathering { rows, shares })
    }

    /// The children of a part: those that are best if the binary tree is followed, else equal shares.
    pub(super) fn children(&self, part: Part, gathering: &Gathering) -> Vec<Part> {
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
                let boxes = self.order[first..end].iter().map(|&id| self.tree.bounds[id as usize]);
                let bounds = boxes.fold(Aabb::empty(), |all, one| all.union(&one));
                Part { first, count: end - first, node: None, bounds }
            })
            .collect()
    }

    /// The nodes of sixteen children, the second one on top of all; the first one has that as its only child. `leaf` makes
    /// a child of primitives, by their numbers, that are balls or not.
    pub(crate) fn collapse(
        &self,
        stop: Stop<'_>,
        mut leaf: impl FnMut(bool, &[u32]) -> u32,
    ) -> Result<Vec<Node>, Stopped> {
        let mut nodes = vec![Node::EMPTY, Node::EMPTY];
        nodes[0].child[0] = 1 << KIND_BITS | INNER;
        for axis in 0..3 {
            nodes[0].planes[axis][0] = f32::NEG_INFINITY;
            nodes[0].planes[axis + 3][0] = f32::INFINITY;
        }
        let gathering = self.gather(stop)?;
        let mut todo = vec![(1, self.whole(), 1)];
        while let Some((at, part, level)) = todo.pop() {
            stop.check_in_turn(at << 6)?;
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
        Ok(nodes)
    }
}

/// The corners of a box, moved apart by two roundings of its largest coordinate: hits are computed, too. Boxes
/// within boxes stay so.
pub(super) fn padded(bounds: &Aabb) -> [Vec3; 2] {
    let (min, max) = (Vec3::from(bounds.min), Vec3::from(bounds.max));
    let pad = 2.0 * f32::EPSILON * min.abs().max(max.abs()).max_element();
    [min - pad, max + pad]
}

impl Tree {
    /// Builds the tree and puts the primitives, at least one, into its order.
    ///
    /// # Errors
    /// If it is stopped.
    pub fn new(facets: &mut Vec<Facet>, balls: &mut Vec<Ball>, stop: Stop<'_>) -> Result<Self, Stopped> {
        let boxes: Vec<Aabb> = facets.iter().map(facet_box).chain(balls.iter().map(ball_box)).collect();
        let binary = Binary::new(&boxes, facets.len(), LEAF, stop)?;
        drop(boxes);
        let (mut facet_numbers, mut ball_numbers) = (Vec::new(), Vec::new());
        facet_numbers.reserve_exact(facets.len() * FACET_NUMBERS + WINDOW);
        ball_numbers.reserve_exact(balls.len() * BALL_NUMBERS + WINDOW);
        let (mut facet_order, mut ball_order) = (Vec::new(), Vec::new());
        let nodes = binary.collapse(stop, |are_balls, ids| {
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
        })?;
        // Lanes read beyond the last leaf.
        facet_numbers.extend([0.0; WINDOW]);
        ball_numbers.extend([0.0; WINDOW]);
        let first_ball = facets.len() as u32;
        *facets = facet_order;
        *balls = ball_order;
        Ok(Self { nodes, facets: facet_numbers, balls: ball_numbers, first_ball })
    }

    /// Number of nodes.
    pub(crate) fn node_count(&self) -> usize {
        self.nodes.len()
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;

    use super::*;
    use crate::geometry::bvh::LEVELS;

    /// Boxes scattered by multiples of the golden ratio and the like, of all sizes.
    pub(super) fn boxes(n: usize, seed: f32) -> Vec<Aabb> {
        let part = |i: usize, by: f32| (i as f32 * by + seed).fract();
        let corner = |i| Vec3A::new(part(i, 0.618_034), part(i, 0.754_877_7), part(i, 0.569_840_3)) * 4.0;
        let size = |i| Vec3A::new(part(i, 0.8191), part(i, 0.6711), part(i, 0.5497)) * (0.05 + part(i, 0.415) * 2.0);
        (0..n).map(|i| Aabb::new(corner(i), corner(i) + size(i))).collect()
    }

    /// Sum of the areas of all nodes and leaves below a part, and number of levels.
    pub(super) fn cost(binary: &Binary, gathering: &Gathering, part: Part) -> (f64, usize) {
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
    pub(super) fn least_costs(binary: &Binary, node: u32) -> Vec<f64> {
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
    pub(super) fn no_other_gathering_costs_less() {
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
            let binary = Binary::new(&boxes, first_ball, leaf, Stop::NEVER).expect("nobody stops it");
            let (root, top) = (binary.tree.root, binary.whole());
            let (found, levels) = cost(&binary, &binary.gather(Stop::NEVER).expect("nobody stops it"), top);
            assert!(levels < CLUSTERED, "the binary tree is followed everywhere");
            let least = least_costs(&binary, root)[0] - f64::from(top.bounds.half_area());
            assert!((found - least).abs() < 1e-5 * least, "{n} boxes, {leaf} to a leaf: {found} and {least}");
        }
    }

    #[test]
    pub(super) fn a_tree_has_no_more_levels_than_there_is_room_for() {
        // Each box half as large and as far off as the one before: a binary tree over these is a chain.
        let chain = (0..250).map(|i| 2.0f32.powi(i - 125)).map(|s| Aabb::new(Vec3A::splat(s), Vec3A::splat(1.5 * s)));
        let chain: Vec<Aabb> = chain.collect();
        let flat = vec![Aabb::new(Vec3A::ZERO, Vec3A::ONE); 5000];
        for (boxes, first_ball, leaf) in
            [(&chain, 250, 1), (&chain, 100, 8), (&flat, 5000, 1), (&flat, 2500, 8), (&boxes(5000, 0.3), 2000, 8)]
        {
            let binary = Binary::new(boxes, first_ball, leaf, Stop::NEVER).expect("nobody stops it");
            let nodes = binary.collapse(Stop::NEVER, |_, _| 0).expect("nobody stops it");
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
        let binary = Binary::new(&chain, 250, 1, Stop::NEVER).expect("nobody stops it");
        let (_, levels) = cost(&binary, &binary.gather(Stop::NEVER).expect("nobody stops it"), binary.whole());
        assert!(levels > CLUSTERED, "{levels} levels");
    }
}
