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
//! A technique and a light take their part of x (`numbers.rs`), and with it whole columns where they share out evenly. So that
//! they do, the lattice of directions may have other cells than that of the position in the pixel ([`shared_out`]).
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
    /// Anywhere in its slots, or in the middle; the position in the pixel is then in the middle of its cell.
    jitter: bool,
    orders: Orders,
    pixel: Cells,
    direction: Cells,
}

/// One of its two lattices, of the position in the pixel or of directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    /// n columns and m rows.
    strata: [u32; 2],
    columns: Golden,
    rows: Golden,
    /// Parts of the unit interval: n, m and N.
    column: Parts,
    row: Parts,
    slot: Parts,
    /// By sample of a run, in units of 2^-32: where its column begins, how far its slot is from there, and y.
    start: [u32; RUN + 1],
    offset: [u32; RUN + 1],
    y: [u32; RUN + 1],
}

/// How a pixel rotates the lattice, in units of 2^-32: the columns, with the place in a slot; the slots in a column; y, with
/// the place in a slot there (one addition, [`super::lattice::shifted`]).
pub(super) type Turn<L> = [<L as Lanes>::U; 3];

/// The cells of directions where the pixel has these and choices fall into so many parts: as many in all, in at most twice the columns
/// so that each part has whole ones, if that can be, and two rather than one. With 6 x 6 and four lights, 12 x 3; with 8 x 8, four lights
/// and either technique as often, 16 x 4. Where it cannot be, pairs of parts share.
fn shared_out([n, m]: [u32; 2], parts: usize) -> [u32; 2] {
    let of = |parts: u32, least: u32| {
        (n.max(least)..=2 * n).find(|columns| (n * m).is_multiple_of(*columns) && columns.is_multiple_of(parts))
    };
    let parts = u32::try_from(parts).unwrap_or(u32::MAX).max(1);
    let halves = std::iter::successors(Some(parts), |parts| parts.is_multiple_of(2).then_some(parts / 2));
    let columns = halves.filter_map(|parts| of(parts, parts.saturating_mul(2)).or_else(|| of(parts, 1))).next();
    let columns = columns.unwrap_or(n);
    [columns, n * m / columns]
}

impl StrataLattice {
    /// For n x m samples, and choices that fall into so many parts.
    pub(super) fn new(strata: [u32; 2], jitter: bool, parts: usize) -> Self {
        let [pixel, direction] = [strata, shared_out(strata, parts)].map(Cells::new);
        Self { jitter, orders: Orders::new(strata[0] * strata[1]), pixel, direction }
    }

    /// The lattice of a dimension.
    #[inline(always)]
    pub(super) fn of(&self, dimension: Dimension) -> &Cells {
        if dimension == Dimension::Pixel { &self.pixel } else { &self.direction }
    }

    /// Turns to the samples from `first` on, counted in their round.
    #[inline(always)]
    pub(super) fn start(&mut self, first: u32, length: u32) {
        for i in 0..length as usize {
            let [direction, pixel] = self.orders.place(first + i as u32);
            self.direction.put(i, direction, false);
            self.pixel.put(i, pixel, !self.jitter);
        }
    }

    /// The rotation that the random bits of `key` name.
    #[inline(always)]
    pub(super) fn turn<L: Lanes>(&self, l: L, key: L::U, dimension: Dimension) -> Turn<L> {
        let cells = self.of(dimension);
        let [n, m] = cells.strata;
        let low = l.u(0xffff);
        let (column, slot) = (cells.column.random_start(l, key >> 16, n), key & low);
        if dimension == Dimension::Pixel && !self.jitter {
            let row = cells.row.random_start(l, slot, m);
            return [column + l.u(cells.column.middle()), l.u(0), row + l.u(cells.row.middle())];
        }
        let along_y = cells.slot.random_start(l, mix(l, key + l.u(1)) >> 16, n * m);
        let [mut in_x, mut in_y] = [l.u(cells.slot.middle()); 2];
        if self.jitter {
            in_x = cells.slot.within(l, mix(l, key + l.u(2)));
            in_y = cells.slot.within(l, mix(l, key + l.u(3)));
        }
        [column + in_x, cells.slot.random_start(l, slot, m), along_y + in_y]
    }
}

impl Cells {
    fn new(strata @ [n, m]: [u32; 2]) -> Self {
        Self {
            strata,
            columns: Golden::new(n),
            rows: Golden::new(m),
            column: Parts::new(n),
            row: Parts::new(m),
            slot: Parts::new(n * m),
            start: [0; RUN + 1],
            offset: [0; RUN + 1],
            y: [0; RUN + 1],
        }
    }

    /// Sample i of the run is number k of the lattice, in slots of its own or in the middle of its cell.
    #[inline(always)]
    fn put(&mut self, i: usize, k: u32, in_middle: bool) {
        let [n, m] = self.strata;
        let (along_x, along_y) = (k / m, self.rows.place(k % m));
        self.start[i] = self.column.start(along_x);
        (self.offset[i], self.y[i]) = if in_middle {
            (0, self.row.start(along_y))
        } else {
            (self.slot.start(k % m), self.slot.start(along_y * n + self.columns.place(along_x)))
        };
    }

    /// By sample of the run, the two parts of x, for [`Self::x`].
    pub(super) fn parts_of_x(&self) -> [&[u32; RUN + 1]; 2] {
        [&self.start, &self.offset]
    }

    /// By sample of the run, y.
    pub(super) fn y(&self) -> &[u32; RUN + 1] {
        &self.y
    }

    /// The first number of a pixel's sample, of whose column and slot there these are the places, rotated.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_have_whole_columns_where_they_can() {
        let expected = [
            ([6, 6], 4, [12, 3]),
            ([8, 8], 4, [8, 8]),
            ([8, 8], 8, [16, 4]),
            // Nine rows cannot be cut into eights: pairs of parts have three columns.
            ([9, 8], 8, [12, 6]),
            ([4, 4], 4, [8, 2]),
            ([8, 8], 1, [8, 8]),
            ([8, 8], 5, [8, 8]),
            ([1, 1], 4, [1, 1]),
            ([7, 7], 65, [7, 7]),
        ];
        for (strata, parts, cells) in expected {
            assert_eq!(shared_out(strata, parts), cells, "{strata:?} in {parts}");
        }
    }
}
