//! Adaptive quadrature over the unit square that keeps its nodes, so that one refinement serves
//! every integral that is later asked for.

/// Abscissae and weights of the four-point Gauss-Legendre rule on [0, 1].
pub(crate) const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// Smallest side of a cell: where something jumps, refinement ends here.
const FINEST: f64 = 1.0 / 16_384.0;

/// A square part of the domain with its nodes and what they sum to.
struct Cell<N, const K: usize> {
    corner: [f64; 2],
    side: f64,
    nodes: Vec<N>,
    sums: [f64; K],
}

/// Something to be integrated over the unit square: `node` turns a point and its weight into a node
/// (or `None` where there is nothing), `features` are the K numbers whose sums decide where to refine.
pub trait Domain<const K: usize> {
    /// What a node holds; its weight included.
    type Node;
    /// The node at a point of the square.
    fn node(&self, at: [f64; 2], weight: f64) -> Option<Self::Node>;
    /// What refinement looks at; jumps belong in here as well.
    fn features(&self, node: &Self::Node) -> [f64; K];
}

/// Nodes over all `domains`. A cell is split until its features and the sums over its four quarters
/// differ by at most `tolerance` of the features' totals.
pub fn nodes<D: Domain<K>, const K: usize>(domains: &[D], cells_per_side: usize, tolerance: f64) -> Vec<D::Node> {
    let mut coarse = Vec::new();
    let mut totals = [0.0f64; K];
    for domain in domains {
        let side = 1.0 / cells_per_side as f64;
        for i in 0..cells_per_side * cells_per_side {
            let corner = [(i % cells_per_side) as f64 * side, (i / cells_per_side) as f64 * side];
            let cell = evaluate(domain, corner, side);
            for (total, sum) in totals.iter_mut().zip(cell.sums) {
                *total += sum;
            }
            coarse.push((domain, cell));
        }
    }
    let limits = totals.map(|total| tolerance * total);
    let mut result = Vec::new();
    for (domain, cell) in coarse {
        refine(domain, cell, &limits, &mut result);
    }
    result
}

fn evaluate<D: Domain<K>, const K: usize>(domain: &D, corner: [f64; 2], side: f64) -> Cell<D::Node, K> {
    let mut cell = Cell { corner, side, nodes: Vec::with_capacity(16), sums: [0.0; K] };
    for (x, wx) in GAUSS {
        for (y, wy) in GAUSS {
            let at = [corner[0] + x * side, corner[1] + y * side];
            if let Some(node) = domain.node(at, wx * wy * side * side) {
                for (sum, feature) in cell.sums.iter_mut().zip(domain.features(&node)) {
                    *sum += feature;
                }
                cell.nodes.push(node);
            }
        }
    }
    cell
}

fn refine<D: Domain<K>, const K: usize>(
    domain: &D,
    cell: Cell<D::Node, K>,
    limits: &[f64; K],
    result: &mut Vec<D::Node>,
) {
    let side = cell.side / 2.0;
    let quarters = [[0.0, 0.0], [side, 0.0], [0.0, side], [side, side]]
        .map(|[x, y]| evaluate(domain, [cell.corner[0] + x, cell.corner[1] + y], side));
    let settled = (0..K).all(|k| {
        let sum: f64 = quarters.iter().map(|q| q.sums[k]).sum();
        (sum - cell.sums[k]).abs() <= limits[k]
    });
    for quarter in quarters {
        if settled || side <= FINEST {
            result.extend(quarter.nodes);
        } else {
            refine(domain, quarter, limits, result);
        }
    }
}
