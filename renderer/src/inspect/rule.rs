//! The five-point Gauss-Legendre rule on [0, 1], its square, and the square cut along a curve.

/// Points per axis.
pub(super) const N: usize = 5;
/// Points of the square rule, `i * N + j` for the i-th u and the j-th v.
pub(super) const NODES: usize = N * N;

/// Abscissae.
pub(super) const X: [f64; N] =
    [0.046_910_077_030_668, 0.230_765_344_947_158_45, 0.5, 0.769_234_655_052_841_5, 0.953_089_922_969_332];

/// Weights.
pub(super) const W: [f64; N] = [
    0.118_463_442_528_094_54,
    0.239_314_335_249_683_23,
    0.284_444_444_444_444_44,
    0.239_314_335_249_683_23,
    0.118_463_442_528_094_54,
];

/// Weights of the rule of degree 3 on the same abscissae: what it says differently is the error.
const COARSE: [f64; N] = [0.202_964_438_547_983_2, 0.0, 0.594_071_122_904_033_6, 0.0, 0.202_964_438_547_983_2];

/// By abscissa, what turns a sum by the rule into the difference of the coarse one.
pub(super) const DIFFERENCE: [f64; N] = {
    let mut difference = [0.0; N];
    let mut i = 0;
    while i < N {
        difference[i] = COARSE[i] / W[i] - 1.0;
        i += 1;
    }
    difference
};

/// By abscissa, what makes of values there the coefficient of the Legendre polynomial of degree 4.
pub(super) const FOURTH: [f64; N] = {
    let mut weights = [0.0; N];
    let mut i = 0;
    while i < N {
        let x2 = (2.0 * X[i] - 1.0) * (2.0 * X[i] - 1.0);
        weights[i] = 9.0 * W[i] * (35.0 * x2 * x2 - 30.0 * x2 + 3.0) / 8.0;
        i += 1;
    }
    weights
};

/// Error of the area of a strip's parts at which it is no longer halved.
const AREA: f64 = 1e-6;
/// How often it is halved at most.
const DEPTH: u32 = 6;
/// Steps in which roots are looked for on a line.
const STEPS: usize = 8;

/// The polynomials that are 1 at one abscissa and 0 at the others (Lagrange), at x.
pub(super) fn basis(x: f64) -> [f64; N] {
    X.map(|at| X.iter().filter(|&&other| other != at).map(|other| (x - other) / (at - other)).product())
}

fn along(line: &[f64; N], x: f64) -> f64 {
    basis(x).iter().zip(line).map(|(b, g)| b * g).sum()
}

/// Smallest and largest value on the square of what is known at the nodes, its edges included, with some to spare.
pub(super) fn range(g: &[f64; NODES]) -> [f64; 2] {
    let (mut min, mut max) = (f64::INFINITY, f64::NEG_INFINITY);
    let ends = [0.0, X[1], X[2], X[3], 1.0].map(basis);
    for u in &ends {
        for v in &ends {
            let mut value = 0.0;
            for i in 0..N {
                for j in 0..N {
                    value += u[i] * v[j] * g[i * N + j];
                }
            }
            (min, max) = (min.min(value), max.max(value));
        }
    }
    let spare = 0.1 * (max - min);
    [min - spare, max + spare]
}

/// Weights of the nodes for integrals over the parts of the square where g, known at the nodes, lies before, between and
/// after the `cuts`, which rise: one part more than cuts. Exact where g and the integrand are polynomials of degree 4, but
/// for what is left of the parts' areas where a curve ends: [`AREA`].
pub(super) fn split(g: &[f64; NODES], cuts: &[f64]) -> Vec<[f64; NODES]> {
    // Lines run along the axis in which g changes more, so that they cross the curves.
    let change = |step: usize, next: usize| {
        let at = |i: usize, j: usize| g[i * next + j * step];
        (0..N).flat_map(|i| (1..N).map(move |j| (i, j))).map(|(i, j)| (at(i, j) - at(i, j - 1)).abs()).sum::<f64>()
    };
    let (step, next) = if change(1, N) >= change(N, 1) { (1, N) } else { (N, 1) };
    let strips = Strips { g, cuts, step, next };
    strips.refine(strips.parts(0.0, 1.0), (0.0, 1.0), 0)
}

type Parts = Vec<[f64; NODES]>;

/// A square cut into strips, and each strip by curves.
struct Strips<'a> {
    g: &'a [f64; NODES],
    cuts: &'a [f64],
    /// From node to node along a line, and from line to line.
    step: usize,
    next: usize,
}

impl Strips<'_> {
    /// The parts of a strip, halved until their areas are known.
    fn refine(&self, whole: Parts, (a, b): (f64, f64), depth: u32) -> Parts {
        let middle = 0.5 * (a + b);
        let [first, second] = [self.parts(a, middle), self.parts(middle, b)];
        let area = |part: &[f64; NODES]| part.iter().sum::<f64>();
        let settled = (0..whole.len()).all(|k| (area(&whole[k]) - area(&first[k]) - area(&second[k])).abs() <= AREA);
        if settled || depth >= DEPTH {
            return sum(first, &second);
        }
        sum(self.refine(first, (a, middle), depth + 1), &self.refine(second, (middle, b), depth + 1))
    }

    /// The parts of the strip between a and b, by the lines at its abscissae.
    fn parts(&self, a: f64, b: f64) -> Parts {
        let mut parts = vec![[0.0; NODES]; self.cuts.len() + 1];
        for (x, w) in X.into_iter().zip(W) {
            let (outer, weight) = (basis(a + (b - a) * x), w * (b - a));
            let mut line = [0.0; N];
            for (j, value) in line.iter_mut().enumerate() {
                *value = (0..N).map(|i| outer[i] * self.g[i * self.next + j * self.step]).sum();
            }
            let mut ends = vec![0.0, 1.0];
            for &cut in self.cuts {
                roots(&line, cut, &mut ends);
            }
            ends.sort_by(f64::total_cmp);
            for pair in ends.windows(2) {
                let length = pair[1] - pair[0];
                let middle = along(&line, 0.5 * (pair[0] + pair[1]));
                let part = &mut parts[self.cuts.iter().filter(|&&cut| cut <= middle).count()];
                for (y, w) in X.into_iter().zip(W) {
                    let inner = basis(pair[0] + length * y);
                    for i in 0..N {
                        for j in 0..N {
                            part[i * self.next + j * self.step] += weight * outer[i] * w * length * inner[j];
                        }
                    }
                }
            }
        }
        parts
    }
}

fn sum(mut a: Parts, b: &Parts) -> Parts {
    for (a, b) in a.iter_mut().flatten().zip(b.iter().flatten()) {
        *a += b;
    }
    a
}

/// Adds where the polynomial through `line` passes `level`.
fn roots(line: &[f64; N], level: f64, to: &mut Vec<f64>) {
    let value = |x: f64| along(line, x) - level;
    let (mut a, mut at_a) = (0.0, value(0.0));
    for k in 1..=STEPS {
        let b = k as f64 / STEPS as f64;
        let at_b = value(b);
        if (at_a < 0.0) != (at_b < 0.0) {
            to.push(root(&value, (a, at_a), (b, at_b)));
        }
        (a, at_a) = (b, at_b);
    }
}

/// A root between two points of different sign, by false position (Illinois).
fn root(value: &impl Fn(f64) -> f64, mut a: (f64, f64), mut b: (f64, f64)) -> f64 {
    let mut x = a.0;
    for _ in 0..20 {
        x = (a.0 * b.1 - b.0 * a.1) / (b.1 - a.1);
        let at = value(x);
        if at.abs() < 1e-10 {
            break;
        }
        if (at < 0.0) == (b.1 < 0.0) {
            a.1 *= 0.5;
        } else {
            a = b;
        }
        b = (x, at);
    }
    x.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rule_has_degree_nine() {
        for k in 0..10 {
            let sum: f64 = X.iter().zip(W).map(|(x, w)| w * x.powi(k)).sum();
            assert!((sum - 1.0 / f64::from(k + 1)).abs() < 1e-14, "x^{k}: {sum}");
        }
        let coarse: f64 = X.iter().zip(COARSE).map(|(x, w)| w * x.powi(3)).sum();
        assert!((coarse - 0.25).abs() < 1e-14, "{coarse}");
    }

    #[test]
    fn a_square_cut_by_a_parabola_has_the_right_parts() {
        // Above v = u^2 / 2, and between it and v = u^2 / 2 + 1 / 4.
        let mut g = [0.0; NODES];
        for i in 0..N {
            for j in 0..N {
                g[i * N + j] = X[j] - 0.5 * X[i] * X[i];
            }
        }
        for transposed in [false, true] {
            let turned = |k: usize| if transposed { k % N * N + k / N } else { k };
            let mut h = [0.0; NODES];
            for (k, g) in g.into_iter().enumerate() {
                h[turned(k)] = g;
            }
            let parts = split(&h, &[0.0, 0.25]);
            let areas: Vec<f64> = parts.iter().map(|part| part.iter().sum()).collect();
            for (area, exact) in areas.iter().zip([1.0 / 6.0, 0.25, 1.0 - 0.25 - 1.0 / 6.0]) {
                assert!((area - exact).abs() < 1e-6, "{areas:?}");
            }
            // The integral of u v below the first curve: that of u (u^2 / 2)^2 / 2.
            let product: f64 = (0..NODES).map(|k| parts[0][turned(k)] * X[k / N] * X[k % N]).sum();
            assert!((product - 1.0 / 48.0).abs() < 1e-6, "{product}");
        }
    }
}
