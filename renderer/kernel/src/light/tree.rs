//! Which of many lights a ray may hit: a tree over their boxes, so that a direction's density does not take a time that
//! grows with the number of lights.
//!
//! It only narrows the lights down. Each ray gets a short list, in the order of their numbers, of lights whose boxes it
//! passes; those are then asked as all would be asked without a tree, and their densities summed in the same order, to the
//! same bits. Boxes and passages are widened by far more than rounding amounts to. Only facets seen edge-on could be
//! hit, by rounding, outside their boxes: where there is a tree they are not.
//!
//! Every ray is walked alone: light samples of one packet go to as many lights as there are lanes.

use crate::geometry::bvh::{Binary, FAN, INNER, KIND_BITS, LEVELS, Node, near_and_far, reciprocal};
use crate::lanes::{Lanes, Mask, PACKET, Place, Real, V3};
use crate::stop::{Stop, Stopped};
use obvhs::aabb::Aabb;

/// Longest list of a ray. One that may hit more lights has to ask all.
pub const MOST_HITS: usize = 8;

/// What boxes and passages are widened by, as a fraction of their size.
const WIDER: f32 = 1e-5;

/// Densities and radiances of lights that are not a few spheres, compiled out of line.
pub struct ManyLights;
impl Place for ManyLights {}

/// The tree.
pub struct LightTree {
    nodes: Vec<Node>,
}

/// For each ray of a packet the lights that it may hit.
pub struct LightHits {
    /// `[place in the list][lane]`, ascending.
    numbers: [[u32; PACKET]; MOST_HITS],
    /// By lane: how many there are, [`MOST_HITS`] + 1 for too many.
    counts: [u32; PACKET],
}

impl std::fmt::Debug for LightTree {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "LightTree {{ {} nodes }}", self.nodes.len())
    }
}

impl LightTree {
    /// Over the boxes of lights, at least one.
    ///
    /// # Errors
    /// If it is stopped.
    pub fn new(boxes: &[Aabb], stop: Stop<'_>) -> Result<Self, Stopped> {
        let wide: Vec<Aabb> = boxes
            .iter()
            .map(|b| {
                let pad = b.min.abs().max(b.max.abs()).max_element() * WIDER;
                Aabb::new(b.min - pad, b.max + pad)
            })
            .collect();
        let binary = Binary::new(&wide, wide.len(), 1, stop)?;
        Ok(Self { nodes: binary.collapse(stop, |_, numbers| numbers[0] << KIND_BITS)? })
    }

    /// The lights that each ray may hit.
    #[inline(always)]
    pub fn may_hit<L: Lanes>(&self, l: L, origin: V3<L>, dir: V3<L>) -> LightHits {
        let inverse = reciprocal(l, dir);
        let mut rays = [[0.0; PACKET]; 6];
        for (to, v) in rays.iter_mut().zip([origin.x, origin.y, origin.z, inverse.x, inverse.y, inverse.z]) {
            v.store(to);
        }
        let mut hit = LightHits { numbers: [[0; PACKET]; MOST_HITS], counts: [0; PACKET] };
        for lane in 0..L::N {
            self.walk(l.part(), &rays, lane, &mut hit);
        }
        hit
    }

    /// Makes the list of one ray: origin and inverse direction from `rays`.
    #[inline(always)]
    fn walk<L: Lanes>(&self, l: L, rays: &[[f32; PACKET]; 6], lane: usize, hit: &mut LightHits) {
        let [ox, oy, oz, ix, iy, iz] = rays;
        let [ox, oy, oz, ix, iy, iz] = [ox[lane], oy[lane], oz[lane], ix[lane], iy[lane], iz[lane]];
        let (near, far) = near_and_far([ix < 0.0, iy < 0.0, iz < 0.0]);
        let mut waiting = [0u32; LEVELS * (FAN - 1) + 1];
        waiting[0] = 1;
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let node = &self.nodes[waiting[depth] as usize];
            let mut k = 0;
            while k < FAN {
                let from = [
                    (l.load(&node.planes[near[0]][k..]) - ox) * ix,
                    (l.load(&node.planes[near[1]][k..]) - oy) * iy,
                    (l.load(&node.planes[near[2]][k..]) - oz) * iz,
                ];
                let to = [
                    (l.load(&node.planes[far[0]][k..]) - ox) * ix,
                    (l.load(&node.planes[far[1]][k..]) - oy) * iy,
                    (l.load(&node.planes[far[2]][k..]) - oz) * iz,
                ];
                let enter = from[0].max(from[1]).max(from[2].max(l.f(0.0))) * (1.0 - WIDER);
                let leave = to[0].min(to[1]).min(to[2]) * (1.0 + WIDER);
                let mut passed = enter.le(leave).bits();
                while passed != 0 {
                    let child = node.child[k + passed.trailing_zeros() as usize];
                    passed &= passed - 1;
                    if child & INNER != 0 {
                        waiting[depth] = child >> KIND_BITS;
                        depth += 1;
                    } else if !hit.insert(lane, child >> KIND_BITS) {
                        return;
                    }
                }
                k += L::N;
            }
        }
    }
}

impl LightHits {
    /// Puts a light into a ray's list, where its number belongs. False if that is too long now.
    #[inline(always)]
    fn insert(&mut self, lane: usize, number: u32) -> bool {
        let count = self.counts[lane] as usize;
        self.counts[lane] += 1;
        if count == MOST_HITS {
            return false;
        }
        let mut at = count;
        while at > 0 && self.numbers[at - 1][lane] > number {
            self.numbers[at][lane] = self.numbers[at - 1][lane];
            at -= 1;
        }
        self.numbers[at][lane] = number;
        true
    }

    /// Length of the longest list, and the lanes (as bits) whose list is too long to be one.
    #[inline(always)]
    pub fn longest<L: Lanes>(&self) -> (usize, u32) {
        let (mut longest, mut too_many) = (0, 0);
        for (lane, &count) in self.counts[..L::N].iter().enumerate() {
            if count as usize > MOST_HITS {
                too_many |= 1 << lane;
            } else {
                longest = longest.max(count as usize);
            }
        }
        (longest, too_many)
    }

    /// The `k`-th light of each list, and the lanes (as bits) that have so many and not too many. Elsewhere the number of
    /// some light.
    #[inline(always)]
    pub fn get<L: Lanes>(&self, k: usize) -> (&[u32; PACKET], u32) {
        let mut there = 0;
        for (lane, &count) in self.counts[..L::N].iter().enumerate() {
            there |= u32::from(count as usize > k && count as usize <= MOST_HITS) << lane;
        }
        (&self.numbers[k], there)
    }
}
