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
use strata::{Order, Strata, nested};
use strata_lattice::StrataLattice;
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
    /// By dimension: how the pattern is made each pixel's own. Strata are shuffled ([`strata::Shuffle`]), Sobol points
    /// scrambled ([`scramble`]), a lattice is shifted and one of strata rotated ([`strata_lattice::Turn`]).
    own: [[L::U; 3]; COUNT],
}

impl<L: Lanes> Pixels<L> {
    /// Those with these [`pixel_keys`], for [`Sampler::turn`] to turn.
    #[inline(always)]
    pub fn new(l: L, keys: L::U) -> Self {
        Self { keys, own: [[l.u(0); 3]; COUNT] }
    }

    /// Others, not turned yet.
    #[inline(always)]
    pub fn change(&mut self, keys: L::U) {
        self.keys = keys;
    }
}

impl Sampler {
    /// A sampler for the dimensions that are wanted, where choices fall into so many parts ([`Estimator::parts`]).
    ///
    /// [`Estimator::parts`]: crate::request::Estimator::parts
    pub fn new(settings: &SamplerSettings, wanted: [bool; COUNT], parts: usize) -> Self {
        let SamplerSettings { kind, strata, jitter } = *settings;
        let rows_and_columns = if kind == SamplerKind::Stratified { strata } else { [1; 2] };
        Self {
            settings: *settings,
            wanted: if kind.is_nested() { Dimension::once_nested(wanted) } else { wanted },
            key: 0,
            first: 0,
            round: 0,
            counters: [[0; RUN + 1]; COUNT],
            reversed: [0; RUN + 1],
            strata: Strata::new(strata[0] * strata[1]),
            order: [[0; RUN + 1]; COUNT],
            lattice: Lattice::NOTHING,
            strata_lattice: StrataLattice::new(rows_and_columns, jitter, parts),
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
            SamplerKind::Independent | SamplerKind::PaddedStratified => {
                for (d, counters) in self.counters.iter_mut().enumerate().filter(|(d, _)| self.wanted[*d]) {
                    for (i, counter) in counters.iter_mut().enumerate().take(length as usize) {
                        // A bijection of the index: no number of a pixel comes twice in 2^32 samples.
                        *counter = mix_one(first.wrapping_add(i as u32) ^ STREAMS[d].0);
                    }
                }
            }
            SamplerKind::Sobol | SamplerKind::PaddedSobol => {
                for (i, reversed) in self.reversed.iter_mut().enumerate().take(length as usize) {
                    *reversed = (first + i as u32).reverse_bits();
                }
            }
            SamplerKind::Lattice => self.lattice.start(first, length),
            SamplerKind::Stratified => self.strata_lattice.start(first % n, length),
        }
        length
    }

    /// Turns to the patch with this [`patch_key`]. Its [`Pixels`] have to be turned next.
    #[inline(always)]
    pub fn enter<L: Lanes>(&mut self, l: L, key: u32) {
        self.key = key;
        if self.settings.kind != SamplerKind::PaddedStratified {
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
            let place = self.place_of(dimension);
            pixels.own[d] = match self.settings.kind {
                SamplerKind::Independent => continue,
                SamplerKind::PaddedStratified => {
                    let key = mix(l, keys ^ l.u(round_key(self.round, dimension)));
                    if self.alternates(dimension) { nested(l, key) } else { self.strata.shuffle(l, key) }
                }
                SamplerKind::Sobol | SamplerKind::PaddedSobol => {
                    scramble(l, mix(l, keys ^ l.u(mix_one(0x51ed_270b ^ place as u32))))
                }
                SamplerKind::Lattice => scramble(l, mix(l, keys ^ l.u(mix_one(0x2545_f491 ^ place as u32)))),
                SamplerKind::Stratified => {
                    let key = mix(l, keys ^ l.u(round_key(self.round, place)));
                    self.strata_lattice.turn(l, key, dimension)
                }
            };
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

    /// The dimension whose key makes the pattern of this one each pixel's own: itself, if it is padded. Nested, the first
    /// direction of a sample has the same whichever technique draws it, so that the techniques share a pattern
    /// where only one of them is drawn.
    #[inline(always)]
    fn place_of(&self, dimension: Dimension) -> Dimension {
        match dimension {
            _ if !self.settings.kind.is_nested() => dimension,
            Dimension::Bsdf if self.wanted[Dimension::Light as usize] => Dimension::Bsdf,
            Dimension::Technique | Dimension::LightChoice | Dimension::Light | Dimension::Lobe | Dimension::Bsdf => {
                Dimension::Light
            }
            Dimension::Pixel => Dimension::Pixel,
        }
    }

    /// A sample of the run in these pixels.
    #[inline(always)]
    pub fn sample<'a, L: Lanes>(&'a self, l: L, which: Which<L>, pixels: &'a Pixels<L>) -> Drawing<'a, L> {
        Drawing { sampler: self, l, which, pixels }
    }
}

/// The numbers of one sample of each pixel of a packet, to be drawn.
#[derive(Clone, Copy)]
pub struct Drawing<'a, L: Lanes> {
    sampler: &'a Sampler,
    pub(crate) l: L,
    pub(crate) which: Which<L>,
    pixels: &'a Pixels<L>,
}

impl<L: Lanes> Drawing<'_, L> {
    /// The sample after it.
    #[inline(always)]
    pub(crate) fn following(self) -> Self {
        let Which { sample, next } = self.which;
        Self { which: Which { sample: sample + 1, next }, ..self }
    }

    /// The number that says which technique draws the sample.
    #[inline(always)]
    pub fn technique(self) -> L::F {
        self.number(Dimension::Technique)
    }

    /// The other numbers. Dimensions that are not wanted are left as they are, and so are those of a technique that
    /// is not `drawn`. (All in one place and one loop: a call of its own for every use made the kernel
    /// six times as large and its compilation minutes long.)
    #[inline(always)]
    pub fn draw(self, drawn: PerTechnique<bool>, numbers: &mut Numbers<L>) {
        let wanted = &self.sampler.wanted;
        for (dimension, drawn) in [(Dimension::LightChoice, drawn.light), (Dimension::Lobe, drawn.bsdf)] {
            if wanted[dimension as usize] && drawn {
                numbers.set_1d(dimension, self.number(dimension));
            }
        }
        for (dimension, drawn) in
            [(Dimension::Pixel, true), (Dimension::Light, drawn.light), (Dimension::Bsdf, drawn.bsdf)]
        {
            if wanted[dimension as usize] && drawn {
                numbers.set(dimension, self.pair(dimension));
            }
        }
        // The technique's number is there already: it is the first one of its direction, this is the second.
        let technique = Dimension::Technique;
        if wanted[technique as usize] && self.sampler.settings.kind.is_nested() {
            numbers.set(technique, [numbers.get_1d(technique), self.second(technique)]);
        }
    }

    /// The numbers of a dimension that has two.
    #[inline(always)]
    fn pair(self, dimension: Dimension) -> [L::F; 2] {
        let Self { sampler, l, which, pixels } = self;
        let d = dimension as usize;
        match sampler.settings.kind {
            SamplerKind::Independent => self.pair_of_bits(d).map(
                #[inline(always)]
                |bits| bits * UNIT,
            ),
            SamplerKind::PaddedStratified => {
                let [nx, ny] = sampler.settings.strata;
                let [jx, jy] = if sampler.settings.jitter { self.pair_of_bits(d) } else { [l.f(HALF); 2] };
                let stratum = which.of(l, &sampler.order[d]);
                let stratum = sampler.strata.place(l, stratum, &pixels.own[d]).to_real();
                // The half keeps the quotient clear of integers.
                let row = ((stratum + 0.5) * (1.0 / nx as f32)).to_uint().to_real();
                let column = stratum - row * nx as f32;
                [in_stratum(l, column, nx, jx), in_stratum(l, row, ny, jy)]
            }
            SamplerKind::Sobol | SamplerKind::PaddedSobol => {
                sobol_2d(l, which.of(l, &sampler.reversed), &pixels.own[d])
            }
            SamplerKind::Lattice | SamplerKind::Stratified => [self.number(dimension), self.second(dimension)],
        }
    }

    /// The number of a dimension that has one; the first one of a dimension that has two, where those are nested.
    #[inline(always)]
    fn number(self, dimension: Dimension) -> L::F {
        let Self { sampler, l, which, pixels } = self;
        let d = dimension as usize;
        let own = &pixels.own[d];
        match sampler.settings.kind {
            SamplerKind::Independent => self.bits(d) * UNIT,
            SamplerKind::PaddedStratified => {
                let offset = if sampler.settings.jitter { self.bits(d) } else { l.f(HALF) };
                let stratum = which.of(l, &sampler.order[d]);
                let stratum = if sampler.alternates(dimension) {
                    sampler.strata.place_nested(l, stratum, own)
                } else {
                    sampler.strata.place(l, stratum, own)
                };
                in_stratum(l, stratum.to_real(), sampler.strata.n, offset)
            }
            SamplerKind::Sobol | SamplerKind::PaddedSobol => sobol_1d(l, which.of(l, &sampler.reversed), own),
            SamplerKind::Lattice => lattice::shifted::<L>(which.of(l, &sampler.lattice.of(dimension)[0]), own[1]),
            SamplerKind::Stratified => {
                let cells = sampler.strata_lattice.of(dimension);
                let [column, slot] = cells.parts_of_x();
                cells.x(l, [which.of(l, column), which.of(l, slot)], own)
            }
        }
    }

    /// The second number of a dimension that has two, where those are nested.
    #[inline(always)]
    fn second(self, dimension: Dimension) -> L::F {
        let Self { sampler, l, which, pixels } = self;
        let own = &pixels.own[dimension as usize];
        match sampler.settings.kind {
            SamplerKind::Lattice => lattice::shifted::<L>(which.of(l, &sampler.lattice.of(dimension)[1]), own[2]),
            SamplerKind::Stratified => {
                lattice::shifted::<L>(which.of(l, sampler.strata_lattice.of(dimension).y()), own[2])
            }
            SamplerKind::Independent
            | SamplerKind::PaddedStratified
            | SamplerKind::Sobol
            | SamplerKind::PaddedSobol => self.pair(dimension)[1],
        }
    }

    /// 24 random bits as a number in [0, 2^24), uniform and independent over pixels, samples and dimensions.
    #[inline(always)]
    fn bits(self, d: usize) -> L::F {
        let first = self.first_bits(d);
        let bits = if STREAMS[d].1 == 0 { first } else { mix_on(self.l, first) };
        (bits >> 8).to_real()
    }

    /// Two such numbers.
    #[inline(always)]
    fn pair_of_bits(self, d: usize) -> [L::F; 2] {
        let first = self.first_bits(d);
        [(first >> 8).to_real(), (mix_on(self.l, first) >> 8).to_real()]
    }

    #[inline(always)]
    fn first_bits(self, d: usize) -> L::U {
        mix(self.l, self.pixels.keys ^ self.which.of(self.l, &self.sampler.counters[d]))
    }
}

/// What tells the strata of one dimension and round from others.
fn round_key(round: u32, dimension: Dimension) -> u32 {
    mix_one(round.wrapping_mul(8) + dimension as u32 + 1)
}

#[cfg(test)]
mod tests;
