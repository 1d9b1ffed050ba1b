//! Binary trees of usual scenes, built by the crate obvhs: locally ordered clustering, then reinsertion of the largest nodes.

use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

use super::clusters::{Clusters, NONE};

/// Most boxes of a tree that obvhs builds. It cannot be stopped, and where many boxes are equal its time is quadratic: about 50 ms
/// for so many.
pub(super) const MOST: usize = 1024;

/// Over boxes, at least one.
pub(super) fn build(boxes: &[Aabb]) -> Clusters {
    let indices = (0..boxes.len() as u32).collect();
    let mut builder = PlocBuilder::with_capacity(boxes.len());
    let mut tree = builder.build(PlocSearchDistance::High, boxes, indices, SortPrecision::U64, 0);
    ReinsertionOptimizer::default().run(&mut tree, 0.05, None);
    renumbered(&tree, boxes)
}

/// With the leaves first, by the number of their box, and nodes after both of their children.
fn renumbered(tree: &Bvh2, boxes: &[Aabb]) -> Clusters {
    let mut found = Clusters { bounds: boxes.to_vec(), children: vec![[NONE; 2]; boxes.len()], root: 0 };
    // Down on the way in, up on the way out: a node is there twice, the second time marked.
    const OUT: u32 = 1 << 31;
    let mut stack = vec![0];
    let mut done: Vec<u32> = Vec::new();
    while let Some(at) = stack.pop() {
        let node = &tree.nodes[(at & !OUT) as usize];
        if at & OUT != 0 {
            let (second, first) = (done.pop(), done.pop());
            found.children.push([first, second].map(|child| child.expect("both children are done")));
            done.push(found.bounds.len() as u32);
            found.bounds.push(node.aabb);
        } else if node.prim_count > 0 {
            done.push(tree.primitive_indices[node.first_index as usize]);
        } else {
            stack.extend([at | OUT, node.first_index + 1, node.first_index]);
        }
    }
    found.root = done[0];
    found
}
