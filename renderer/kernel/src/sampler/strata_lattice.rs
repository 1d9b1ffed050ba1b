//! A lattice of N = n x m samples with one in each of n x m cells, and one in each of N slots of either axis.
//!
//! Sample k of the lattice is in column `k div m`, in the `k mod m`-th slot of it. Golden permutations s of the rows and t
//! of the columns say where it is along y:
//!
//! ```text
//! x = k / N,      y = (s(k mod m) + t(k div m) / n) / m
//! ```
//!
//! These are multi-jittered samples (Chiu, Shirley and Wang 1994), regular instead of random. Each pixel rotates the columns,
//! the slots in a column, the rows and the slots in a row by random numbers of its own, which keeps all of that and makes
//! each sample uniform; in each round of N samples by others.

use super::RUN;
use super::hash::mix;
use super::spread::{Golden, Orders};
use super::strata::rotate;
use super::unit::{HALF, in_stratum};
use crate::lanes::{Lanes, Uint};

/// What the pixels have in common: for a run of samples, where each is before any pixel rotates it.
#[derive(Clone, Copy, Debug)]
pub(super) struct StrataLattice {
    /// n columns and m rows.
    strata: [u32; 2],
    columns: Golden,
    rows: Golden,
    orders: Orders,
    /// Of the direction's numbers, and of the position in the pixel.
    pub(super) direction: Places,
    pub(super) pixel: Places,
}

/// By sample of a run: its column and slot there, `k div m` and `k mod m`, and where [`Golden`] takes either.
#[derive(Clone, Copy, Debug)]
pub(super) struct Places {
    pub(super) column: [u32; RUN + 1],
    pub(super) slot: [u32; RUN + 1],
    pub(super) row: [u32; RUN + 1],
    pub(super) slot_of_row: [u32; RUN + 1],
}

impl Places {
    const NOTHING: Self =
        Self { column: [0; RUN + 1], slot: [0; RUN + 1], row: [0; RUN + 1], slot_of_row: [0; RUN + 1] };
}

impl StrataLattice {
    pub(super) fn new(strata @ [n, m]: [u32; 2]) -> Self {
        let (columns, rows) = (Golden::new(n), Golden::new(m));
        let orders = Orders::new(n * m);
        Self { strata, columns, rows, orders, direction: Places::NOTHING, pixel: Places::NOTHING }
    }

    /// Turns to the samples from `first` on, counted in their round.
    #[inline(always)]
    pub(super) fn start(&mut self, first: u32, length: u32) {
        let m = self.strata[1];
        for i in 0..length as usize {
            let [direction, pixel] = self.orders.place(first + i as u32);
            for (places, k) in [(&mut self.direction, direction), (&mut self.pixel, pixel)] {
                (places.column[i], places.slot[i]) = (k / m, k % m);
                (places.row[i], places.slot_of_row[i]) = (self.rows.place(k % m), self.columns.place(k / m));
            }
        }
    }

    /// The first number of a pixel's sample.
    #[inline(always)]
    pub(super) fn x<L: Lanes>(&self, l: L, place: &Place<L>, turn: &Turn<L>) -> L::F {
        let [n, m] = self.strata;
        let column = rotate(l, place.column, turn.column, n).to_real();
        let slot = rotate(l, place.slot, turn.slot, m).to_real();
        in_stratum(l, column * m as f32 + slot, n * m, turn.offset[0])
    }

    /// The second number.
    #[inline(always)]
    pub(super) fn y<L: Lanes>(&self, l: L, place: &Place<L>, turn: &Turn<L>) -> L::F {
        let [n, m] = self.strata;
        let row = self.rows.rotated(l, [place.slot, place.row], turn.slot, turn.row);
        let slot = self.columns.rotated(l, [place.column, place.slot_of_row], turn.column, turn.slot_of_row);
        in_stratum(l, row * n as f32 + slot, n * m, turn.offset[1])
    }

    /// The centre of the cell that a pixel's sample is in.
    #[inline(always)]
    pub(super) fn centre<L: Lanes>(&self, l: L, place: &Place<L>, turn: &Turn<L>) -> [L::F; 2] {
        let [n, m] = self.strata;
        let column = rotate(l, place.column, turn.column, n).to_real();
        let row = self.rows.rotated(l, [place.slot, place.row], turn.slot, turn.row);
        [in_stratum(l, column, n, l.f(HALF)), in_stratum(l, row, m, l.f(HALF))]
    }
}

/// Of [`Places`], those of one sample of each pixel.
#[derive(Clone, Copy)]
pub(super) struct Place<L: Lanes> {
    pub(super) column: L::U,
    pub(super) slot: L::U,
    pub(super) row: L::U,
    pub(super) slot_of_row: L::U,
}

/// How a pixel rotates the lattice.
#[derive(Clone, Copy)]
pub(super) struct Turn<L: Lanes> {
    /// 0 to n - 1, m - 1, m - 1, n - 1.
    column: L::U,
    slot: L::U,
    row: L::U,
    slot_of_row: L::U,
    /// Where in the slots of both axes, in units of 2^-24: the same for all samples.
    offset: [L::F; 2],
}

impl<L: Lanes> Turn<L> {
    /// None at all.
    #[inline(always)]
    pub(super) fn none(l: L) -> Self {
        let zero = l.u(0);
        Self { column: zero, slot: zero, row: zero, slot_of_row: zero, offset: [l.f(HALF); 2] }
    }

    /// The one that the random bits of `key` name. Without `jitter` samples are in the middle of their slots.
    #[inline(always)]
    pub(super) fn new(l: L, key: L::U, [n, m]: [u32; 2], jitter: bool) -> Self {
        let first = mix(l, key + l.u(1));
        let mut offset = [l.f(HALF); 2];
        if jitter {
            offset = [(mix(l, key + l.u(2)) >> 8).to_real(), (mix(l, key + l.u(3)) >> 8).to_real()];
        }
        let low = l.u(0xffff);
        Self {
            column: below(l, key >> 16, n),
            slot: below(l, key & low, m),
            row: below(l, first >> 16, m),
            slot_of_row: below(l, first & low, n),
            offset,
        }
    }
}

/// 0 to n - 1, from 16 random bits r: floor(r n / 2^16), uniform to 2^-16 n.
#[inline(always)]
fn below<L: Lanes>(l: L, bits: L::U, n: u32) -> L::U {
    (bits * l.u(n)) >> 16
}
