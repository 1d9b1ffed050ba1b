//! All surfaces of a scene, and the two questions asked of them: what does a ray meet first, and
//! is anything in its way.

use std::fmt;

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

use crate::lanes::{Lanes, Mask, Real, V3};
use crate::patch::List;
use crate::shape::{Ball, Facet};

/// Up to so many primitives a list is searched from end to end; a tree pays from about there.
const FLAT_LIMIT: usize = 24;

/// Levels a traversal can be deep. A binary tree over 2^32 primitives of sane shape stays below.
const STACK: usize = 128;

/// Opaque primitives: facets first, then spheres; the index over both is the primitive's id.
#[derive(Default)]
pub struct Geometry {
    /// Triangles and parallelograms.
    pub facets: Vec<Facet>,
    /// Spheres.
    pub balls: Vec<Ball>,
    tree: Option<Bvh2>,
}

impl fmt::Debug for Geometry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let nodes = self.tree.as_ref().map_or(0, |tree| tree.nodes.len());
        write!(f, "Geometry {{ {} facets, {} balls, {nodes} nodes }}", self.facets.len(), self.balls.len())
    }
}

/// What a packet of rays met first.
#[derive(Clone, Copy)]
pub struct Nearest<L: Lanes> {
    /// Distance; infinite if nothing was met.
    pub t: L::F,
    /// Primitive id; meaningless where `t` is infinite.
    pub id: L::U,
}

impl Geometry {
    /// Collects the primitives and builds a tree over them if there are many.
    pub fn new(facets: Vec<Facet>, balls: Vec<Ball>) -> Self {
        let mut geometry = Self { facets, balls, tree: None };
        if geometry.facets.len() + geometry.balls.len() > FLAT_LIMIT {
            geometry.tree = Some(geometry.build_tree());
        }
        geometry
    }

    /// Number of primitives.
    pub fn len(&self) -> usize {
        self.facets.len() + self.balls.len()
    }

    /// True if there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Box around everything.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let mut min = Vec3::INFINITY;
        let mut max = Vec3::NEG_INFINITY;
        for p in self.facets.iter().flat_map(Facet::corners) {
            min = min.min(p);
            max = max.max(p);
        }
        for ball in &self.balls {
            min = min.min(ball.center - ball.radius);
            max = max.max(ball.center + ball.radius);
        }
        (min, max)
    }

    fn build_tree(&self) -> Bvh2 {
        let facet_boxes = self.facets.iter().map(|f| {
            f.corners().fold(Aabb::empty(), |mut b, p| {
                b.extend(p.into());
                b
            })
        });
        let ball_boxes =
            self.balls.iter().map(|b| Aabb::new(Vec3A::from(b.center) - b.radius, Vec3A::from(b.center) + b.radius));
        let boxes: Vec<Aabb> = facet_boxes.chain(ball_boxes).collect();
        let indices = (0..boxes.len() as u32).collect();
        let mut tree = PlocBuilder::with_capacity(boxes.len()).build(
            PlocSearchDistance::Low,
            &boxes,
            indices,
            SortPrecision::U64,
            0,
        );
        ReinsertionOptimizer::default().run(&mut tree, 0.05, None);
        collapse(&mut tree, 4, 1.0);
        tree
    }

    /// True where there are so many primitives that a tree is searched, not a list.
    pub fn has_tree(&self) -> bool {
        self.tree.is_some()
    }

    /// First primitive of the list that each ray meets; of all primitives where there is a tree.
    /// Directions are unit vectors.
    #[inline(always)]
    pub fn nearest<L: Lanes>(&self, l: L, origin: V3<L>, dir: V3<L>, list: &List) -> Nearest<L> {
        let t_min = l.f(0.0);
        let mut best = Nearest { t: l.f(f32::INFINITY), id: l.u(0) };
        match &self.tree {
            None => {
                // Facets, then balls: two plain loops, since a choice inside one would carry all vectors
                // through memory.
                let mut k = 0;
                while k < list.len() && list.get(k) < self.facets.len() {
                    let (t, hit) = self.facets[list.get(k)].intersect(l, origin, dir);
                    best = nearer(l, list.get(k), t, hit & t.gt(t_min), best);
                    k += 1;
                }
                while k < list.len() {
                    let t = self.balls[list.get(k) - self.facets.len()].nearest(l, origin, dir, t_min);
                    best = nearer(l, list.get(k), t, l.m(true), best);
                    k += 1;
                }
            }
            Some(tree) => {
                let inverse = reciprocal(l, dir);
                let mut stack = [0u32; STACK];
                let mut depth = 1;
                while depth > 0 {
                    depth -= 1;
                    let node = &tree.nodes[stack[depth] as usize];
                    if !enters(l, &node.aabb, origin, inverse, best.t).any() {
                        continue;
                    }
                    if node.prim_count > 0 {
                        let first = node.first_index as usize;
                        for slot in first..first + node.prim_count as usize {
                            let id = tree.primitive_indices[slot] as usize;
                            let (t, hit) = self.meet(l, id, origin, dir, t_min);
                            best = nearer(l, id, t, hit, best);
                        }
                    } else {
                        let (near, far) = children_by_distance(tree, node.first_index, origin, dir);
                        stack[depth] = far;
                        stack[depth + 1] = near;
                        depth += 2;
                    }
                }
            }
        }
        best
    }

    /// True where a primitive of the list, or any where there is a tree, lies between 0 and `t_max`
    /// along the ray. Lanes that are not `wanted` may answer either way.
    #[inline(always)]
    pub fn blocked<L: Lanes>(&self, l: L, origin: V3<L>, dir: V3<L>, t_max: L::F, wanted: L::M, list: &List) -> L::M {
        let mut blocked = l.m(false);
        match &self.tree {
            None => {
                let zero = l.f(0.0);
                let mut k = 0;
                while k < list.len() && list.get(k) < self.facets.len() {
                    let (t, hit) = self.facets[list.get(k)].intersect(l, origin, dir);
                    blocked = blocked | (hit & t.gt(zero) & t.lt(t_max));
                    k += 1;
                }
                while k < list.len() {
                    let t = self.balls[list.get(k) - self.facets.len()].nearest(l, origin, dir, zero);
                    blocked = blocked | t.lt(t_max);
                    k += 1;
                }
            }
            Some(tree) => {
                let inverse = reciprocal(l, dir);
                let mut stack = [0u32; STACK];
                let mut depth = 1;
                while depth > 0 {
                    depth -= 1;
                    let node = &tree.nodes[stack[depth] as usize];
                    let open = wanted & !blocked;
                    if !open.any() {
                        break;
                    }
                    if !(enters(l, &node.aabb, origin, inverse, t_max) & open).any() {
                        continue;
                    }
                    if node.prim_count > 0 {
                        let first = node.first_index as usize;
                        for slot in first..first + node.prim_count as usize {
                            let id = tree.primitive_indices[slot] as usize;
                            let (t, hit) = self.meet(l, id, origin, dir, l.f(0.0));
                            blocked = blocked | (hit & t.lt(t_max));
                        }
                    } else {
                        let (near, far) = children_by_distance(tree, node.first_index, origin, dir);
                        stack[depth] = far;
                        stack[depth + 1] = near;
                        depth += 2;
                    }
                }
            }
        }
        blocked
    }

    /// Distance to a primitive, and whether it is met beyond `t_min`.
    #[inline(always)]
    fn meet<L: Lanes>(&self, l: L, id: usize, origin: V3<L>, dir: V3<L>, t_min: L::F) -> (L::F, L::M) {
        match self.facets.get(id) {
            Some(facet) => {
                let (t, hit) = facet.intersect(l, origin, dir);
                (t, hit & t.gt(t_min))
            }
            None => (self.balls[id - self.facets.len()].nearest(l, origin, dir, t_min), l.m(true)),
        }
    }
}

/// The nearer of what was met so far and primitive `id`, at distance `t` where `hit`.
#[inline(always)]
fn nearer<L: Lanes>(l: L, id: usize, t: L::F, hit: L::M, best: Nearest<L>) -> Nearest<L> {
    let hit = hit & t.lt(best.t);
    Nearest { t: hit.select(t, best.t), id: hit.select_u(l.u(id as u32), best.id) }
}

/// `1 / d`, with zeros moved off zero so that no slab test multiplies zero by infinity.
#[inline(always)]
fn reciprocal<L: Lanes>(l: L, d: V3<L>) -> V3<L> {
    let tiny = l.f(1e-20);
    let one = l.f(1.0);
    V3 {
        x: one / d.x.abs().lt(tiny).select(tiny, d.x),
        y: one / d.y.abs().lt(tiny).select(tiny, d.y),
        z: one / d.z.abs().lt(tiny).select(tiny, d.z),
    }
}

/// True where the ray meets the box between 0 and `t_max`. The far end is widened by a few ulp, so
/// that rounding never loses a primitive on a face of its box.
#[inline(always)]
fn enters<L: Lanes>(l: L, aabb: &Aabb, origin: V3<L>, inverse: V3<L>, t_max: L::F) -> L::M {
    let min = V3::splat(l, Vec3::from(aabb.min)) - origin;
    let max = V3::splat(l, Vec3::from(aabb.max)) - origin;
    let (ax, bx) = (min.x * inverse.x, max.x * inverse.x);
    let (ay, by) = (min.y * inverse.y, max.y * inverse.y);
    let (az, bz) = (min.z * inverse.z, max.z * inverse.z);
    let near = ax.min(bx).max(ay.min(by)).max(az.min(bz)).max(l.f(0.0));
    let far = ax.max(bx).min(ay.max(by)).min(az.max(bz));
    near.le((far * (1.0 + 4.0 * f32::EPSILON)).min(t_max))
}

/// The two children, the one nearer along the first lane's ray first. Any order is correct.
#[inline(always)]
fn children_by_distance<L: Lanes>(tree: &Bvh2, first: u32, origin: V3<L>, dir: V3<L>) -> (u32, u32) {
    let o = Vec3A::new(origin.x.lane(0), origin.y.lane(0), origin.z.lane(0));
    let d = Vec3A::new(dir.x.lane(0), dir.y.lane(0), dir.z.lane(0));
    let along = |i: u32| (tree.nodes[i as usize].aabb.center() - o).dot(d);
    if along(first) <= along(first + 1) { (first, first + 1) } else { (first + 1, first) }
}
