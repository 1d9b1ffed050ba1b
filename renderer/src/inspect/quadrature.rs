//! Adaptive quadrature over the directions of all lights: where the integrand is asked, until every estimator's moments
//! are known to the tolerance.
//!
//! Cells of a [`Chart`] hold 5 x 5 Gauss nodes. They are first made small against the specular lobe near its peak, which
//! then cannot slip between nodes; after that the cell with the largest error is cut in two, across the worse axis.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::Vec3;

use super::cell::{ASKED, Cell, K, halves};
use super::chart::Chart;
use super::node::Node;
use super::point::Point;

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
/// What all cells found.
pub(super) struct Cells {
    /// Those from which light comes.
    pub list: Vec<Cell>,
    /// Index of the light by [`Cell::chart`].
    pub lights: Vec<usize>,
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
    let per_light = accuracy.evaluations / (4 * ASKED * integrator.charts.len().max(1));
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

    /// Asks the integrand all over a cell.
    fn cell(&mut self, chart: usize, corner: [f64; 2], side: [f64; 2]) -> Cell {
        self.evaluations += ASKED;
        Cell::new(chart, corner, side, |at, area| self.node(chart, at, area))
    }

    /// Cuts cells until the errors are small.
    fn refine(mut self, accuracy: &Accuracy) -> Cells {
        let mut sums = Sums::default();
        for cell in &self.cells {
            sums.add(cell, 1.0);
        }
        let mut queue: BinaryHeap<Waiting> = BinaryHeap::new();
        queue.extend(self.cells.iter().enumerate().map(|(index, cell)| sums.waiting(cell, index)));
        while sums.relative_error() > accuracy.relative_error && self.evaluations + 2 * ASKED <= self.most {
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
        let lights = self.charts.iter().map(|(light, _)| *light).collect();
        Cells { list: self.cells, lights, evaluations, relative_error }
    }
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
