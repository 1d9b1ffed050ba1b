//! The integrand and both densities of one point, tabulated over the directions of all lights.

use glam::{DVec3, Vec3};
use mislab_kernel::request::Estimator;

use super::direction::Direction;
use super::luminance;
use super::node::Node;
use super::point::Point;
use super::quadrature::{Accuracy, integrate};
use super::rule::{N, NODES, W, range, split};
use super::weights::{Share, Weigh as _};

/// A part of a light's directions between whose nodes polynomials tell everything.
struct Smooth {
    nodes: [Node; NODES],
    /// Of the logarithm of p_L / p_B.
    range: [f64; 2],
}

/// The integrand of one [`Point`] over the directions of all lights, and over a mirror's one direction.
///
/// All moments of all estimators follow from it: with f and p in place of the sample's,
///
/// ```text
/// light, bsdf   E Y^k = int p_t (f / p_t)^k
/// mis_all       Y = X_L + X_B, independent,   E X_t^k = int p_t (w_t f / p_t)^k      (Veach 1997, eq. 9.4)
/// mis           E Y^k = sum over t of  int c_t p_t (w_t f / (c_t p_t))^k             (Veach 1997, eq. 9.15)
/// ```
pub struct Table {
    smooth: Vec<Smooth>,
    /// Directions that weigh what they say: those of cells with edges in them, and a mirror's.
    single: Vec<Node>,
    /// Luminance by light of the built scene.
    by_light: Vec<f64>,
    evaluations: usize,
    relative_error: f64,
}

impl Point<'_> {
    /// Tabulates the integrand. With the default accuracy a few milliseconds.
    pub fn tabulate(&self, accuracy: &Accuracy) -> Table {
        let cells = integrate(self, accuracy);
        let mut table = Table {
            smooth: Vec::new(),
            single: Vec::new(),
            by_light: vec![0.0; self.scene.lights.list.len()],
            evaluations: cells.evaluations,
            relative_error: cells.relative_error,
        };
        for cell in cells.list {
            table.by_light[cells.lights[cell.chart]] += cell.nodes.iter().map(|node| node.y * node.dw).sum::<f64>();
            if cell.is_smooth() && cell.nodes.iter().all(|node| node.p[0] > 0.0 && node.p[1] > 0.0) {
                table.smooth.push(Smooth { nodes: cell.nodes, range: range(&cell.nodes.map(|node| node.odds())) });
            } else {
                table.single.extend(cell.nodes.into_iter().filter(|node| node.dw > 0.0));
            }
        }
        table.add_mirror(self);
        table
    }
}

impl Table {
    /// From directions that weigh what they say, each with the index of its light; a mirror's is added.
    pub(super) fn of_nodes(point: &Point<'_>, nodes: Vec<(usize, Node)>, evaluations: usize, error: f64) -> Self {
        let mut by_light = vec![0.0; point.scene.lights.list.len()];
        for (light, node) in &nodes {
            by_light[*light] += node.y * node.dw;
        }
        let single = nodes.into_iter().map(|(_, node)| node).collect();
        let mut table = Self { smooth: Vec::new(), single, by_light, evaluations, relative_error: error };
        table.add_mirror(point);
        table
    }

    /// The one direction of a mirror.
    fn add_mirror(&mut self, point: &Point<'_>) {
        if let Some(Direction { f, p_bsdf, hit: Some(hit), .. }) = point.mirror().filter(|m| m.f != Vec3::ZERO) {
            let y = luminance(f.as_dvec3());
            self.by_light[hit.light] += y;
            self.single.push(Node { dw: 1.0, y, f, p: [0.0, p_bsdf] });
        }
    }

    /// Luminance of the reflected radiance that comes from each light of the built scene, by index.
    pub fn by_light(&self) -> &[f64] {
        &self.by_light
    }

    /// All directions, those of smooth parts included; what they weigh is right for functions without jumps.
    pub(super) fn nodes(&self) -> impl Iterator<Item = &Node> {
        self.single.iter().chain(self.smooth.iter().flat_map(|cell| &cell.nodes))
    }

    /// Directions that were asked about.
    pub fn evaluations(&self) -> usize {
        self.evaluations
    }

    /// Estimated error of integrals over all directions, relative to them: of f, of its square over either density and
    /// over their sum, and others. Single precision (1e-6, more in the narrowest lobes) is not in it.
    pub fn relative_error(&self) -> f64 {
        self.relative_error
    }

    /// The reflected radiance itself, per channel: the integral of f.
    pub fn radiance(&self) -> DVec3 {
        self.nodes().map(|node| node.f.as_dvec3() * node.dw).sum()
    }

    /// Calls `visit` with every direction, the solid angle that it stands for (of a mirror 1; where a heuristic jumps it
    /// may be negative) and what the estimator makes of it, light and BSDF.
    pub(super) fn visit(&self, estimator: &Estimator, mut visit: impl FnMut(&Node, f64, [Share; 2])) {
        for node in &self.single {
            visit(node, node.dw, estimator.weigh(node.p));
        }
        let (cuts, sides) = estimator.jumps();
        for Smooth { nodes, range: [min, max] } in &self.smooth {
            if !cuts.iter().any(|cut| min < cut && cut < max) {
                for node in nodes {
                    visit(node, node.dw, estimator.weigh(node.p));
                }
                continue;
            }
            for (weights, &side) in split(&nodes.map(|node| node.odds()), &cuts).iter().zip(sides) {
                if weights.iter().all(|&weight| weight == 0.0) {
                    continue;
                }
                for (k, node) in nodes.iter().enumerate() {
                    let part = weights[k] / (W[k / N] * W[k % N]);
                    visit(node, node.dw * part, estimator.weigh_on(side, node.p));
                }
            }
        }
    }
}
