//! A lattice that grows: every number of samples, from the first on, is spread evenly.
//!
//! Sample i has the fraction f, whose bits are those of i in reverse order (van der Corput), and the point `(f, A f)`
//! modulo 1: the first `2^m` are the rank-1 lattice `(k, A k) / 2^m` for every m (Hickernell, Hong, L'Ecuyer and Lemieux
//! 2000). The position in the pixel is a second such lattice, of `B f`. Each pixel shifts every
//! number by a random one of its own (Cranley and Patterson 1976), so that each sample is uniform, and
//! every prefix unbiased.

use super::RUN;
use super::dimension::Dimension;
use super::unit::to_unit;
use crate::lanes::Lanes;

/// Slope of the lattice. The shortest vector of the first `2^m` points, over that of a hexagonal lattice, is at least 0.49
/// for m = 3 to 24, and for squares stretched by 0.08 to 5, into which lights and lobes cut the unit square.
const A: u32 = 0x0002_21a5;

/// Slope between the position in the pixel and the direction.
const B: u32 = 0xff10_7f27;

/// By axis, a number for each sample of a run: the lattice before any pixel shifts it, in units of 2^-32.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lattice {
    direction: [[u32; RUN + 1]; 2],
    pixel: [[u32; RUN + 1]; 2],
}

impl Lattice {
    pub(super) const NOTHING: Self = Self { direction: [[0; RUN + 1]; 2], pixel: [[0; RUN + 1]; 2] };

    /// By axis, the numbers of a dimension.
    #[inline(always)]
    pub(super) fn of(&self, dimension: Dimension) -> &[[u32; RUN + 1]; 2] {
        if dimension == Dimension::Pixel { &self.pixel } else { &self.direction }
    }

    /// Turns to the samples from `first` on.
    #[inline(always)]
    pub(super) fn start(&mut self, first: u32, length: u32) {
        for i in 0..length as usize {
            let f = first.wrapping_add(i as u32).reverse_bits();
            let g = f.wrapping_mul(B);
            for (axis, slope) in [1, A].into_iter().enumerate() {
                self.direction[axis][i] = f.wrapping_mul(slope);
                self.pixel[axis][i] = g.wrapping_mul(slope);
            }
        }
    }
}

/// A number of the lattice with a pixel's own shift, in [0, 1).
#[inline(always)]
pub(super) fn shifted<L: Lanes>(number: L::U, shift: L::U) -> L::F {
    to_unit::<L>(number + shift)
}
