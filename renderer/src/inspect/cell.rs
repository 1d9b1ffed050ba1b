//! A part of a light's directions: 5 x 5 Gauss nodes, and what they say about its error.

use super::node::Node;
use super::rule::{DIFFERENCE, FOURTH, N, NODES, W, X};

/// Quantities that are looked at for errors, see [`features`].
pub(super) const K: usize = 8;
/// Directions that a cell asks about: its nodes and corners.
pub(super) const ASKED: usize = NODES + 4;
/// Least error of a cell that the edge of a light or shadow crosses, in units of its content.
const EDGE: f64 = 0.05;

/// A part of a light's directions.
pub(super) struct Cell {
    pub chart: usize,
    pub corner: [f64; 2],
    pub side: [f64; 2],
    pub nodes: [Node; NODES],
    pub content: [f64; K],
    pub error: [f64; K],
    /// True where light comes from some of its directions only, or another light's edge is among them.
    pub rough: bool,
    /// The axis along which the error is larger.
    pub axis: usize,
}

impl Cell {
    /// Asks for the integrand at the nodes and at the corners, each with a share of the square's area to stand for.
    pub fn new(chart: usize, corner: [f64; 2], side: [f64; 2], ask: impl Fn([f64; 2], f64) -> Node) -> Self {
        let mut nodes = [Node::DARK; NODES];
        let (mut content, mut differences) = ([0.0; K], [[0.0; K]; 2]);
        let mut lit = 0;
        for (k, node) in nodes.iter_mut().enumerate() {
            let (i, j) = (k / N, k % N);
            let at = [corner[0] + X[i] * side[0], corner[1] + X[j] * side[1]];
            *node = ask(at, W[i] * W[j] * side[0] * side[1]);
            lit += usize::from(node.dw > 0.0);
            for (q, feature) in features(node).into_iter().enumerate() {
                content[q] += feature;
                differences[0][q] += DIFFERENCE[i] * feature;
                differences[1][q] += DIFFERENCE[j] * feature;
            }
        }
        // An edge may pass between the nodes and the cell's own corners.
        let mut least = [0.0f64; K];
        let mut rough = lit != 0 && lit != NODES;
        for (u, v) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let at = [corner[0] + f64::from(u as u8) * side[0], corner[1] + f64::from(v as u8) * side[1]];
            let end = ask(at, side[0] * side[1]);
            let next = &nodes[u * (N - 1) * N + v * (N - 1)];
            let jumps = end.p[0] > 1.5 * next.p[0] || next.p[0] > 1.5 * end.p[0];
            rough |= (end.y > 0.0) != (next.y > 0.0) || (end.y > 0.0 && jumps);
            for (least, feature) in least.iter_mut().zip(features(&end)) {
                *least = least.max(EDGE * feature);
            }
        }
        let mut error = [0.0; K];
        let mut worst = [0.0f64; 2];
        for q in 0..K {
            if content[q] > 0.0 {
                let relative = differences.map(|d| d[q].abs() / content[q]);
                worst = [0, 1].map(|axis| worst[axis].max(relative[axis]));
                let sum = relative[0] + relative[1];
                // Where the integrand is smooth, terms of degree 4 are left out by the coarse rule, those of degree 10 by
                // the fine one.
                error[q] = content[q] * if rough { sum.max(EDGE) } else { sum * sum.min(1.0) };
            }
            if rough {
                error[q] = error[q].max(least[q]);
            }
        }
        // Where nothing is known yet, the longer one.
        let by_axis = if worst == [0.0; 2] { side } else { [0, 1].map(|axis| worst[axis] * side[axis].sqrt()) };
        let axis = usize::from(by_axis[1] > by_axis[0]);
        Self { chart, corner, side, nodes, content, error, rough, axis }
    }

    /// True if nothing comes from there, as far as its nodes know.
    pub fn is_dark(&self) -> bool {
        self.content[0] == 0.0
    }

    /// Largest terms of degree 4 along either axis in the logarithm of p_L / p_B; 0 where light does not come from all of it.
    pub fn bends(&self) -> [f64; 2] {
        let mut bends = [0.0f64; 2];
        if self.is_dark() || self.rough || self.nodes.iter().any(|node| node.p[0].min(node.p[1]) <= 0.0) {
            return bends;
        }
        let g = self.nodes.map(|node| node.odds());
        for k in 0..N {
            let along = |step: usize, next: usize| (0..N).map(|i| FOURTH[i] * g[i * step + k * next]).sum::<f64>();
            bends = [bends[0].max(along(N, 1).abs()), bends[1].max(along(1, N).abs())];
        }
        bends
    }

    /// True if polynomials through the nodes tell what is between them.
    pub fn is_smooth(&self) -> bool {
        !self.rough && (0..K).all(|k| self.error[k] <= 1e-3 * self.content[k])
    }
}

/// The two halves of a cell.
pub(super) fn halves(corner: [f64; 2], mut side: [f64; 2], axis: usize) -> [([f64; 2], [f64; 2]); 2] {
    side[axis] *= 0.5;
    let mut other = corner;
    other[axis] += side[axis];
    [(corner, side), (other, side)]
}

/// What is to be exact: f, its squares over either density and over their sum, what balance and power heuristics make of
/// them, and the probabilities to hit a light.
fn features(node: &Node) -> [f64; K] {
    let (y, l, b) = (node.y, f64::from(node.p[0]), f64::from(node.p[1]));
    let over = |p: f64| if p > 0.0 { y * y / p } else { 0.0 };
    let (l2, b2) = (l * l, b * b);
    let share = if l > 0.0 { l / (l + b) } else { 0.0 };
    let power = if l2 + b2 > 0.0 { y * y * (l * l2 + b * b2) / (l2 + b2).powi(2) } else { 0.0 };
    [y, over(l), over(b), over(l + b), y * share, power, l, b].map(|feature| feature * node.dw)
}
