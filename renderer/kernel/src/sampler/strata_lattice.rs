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
//! the slots in a column, and y by random numbers of its own, which keeps all of that (the samples of a
//! column are 1/m apart along y) and makes each sample uniform; in each round of N samples by others.
//!
//! Everything is counted in units of 2^-32, so that a rotation of the unit interval is one addition.

use super::RUN;
use super::dimension::Dimension;
use super::hash::mix;
use super::spread::{Golden, Orders};
use super::unit::to_unit;
use crate::lanes::{Lanes, Mask, Uint};

/// What the pixels have in common: for a run of samples, where each is before any pixel rotates it.
#[derive(Clone, Copy, Debug)]
pub(super) struct StrataLattice {
    /// n columns and m rows.
    strata: [u32; 2],
    /// Anywhere in its slots, or in the middle; the position in the pixel is then in the middle of its cell.
    jitter: bool,
    columns: Golden,
    rows: Golden,
    orders: Orders,
    /// Parts of the unit interval: n, m and N.
    column: Parts,
    row: Parts,
    slot: Parts,
    /// Of the direction's numbers, and of the position in the pixel.
    direction: Places,
    pixel: Places,
}

/// By sample of a run, in units of 2^-32: where its column begins, how far its slot is from there, and y.
#[derive(Clone, Copy, Debug)]
pub(super) struct Places {
    column: [u32; RUN + 1],
    slot: [u32; RUN + 1],
    y: [u32; RUN + 1],
}

impl Places {
    const NOTHING: Self = Self { column: [0; RUN + 1], slot: [0; RUN + 1], y: [0; RUN + 1] };

    /// The tables of x: column and slot.
    pub(super) fn x(&self) -> [&[u32; RUN + 1]; 2] {
        [&self.column, &self.slot]
    }

    /// The table of y.
    pub(super) fn y(&self) -> &[u32; RUN + 1] {
        &self.y
    }
}

/// How a pixel rotates the lattice, in units of 2^-32: the columns, with the place in a slot; the slots in a column; y, with
/// the place in a slot there (one addition, [`super::lattice::shifted`]).
pub(super) type Turn<L> = [<L as Lanes>::U; 3];

impl StrataLattice {
    pub(super) fn new(strata @ [n, m]: [u32; 2], jitter: bool) -> Self {
        Self {
            strata,
            jitter,
            columns: Golden::new(n),
            rows: Golden::new(m),
            orders: Orders::new(n * m),
            column: Parts::new(n),
            row: Parts::new(m),
            slot: Parts::new(n * m),
            direction: Places::NOTHING,
            pixel: Places::NOTHING,
        }
    }

    /// Where the samples of the run are in a dimension.
    #[inline(always)]
    pub(super) fn of(&self, dimension: Dimension) -> &Places {
        if dimension == Dimension::Pixel { &self.pixel } else { &self.direction }
    }

    /// Turns to the samples from `first` on, counted in their round.
    #[inline(always)]
    pub(super) fn start(&mut self, first: u32, length: u32) {
        let [n, m] = self.strata;
        let (column, row, slot) = (self.column, self.row, self.slot);
        for i in 0..length as usize {
            let [direction, pixel] = self.orders.place(first + i as u32);
            for (places, k, in_cells) in
                [(&mut self.direction, direction, false), (&mut self.pixel, pixel, !self.jitter)]
            {
                let (along_x, along_y) = (k / m, self.rows.place(k % m));
                places.column[i] = column.start(along_x);
                (places.slot[i], places.y[i]) = if in_cells {
                    (0, row.start(along_y))
                } else {
                    (slot.start(k % m), slot.start(along_y * n + self.columns.place(along_x)))
                };
            }
        }
    }

    /// The rotation that the random bits of `key` name, for the position in a pixel or for a direction.
    #[inline(always)]
    pub(super) fn turn<L: Lanes>(&self, l: L, key: L::U, of_pixel: bool) -> Turn<L> {
        let [n, m] = self.strata;
        let low = l.u(0xffff);
        let (column, slot) = (self.column.random_start(l, key >> 16, n), key & low);
        if of_pixel && !self.jitter {
            let row = self.row.random_start(l, slot, m);
            return [column + l.u(self.column.middle()), l.u(0), row + l.u(self.row.middle())];
        }
        let along_y = self.slot.random_start(l, mix(l, key + l.u(1)) >> 16, n * m);
        let [mut in_x, mut in_y] = [l.u(self.slot.middle()); 2];
        if self.jitter {
            in_x = self.slot.within(l, mix(l, key + l.u(2)));
            in_y = self.slot.within(l, mix(l, key + l.u(3)));
        }
        [column + in_x, self.slot.random_start(l, slot, m), along_y + in_y]
    }

    /// The first number of a pixel's sample: its column and its slot there, rotated.
    #[inline(always)]
    pub(super) fn x<L: Lanes>(&self, l: L, [column, slot]: [L::U; 2], turn: &Turn<L>) -> L::F {
        let (slot, width) = (slot + turn[1], l.u(self.column.width - SLACK));
        let slot = slot.lt(width).select_u(slot, slot - width);
        to_unit::<L>(column + turn[0] + slot)
    }
}

/// By how much places in units of 2^-32 may be off: each is rounded down.
const SLACK: u32 = 4;

/// What is kept free at either end of a slot, so that places stay in it where they are off, and when 24 bits are left.
const MARGIN: u32 = 256 + 4 * SLACK;

/// The unit interval in n equal parts, 1 to 65536.
#[derive(Clone, Copy, Debug)]
struct Parts {
    n: u32,
    /// Width of one in units of 2^-32, rounded down, and 2^16 times what that leaves; of one part, all but the last unit.
    width: u32,
    rest: u32,
}

impl Parts {
    fn new(n: u32) -> Self {
        let (width, left) = ((1u64 << 32) / u64::from(n), (1u64 << 32) % u64::from(n));
        Self { n, width: u32::try_from(width).unwrap_or(u32::MAX), rest: ((left << 16) / u64::from(n)) as u32 }
    }

    /// Where part i begins.
    fn start(self, i: u32) -> u32 {
        ((u64::from(i) << 32) / u64::from(self.n)) as u32
    }

    /// Half of a part.
    fn middle(self) -> u32 {
        self.width / 2
    }

    /// Where one of the first `count` parts begins, by 16 random bits r: part floor(r count / 2^16), uniform
    /// to 2^-16 count.
    #[inline(always)]
    fn random_start<L: Lanes>(self, l: L, bits: L::U, count: u32) -> L::U {
        let part = (bits * l.u(count)) >> 16;
        part * l.u(self.width) + ((part * l.u(self.rest)) >> 16)
    }

    /// Somewhere in a part, but for its ends.
    #[inline(always)]
    fn within<L: Lanes>(self, l: L, bits: L::U) -> L::U {
        let span = self.width - 2 * MARGIN;
        let [high, low] = [span >> 16, span & 0xffff].map(
            #[inline(always)]
            |half| l.u(half),
        );
        let (first, second) = (bits >> 16, bits & l.u(0xffff));
        first * high + ((first * low) >> 16) + ((second * high) >> 16) + l.u(MARGIN)
    }
}
