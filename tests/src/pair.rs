//! A sampler against its density: histograms of what is drawn, integrals of what is claimed.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{DVec3, Vec3};
use mislab_kernel::lanes::{Lanes, Lanewise, Mask, PACKET, Real, Task, V3};
use mislab_kernel::sampler::{Dimension, Numbers, pixel_keys};
use mislab_renderer::{SamplerKind, SamplerSettings, Strategy};

use crate::charts::Chart;
use crate::chi_square::{LEAST_EXPECTED, Outcome, chi_square};
use crate::draws::Draws;
use crate::quadrature::GAUSS;

/// Cells of a histogram, down and across: whole numbers of those of the last, which alone is integrated over.
pub const TABLES: [[usize; 2]; 3] = [[10, 20], [50, 100], [100, 200]];
/// The finest.
const FINEST: [usize; 2] = TABLES[2];
/// Samples of every pair.
pub const SAMPLES: usize = 4_000_000;
/// A cell is split until the parts of its integral differ from the whole by no more.
const TOLERANCE: f64 = 1e-8;
/// Samples that show where the density has narrow features.
const PILOTS: usize = 60_000;
/// Samples per call.
const CHUNK: usize = PACKET * 250;

/// A way to draw directions and the density that it claims to have.
pub trait Pair: Sync {
    /// Draws directions; false where it failed.
    fn sample<L: Lanes>(&self, l: L, random: &Numbers<L>) -> (V3<L>, L::M);
    /// Density of [`Self::sample`], per solid angle.
    fn density<L: Lanes>(&self, l: L, wi: V3<L>) -> L::F;
}

/// A pair with all that is needed to judge it.
pub struct Case<'a, P> {
    /// What it is.
    pub name: String,
    /// The sampler and its density.
    pub pair: P,
    /// Coordinates to look at it in.
    pub charts: Vec<Chart>,
    /// Whether the charts after the first show a part only of what the pair samples.
    pub partly: bool,
    /// Probability that a sample succeeds, and so the integral of the density.
    pub success: f64,
    /// How far, in radians, single precision may put a direction outside the reach of its sampler.
    pub rounding: f64,
    /// Code that draws the samples.
    pub how: Lanewise,
    /// For the list of all cases.
    pub settings: &'a SamplerSettings,
}

/// Independent numbers.
pub const INDEPENDENT: SamplerSettings =
    SamplerSettings { kind: SamplerKind::Independent, strata: [1, 1], jitter: true };

struct Draw<'a, P> {
    pair: &'a P,
    settings: &'a SamplerSettings,
    seed: u32,
    first: u32,
    out: &'a mut Vec<(Vec3, bool, f32)>,
}

impl<P: Pair> Task for Draw<'_, P> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let mut sampler = Draws::new(l, self.settings, Dimension::wanted(Strategy::MisAll, true, true));
        let mut lane = 0;
        while lane < PACKET as u32 {
            sampler.start(pixel_keys(l, self.seed, l.iota() + l.u(lane), l.u(7)), self.seed);
            for index in 0..(CHUNK / PACKET) as u32 {
                let (wi, valid) = self.pair.sample(l, &sampler.draw(self.first + index));
                let density = self.pair.density(l, wi);
                let bits = valid.bits();
                for i in 0..L::N {
                    let wi = Vec3::new(wi.x.lane(i), wi.y.lane(i), wi.z.lane(i));
                    self.out.push((wi, bits >> i & 1 == 1, density.lane(i)));
                }
            }
            lane += L::N as u32;
        }
    }
}

/// Directions, whether they are valid, and their densities: `CHUNK` at a time to `each`.
pub fn draw<P: Pair>(case: &Case<'_, P>, seed: u32, count: usize, mut each: impl FnMut(&[(Vec3, bool, f32)])) {
    let mut out = Vec::with_capacity(CHUNK);
    for chunk in 0..count.div_ceil(CHUNK) {
        out.clear();
        let first = (chunk * (CHUNK / PACKET)) as u32;
        case.how.run(Draw { pair: &case.pair, settings: case.settings, seed, first, out: &mut out });
        each(&out[..CHUNK.min(count - chunk * CHUNK)]);
    }
}

struct Evaluate<'a, P> {
    pair: &'a P,
    directions: &'a [[f32; PACKET]; 3],
}

impl<P: Pair> Task for Evaluate<'_, P> {
    type Output = [f32; PACKET];
    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> [f32; PACKET] {
        let [x, y, z] = self.directions;
        let mut out = [0.0; PACKET];
        let mut lane = 0;
        while lane < PACKET {
            let wi = V3 { x: l.load(&x[lane..]), y: l.load(&y[lane..]), z: l.load(&z[lane..]) };
            self.pair.density(l, wi).store(&mut out[lane..]);
            lane += L::N;
        }
        out
    }
}

/// Densities at sixteen directions, rounded to single precision.
pub fn densities<P: Pair>(pair: &P, at: &[DVec3; 16]) -> [f32; 16] {
    // Lanes that nobody asks for look somewhere, too.
    let mut directions = [[0.6; PACKET], [0.0; PACKET], [0.8; PACKET]];
    for (i, d) in at.iter().enumerate() {
        for k in 0..3 {
            directions[k][i] = d[k] as f32;
        }
    }
    let found = Lanewise::best().run(Evaluate { pair, directions: &directions });
    std::array::from_fn(|i| found[i])
}

/// A pair's density over one chart.
struct Integral<'a, P> {
    pair: &'a P,
    chart: &'a Chart,
}

impl<P: Pair> Integral<'_, P> {
    /// The rule of 4 x 4 Gauss points.
    fn rule(&self, corner: [f64; 2], size: [f64; 2]) -> f64 {
        let mut directions = [DVec3::Z; 16];
        let mut weights = [0.0; 16];
        for (i, (x, wx)) in GAUSS.into_iter().enumerate() {
            for (j, (y, wy)) in GAUSS.into_iter().enumerate() {
                let (d, area) = self.chart.direction([corner[0] + x * size[0], corner[1] + y * size[1]]);
                directions[4 * i + j] = d;
                weights[4 * i + j] = wx * wy * size[0] * size[1] * area;
            }
        }
        let densities = densities(self.pair, &directions);
        densities.iter().zip(weights).filter(|(_, w)| *w > 0.0).map(|(&p, w)| f64::from(p) * w).sum()
    }

    /// Integral over a cell. What the rule overlooks, a narrow lobe in a large cell, is seen from where
    /// `pilots` fell: cells are split until few of them are in each.
    fn refine(&self, corner: [f64; 2], size: [f64; 2], whole: f64, pilots: &mut [[f64; 2]], depth: u32) -> f64 {
        let half = size.map(|s| s / 2.0);
        let middle = [corner[0] + half[0], corner[1] + half[1]];
        let corners = [corner, [corner[0], middle[1]], [middle[0], corner[1]], middle];
        let parts = corners.map(|corner| self.rule(corner, half));
        let sum: f64 = parts.iter().sum();
        let seen = pilots.len() <= 8 && (sum > 0.0 || pilots.is_empty());
        let fine = size[0] <= 1.0 / 150.0;
        let settled = (sum - whole).abs() <= TOLERANCE && seen && fine;
        if settled || depth == 30 {
            return sum;
        }
        let (top, bottom) = split(pilots, 0, middle[0]);
        let (a, b) = split(top, 1, middle[1]);
        let (c, d) = split(bottom, 1, middle[1]);
        let quarters = [a, b, c, d].into_iter().zip(corners).zip(parts);
        quarters.map(|((pilots, corner), part)| self.refine(corner, half, part, pilots, depth + 1)).sum()
    }

    /// Integrals over the cells of a table.
    fn cells(&self, [rows, columns]: [usize; 2], pilots: &[[f64; 2]]) -> Vec<f64> {
        let size = [1.0 / rows as f64, 1.0 / columns as f64];
        let mut fallen = vec![Vec::new(); rows * columns];
        for &pilot in pilots {
            fallen[cell_of(pilot, [rows, columns])].push(pilot);
        }
        let mut cells = Vec::with_capacity(rows * columns);
        for (k, pilots) in fallen.iter_mut().enumerate() {
            let corner = [(k / columns) as f64 * size[0], (k % columns) as f64 * size[1]];
            cells.push(self.refine(corner, size, self.rule(corner, size), pilots, 0));
        }
        cells
    }
}

/// What the cells of a coarser table hold, given those of the finest.
fn gathered(finest: &[f64], [rows, columns]: [usize; 2]) -> Vec<f64> {
    let [down, across] = [FINEST[0] / rows, FINEST[1] / columns];
    let mut cells = vec![0.0; rows * columns];
    for (k, value) in finest.iter().enumerate() {
        let [row, column] = [k / FINEST[1] / down, k % FINEST[1] / across];
        cells[row * columns + column] += value;
    }
    cells
}

/// Brings the points below `at` along an axis to the front.
fn split(points: &mut [[f64; 2]], axis: usize, at: f64) -> (&mut [[f64; 2]], &mut [[f64; 2]]) {
    let mut below = 0;
    for i in 0..points.len() {
        if points[i][axis] < at {
            points.swap(i, below);
            below += 1;
        }
    }
    points.split_at_mut(below)
}

fn cell_of([u, v]: [f64; 2], [rows, columns]: [usize; 2]) -> usize {
    (u * rows as f64) as usize * columns + (v * columns as f64) as usize
}

/// Integral of a pair's density over the directions of a chart.
pub fn integral<P: Pair>(pair: &P, chart: &Chart) -> f64 {
    Integral { pair, chart }.cells(TABLES[1], &[]).iter().sum()
}

/// What was found for one case, chart and table.
#[derive(Clone, Debug)]
pub struct Found {
    /// Case, chart, cells.
    pub label: String,
    /// The test.
    pub outcome: Outcome,
    /// Integral of the density over the chart less the probability of success.
    pub excess: f64,
    /// Valid samples where the density is 0, and 0 all around.
    pub stray: Vec<DVec3>,
}

/// Draws samples and compares them, in every chart and table, with the integrals of the density.
///
/// # Panics
/// If a valid sample is not of unit length.
pub fn check<P: Pair>(case: &Case<'_, P>, seed: u32) -> Vec<Found> {
    let mut counts: Vec<Vec<u32>> =
        case.charts.iter().flat_map(|_| TABLES.map(|[rows, columns]| vec![0; rows * columns + 1])).collect();
    let mut stray = Vec::new();
    let mut pilots = vec![Vec::new(); case.charts.len()];
    let mut drawn = 0;
    draw(case, seed, SAMPLES, |samples| {
        for &(wi, valid, density) in samples {
            let mut d = wi.as_dvec3();
            let flat = matches!(case.charts[0], Chart::Flat);
            if valid {
                let length = d.length();
                assert!(flat || (length - 1.0).abs() < 3e-7, "{}: {wi} has length {length}", case.name);
                if density <= 0.0 || density.is_nan() {
                    match brought_back(case, d) {
                        Some(inside) => d = inside,
                        None => stray.push(d),
                    }
                }
                if !flat {
                    d /= length;
                }
            }
            for (c, chart) in case.charts.iter().enumerate() {
                let at = if valid { chart.place(d) } else { None };
                if drawn < PILOTS {
                    pilots[c].extend(at);
                }
                for (t, &[rows, columns]) in TABLES.iter().enumerate() {
                    let cell = match at {
                        Some(at) => cell_of(at, [rows, columns]),
                        None => rows * columns,
                    };
                    counts[3 * c + t][cell] += 1;
                }
            }
            drawn += 1;
        }
    });
    // Quadrature on squares misses slivers at the rims of lights that cross a cell: some ten samples, which
    // must not meet a cell that expects no more.
    let least = if case.partly { 100.0 * LEAST_EXPECTED } else { LEAST_EXPECTED };
    let mut found = Vec::new();
    for (c, chart) in case.charts.iter().enumerate() {
        let finest = Integral { pair: &case.pair, chart }.cells(FINEST, &pilots[c]);
        for (t, table) in TABLES.into_iter().enumerate() {
            let mut expected = gathered(&finest, table);
            let total: f64 = expected.iter().sum();
            for e in &mut expected {
                *e *= SAMPLES as f64;
            }
            // Samples that failed, or lie outside the chart. Where it is known how many do, a millionth that the
            // quadrature is off shall not count as failing: `excess` judges that.
            let inside = if c > 0 && case.partly { total } else { case.success };
            for e in &mut expected {
                *e *= if total > 0.0 { inside / total } else { 1.0 };
            }
            expected.push((1.0 - inside).max(0.0) * SAMPLES as f64);
            found.push(Found {
                label: format!("{}, {} of {} x {}", case.name, chart.name(), table[0], table[1]),
                outcome: chi_square(&counts[3 * c + t], &expected, least),
                excess: if c > 0 && case.partly { 0.0 } else { total - case.success },
                stray: stray.clone(),
            });
        }
    }
    found
}

/// A direction of density above 0 within rounding of one where it is 0.
fn brought_back<P: Pair>(case: &Case<'_, P>, d: DVec3) -> Option<DVec3> {
    let (t, b) = d.normalize().any_orthonormal_pair();
    let around: [DVec3; 16] = std::array::from_fn(|i| {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / 8.0).sin_cos();
        d + (t * cos + b * sin) * (case.rounding * if i < 8 { 1.0 } else { 0.4 })
    });
    let near = densities(&case.pair, &around);
    near.iter().position(|&p| p > 0.0).map(|i| around[i])
}

/// Calls `each` with the indices below `count`, on all cores.
pub fn in_parallel<R: Send>(count: usize, each: impl Fn(usize) -> R + Sync) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let results = Mutex::new(Vec::with_capacity(count));
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    if i >= count {
                        break;
                    }
                    let result = each(i);
                    results.lock().expect("no thread panics while it holds the lock").push((i, result));
                }
            });
        }
    });
    let mut results = results.into_inner().expect("no thread panics while it holds the lock");
    results.sort_by_key(|&(i, _)| i);
    results.into_iter().map(|(_, result)| result).collect()
}
