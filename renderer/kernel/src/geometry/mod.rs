//! All surfaces of a scene, and the two questions asked of them: what does a ray hit first, and
//! is anything in its way.

pub mod bounds;
pub mod bvh;
pub mod grid;
pub mod hit;
pub mod list;
pub mod shape;

use std::fmt;

use glam::Vec3;

use crate::lanes::{Lanes, Mask, PACKET, Real, Uint, V3};
use crate::stop::{Stop, Stopped};
use bvh::Tree;
use hit::Nearest;
use list::List;
use shape::{Ball, Facet};

/// Up to so many primitives a list is searched from end to end; a tree pays from about there.
const FLAT_LIMIT: usize = 24;

/// Opaque primitives: facets first, then spheres; the index over both is the primitive's id.
pub struct BuiltGeometry {
    /// Triangles and parallelograms.
    pub facets: Vec<Facet>,
    /// Spheres.
    pub balls: Vec<Ball>,
    tree: Option<Tree>,
    bounds: (Vec3, Vec3),
}

impl fmt::Debug for BuiltGeometry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let nodes = self.tree.as_ref().map_or(0, |tree| tree.node_count());
        write!(f, "Geometry {{ {} facets, {} balls, {nodes} nodes }}", self.facets.len(), self.balls.len())
    }
}

impl BuiltGeometry {
    /// Collects the primitives and builds a tree over them if there are many.
    ///
    /// # Errors
    /// If it is stopped.
    pub fn new(mut facets: Vec<Facet>, mut balls: Vec<Ball>, stop: Stop<'_>) -> Result<Self, Stopped> {
        let mut min = Vec3::INFINITY;
        let mut max = Vec3::NEG_INFINITY;
        for p in facets.iter().flat_map(Facet::corners) {
            min = min.min(p);
            max = max.max(p);
        }
        for ball in &balls {
            min = min.min(ball.center - ball.radius);
            max = max.max(ball.center + ball.radius);
        }
        let many = facets.len() + balls.len() > FLAT_LIMIT;
        let tree = many.then(|| Tree::new(&mut facets, &mut balls, stop)).transpose()?;
        Ok(Self { facets, balls, tree, bounds: (min, max) })
    }

    /// Number of primitives.
    pub fn len(&self) -> usize {
        self.facets.len() + self.balls.len()
    }

    /// True if there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Box around everything; not finite if there is nothing.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds
    }

    /// True where there are so many primitives that a tree is searched, not a list.
    pub fn has_tree(&self) -> bool {
        self.tree.is_some()
    }

    /// First primitive of the list that each ray hits; of all primitives where there is a tree.
    /// Directions are unit vectors.
    #[inline(always)]
    pub fn nearest<L: Lanes>(&self, l: L, origin: V3<L>, dir: V3<L>, list: &List) -> Nearest<L> {
        let t_min = l.f(0.0);
        let mut best = Nearest { t: l.f(f32::INFINITY), id: l.u(0) };
        match &self.tree {
            None => {
                // Facets, then balls: two plain loops, since a choice inside one would carry all vectors
                // through memory.
                let (mut facets, mut balls) = list.split(self.facets.len());
                while let Some(id) = facets.take_first() {
                    let (t, hit) = self.facets[id].intersect(l, origin, dir);
                    best = nearer(l, id, t, hit & t.gt(t_min), best);
                }
                while let Some(id) = balls.take_first() {
                    let t = self.balls[id - self.facets.len()].nearest(l, origin, dir, t_min);
                    best = nearer(l, id, t, l.m(true), best);
                }
            }
            Some(tree) => return walk::<L, false>(l, tree, origin, dir, l.f(f32::INFINITY)),
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
                let (mut facets, mut balls) = list.split(self.facets.len());
                while let Some(id) = facets.take_first() {
                    let (t, hit) = self.facets[id].intersect(l, origin, dir);
                    blocked = blocked | (hit & t.gt(zero) & t.lt(t_max));
                }
                while let Some(id) = balls.take_first() {
                    let t = self.balls[id - self.facets.len()].nearest(l, origin, dir, zero);
                    blocked = blocked | t.lt(t_max);
                }
            }
            Some(tree) => {
                let asked = wanted & t_max.ge(l.f(0.0));
                let t_max = asked.select(t_max, l.f(f32::NEG_INFINITY));
                return asked & walk::<L, true>(l, tree, origin, dir, t_max).t.lt(l.f(0.0));
            }
        }
        blocked
    }
}

/// [`Tree::walk`], as many rays at a time as fill one vector.
#[inline(always)]
fn walk<L: Lanes, const ANY: bool>(l: L, tree: &Tree, origin: V3<L>, dir: V3<L>, t_max: L::F) -> Nearest<L> {
    l.out_of_line::<bvh::Walks, _>(
        #[inline(always)]
        move || walk_parts::<L, ANY>(l, tree, origin, dir, t_max),
    )
}

#[inline(always)]
fn walk_parts<L: Lanes, const ANY: bool>(l: L, tree: &Tree, origin: V3<L>, dir: V3<L>, t_max: L::F) -> Nearest<L> {
    let part = l.part();
    let mut numbers = [[0.0; PACKET]; 7];
    for (to, v) in numbers.iter_mut().zip([origin.x, origin.y, origin.z, dir.x, dir.y, dir.z, t_max]) {
        v.store(to);
    }
    let (mut t, mut id) = ([0.0; PACKET], [0; PACKET]);
    let mut k = 0;
    while k < L::N {
        let [ox, oy, oz, dx, dy, dz, t_max] = &numbers;
        let origin = V3 { x: part.load(&ox[k..]), y: part.load(&oy[k..]), z: part.load(&oz[k..]) };
        let dir = V3 { x: part.load(&dx[k..]), y: part.load(&dy[k..]), z: part.load(&dz[k..]) };
        let hit = tree.walk::<L::Part, ANY>(part, origin, dir, part.load(&t_max[k..]));
        hit.t.store(&mut t[k..]);
        hit.id.store(&mut id[k..]);
        k += L::Part::N;
    }
    Nearest { t: l.load(&t), id: l.load_u(&id) }
}

/// The nearer of what was hit so far and primitive `id`, at distance `t` where `hit`.
#[inline(always)]
fn nearer<L: Lanes>(l: L, id: usize, t: L::F, hit: L::M, best: Nearest<L>) -> Nearest<L> {
    let hit = hit & t.lt(best.t);
    Nearest { t: hit.select(t, best.t), id: hit.select_u(l.u(id as u32), best.id) }
}
