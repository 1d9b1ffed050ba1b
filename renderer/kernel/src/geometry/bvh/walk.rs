//! The walk of a packet through the tree.

use std::cell::Cell;

use super::{ALONE, BALL_NUMBERS, BALLS, FAN, INNER, KIND_BITS, LEAF, ROOT, STACK, TOGETHER, Tree, WIDER, WINDOW};
use crate::geometry::hit::Nearest;
use crate::geometry::shape::{BallLanes, FACET_NUMBERS, FacetLanes};
use crate::lanes::{Lanes, Mask, Real, Uint, V3};

/// Rays, and what they have hit so far.
pub(super) struct Rays<L: Lanes> {
    origin: V3<L>,
    dir: V3<L>,
    inverse: V3<L>,
    best: Nearest<L>,
    /// The same numbers, for walking one by one: origin, direction, inverse.
    numbers: [[f32; FAN]; 9],
}

/// One ray, in all lanes.
pub(super) struct Ray<L: Lanes> {
    origin: V3<L>,
    dir: V3<L>,
    inverse: V3<L>,
}

/// A number for each child, in one line of the cache: what lanes write there is read back soon.
#[repr(align(64))]
pub(super) struct Row([f32; FAN]);

/// Children waiting to be looked at, the last one first.
pub(super) struct Waiting {
    /// Those of a packet: see [`child_key`], of where the first of its rays enters.
    together: [u64; STACK],
    /// Which of its rays.
    lanes: [u32; STACK],
    /// Those of a ray by itself: see [`entry_key`].
    alone: [u64; STACK],
}

impl Default for Waiting {
    fn default() -> Self {
        Self { together: [0; STACK], lanes: [0; STACK], alone: [0; STACK] }
    }
}

thread_local! {
    /// Kept from packet to packet: to clear it would take as long as a ray.
    static WAITING: Cell<Option<Box<Waiting>>> = const { Cell::new(None) };
}

/// Child `i` of a node, and where it is entered (the larger, the farther).
#[inline(always)]
pub(super) fn child_key(node: usize, i: usize, enters: f32) -> u64 {
    u64::from(enters.to_bits()) << 32 | (node * FAN + i) as u64
}

/// The inverse of [`child_key`].
#[inline(always)]
pub(super) fn child_of_key(key: u64) -> (usize, usize, f32) {
    let child = key as u32 as usize;
    (child / FAN, child % FAN, f32::from_bits((key >> 32) as u32))
}

/// A child, as [`super::Node::child`] has it, and where it is entered. A ray by itself needs no more, and what it needs next
/// does not wait for the node above to be read once more: a tenth faster.
#[inline(always)]
pub(super) fn entry_key(child: u32, enters: f32) -> u64 {
    u64::from(enters.to_bits()) << 32 | u64::from(child)
}

/// The inverse of [`entry_key`].
#[inline(always)]
pub(super) fn child_of_entry_key(key: u64) -> (u32, f32) {
    (key as u32, f32::from_bits((key >> 32) as u32))
}

/// `1 / d`, with zeros moved off zero so that no test multiplies zero by infinity.
#[inline(always)]
pub(crate) fn reciprocal<L: Lanes>(l: L, d: V3<L>) -> V3<L> {
    let tiny = l.f(1e-20);
    let one = l.f(1.0);
    V3 {
        x: one / d.x.abs().lt(tiny).select(tiny, d.x),
        y: one / d.y.abs().lt(tiny).select(tiny, d.y),
        z: one / d.z.abs().lt(tiny).select(tiny, d.z),
    }
}

/// Where rays enter and leave a box, widened, from the distances along the three axes.
#[inline(always)]
pub(super) fn passage<L: Lanes>(l: L, near: V3<L>, far: V3<L>) -> (L::F, L::F) {
    let enter = near.x.max(near.y).max(near.z.max(l.f(0.0)));
    let leave = far.x.min(far.y).min(far.z);
    (enter * (1.0 - WIDER), leave * (1.0 + WIDER))
}

impl Tree {
    /// What each ray hits first, nearer than `t_max` or just there; with `ANY` the distance becomes
    /// minus infinity where anything nearer than `t_max` is hit. Rays with a negative `t_max` meet nothing.
    #[inline(always)]
    pub fn walk<L: Lanes, const ANY: bool>(&self, l: L, origin: V3<L>, dir: V3<L>, t_max: L::F) -> Nearest<L> {
        let inverse = reciprocal(l, dir);
        let mut numbers = [[0.0; FAN]; 9];
        let [a, b, c, d, e, f, g, h, i] = &mut numbers;
        origin.x.store(a);
        origin.y.store(b);
        origin.z.store(c);
        dir.x.store(d);
        dir.y.store(e);
        dir.z.store(f);
        inverse.x.store(g);
        inverse.y.store(h);
        inverse.z.store(i);
        let mut rays = Rays { origin, dir, inverse, best: Nearest { t: t_max, id: l.u(0) }, numbers };
        let mut waiting = WAITING.take().unwrap_or_default();
        let zero = l.f(0.0);
        let negative = [inverse.x.lt(zero).bits(), inverse.y.lt(zero).bits(), inverse.z.lt(zero).bits()];
        let mut todo = t_max.ge(zero).bits();
        let mut alone = 0;
        while todo != 0 {
            let first = todo.trailing_zeros();
            let mut octant = todo;
            let mut signs = [false; 3];
            for axis in 0..3 {
                signs[axis] = negative[axis] >> first & 1 == 1;
                octant &= if signs[axis] { negative[axis] } else { !negative[axis] };
            }
            todo &= !octant;
            if octant.count_ones() >= TOGETHER {
                self.walk_together::<L, ANY>(l, &mut rays, signs, octant, &mut waiting);
            } else {
                alone |= octant;
            }
        }
        self.walk_alone::<L, ANY>(l, &mut rays, alone, (self.nodes[0].child[0], &[0.0; FAN]), &mut waiting.alone);
        WAITING.set(Some(waiting));
        rays.best
    }

    /// Walks the rays of `lanes`, which point into the octant of these `signs`.
    #[inline(always)]
    pub(super) fn walk_together<L: Lanes, const ANY: bool>(
        &self,
        l: L,
        rays: &mut Rays<L>,
        signs: [bool; 3],
        lanes: u32,
        waiting: &mut Waiting,
    ) {
        let beam = Beam::new(l, rays, signs, lanes);
        let Rays { origin, inverse, .. } = *rays;
        let (near, far) = beam.planes;
        waiting.together[0] = ROOT;
        waiting.lanes[0] = lanes;
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let (node, i, enters) = child_of_key(waiting.together[depth]);
            let asked = l.mask(waiting.lanes[depth]) & rays.best.t.ge(l.f(enters));
            if !asked.any() {
                continue;
            }
            let planes = &self.nodes[node].planes;
            let from = V3 {
                x: (l.f(planes[near[0]][i]) - origin.x) * inverse.x,
                y: (l.f(planes[near[1]][i]) - origin.y) * inverse.y,
                z: (l.f(planes[near[2]][i]) - origin.z) * inverse.z,
            };
            let to = V3 {
                x: (l.f(planes[far[0]][i]) - origin.x) * inverse.x,
                y: (l.f(planes[far[1]][i]) - origin.y) * inverse.y,
                z: (l.f(planes[far[2]][i]) - origin.z) * inverse.z,
            };
            let (enter, leave) = passage(l, from, to);
            let inside = asked & enter.le(leave.min(rays.best.t));
            let bits = inside.bits();
            if bits == 0 {
                continue;
            }
            let child = self.nodes[node].child[i];
            if bits.count_ones() <= ALONE {
                let mut entered = [0.0; FAN];
                enter.store(&mut entered);
                let start = (child, &entered);
                self.walk_alone::<L, ANY>(l, rays, bits, start, &mut waiting.alone);
            } else if child & INNER != 0 {
                let at = (child >> KIND_BITS) as usize;
                depth = self.push_children(l, at, bits, &beam, waiting, depth);
            } else {
                self.hit_together::<L, ANY>(l, rays, child, inside, enter);
            }
        }
    }

    /// Puts the children that rays of the packet may enter on the stack, the nearest on top; returns the new
    /// depth.
    #[inline(always)]
    pub(super) fn push_children<L: Lanes>(
        &self,
        l: L,
        at: usize,
        lanes: u32,
        beam: &Beam<L>,
        waiting: &mut Waiting,
        mut depth: usize,
    ) -> usize {
        let (near, far) = beam.planes;
        let planes = &self.nodes[at].planes;
        let mut enters = Row([0.0; FAN]);
        let mut todo = 0;
        let mut k = 0;
        while k < FAN {
            let from = V3 {
                x: least_product(l.load(&planes[near[0]][k..]) - beam.near.x, beam.least.x, beam.largest.x),
                y: least_product(l.load(&planes[near[1]][k..]) - beam.near.y, beam.least.y, beam.largest.y),
                z: least_product(l.load(&planes[near[2]][k..]) - beam.near.z, beam.least.z, beam.largest.z),
            };
            let to = V3 {
                x: largest_product(l.load(&planes[far[0]][k..]) - beam.far.x, beam.least.x, beam.largest.x),
                y: largest_product(l.load(&planes[far[1]][k..]) - beam.far.y, beam.least.y, beam.largest.y),
                z: largest_product(l.load(&planes[far[2]][k..]) - beam.far.z, beam.least.z, beam.largest.z),
            };
            let (enter, leave) = passage(l, from, to);
            enter.store(&mut enters.0[k..]);
            todo |= enter.le(leave).bits() << k;
            k += L::N;
        }
        let bottom = depth;
        while todo != 0 {
            let i = todo.trailing_zeros() as usize;
            todo &= todo - 1;
            insert(&mut waiting.together, bottom, depth, child_key(at, i, enters.0[i]));
            waiting.lanes[depth] = lanes;
            depth += 1;
        }
        depth
    }

    /// Asks the primitives of a leaf for the rays of `inside`, which enter its box at `enter`.
    #[inline(always)]
    pub(super) fn hit_together<L: Lanes, const ANY: bool>(
        &self,
        l: L,
        rays: &mut Rays<L>,
        child: u32,
        inside: L::M,
        enter: L::F,
    ) {
        let zero = l.f(0.0);
        let (first, n) = leaf(child);
        if child & BALLS == 0 {
            let numbers = window(&self.facets, first as usize * FACET_NUMBERS);
            for i in 0..n {
                let facet = FacetLanes {
                    p0: V3 { x: l.f(numbers[i]), y: l.f(numbers[n + i]), z: l.f(numbers[2 * n + i]) },
                    normal: V3 { x: l.f(numbers[3 * n + i]), y: l.f(numbers[4 * n + i]), z: l.f(numbers[5 * n + i]) },
                    u_axis: V3 { x: l.f(numbers[6 * n + i]), y: l.f(numbers[7 * n + i]), z: l.f(numbers[8 * n + i]) },
                    v_axis: V3 { x: l.f(numbers[9 * n + i]), y: l.f(numbers[10 * n + i]), z: l.f(numbers[11 * n + i]) },
                    triangle: l.f(numbers[12 * n + i]),
                };
                let (t, hit) = facet.intersect(l, rays.origin, rays.dir);
                rays.take::<ANY>(l, t.max(enter), hit & t.gt(zero) & inside, first + i as u32);
            }
        } else {
            let numbers = window(&self.balls, first as usize * BALL_NUMBERS);
            for i in 0..n {
                let center = V3 { x: l.f(numbers[i]), y: l.f(numbers[n + i]), z: l.f(numbers[2 * n + i]) };
                let ball = BallLanes { center, radius2: l.f(numbers[3 * n + i]) };
                let t = ball.nearest(l, rays.origin, rays.dir, zero);
                let hit = t.lt(l.f(f32::INFINITY)) & inside;
                rays.take::<ANY>(l, t.max(enter), hit, self.first_ball + first + i as u32);
            }
        }
    }

    /// Walks the rays of `lanes` one by one, from a child that they enter at given distances.
    #[inline(always)]
    pub(super) fn walk_alone<L: Lanes, const ANY: bool>(
        &self,
        l: L,
        rays: &mut Rays<L>,
        mut lanes: u32,
        start: (u32, &[f32; FAN]),
        waiting: &mut [u64; STACK],
    ) {
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let mut numbers = [0.0; 9];
            for (number, of_all) in numbers.iter_mut().zip(&rays.numbers) {
                *number = of_all[lane];
            }
            let ray = Ray::new(l, &numbers);
            let few = Ray::new(l.few(), &numbers);
            let planes = near_and_far([numbers[6] < 0.0, numbers[7] < 0.0, numbers[8] < 0.0]);
            let mut best = (rays.best.t.lane(lane), rays.best.id.lane(lane));
            let mut next = entry_key(start.0, start.1[lane]);
            let mut depth = 0;
            'ray: loop {
                let (child, enter) = child_of_entry_key(next);
                if child & INNER == 0 {
                    best = self.hit_alone::<L::Few, ANY>(l.few(), &few, child, enter, best);
                    if ANY && best.0 < 0.0 {
                        break 'ray;
                    }
                } else {
                    let at = (child >> KIND_BITS) as usize;
                    let (mut todo, enters) = self.entered(l, at, &ray, planes, best.0);
                    if todo != 0 {
                        // The nearest one next; the others have to wait.
                        let children = &self.nodes[at].child;
                        let first = todo.trailing_zeros() as usize;
                        next = entry_key(children[first], enters.0[first]);
                        todo &= todo - 1;
                        while todo != 0 {
                            let other = todo.trailing_zeros() as usize;
                            todo &= todo - 1;
                            let key = entry_key(children[other], enters.0[other]);
                            waiting[depth] = key.max(next);
                            next = key.min(next);
                            depth += 1;
                        }
                        continue;
                    }
                }
                loop {
                    if depth == 0 {
                        break 'ray;
                    }
                    depth -= 1;
                    next = waiting[depth];
                    if child_of_entry_key(next).1 <= best.0 {
                        break;
                    }
                }
            }
            let here = l.mask(1 << lane);
            rays.best.t = here.select(l.f(best.0), rays.best.t);
            rays.best.id = here.select_u(l.u(best.1), rays.best.id);
        }
    }

    /// The children (bit i is child i) that a ray enters nearer than `t_max` or just there, and where.
    #[inline(always)]
    pub(super) fn entered<L: Lanes>(
        &self,
        l: L,
        at: usize,
        ray: &Ray<L>,
        (near, far): ([usize; 3], [usize; 3]),
        t_max: f32,
    ) -> (u32, Row) {
        let planes = &self.nodes[at].planes;
        let mut enters = Row([0.0; FAN]);
        let mut entered = 0;
        let mut k = 0;
        while k < FAN {
            let from = V3 {
                x: (l.load(&planes[near[0]][k..]) - ray.origin.x) * ray.inverse.x,
                y: (l.load(&planes[near[1]][k..]) - ray.origin.y) * ray.inverse.y,
                z: (l.load(&planes[near[2]][k..]) - ray.origin.z) * ray.inverse.z,
            };
            let to = V3 {
                x: (l.load(&planes[far[0]][k..]) - ray.origin.x) * ray.inverse.x,
                y: (l.load(&planes[far[1]][k..]) - ray.origin.y) * ray.inverse.y,
                z: (l.load(&planes[far[2]][k..]) - ray.origin.z) * ray.inverse.z,
            };
            let (enter, leave) = passage(l, from, to);
            enter.store(&mut enters.0[k..]);
            entered |= enter.le(leave.min(l.f(t_max))).bits() << k;
            k += L::N;
        }
        (entered, enters)
    }

    /// Asks the primitives of a leaf for one ray, which enters its box at `enter`.
    #[inline(always)]
    pub(super) fn hit_alone<L: Lanes, const ANY: bool>(
        &self,
        l: L,
        ray: &Ray<L>,
        child: u32,
        enter: f32,
        mut best: (f32, u32),
    ) -> (f32, u32) {
        let zero = l.f(0.0);
        let infinite = l.f(f32::INFINITY);
        let (first, n) = leaf(child);
        let mut k = 0;
        while k < n {
            let (t, hit, id) = if child & BALLS == 0 {
                let numbers = window(&self.facets, first as usize * FACET_NUMBERS + k);
                let facet = FacetLanes {
                    p0: load(l, numbers, n, 0),
                    normal: load(l, numbers, n, 3),
                    u_axis: load(l, numbers, n, 6),
                    v_axis: load(l, numbers, n, 9),
                    triangle: l.load(&numbers[12 * n..]),
                };
                let (t, hit) = facet.intersect(l, ray.origin, ray.dir);
                (t, hit & t.gt(zero), first)
            } else {
                let numbers = window(&self.balls, first as usize * BALL_NUMBERS + k);
                let ball = BallLanes { center: load(l, numbers, n, 0), radius2: l.load(&numbers[3 * n..]) };
                let t = ball.nearest(l, ray.origin, ray.dir, zero);
                (t, t.lt(infinite), self.first_ball + first)
            };
            let t = t.max(l.f(enter));
            let hit = hit & t.le(l.f(best.0)) & l.iota().lt(l.u((n - k) as u32));
            if hit.any() {
                let t = hit.select(t, infinite);
                let least = t.least();
                let id = id + k as u32 + t.le(l.f(least)).bits().trailing_zeros();
                if ANY {
                    if least < best.0 {
                        return (f32::NEG_INFINITY, 0);
                    }
                } else if least < best.0 || id < best.1 {
                    best = (least, id);
                }
            }
            k += L::N;
        }
        best
    }
}

impl<L: Lanes> Ray<L> {
    /// From origin, direction and inverse.
    #[inline(always)]
    pub(super) fn new(l: L, numbers: &[f32; 9]) -> Self {
        let [ox, oy, oz, dx, dy, dz, ix, iy, iz] = *numbers;
        Self {
            origin: V3 { x: l.f(ox), y: l.f(oy), z: l.f(oz) },
            dir: V3 { x: l.f(dx), y: l.f(dy), z: l.f(dz) },
            inverse: V3 { x: l.f(ix), y: l.f(iy), z: l.f(iz) },
        }
    }
}

impl<L: Lanes> Rays<L> {
    /// Takes note of primitive `id`, met at distance `t` where `hit`.
    #[inline(always)]
    pub(super) fn take<const ANY: bool>(&mut self, l: L, t: L::F, hit: L::M, id: u32) {
        let best = &mut self.best;
        if ANY {
            best.t = (hit & t.lt(best.t)).select(l.f(f32::NEG_INFINITY), best.t);
        } else {
            let nearer = hit & t.le(best.t) & (t.lt(best.t) | l.u(id).lt(best.id));
            best.t = nearer.select(t, best.t);
            best.id = nearer.select_u(l.u(id), best.id);
        }
    }
}

/// What holds for all rays of a packet that point into one octant.
pub(super) struct Beam<L: Lanes> {
    /// See [`near_and_far`].
    planes: ([usize; 3], [usize; 3]),
    /// Along each axis the origin that has come farthest, and the one that lags behind most.
    near: V3<L>,
    far: V3<L>,
    /// Bounds of the inverse directions.
    least: V3<L>,
    largest: V3<L>,
}

impl<L: Lanes> Beam<L> {
    #[inline(always)]
    pub(super) fn new(l: L, rays: &Rays<L>, signs: [bool; 3], lanes: u32) -> Self {
        let lanes = l.mask(lanes);
        let (origin, inverse) = (rays.origin, rays.inverse);
        let (least_x, largest_x) = range(l, origin.x, lanes);
        let (least_y, largest_y) = range(l, origin.y, lanes);
        let (least_z, largest_z) = range(l, origin.z, lanes);
        let (ix0, ix1) = range(l, inverse.x, lanes);
        let (iy0, iy1) = range(l, inverse.y, lanes);
        let (iz0, iz1) = range(l, inverse.z, lanes);
        Self {
            planes: near_and_far(signs),
            near: V3 {
                x: if signs[0] { least_x } else { largest_x },
                y: if signs[1] { least_y } else { largest_y },
                z: if signs[2] { least_z } else { largest_z },
            },
            far: V3 {
                x: if signs[0] { largest_x } else { least_x },
                y: if signs[1] { largest_y } else { least_y },
                z: if signs[2] { largest_z } else { least_z },
            },
            least: V3 { x: ix0, y: iy0, z: iz0 },
            largest: V3 { x: ix1, y: iy1, z: iz1 },
        }
    }
}

/// Least and largest number of some lanes, in all lanes.
#[inline(always)]
pub(super) fn range<L: Lanes>(l: L, v: L::F, lanes: L::M) -> (L::F, L::F) {
    let least = lanes.select(v, l.f(f32::INFINITY)).least();
    let largest = lanes.select(v, l.f(f32::NEG_INFINITY)).largest();
    (l.f(least), l.f(largest))
}

/// The least of `x` times numbers from `a` to `b`, which have one sign.
#[inline(always)]
pub(super) fn least_product<F: Real>(x: F, a: F, b: F) -> F {
    (x * a).min(x * b)
}

/// The largest of them.
#[inline(always)]
pub(super) fn largest_product<F: Real>(x: F, a: F, b: F) -> F {
    (x * a).max(x * b)
}

/// First primitive of a leaf and how many there are: visibly at most [`LEAF`], which spares checks of indices.
#[inline(always)]
pub(super) fn leaf(child: u32) -> (u32, usize) {
    (child >> KIND_BITS, child as usize % LEAF + 1)
}

/// Numbers from `at` on.
#[inline(always)]
pub(super) fn window(numbers: &[f32], at: usize) -> &[f32; WINDOW] {
    numbers[at..].first_chunk().expect("the list goes on for so long after the last leaf")
}

/// Numbers `3 rows` of a leaf of `n` primitives as a vector.
#[inline(always)]
pub(super) fn load<L: Lanes>(l: L, numbers: &[f32; WINDOW], n: usize, row: usize) -> V3<L> {
    V3 { x: l.load(&numbers[row * n..]), y: l.load(&numbers[(row + 1) * n..]), z: l.load(&numbers[(row + 2) * n..]) }
}

/// Indices of the planes through which rays with these signs of direction enter a box, and leave it.
#[inline(always)]
pub(crate) fn near_and_far(signs: [bool; 3]) -> ([usize; 3], [usize; 3]) {
    let mut near = [0, 1, 2];
    let mut far = [3, 4, 5];
    for axis in 0..3 {
        if signs[axis] {
            near[axis] = axis + 3;
            far[axis] = axis;
        }
    }
    (near, far)
}

/// Puts a child among those from `bottom` to `top`, the farthest first.
#[inline(always)]
pub(super) fn insert(children: &mut [u64], bottom: usize, top: usize, key: u64) {
    let mut at = top;
    while at > bottom && children[at - 1] < key {
        children[at] = children[at - 1];
        at -= 1;
    }
    children[at] = key;
}
