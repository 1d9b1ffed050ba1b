//! Random numbers: every one a function of (seed, pixel, sample index, dimension).
//!
//! No state is carried from sample to sample, so that pixels, samples and techniques may be
//! computed in any order, on any thread, skipped or replayed, and give the same bits.

mod dimension;
pub mod hash;
mod lattice;
mod numbers;
mod sobol;
mod spread;
mod strata;
mod strata_lattice;
mod unit;

use crate::lanes::{Lanes, Mask, PACKET, Real, Uint};
use crate::request::{PerTechnique, SamplerKind, SamplerSettings};
pub use dimension::Dimension;
use dimension::STREAMS;
use hash::{mix, mix_on, mix_one};
use lattice::Lattice;
pub use numbers::Numbers;
use sobol::{scramble, sobol_1d, sobol_2d};
use strata::{Order, Shuffle, Strata, nested};
use strata_lattice::{Place, StrataLattice, Turn};
use unit::{HALF, UNIT, in_stratum};

/// What distinguishes the pixels of a packet, for one seed. Different pixels (of images up to
/// 65536 squared) have different keys.
#[inline(always)]
pub fn pixel_keys<L: Lanes>(l: L, seed: u32, x: L::U, y: L::U) -> L::U {
    let h = mix(l, ((y << 16) | x) ^ l.u(mix_one(seed)));
    mix(l, h + l.u(mix_one(seed ^ 0x9e37_79b9)))
}

/// What distinguishes the patch whose first pixel is (x, y), for one seed.
pub fn patch_key(seed: u32, [x, y]: [u32; 2]) -> u32 {
    mix_one(mix_one((y << 16) | x) ^ mix_one(seed ^ 0x85eb_ca6b))
}

/// Which sample of a run to draw.
#[derive(Clone, Copy)]
pub struct Which<L: Lanes> {
    /// That one,
    pub sample: usize,
    /// and the one after it where true.
    pub next: L::M,
}

impl<L: Lanes> Which<L> {
    /// What belongs to the sample, from a table by sample.
    #[inline(always)]
    fn of(&self, l: L, table: &Table) -> L::U {
        self.next.select_u(l.u(table[self.sample + 1]), l.u(table[self.sample]))
    }
}

/// A number by sample of a run; the last one means nothing.
type Table = [u32; RUN + 1];

/// Draws the random numbers of the pixels of a patch, a run of samples at a time. It keeps what the pixels have in
/// common; each one's own are [`Pixels`].
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    settings: SamplerSettings,
    /// By dimension: whether it has numbers of its own that anybody asks for.
    wanted: [bool; COUNT],
    /// The patch's own.
    key: u32,
    /// First sample of the run, and the round of strata that it belongs to.
    first: u32,
    round: u32,
    /// By dimension and sample of the run: what tells its random numbers from others.
    counters: [Table; COUNT],
    /// By sample of the run: its number, bits reversed.
    reversed: Table,
    strata: Strata,
    /// By dimension: the stratum that comes with each sample of the run, before each pixel shuffles it.
    order: [Table; COUNT],
    lattice: Lattice,
    strata_lattice: StrataLattice,
}

/// Most samples of a run.
pub const RUN: usize = PACKET;

/// How many dimensions there are.
const COUNT: usize = Dimension::ALL.len();

/// What tells the pixels of a packet from others, for one round of strata.
#[derive(Clone, Copy)]
pub struct Pixels<L: Lanes> {
    keys: L::U,
    /// By dimension: how the strata are shuffled.
    shuffles: [Shuffle<L>; COUNT],
    /// By dimension: how Sobol points are scrambled, and, the last two, how a lattice is shifted.
    scrambles: [[L::U; 3]; COUNT],
    /// By dimension: how a lattice of strata is rotated.
    turns: [Turn<L>; COUNT],
}

impl<L: Lanes> Pixels<L> {
    /// Those with these [`pixel_keys`], for [`Sampler::turn`] to turn.
    #[inline(always)]
    pub fn new(l: L, keys: L::U) -> Self {
        let still = Shuffle { key: l.u(0), factor: l.u(1), shift: l.u(0) };
        let (shuffles, scrambles) = ([still; COUNT], [[l.u(0); 3]; COUNT]);
        Self { keys, shuffles, scrambles, turns: [Turn::none(l); COUNT] }
    }

    /// Others, not turned yet.
    #[inline(always)]
    pub fn change(&mut self, keys: L::U) {
        self.keys = keys;
    }
}

impl Sampler {
    /// A sampler for the dimensions that are wanted.
    pub fn new(settings: &SamplerSettings, wanted: [bool; COUNT]) -> Self {
        let kind = settings.kind;
        let rows_and_columns = if kind == SamplerKind::StrataLattice { settings.strata } else { [1; 2] };
        Self {
            settings: *settings,
            wanted: if kind.is_nested() { Dimension::once_nested(wanted) } else { wanted },
            key: 0,
            first: 0,
            round: 0,
            counters: [[0; RUN + 1]; COUNT],
            reversed: [0; RUN + 1],
            strata: Strata::new(settings.strata[0] * settings.strata[1]),
            order: [[0; RUN + 1]; COUNT],
            lattice: Lattice::NOTHING,
            strata_lattice: StrataLattice::new(rows_and_columns),
        }
    }

    /// Room for the numbers of a sample, all of them zero.
    #[inline(always)]
    pub fn nothing<L: Lanes>(&self, l: L) -> Numbers<L> {
        Numbers::nothing(l, self.settings.kind.is_nested())
    }

    /// Turns to samples number `first` and after, in any patch. Returns how many the run holds, 1 to [`RUN`]: no
    /// more than are `left`, nor than their round of strata has.
    #[inline(always)]
    pub fn start(&mut self, first: u32, left: u32) -> u32 {
        let n = self.strata.n;
        let mut length = left.min(RUN as u32);
        self.first = first;
        if self.settings.kind.has_strata() {
            self.round = first / n;
            length = length.min(n - first % n);
        }
        match self.settings.kind {
            SamplerKind::Independent | SamplerKind::Stratified => {
                for (d, counters) in self.counters.iter_mut().enumerate().filter(|(d, _)| self.wanted[*d]) {
                    for (i, counter) in counters.iter_mut().enumerate().take(length as usize) {
                        // A bijection of the index: no number of a pixel comes twice in 2^32 samples.
                        *counter = mix_one(first.wrapping_add(i as u32) ^ STREAMS[d].0);
                    }
                }
            }
            SamplerKind::Sobol => {
                for (i, reversed) in self.reversed.iter_mut().enumerate().take(length as usize) {
                    *reversed = (first + i as u32).reverse_bits();
                }
            }
            SamplerKind::Lattice => self.lattice.start(first, length),
            SamplerKind::StrataLattice => self.strata_lattice.start(first % n, length),
        }
        length
    }

    /// Turns to the patch with this [`patch_key`]. Its [`Pixels`] have to be turned next.
    #[inline(always)]
    pub fn enter<L: Lanes>(&mut self, l: L, key: u32) {
        self.key = key;
        if self.settings.kind != SamplerKind::Stratified {
            return;
        }
        for dimension in Dimension::ALL {
            let d = dimension as usize;
            if !self.wanted[d] {
                continue;
            }
            if self.alternates(dimension) {
                for (i, stratum) in self.order[d].iter_mut().enumerate() {
                    *stratum = self.strata.reversed(self.first % self.strata.n + i as u32);
                }
                continue;
            }
            let order = Order::new(self.strata, self.key ^ round_key(self.round, dimension));
            let mut i = 0;
            // All positions of the run at once, or as many as there are lanes. What lies beyond is not used.
            while i < RUN {
                let position = l.iota() + l.u(self.first % self.strata.n + i as u32);
                order.place(l, position).store(&mut self.order[d][i..]);
                i += L::N;
            }
        }
    }

    /// Turns the pixels to the round of the run.
    #[inline(always)]
    pub fn turn<L: Lanes>(&self, l: L, pixels: &mut Pixels<L>) {
        let keys = pixels.keys;
        for dimension in Dimension::ALL {
            let d = dimension as usize;
            if !self.wanted[d] {
                continue;
            }
            match self.settings.kind {
                SamplerKind::Independent => {}
                SamplerKind::Stratified => {
                    let key = mix(l, keys ^ l.u(round_key(self.round, dimension)));
                    pixels.shuffles[d] =
                        if self.alternates(dimension) { nested(l, key) } else { self.strata.shuffle(l, key) };
                }
                SamplerKind::Sobol => {
                    pixels.scrambles[d] = scramble(l, mix(l, keys ^ l.u(mix_one(0x51ed_270b ^ dimension as u32))));
                }
                SamplerKind::Lattice => {
                    let place = self.place_of(dimension) as u32;
                    pixels.scrambles[d] = scramble(l, mix(l, keys ^ l.u(mix_one(0x2545_f491 ^ place))));
                }
                SamplerKind::StrataLattice => {
                    let key = mix(l, keys ^ l.u(round_key(self.round, self.place_of(dimension))));
                    pixels.turns[d] = Turn::new(l, key, self.settings.strata, self.settings.jitter);
                }
            }
        }
    }

    /// True where the strata of a dimension are not visited in random order, but so that any 2^k successive samples from a
    /// multiple of 2^k on, of all strata in a row, are as far apart as can be: the techniques of the one-sample model then
    /// alternate, so that luck does not decide which one comes how often, and the kernel can work on pairs of samples that
    /// have one of each.
    #[inline(always)]
    fn alternates(&self, dimension: Dimension) -> bool {
        dimension == Dimension::Technique && self.strata.n.is_power_of_two()
    }

    /// The dimension whose random shift moves a lattice for this one. The first direction of a sample has the same
    /// whichever technique draws it, so that the techniques share a pattern where only one of them is drawn.
    #[inline(always)]
    fn place_of(&self, dimension: Dimension) -> Dimension {
        match dimension {
            Dimension::Bsdf if self.wanted[Dimension::Light as usize] => Dimension::Bsdf,
            Dimension::Technique | Dimension::LightChoice | Dimension::Light | Dimension::Lobe | Dimension::Bsdf => {
                Dimension::Light
            }
            Dimension::Pixel => Dimension::Pixel,
        }
    }

    /// The number that says which technique draws sample `i` of the run.
    #[inline(always)]
    pub fn technique<L: Lanes>(&self, l: L, i: usize, pixels: &Pixels<L>) -> L::F {
        self.number(l, Which { sample: i, next: l.m(false) }, pixels, Dimension::Technique)
    }

    /// The other numbers of a sample of the run. Dimensions that are not wanted are left as they are, and so are those of
    /// a technique that is not `drawn`. (All in one place and one loop: a call of its own
    /// for every use made the kernel six times as large and its compilation minutes long.)
    #[inline(always)]
    pub fn draw<L: Lanes>(
        &self,
        l: L,
        which: Which<L>,
        pixels: &Pixels<L>,
        drawn: PerTechnique<bool>,
        numbers: &mut Numbers<L>,
    ) {
        for (dimension, drawn) in [(Dimension::LightChoice, drawn.light), (Dimension::Lobe, drawn.bsdf)] {
            if self.wanted[dimension as usize] && drawn {
                numbers.set_1d(dimension, self.number(l, which, pixels, dimension));
            }
        }
        for (dimension, drawn) in
            [(Dimension::Pixel, true), (Dimension::Light, drawn.light), (Dimension::Bsdf, drawn.bsdf)]
        {
            let d = dimension as usize;
            if self.wanted[d] && drawn {
                numbers.set(dimension, self.pair(l, which, pixels, dimension));
            }
        }
        // The technique's number is there already: it is the first one of its direction, this is the second.
        let technique = Dimension::Technique;
        if self.wanted[technique as usize] {
            let second = match self.settings.kind {
                SamplerKind::Independent | SamplerKind::Stratified | SamplerKind::Sobol => None,
                SamplerKind::Lattice => Some(self.lattice(l, which, pixels, technique, 1)),
                SamplerKind::StrataLattice => Some(self.strata_lattice(l, which, pixels, technique, 1)),
            };
            if let Some(v) = second {
                numbers.set(technique, [numbers.get_1d(technique), v]);
            }
        }
    }

    /// The numbers of a sample in a dimension that has two.
    #[inline(always)]
    fn pair<L: Lanes>(&self, l: L, which: Which<L>, pixels: &Pixels<L>, dimension: Dimension) -> [L::F; 2] {
        let d = dimension as usize;
        match self.settings.kind {
            SamplerKind::Independent => {
                let [x, y] = self.pair_of_bits(l, which, pixels, d);
                [x * UNIT, y * UNIT]
            }
            SamplerKind::Stratified => {
                let [nx, ny] = self.settings.strata;
                let jitter = self.settings.jitter;
                let [jx, jy] = if jitter { self.pair_of_bits(l, which, pixels, d) } else { [l.f(HALF); 2] };
                let stratum = which.of(l, &self.order[d]);
                let stratum = self.strata.place(l, stratum, &pixels.shuffles[d]).to_real();
                // The half keeps the quotient clear of integers.
                let row = ((stratum + 0.5) * (1.0 / nx as f32)).to_uint().to_real();
                let column = stratum - row * nx as f32;
                [in_stratum(l, column, nx, jx), in_stratum(l, row, ny, jy)]
            }
            SamplerKind::Sobol => sobol_2d(l, which.of(l, &self.reversed), &pixels.scrambles[d]),
            SamplerKind::StrataLattice if dimension == Dimension::Pixel && !self.settings.jitter => {
                self.strata_lattice.centre(l, &self.place(l, which, dimension), &pixels.turns[d])
            }
            SamplerKind::Lattice => {
                [self.lattice(l, which, pixels, dimension, 0), self.lattice(l, which, pixels, dimension, 1)]
            }
            SamplerKind::StrataLattice => {
                let (place, turn) = (self.place(l, which, dimension), &pixels.turns[d]);
                [self.strata_lattice.x(l, &place, turn), self.strata_lattice.y(l, &place, turn)]
            }
        }
    }

    /// The number of a sample in a dimension that has one; the first one of a lattice.
    #[inline(always)]
    fn number<L: Lanes>(&self, l: L, which: Which<L>, pixels: &Pixels<L>, dimension: Dimension) -> L::F {
        let d = dimension as usize;
        match self.settings.kind {
            SamplerKind::Independent => self.bits(l, which, pixels, d) * UNIT,
            SamplerKind::Stratified => {
                let offset = if self.settings.jitter { self.bits(l, which, pixels, d) } else { l.f(HALF) };
                let (stratum, shuffle) = (which.of(l, &self.order[d]), &pixels.shuffles[d]);
                let stratum = if self.alternates(dimension) {
                    self.strata.place_nested(l, stratum, shuffle)
                } else {
                    self.strata.place(l, stratum, shuffle)
                };
                in_stratum(l, stratum.to_real(), self.strata.n, offset)
            }
            SamplerKind::Sobol => sobol_1d(l, which.of(l, &self.reversed), &pixels.scrambles[d]),
            SamplerKind::Lattice => self.lattice(l, which, pixels, dimension, 0),
            SamplerKind::StrataLattice => self.strata_lattice(l, which, pixels, dimension, 0),
        }
    }

    /// A number of the lattice that grows, by axis.
    #[inline(always)]
    fn lattice<L: Lanes>(&self, l: L, which: Which<L>, pixels: &Pixels<L>, dimension: Dimension, axis: usize) -> L::F {
        let Lattice { pixel, direction } = &self.lattice;
        let table = if dimension == Dimension::Pixel { pixel } else { direction };
        lattice::shifted::<L>(which.of(l, &table[axis]), pixels.scrambles[dimension as usize][axis + 1])
    }

    /// A number of the lattice of strata, by axis.
    #[inline(always)]
    fn strata_lattice<L: Lanes>(
        &self,
        l: L,
        which: Which<L>,
        pixels: &Pixels<L>,
        dimension: Dimension,
        axis: usize,
    ) -> L::F {
        let place = self.place(l, which, dimension);
        let turn = &pixels.turns[dimension as usize];
        if axis == 0 { self.strata_lattice.x(l, &place, turn) } else { self.strata_lattice.y(l, &place, turn) }
    }

    /// Where a sample is in the lattice of strata.
    #[inline(always)]
    fn place<L: Lanes>(&self, l: L, which: Which<L>, dimension: Dimension) -> Place<L> {
        let StrataLattice { pixel, direction, .. } = &self.strata_lattice;
        let places = if dimension == Dimension::Pixel { pixel } else { direction };
        Place {
            column: which.of(l, &places.column),
            slot: which.of(l, &places.slot),
            row: which.of(l, &places.row),
            slot_of_row: which.of(l, &places.slot_of_row),
        }
    }

    /// 24 random bits as a number in [0, 2^24), uniform and independent over pixels, samples and dimensions.
    #[inline(always)]
    fn bits<L: Lanes>(&self, l: L, which: Which<L>, pixels: &Pixels<L>, d: usize) -> L::F {
        let first = mix(l, pixels.keys ^ which.of(l, &self.counters[d]));
        let bits = if STREAMS[d].1 == 0 { first } else { mix_on(l, first) };
        (bits >> 8).to_real()
    }

    /// Two such numbers.
    #[inline(always)]
    fn pair_of_bits<L: Lanes>(&self, l: L, which: Which<L>, pixels: &Pixels<L>, d: usize) -> [L::F; 2] {
        let first = mix(l, pixels.keys ^ which.of(l, &self.counters[d]));
        [(first >> 8).to_real(), (mix_on(l, first) >> 8).to_real()]
    }
}

/// What tells the strata of one dimension and round from others.
fn round_key(round: u32, dimension: Dimension) -> u32 {
    mix_one(round.wrapping_mul(8) + dimension as u32 + 1)
}

#[cfg(test)]
mod tests;
