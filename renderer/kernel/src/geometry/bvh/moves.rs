//! Better places for the largest nodes of a binary tree.
//!
//! A node is taken out and put in again where the boxes above it grow least; that place is looked for from the root down,
//! the most promising node first (Bittner, Hapala and Havran 2013, "Fast insertion-based optimization of bounding volume
//! hierarchies"). Where everything overlaps, all places look promising: after some of them, the best one so far is taken.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::clusters::{Clusters, NONE};
use crate::stop::{Stop, Stopped};

/// Share of the nodes that are moved in the first round. Round k moves a share of 1 / (2 k + 1) of that: the larger a node,
/// the more often it is looked at.
const SHARE: f32 = 0.05;

/// Rounds.
const ROUNDS: usize = 16;

/// Most places that are looked at for one node.
const MOST_PLACES: usize = 256;

/// Moves the largest nodes.
pub(super) fn improve(tree: &mut Clusters, stop: Stop<'_>) -> Result<(), Stopped> {
    let mut moves = Moves::new(tree);
    let mut candidates = Vec::new();
    for round in 0..ROUNDS {
        let count = (moves.tree.bounds.len() as f32 * SHARE / (2 * round + 1) as f32) as usize;
        moves.largest(count, &mut candidates);
        for (i, &(_, node)) in candidates.iter().enumerate() {
            stop.check_in_turn(16 * i)?;
            moves.move_node(node);
        }
    }
    Ok(())
}

struct Moves<'a> {
    tree: &'a mut Clusters,
    /// The node above each; [`NONE`] of the root.
    parents: Vec<u32>,
    /// Places to look at: what the nodes above them grow by, and where; the least growth first.
    promising: BinaryHeap<Reverse<(u32, u32)>>,
}

impl<'a> Moves<'a> {
    fn new(tree: &'a mut Clusters) -> Self {
        let mut parents = vec![NONE; tree.bounds.len()];
        for (node, &[a, b]) in tree.children.iter().enumerate() {
            if a != NONE {
                parents[a as usize] = node as u32;
                parents[b as usize] = node as u32;
            }
        }
        Self { tree, parents, promising: BinaryHeap::new() }
    }

    /// About `count` of the largest nodes, the largest first. They are looked for among those made last, which are near the root.
    fn largest(&self, count: usize, found: &mut Vec<(u32, u32)>) {
        let n = self.tree.bounds.len();
        let areas = (n - (2 * count).min(n)..n).map(|node| (order(self.area(node as u32)), node as u32));
        found.clear();
        found.extend(areas);
        found.sort_unstable_by_key(|&entry| Reverse(entry));
        found.truncate(count);
    }

    fn area(&self, node: u32) -> f32 {
        self.tree.bounds[node as usize].half_area()
    }

    /// By how much a node must grow to hold another one as well.
    fn growth(&self, node: u32, by: u32) -> f32 {
        self.joint_area(node, by) - self.area(node)
    }

    fn joint_area(&self, a: u32, b: u32) -> f32 {
        self.tree.bounds[a as usize].union(&self.tree.bounds[b as usize]).half_area()
    }

    /// Takes a node out and puts it where it costs least; at worst back to where it was.
    fn move_node(&mut self, node: u32) {
        let parent = self.parents[node as usize];
        if parent == NONE || self.parents[parent as usize] == NONE {
            return;
        }
        let above = self.parents[parent as usize];
        let [a, b] = self.tree.children[parent as usize];
        let sibling = if a == node { b } else { a };
        self.replace_child(above, parent, sibling);
        self.refit(above);
        let place = self.best_place(node, sibling);
        // The parent is used again, between the place and what was above it.
        let above = self.parents[place as usize];
        self.tree.children[parent as usize] = [place, node];
        self.parents[node as usize] = parent;
        self.parents[parent as usize] = above;
        if above == NONE {
            self.tree.root = parent;
        } else {
            self.replace_child(above, place, parent);
        }
        self.parents[place as usize] = parent;
        // Its box may be just what it was elsewhere; those above have to grow all the same.
        self.tree.bounds[parent as usize] = self.tree.bounds[place as usize].union(&self.tree.bounds[node as usize]);
        self.refit(above);
    }

    fn replace_child(&mut self, node: u32, old: u32, new: u32) {
        for child in &mut self.tree.children[node as usize] {
            if *child == old {
                *child = new;
            }
        }
        self.parents[new as usize] = node;
    }

    /// Boxes from a node upwards, as long as they change.
    fn refit(&mut self, mut node: u32) {
        while node != NONE {
            let [a, b] = self.tree.children[node as usize].map(|child| self.tree.bounds[child as usize]);
            let joint = a.union(&b);
            if std::mem::replace(&mut self.tree.bounds[node as usize], joint) == joint {
                return;
            }
            node = self.parents[node as usize];
        }
    }

    /// Beside which node another one, that is in no place, costs least; `known` is one such place.
    fn best_place(&mut self, node: u32, known: u32) -> u32 {
        let mut known_cost = self.joint_area(known, node);
        let mut above = self.parents[known as usize];
        while above != NONE {
            known_cost += self.growth(above, node);
            above = self.parents[above as usize];
        }
        let mut best = (known_cost, known);
        let own_area = self.area(node);
        self.promising.clear();
        self.promising.push(Reverse((order(0.0), self.tree.root)));
        for _ in 0..MOST_PLACES {
            let Some(Reverse((growth, place))) = self.promising.pop() else { break };
            let growth = f32::from_bits(growth);
            // What lies below costs at least that. A sum that is no number is no better either.
            let may_be_better = |growth: f32, best: f32| growth + own_area < best;
            if !may_be_better(growth, best.0) {
                break;
            }
            let joint = self.joint_area(place, node);
            if growth + joint < best.0 {
                best = (growth + joint, place);
            }
            let growth = growth + (joint - self.area(place)).max(0.0);
            if let Some(below) = self.tree.below(place)
                && may_be_better(growth, best.0)
            {
                self.promising.extend(below.map(|child| Reverse((order(growth), child))));
            }
        }
        best.1
    }
}

/// The bits of a number that is not negative, which are in the order of the numbers.
fn order(v: f32) -> u32 {
    v.to_bits()
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;
    use obvhs::aabb::Aabb;

    use super::*;

    fn cost(tree: &Clusters) -> f64 {
        let inner = (0..tree.bounds.len() as u32).filter(|&node| tree.below(node).is_some());
        inner.map(|node| f64::from(tree.bounds[node as usize].half_area())).sum()
    }

    /// Every node is once in the tree, and its box is around its children's.
    fn check(tree: &Clusters) {
        let (mut todo, mut seen) = (vec![tree.root], 0);
        while let Some(node) = todo.pop() {
            seen += 1;
            if let Some(below) = tree.below(node) {
                let [a, b] = below.map(|child| tree.bounds[child as usize]);
                assert_eq!(tree.bounds[node as usize], a.union(&b));
                todo.extend(below);
            }
        }
        assert_eq!(seen, tree.bounds.len());
    }

    #[test]
    fn moves_make_a_tree_cheaper_and_keep_it_one() {
        let part = |i: usize, by: f32| (i as f32 * by).fract();
        let corner = |i| Vec3A::new(part(i, 0.618_034), part(i, 0.754_877_7), part(i, 0.569_840_3)) * 4.0;
        let size = |i| Vec3A::new(part(i, 0.8191), part(i, 0.6711), part(i, 0.5497)) * part(i, 0.415);
        let boxes: Vec<Aabb> = (0..3000).map(|i| Aabb::new(corner(i), corner(i) + size(i))).collect();
        let mut tree = Clusters::new(&boxes, Stop::NEVER).expect("nobody stops it");
        let before = cost(&tree);
        improve(&mut tree, Stop::NEVER).expect("nobody stops it");
        check(&tree);
        let after = cost(&tree);
        assert!(after < 0.99 * before, "{before} became {after}");
    }

    #[test]
    fn a_box_in_the_wrong_place_finds_the_right_one() {
        let at = |x: f32| Aabb::new(Vec3A::splat(x), Vec3A::splat(x + 1.0));
        // 0 and 100 together, 101 and 1 together.
        let mut tree =
            Clusters { bounds: [0.0, 100.0, 101.0, 1.0].map(at).into(), children: vec![[NONE; 2]; 4], root: 6 };
        for [a, b] in [[0, 1], [2, 3], [4, 5]] {
            tree.bounds.push(tree.bounds[a as usize].union(&tree.bounds[b as usize]));
            tree.children.push([a, b]);
        }
        let before = cost(&tree);
        Moves::new(&mut tree).move_node(0);
        check(&tree);
        let after = cost(&tree);
        assert!(after < 0.7 * before, "{before} became {after}");
        // There it stays.
        Moves::new(&mut tree).move_node(0);
        check(&tree);
        assert_eq!(cost(&tree), after);
    }

    #[test]
    fn boxes_without_end_do_no_harm() {
        let mut tree =
            Clusters::new(&[Aabb::new(Vec3A::splat(-3e38), Vec3A::splat(3e38)); 100], Stop::NEVER).expect("goes on");
        improve(&mut tree, Stop::NEVER).expect("nobody stops it");
        check(&tree);
    }
}
