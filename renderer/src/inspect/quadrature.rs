//! Adaptive quadrature over the directions of all lights: where the integrand is asked, until every estimator's moments
//! are known to the tolerance.
//!
//! Cells of a [`Chart`] hold 5 x 5 Gauss nodes. They are first made small against the specular lobe near its peak, which
//! then cannot slip between nodes; after that the cell with the largest error is cut in two, across the worse axis.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::Vec3;

use super::chart::Chart;
use super::luminance;
use super::point::Point;
use super::rule::{DIFFERENCE, FOURTH, N, NODES, W, X};
use super::table::Node;

/// How exactly to integrate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Error aimed at, relative to the integrals of f and of its squares over the densities.
    pub relative_error: f64,
    /// Most directions to ask about; the error may then be larger.
    pub evaluations: usize,
}

impl Default for Accuracy {
    fn default() -> Self {
        Self { relative_error: 2e-5, evaluations: 200_000 }
    }
}

/// Quantities that are looked at for errors, see [`features`].
const K: usize = 8;
/// Smallest side of a cell.
const FINEST: f64 = 1.0 / 65_536.0;
/// Largest cell near the lobe's peak, in units of its width or of the distance to the peak.
const GRADING: f64 = 0.75;
/// Largest term of degree 4 that is left in the logarithm of p_L / p_B within a cell: where a heuristic jumps is read from
/// the polynomial through the nodes.
const BEND: f64 = 5e-4;
/// A term this large is the edge of another light, where p_L jumps.
const JUMP: f64 = 0.1;
/// Smallest side of a cell that is cut for its bend.
const FINEST_BENT: f64 = 1.0 / 1024.0;
/// Least error of a cell that the edge of a light or shadow crosses, in units of its content.
const EDGE: f64 = 0.05;

/// A part of a light's directions.
pub(super) struct Cell {
    chart: usize,
    corner: [f64; 2],
    side: [f64; 2],
    pub nodes: [Node; NODES],
    content: [f64; K],
    error: [f64; K],
    /// True where light comes from some of its directions only, or another light's edge is among them.
    pub rough: bool,
    /// The axis along which the error is larger.
    axis: usize,
}

impl Cell {
    fn is_dark(&self) -> bool {
        self.content[0] == 0.0
    }

    /// Largest terms of degree 4 along either axis in the logarithm of p_L / p_B; 0 where light does not come from all of it.
    fn bends(&self) -> [f64; 2] {
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

/// What all cells found.
pub(super) struct Cells {
    /// Those from which light comes.
    pub list: Vec<Cell>,
    /// Directions asked about.
    pub evaluations: usize,
    /// Estimated error, the largest of all quantities that are looked at.
    pub relative_error: f64,
}

struct Integrator<'a> {
    point: &'a Point<'a>,
    /// Index of the light, and its directions.
    charts: Vec<(usize, Chart)>,
    several: bool,
    /// Peak and width of the specular lobe, if there is one.
    lobe: Option<(Vec3, f32)>,
    cells: Vec<Cell>,
    evaluations: usize,
    /// Most evaluations.
    most: usize,
}

/// Cells over all lights.
pub(super) fn integrate(point: &Point<'_>, accuracy: &Accuracy) -> Cells {
    let lights = &point.scene.lights.list;
    let position = point.position();
    let charts: Vec<_> =
        lights.iter().enumerate().filter_map(|(i, light)| Some((i, Chart::new(light, position)?))).collect();
    let cos = point.normal().dot(point.wo()).max(0.1);
    let lobe = point.alpha().filter(|_| !point.is_mirror()).map(|alpha| (point.mirrored(), 2.0 * alpha * cos));
    let mut integrator = Integrator {
        point,
        several: lights.len() > 1,
        lobe,
        cells: Vec::new(),
        evaluations: 0,
        most: accuracy.evaluations,
        charts,
    };
    // A quarter of all evaluations for the start.
    let per_light = accuracy.evaluations / (4 * (NODES + 4) * integrator.charts.len().max(1));
    for chart in 0..integrator.charts.len() {
        let [columns, rows] = integrator.charts[chart].1.grid(per_light);
        let side = [1.0 / columns as f64, 1.0 / rows as f64];
        for i in 0..columns * rows {
            let corner = [(i % columns) as f64 * side[0], (i / columns) as f64 * side[1]];
            integrator.seed(chart, corner, side);
        }
    }
    integrator.refine(accuracy)
}

impl Integrator<'_> {
    /// Cells from `corner` on, small against the lobe.
    fn seed(&mut self, chart: usize, corner: [f64; 2], side: [f64; 2]) {
        if let Some((peak, width)) = self.lobe {
            let at = |u: f64, v: f64| {
                self.charts[chart].1.direction([corner[0] + u * side[0], corner[1] + v * side[1]]).0.as_vec3()
            };
            let middle = at(0.5, 0.5);
            let across = [at(0.0, 0.5).distance(at(1.0, 0.5)), at(0.5, 0.0).distance(at(0.5, 1.0))];
            let reach = [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(1.0, 1.0), at(1.0, 0.5)]
                .iter()
                .map(|corner| corner.distance(middle))
                .fold(0.0, f32::max);
            let to_peak = (middle.distance(peak) - reach).max(0.0);
            if 2.0 * reach > GRADING as f32 * to_peak.max(width) && side[0].min(side[1]) > FINEST {
                let axis = usize::from(across[1] > across[0]);
                for (corner, side) in halves(corner, side, axis) {
                    self.seed(chart, corner, side);
                }
                return;
            }
        }
        let cell = self.cell(chart, corner, side);
        let bends = cell.bends();
        let axis = usize::from(bends[1] > bends[0]);
        // What jumps does not become smooth by cutting; it is left to `refine`.
        let bends = bends[axis] > BEND && bends[axis] < JUMP;
        if bends && side[axis] > FINEST_BENT && self.evaluations < self.most / 2 {
            for (corner, side) in halves(corner, side, axis) {
                self.seed(chart, corner, side);
            }
            return;
        }
        self.cells.push(cell);
    }

    /// The integrand at a point of the square, which stands for so much of its area.
    fn node(&self, chart: usize, at: [f64; 2], area: f64) -> Node {
        let (light, directions) = &self.charts[chart];
        let (wi, stretch) = directions.direction(at);
        let wi = wi.as_vec3();
        if self.point.normal().dot(wi) <= 0.0 {
            return Node::DARK;
        }
        let x = self.point.integrand(wi, false);
        if x.f.element_sum() <= 0.0 || (self.several && self.point.light_in_front(wi) != *light) {
            return Node::DARK;
        }
        Node::new(area * stretch, x.f, x.p_light, x.p_bsdf)
    }

    /// Asks the integrand at the nodes of a cell, and at its corners.
    fn cell(&mut self, chart: usize, corner: [f64; 2], side: [f64; 2]) -> Cell {
        self.evaluations += NODES + 4;
        let mut nodes = [Node::DARK; NODES];
        let (mut content, mut differences) = ([0.0; K], [[0.0; K]; 2]);
        let mut lit = 0;
        for (k, node) in nodes.iter_mut().enumerate() {
            let (i, j) = (k / N, k % N);
            let at = [corner[0] + X[i] * side[0], corner[1] + X[j] * side[1]];
            *node = self.node(chart, at, W[i] * W[j] * side[0] * side[1]);
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
            let end = self.node(chart, at, side[0] * side[1]);
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
        let axis = usize::from(worst[1] * side[1].sqrt() > worst[0] * side[0].sqrt());
        Cell { chart, corner, side, nodes, content, error, rough, axis }
    }

    /// Cuts cells until the errors are small.
    fn refine(mut self, accuracy: &Accuracy) -> Cells {
        let mut sums = Sums::default();
        for cell in &self.cells {
            sums.add(cell, 1.0);
        }
        let mut queue: BinaryHeap<Waiting> = BinaryHeap::new();
        queue.extend(self.cells.iter().enumerate().map(|(index, cell)| sums.waiting(cell, index)));
        while sums.relative_error() > accuracy.relative_error && self.evaluations + 2 * (NODES + 4) <= self.most {
            let Some(Waiting { error, index }) = queue.pop() else { break };
            if error <= 0.0 {
                break;
            }
            let Cell { chart, corner, side, axis, .. } = self.cells[index];
            sums.add(&self.cells[index], -1.0);
            let [first, second] = halves(corner, side, axis).map(|(corner, side)| self.cell(chart, corner, side));
            for (index, cell) in [(index, first), (self.cells.len(), second)] {
                sums.add(&cell, 1.0);
                queue.push(sums.waiting(&cell, index));
                if index < self.cells.len() {
                    self.cells[index] = cell;
                } else {
                    self.cells.push(cell);
                }
            }
        }
        let (evaluations, relative_error) = (self.evaluations, sums.relative_error());
        self.cells.retain(|cell| !cell.is_dark());
        Cells { list: self.cells, evaluations, relative_error }
    }
}

/// The two halves of a cell.
fn halves(corner: [f64; 2], mut side: [f64; 2], axis: usize) -> [([f64; 2], [f64; 2]); 2] {
    side[axis] *= 0.5;
    let mut other = corner;
    other[axis] += side[axis];
    [(corner, side), (other, side)]
}

/// What is to be exact: f, its squares over either density and over their sum, what balance and power heuristics make of
/// them, and the probabilities to meet a light.
fn features(node: &Node) -> [f64; K] {
    let (y, l, b) = (node.y, f64::from(node.p[0]), f64::from(node.p[1]));
    let over = |p: f64| if p > 0.0 { y * y / p } else { 0.0 };
    let (l2, b2) = (l * l, b * b);
    let share = if l > 0.0 { l / (l + b) } else { 0.0 };
    let power = if l2 + b2 > 0.0 { y * y * (l * l2 + b * b2) / (l2 + b2).powi(2) } else { 0.0 };
    [y, over(l), over(b), over(l + b), y * share, power, l, b].map(|feature| feature * node.dw)
}

/// Running totals over all cells.
#[derive(Default)]
struct Sums {
    content: [f64; K],
    smooth: [f64; K],
    /// Errors of cells that an edge crosses have either sign: their squares add up.
    rough: [f64; K],
}

impl Sums {
    fn add(&mut self, cell: &Cell, sign: f64) {
        for q in 0..K {
            self.content[q] += sign * cell.content[q];
            if cell.rough {
                self.rough[q] += sign * cell.error[q].powi(2);
            } else {
                self.smooth[q] += sign * cell.error[q];
            }
        }
    }

    fn relative_error(&self) -> f64 {
        let of = |q: usize| {
            let error = self.smooth[q].max(0.0) + 4.0 * self.rough[q].max(0.0).sqrt();
            if self.content[q] > 0.0 { error / self.content[q] } else { 0.0 }
        };
        (0..K).map(of).fold(0.0, f64::max)
    }

    /// The cell's place in the queue: its largest error in units of the totals.
    fn waiting(&self, cell: &Cell, index: usize) -> Waiting {
        let of = |q: usize| if self.content[q] > 0.0 { cell.error[q] / self.content[q] } else { 0.0 };
        let error = if cell.side[cell.axis] <= FINEST { 0.0 } else { (0..K).map(of).fold(0.0, f64::max) };
        Waiting { error, index }
    }
}

/// A cell that may be cut, by error.
struct Waiting {
    error: f64,
    index: usize,
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        self.error.total_cmp(&other.error).then(self.index.cmp(&other.index))
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Waiting {}

impl Node {
    /// Nothing comes from there.
    const DARK: Self = Self { dw: 0.0, y: 0.0, f: Vec3::ZERO, p: [0.0; 2] };

    fn new(dw: f64, f: Vec3, p_light: f32, p_bsdf: f32) -> Self {
        Self { dw, y: luminance(f.as_dvec3()), f, p: [p_light, p_bsdf] }
    }
}
