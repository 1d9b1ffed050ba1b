//! Random numbers: every one a function of (seed, pixel, sample index, dimension).
//!
//! No state is carried from sample to sample, so that pixels, samples and techniques may be
//! computed in any order, on any thread, skipped or replayed, and give the same bits.

pub mod hash;
mod sobol;
mod strata;
mod unit;

use crate::lanes::{Lanes, Mask, PACKET, Real, Uint};
use crate::request::{PerTechnique, SamplerKind, SamplerSettings, Strategy};
use hash::{mix, mix_on, mix_one};
use sobol::{scramble, sobol_1d, sobol_2d};
use strata::{Order, Shuffle, Strata, nested};
use unit::{HALF, UNIT, in_stratum};

/// What a random number is for. The same technique finds the same numbers in every strategy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Position in the pixel (2).
    Pixel = 0,
    /// Which technique, in the one-sample model (1).
    Technique = 1,
    /// Which light (1).
    LightChoice = 2,
    /// Point or direction on the light (2).
    Light = 3,
    /// Which lobe of the BSDF (1).
    Lobe = 4,
    /// Direction in the lobe (2).
    Bsdf = 5,
}

impl Dimension {
    /// All dimensions, by number.
    pub const ALL: [Self; 6] = [Self::Pixel, Self::Technique, Self::LightChoice, Self::Light, Self::Lobe, Self::Bsdf];

    /// By dimension, whether a strategy asks for it, where there is more than one light to choose
    /// from (`lights`) and a surface with more than one lobe (`lobes`).
    pub fn wanted(strategy: Strategy, lights: bool, lobes: bool) -> [bool; Self::ALL.len()] {
        let draws = strategy.draws();
        Self::ALL.map(|dimension| match dimension {
            Self::Pixel => true,
            Self::Technique => strategy == Strategy::Mis,
            Self::LightChoice => draws.light && lights,
            Self::Light => draws.light,
            Self::Lobe => draws.bsdf && lobes,
            Self::Bsdf => draws.bsdf,
        })
    }
}
/// By dimension: what sets the streams of random numbers apart, and which number of its stream's pair a dimension of
/// one number takes.
const STREAMS: [(u32, usize); Dimension::ALL.len()] = {
    let mut streams = [(0, 0); Dimension::ALL.len()];
    let mut i = 0;
    while i < streams.len() {
        streams[i].0 = mix_one(0x632b_e5ab ^ i as u32);
        i += 1;
    }
    // Every strategy that asks for a technique chooses a light as well: two numbers for one.
    streams[Dimension::LightChoice as usize] = (streams[Dimension::Technique as usize].0, 1);
    streams
};
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

/// The random numbers of one sample, by dimension.
#[derive(Clone, Copy)]
pub struct Numbers<L: Lanes>([[L::F; 2]; Dimension::ALL.len()]);

impl<L: Lanes> Numbers<L> {
    /// Nothing but zeros.
    #[inline(always)]
    pub fn nothing(l: L) -> Self {
        Self([[l.f(0.0); 2]; Dimension::ALL.len()])
    }

    /// One number in [0, 1).
    #[inline(always)]
    pub fn get_1d(&self, dimension: Dimension) -> L::F {
        self.0[dimension as usize][0]
    }

    /// A point in the unit square [0, 1)^2.
    #[inline(always)]
    pub fn get_2d(&self, dimension: Dimension) -> [L::F; 2] {
        self.0[dimension as usize]
    }

    /// Puts the number that says which technique.
    #[inline(always)]
    pub fn set_technique(&mut self, number: L::F) {
        self.0[Dimension::Technique as usize][0] = number;
    }
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
    /// By dimension: whether anybody asks for it.
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
    /// By dimension: how Sobol points are scrambled.
    scrambles: [[L::U; 3]; COUNT],
}

impl<L: Lanes> Pixels<L> {
    /// Those with these [`pixel_keys`], for [`Sampler::turn`] to turn.
    #[inline(always)]
    pub fn new(l: L, keys: L::U) -> Self {
        let still = Shuffle { key: l.u(0), factor: l.u(1), shift: l.u(0) };
        Self { keys, shuffles: [still; COUNT], scrambles: [[l.u(0); 3]; COUNT] }
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
        Self {
            settings: *settings,
            wanted,
            key: 0,
            first: 0,
            round: 0,
            counters: [[0; RUN + 1]; COUNT],
            reversed: [0; RUN + 1],
            strata: Strata::new(settings.strata[0] * settings.strata[1]),
            order: [[0; RUN + 1]; COUNT],
        }
    }

    /// Turns to samples number `first` and after, in any patch. Returns how many the run holds, 1 to [`RUN`]: no
    /// more than are `left`, nor than their round of strata has.
    #[inline(always)]
    pub fn start(&mut self, first: u32, left: u32) -> u32 {
        let n = self.strata.n;
        let mut length = left.min(RUN as u32);
        self.first = first;
        if self.settings.kind == SamplerKind::Stratified {
            self.round = first / n;
            length = length.min(n - first % n);
        }
        if self.settings.kind == SamplerKind::Sobol {
            for (i, reversed) in self.reversed.iter_mut().enumerate().take(length as usize) {
                *reversed = (first + i as u32).reverse_bits();
            }
        } else {
            for (d, counters) in self.counters.iter_mut().enumerate().filter(|(d, _)| self.wanted[*d]) {
                for (i, counter) in counters.iter_mut().enumerate().take(length as usize) {
                    // A bijection of the index: no number of a pixel comes twice in 2^32 samples.
                    *counter = mix_one(first.wrapping_add(i as u32) ^ STREAMS[d].0);
                }
            }
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
            let d = dimension as usize;
            if self.wanted[d] && drawn {
                numbers.0[d][0] = self.number(l, which, pixels, dimension);
            }
        }
        for (dimension, drawn) in
            [(Dimension::Pixel, true), (Dimension::Light, drawn.light), (Dimension::Bsdf, drawn.bsdf)]
        {
            let d = dimension as usize;
            if self.wanted[d] && drawn {
                numbers.0[d] = match self.settings.kind {
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
                };
            }
        }
    }

    /// The number of a sample in a dimension that has one.
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
mod tests {
    use super::*;
    use crate::lanes::{Single, Wrapping};

    fn place(i: u32, n: u32, key: u32) -> u32 {
        Order::new(Strata::new(n), key).place(Single, Wrapping(i)).0
    }

    fn numbers(settings: &SamplerSettings, strategy: Strategy, key: u32, index: u32) -> Numbers<Single> {
        let mut sampler = Sampler::new(settings, Dimension::wanted(strategy, true, true));
        sampler.start(index, 1);
        sampler.enter(Single, key);
        let mut numbers = Numbers::nothing(Single);
        let mut pixels = Pixels::new(Single, Wrapping(key));
        sampler.turn(Single, &mut pixels);
        numbers.set_technique(sampler.technique(Single, 0, &pixels));
        sampler.draw(Single, Which { sample: 0, next: false }, &pixels, PerTechnique::BOTH, &mut numbers);
        numbers
    }

    #[test]
    fn permute_is_a_permutation() {
        for n in [1, 2, 3, 5, 36, 64, 100, 4096, 65536] {
            for key in [0, 1, 0xdead_beef, 77_777] {
                let mut seen = vec![false; n as usize];
                for i in 0..n {
                    let j = place(i, n, key) as usize;
                    assert!(!seen[j], "n = {n}, key = {key}: {j} twice");
                    seen[j] = true;
                }
            }
        }
    }

    #[test]
    fn sobol_pairs_are_a_net() {
        // Every 2^k successive points, aligned, put one into each elementary interval.
        let settings = SamplerSettings { kind: SamplerKind::Sobol, strata: [1, 1], jitter: true };
        for pixel in 0..8 {
            for k in [4u32, 6, 8] {
                for a in 0..=k {
                    let mut seen = vec![0; 1 << k];
                    for i in 0..1 << k {
                        let numbers = numbers(&settings, Strategy::MisAll, mix_one(pixel), i + (3 << k));
                        let [x, y] = numbers.get_2d(Dimension::Light);
                        let cx = (x * (1 << a) as f32) as usize;
                        let cy = (y * (1 << (k - a)) as f32) as usize;
                        seen[cx * (1 << (k - a)) + cy] += 1;
                    }
                    assert!(seen.iter().all(|&c| c == 1), "pixel {pixel}, 2^{k} points, split {a}");
                }
            }
        }
    }

    #[test]
    fn stratified_fills_every_stratum_once() {
        let settings = SamplerSettings { kind: SamplerKind::Stratified, strata: [6, 6], jitter: true };
        for round in 0..3 {
            let mut seen = [0; 36];
            for i in 0..36 {
                let numbers = numbers(&settings, Strategy::Mis, 0x1234_5678, round * 36 + i);
                let [x, y] = numbers.get_2d(Dimension::Pixel);
                seen[(x * 6.0) as usize + 6 * (y * 6.0) as usize] += 1;
            }
            assert_eq!(seen, [1; 36], "round {round}");
        }
    }

    #[test]
    fn strata_come_in_an_almost_uniform_order() {
        // Relative deviation (root mean square over cells) of the joint distribution of two
        // positions from uniform, less what counting noise alone would give.
        for (n, i, j) in [(6, 0, 1), (36, 0, 1), (36, 3, 20), (64, 0, 1), (64, 1, 2), (64, 31, 32), (100, 0, 1)] {
            let trials = 1_000_000u32;
            let mut count = vec![0u32; (n * n) as usize];
            for t in 0..trials {
                let (a, b) = (place(i, n, t), place(j, n, t));
                count[(a * n + b) as usize] += 1;
            }
            let cells = f64::from(n * (n - 1));
            let expected = f64::from(trials) / cells;
            let mut chi2 = 0.0;
            for (cell, &c) in count.iter().enumerate() {
                if cell as u32 / n != cell as u32 % n {
                    chi2 += (f64::from(c) - expected).powi(2) / expected;
                }
            }
            let excess = ((chi2 - cells).max(0.0) / f64::from(trials)).sqrt();
            assert!(excess < 0.1, "n = {n}, positions {i} and {j}: {excess}");
        }
    }
}
