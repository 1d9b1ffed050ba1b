//! Rays in lanes.

use glam::Vec3;
use mislab_kernel::lanes::{Lanes, PACKET, V3};

/// The first `L::N` of these vectors, one in each lane.
#[inline(always)]
pub fn vector<L: Lanes>(l: L, v: &[Vec3; PACKET]) -> V3<L> {
    let [mut x, mut y, mut z] = [[0.0; PACKET]; 3];
    for i in 0..PACKET {
        (x[i], y[i], z[i]) = (v[i].x, v[i].y, v[i].z);
    }
    V3 { x: l.load(&x), y: l.load(&y), z: l.load(&z) }
}
