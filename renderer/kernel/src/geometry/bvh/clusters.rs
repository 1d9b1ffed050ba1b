//! A binary tree over boxes, clustered from the leaves upwards.
//!
//! In rows along a curve, each node looks for the neighbour with which it would fill the smallest box; two that choose each
//! other become one node of the next row (Meister and Bittner 2018, "Parallel locally-ordered clustering for bounding volume
//! hierarchy construction"). Where boxes are equal, nested or flat, many choices are equally good or nobody is chosen in
//! return; such a row is joined pair by pair, so that the time is near n log n whatever the boxes.

use obvhs::aabb::Aabb;

use super::curve::along_curve;
use crate::stop::{Stop, Stopped};

/// How many neighbours on either side are looked at.
const REACH: usize = 24;

/// A row in which fewer than one node in so many finds a partner ...
const FEW: usize = 16;

/// ... is joined pair by pair, if it is as long as that: a shorter one costs little however it is joined.
const LONG: usize = 512;

/// In the place of a node: none.
pub(super) const NONE: u32 = u32::MAX;

/// A binary tree: first one leaf for each box, then the nodes with children, each after both of its children.
pub(super) struct Clusters {
    /// Box of each node.
    pub(super) bounds: Vec<Aabb>,
    /// Children of each node; [`NONE`] of a leaf.
    pub(super) children: Vec<[u32; 2]>,
    /// On top of all; a leaf if it is the only one.
    pub(super) root: u32,
}

impl Clusters {
    /// Over boxes, at least one.
    pub(super) fn new(boxes: &[Aabb], stop: Stop<'_>) -> Result<Self, Stopped> {
        let mut row = along_curve(boxes, stop)?;
        let mut row_bounds: Vec<Aabb> = row.iter().map(|&i| boxes[i as usize]).collect();
        let (mut bounds, mut children) = (boxes.to_vec(), vec![[NONE; 2]; boxes.len()]);
        bounds.reserve_exact(boxes.len() - 1);
        children.reserve_exact(boxes.len() - 1);
        let mut partners = Partners::default();
        while row.len() > 1 {
            partners.choose(&row_bounds, stop)?;
            let mut kept = 0;
            for i in 0..row.len() {
                stop.check_in_turn(i)?;
                let partner = partners.of(i);
                if partner < i {
                    continue;
                }
                if partner > i {
                    let joint = row_bounds[i].union(&row_bounds[partner]);
                    children.push([row[i], row[partner]]);
                    row[kept] = bounds.len() as u32;
                    row_bounds[kept] = joint;
                    bounds.push(joint);
                } else {
                    row[kept] = row[i];
                    row_bounds[kept] = row_bounds[i];
                }
                kept += 1;
            }
            row.truncate(kept);
            row_bounds.truncate(kept);
        }
        Ok(Self { bounds, children, root: row[0] })
    }

    /// The nodes below one that has any.
    pub(super) fn below(&self, node: u32) -> Option<[u32; 2]> {
        Some(self.children[node as usize]).filter(|[first, _]| *first != NONE)
    }
}

/// Who is to be joined with whom in a row.
#[derive(Default)]
struct Partners {
    /// Half area of the joint box with the best neighbour.
    cost: Vec<f32>,
    /// The best neighbour.
    best: Vec<u32>,
    /// Nobody chooses; all are joined with their neighbour.
    in_pairs: bool,
}

impl Partners {
    /// Looks at all neighbours of all nodes.
    fn choose(&mut self, row: &[Aabb], stop: Stop<'_>) -> Result<(), Stopped> {
        let n = row.len();
        let cost = |i: usize, j: usize| row[i].union(&row[j]).half_area();
        // Of equally good neighbours, the one that is paired with: where all boxes are equal, everybody is chosen in return.
        self.best.clear();
        self.best.extend((0..n).map(|i| self::neighbour(i, n) as u32));
        self.cost.clear();
        self.cost.extend((0..n).map(|i| cost(i, self::neighbour(i, n))));
        for i in 0..n {
            stop.check_in_turn(i)?;
            for j in i + 1..n.min(i + 1 + REACH) {
                let joint = cost(i, j);
                for (one, other) in [(i, j), (j, i)] {
                    if joint < self.cost[one] {
                        self.cost[one] = joint;
                        self.best[one] = other as u32;
                    }
                }
            }
        }
        self.in_pairs = false;
        let joined = (0..n).filter(|&i| self.of(i) > i).count();
        self.in_pairs = n > LONG && joined * FEW < n || joined == 0;
        Ok(())
    }

    /// Whom a node is joined with; itself for nobody.
    fn of(&self, i: usize) -> usize {
        let n = self.best.len();
        if self.in_pairs {
            return if i ^ 1 < n { i ^ 1 } else { i };
        }
        let best = self.best[i] as usize;
        if self.best[best] as usize == i { best } else { i }
    }
}

/// The other one of a pair in a row of `n`, at least two; of the odd one out, the one before.
fn neighbour(i: usize, n: usize) -> usize {
    if i ^ 1 < n { i ^ 1 } else { i - 1 }
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;

    use super::*;

    /// Each box once, joint boxes around both children, each node after its children.
    fn check(boxes: &[Aabb]) -> Clusters {
        let tree = Clusters::new(boxes, Stop::NEVER).expect("nobody stops it");
        assert_eq!(tree.bounds.len(), 2 * boxes.len() - 1);
        let mut seen = vec![0; tree.bounds.len()];
        for node in 0..tree.bounds.len() as u32 {
            let Some(below) = tree.below(node) else { continue };
            let [a, b] = below.map(|child| child as usize);
            assert!(a < node as usize && b < node as usize);
            assert_eq!(tree.bounds[node as usize], tree.bounds[a].union(&tree.bounds[b]));
            seen[a] += 1;
            seen[b] += 1;
        }
        seen[tree.root as usize] += 1;
        assert!(seen.iter().all(|&n| n == 1), "every node is somewhere, once");
        tree
    }

    #[test]
    fn every_box_is_in_the_tree_once() {
        let cube = |center: Vec3A, size: f32| Aabb::new(center - size, center + size);
        for n in [1, 2, 3, 7, 64, 1001] {
            check(&vec![cube(Vec3A::ONE, 1.0); n]);
            check(&(0..n).map(|i| cube(Vec3A::ZERO, i as f32)).collect::<Vec<_>>());
            check(&(0..n).map(|i| cube(Vec3A::X * i as f32, 0.0)).collect::<Vec<_>>());
            check(&(0..n).map(|i| cube(Vec3A::splat((i as f32 * 0.618).fract()), 1e30)).collect::<Vec<_>>());
        }
    }

    #[test]
    fn two_heaps_meet_on_top() {
        let at = |x: f32, i: usize| {
            let corner = Vec3A::new(x, (i as f32 * 0.618).fract(), (i as f32 * 0.755).fract());
            Aabb::new(corner, corner + 0.01)
        };
        let boxes: Vec<Aabb> = (0..200).map(|i| at(if i % 2 == 0 { 0.0 } else { 50.0 }, i)).collect();
        let tree = check(&boxes);
        let below = tree.below(tree.root).expect("many boxes");
        assert!(below.iter().all(|&node| tree.bounds[node as usize].half_area() < 2.0), "each heap by itself");
    }
}
