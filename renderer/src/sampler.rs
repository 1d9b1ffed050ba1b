//! Random numbers: every one a function of (seed, pixel, sample index, dimension).
//!
//! No state is carried from sample to sample, so that pixels, samples and techniques may be
//! computed in any order, on any thread, skipped or replayed, and give the same bits.

use crate::lanes::{Lanes, Mask, Real, Uint};
use crate::settings::{SamplerKind, SamplerSettings, Strategy};

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
        Self::ALL.map(|dimension| match dimension {
            Self::Pixel => true,
            Self::Technique => strategy == Strategy::Mis,
            Self::LightChoice => strategy != Strategy::Bsdf && lights,
            Self::Light => strategy != Strategy::Bsdf,
            Self::Lobe => strategy != Strategy::Light && lobes,
            Self::Bsdf => strategy != Strategy::Light,
        })
    }
}

/// The largest float below one.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// A bijection of 32-bit integers with good avalanche (two multiply-xorshift rounds, constants of
/// the low-bias search by Wellons 2018 and followers).
#[inline(always)]
fn mix<L: Lanes>(l: L, x: L::U) -> L::U {
    let x = (x ^ (x >> 16)) * l.u(0x21f0_aaad);
    let x = (x ^ (x >> 15)) * l.u(0xd35a_2d97);
    x ^ (x >> 15)
}

/// [`mix`] for one number.
#[inline(always)]
pub(crate) const fn mix_one(x: u32) -> u32 {
    let x = (x ^ (x >> 16)).wrapping_mul(0x21f0_aaad);
    let x = (x ^ (x >> 15)).wrapping_mul(0xd35a_2d97);
    x ^ (x >> 15)
}

/// By dimension and axis: what sets the streams of random numbers apart.
const STREAMS: [[u32; 2]; Dimension::ALL.len()] = {
    let mut streams = [[0; 2]; Dimension::ALL.len()];
    let mut i = 0;
    while i < 2 * streams.len() {
        streams[i / 2][i % 2] = mix_one(0x632b_e5ab ^ i as u32);
        i += 1;
    }
    streams
};

/// The upper 24 bits as a float in [0, 1).
#[inline(always)]
fn to_unit<L: Lanes>(x: L::U) -> L::F {
    (x >> 8).to_real() * (1.0 / 16_777_216.0)
}

/// What distinguishes the pixels of a packet, for one seed. Different pixels (of images up to
/// 65536 squared) have different keys.
#[inline(always)]
pub fn pixel_keys<L: Lanes>(l: L, seed: u32, x: L::U, y: L::U) -> L::U {
    let h = mix(l, ((y << 16) | x) ^ l.u(mix_one(seed)));
    mix(l, h + l.u(mix_one(seed ^ 0x9e37_79b9)))
}

/// The random numbers of one sample, by dimension.
#[derive(Clone, Copy)]
pub struct Numbers<L: Lanes>([[L::F; 2]; Dimension::ALL.len()]);

impl<L: Lanes> Numbers<L> {
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
}

/// Draws the numbers of a packet's pixels, sample after sample.
#[derive(Clone, Copy)]
pub struct Sampler<'a, L: Lanes> {
    l: L,
    settings: &'a SamplerSettings,
    /// By dimension: whether anybody asks for it.
    wanted: [bool; Dimension::ALL.len()],
    /// The pixels' own.
    pixels: L::U,
    /// By dimension: what does not change from one sample to the next, a [`shuffle`] or a [`scramble`].
    keys: [Keys<L>; Dimension::ALL.len()],
    /// The round of strata that `keys` are for.
    round: Option<u32>,
}

/// Numbers that a pixel keeps for many samples.
type Keys<L> = [<L as Lanes>::U; 9];

impl<'a, L: Lanes> Sampler<'a, L> {
    /// A sampler for the dimensions that `strategy` asks for and `scene` has a use for.
    #[inline(always)]
    pub fn new(l: L, settings: &'a SamplerSettings, wanted: [bool; Dimension::ALL.len()]) -> Self {
        let zero = l.u(0);
        Self { l, settings, wanted, pixels: zero, keys: [[zero; 9]; Dimension::ALL.len()], round: None }
    }

    /// Turns to the pixels with these [`pixel_keys`].
    #[inline(always)]
    pub fn start(&mut self, pixels: L::U) {
        self.pixels = pixels;
        self.round = None;
    }

    /// The numbers of sample `index`. Dimensions that are not wanted are left at 0. (All in one place
    /// and one loop: a call of its own for every use made the kernel six times as large and its
    /// compilation minutes long.)
    #[inline(always)]
    pub fn draw(&mut self, index: u32) -> Numbers<L> {
        let round = match self.settings.kind {
            SamplerKind::Stratified => index / (self.settings.strata[0] * self.settings.strata[1]),
            SamplerKind::Independent | SamplerKind::Sobol => 0,
        };
        let turn = self.round != Some(round);
        self.round = Some(round);
        if turn {
            for dimension in Dimension::ALL {
                if self.wanted[dimension as usize] {
                    self.prepare(dimension, round);
                }
            }
        }
        let mut numbers = [[self.l.f(0.0); 2]; Dimension::ALL.len()];
        for dimension in [Dimension::Technique, Dimension::LightChoice, Dimension::Lobe] {
            if self.wanted[dimension as usize] {
                numbers[dimension as usize][0] = self.get_1d(dimension, index);
            }
        }
        for dimension in [Dimension::Pixel, Dimension::Light, Dimension::Bsdf] {
            if self.wanted[dimension as usize] {
                numbers[dimension as usize] = self.get_2d(dimension, index);
            }
        }
        Numbers(numbers)
    }

    #[inline(always)]
    fn prepare(&mut self, dimension: Dimension, round: u32) {
        let l = self.l;
        match self.settings.kind {
            SamplerKind::Independent => {}
            SamplerKind::Stratified => {
                let n = self.settings.strata[0] * self.settings.strata[1];
                let key = mix(l, self.pixels ^ l.u(mix_one(round.wrapping_mul(8) + dimension as u32 + 1)));
                self.keys[dimension as usize] = shuffle(l, n, key);
            }
            SamplerKind::Sobol => {
                let key = mix(l, self.pixels ^ l.u(mix_one(0x51ed_270b ^ dimension as u32)));
                self.keys[dimension as usize] = scramble(l, key);
            }
        }
    }

    #[inline(always)]
    fn get_1d(&self, dimension: Dimension, index: u32) -> L::F {
        let l = self.l;
        match self.settings.kind {
            SamplerKind::Independent => self.independent(dimension, 0, index),
            SamplerKind::Stratified => {
                let n = self.settings.strata[0] * self.settings.strata[1];
                let stratum = permute(l, index % n, n, &self.keys[dimension as usize]).to_real();
                let offset = self.jitter(dimension, 0, index);
                ((stratum + offset) * (1.0 / n as f32)).min(l.f(BELOW_ONE))
            }
            SamplerKind::Sobol => sobol_1d(l, index, &self.keys[dimension as usize]),
        }
    }

    #[inline(always)]
    fn get_2d(&self, dimension: Dimension, index: u32) -> [L::F; 2] {
        let l = self.l;
        match self.settings.kind {
            SamplerKind::Independent => [self.independent(dimension, 0, index), self.independent(dimension, 1, index)],
            SamplerKind::Stratified => {
                let [nx, ny] = self.settings.strata;
                let n = nx * ny;
                let stratum = permute(l, index % n, n, &self.keys[dimension as usize]).to_real();
                // Row and column of the stratum; the half keeps the quotient clear of integers.
                let row = ((stratum + 0.5) * (1.0 / nx as f32)).to_uint().to_real();
                let column = stratum - row * nx as f32;
                let [jx, jy] = [self.jitter(dimension, 0, index), self.jitter(dimension, 1, index)];
                [
                    ((column + jx) * (1.0 / nx as f32)).min(l.f(BELOW_ONE)),
                    ((row + jy) * (1.0 / ny as f32)).min(l.f(BELOW_ONE)),
                ]
            }
            SamplerKind::Sobol => sobol_2d(l, index, &self.keys[dimension as usize]),
        }
    }

    /// Uniform and independent over pixels, samples and dimensions.
    #[inline(always)]
    fn independent(&self, dimension: Dimension, axis: u32, index: u32) -> L::F {
        let stream = STREAMS[dimension as usize][axis as usize];
        // A bijection of the index: no number of a pixel comes twice in 2^32 samples.
        let counter = mix_one(index ^ stream);
        to_unit::<L>(mix(self.l, self.pixels ^ self.l.u(counter)))
    }

    /// Position inside the stratum.
    #[inline(always)]
    fn jitter(&self, dimension: Dimension, axis: u32, index: u32) -> L::F {
        if self.settings.jitter { self.independent(dimension, axis, index) } else { self.l.f(0.5) }
    }
}

/// Keys of the permutation of 0 .. n that `key` names, 1 <= n <= 65536, for [`permute`]: four that
/// are xored, four odd multipliers, and a rotation. Each pixel and dimension has a new one for each round
/// of n samples.
#[inline(always)]
fn shuffle<L: Lanes>(l: L, n: u32, key: L::U) -> Keys<L> {
    let one = l.u(1);
    let key2 = mix(l, key ^ l.u(0x68e3_1da4));
    // floor(r n / 2^16) for 16 random bits r: uniform to 2^-16 n.
    let shift = ((mix(l, key2) >> 16) * l.u(n)) >> 16;
    [
        key,
        key >> 8,
        key >> 16,
        key2 >> 1,
        (key2 >> 3) | one,
        (key2 >> 11) | one,
        (key2 >> 19) | one,
        (key >> 5) | one,
        shift,
    ]
}

/// Where position `i` goes in the permutation of 0 .. n with these [`shuffle`] keys, i < n.
///
/// A bijection of the next power of two (rounds of xor, multiplication by an odd number and
/// folding of the upper half onto the lower), walked until it lands below n; then a rotation by a
/// uniform amount, so that every position is reached with exactly equal probability.
#[inline(always)]
fn permute<L: Lanes>(l: L, i: u32, n: u32, keys: &Keys<L>) -> L::U {
    if n == 1 {
        return l.u(0);
    }
    let bits = 32 - (n - 1).leading_zeros();
    let mask = l.u((1 << bits) - 1);
    let fold = bits.div_ceil(2);
    let limit = l.u(n);
    let mut x = l.u(i);
    let mut outside = l.m(true);
    while outside.any() {
        let mut y = x;
        // Four rounds; with three, pairs of successive strata are 6 % from uniform at n = 6.
        for round in 0..4 {
            y = ((y ^ keys[round]) * keys[4 + round]) & mask;
            y = y ^ (y >> fold);
        }
        x = outside.select_u(y, x);
        outside = !x.lt(limit);
    }
    let y = x + keys[8];
    y.lt(limit).select_u(y, y - limit)
}

/// Keys of one dimension's Owen scrambling: of the index, of the first and the second number.
#[inline(always)]
fn scramble<L: Lanes>(l: L, key: L::U) -> Keys<L> {
    let unused = l.u(0);
    let [x, y] = [mix(l, key + l.u(1)), mix(l, key + l.u(2))];
    [key, x, y, unused, unused, unused, unused, unused, unused]
}

#[inline(always)]
fn sobol_1d<L: Lanes>(l: L, index: u32, keys: &Keys<L>) -> L::F {
    let index = shuffled_index(l, index, keys[0]);
    to_unit::<L>(reverse_bits(l, scramble_reversed(l, index, keys[1])))
}

/// Owen-scrambled first two Sobol dimensions, decoupled between groups by shuffling the index
/// ("padding", Burley 2020, sections 4 and 5).
#[inline(always)]
fn sobol_2d<L: Lanes>(l: L, index: u32, keys: &Keys<L>) -> [L::F; 2] {
    let index = shuffled_index(l, index, keys[0]);
    let x = scramble_reversed(l, index, keys[1]);
    let y = scramble_reversed(l, pascal(l, index), keys[2]);
    [to_unit::<L>(reverse_bits(l, x)), to_unit::<L>(reverse_bits(l, y))]
}

/// Reverses the order of the bits.
#[inline(always)]
fn reverse_bits<L: Lanes>(l: L, x: L::U) -> L::U {
    let x = ((x >> 1) & l.u(0x5555_5555)) | ((x & l.u(0x5555_5555)) << 1);
    let x = ((x >> 2) & l.u(0x3333_3333)) | ((x & l.u(0x3333_3333)) << 2);
    let x = ((x >> 4) & l.u(0x0f0f_0f0f)) | ((x & l.u(0x0f0f_0f0f)) << 4);
    let x = ((x >> 8) & l.u(0x00ff_00ff)) | ((x & l.u(0x00ff_00ff)) << 8);
    (x >> 16) | (x << 16)
}

/// Owen scrambling of bit-reversed fractions: a hash in which a bit depends on lower bits only
/// (Laine and Karras 2011; constants found by Vegdahl 2021).
#[inline(always)]
fn scramble_reversed<L: Lanes>(l: L, x: L::U, seed: L::U) -> L::U {
    let x = x ^ (x * l.u(0x3d20_adea));
    let x = x + seed;
    let x = x * ((seed >> 16) | l.u(1));
    let x = x ^ (x * l.u(0x0552_6c56));
    x ^ (x * l.u(0x53a2_2864))
}

/// The index, Owen-scrambled as an integer: aligned runs of 2^k indices stay together.
#[inline(always)]
fn shuffled_index<L: Lanes>(l: L, index: u32, key: L::U) -> L::U {
    reverse_bits(l, scramble_reversed(l, l.u(index.reverse_bits()), key))
}

/// Second Sobol dimension, bit-reversed: the generator matrix is Pascal's triangle modulo 2, that
/// is, the bits are coefficients of a polynomial p(x) and the result those of p(x + 1). Since
/// (x + 1)^s = x^s + 1 for powers of two, each halving needs one shift.
#[inline(always)]
fn pascal<L: Lanes>(l: L, x: L::U) -> L::U {
    let x = x ^ (x >> 16);
    let x = x ^ ((x & l.u(0xff00_ff00)) >> 8);
    let x = x ^ ((x & l.u(0xf0f0_f0f0)) >> 4);
    let x = x ^ ((x & l.u(0xcccc_cccc)) >> 2);
    x ^ ((x & l.u(0xaaaa_aaaa)) >> 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{Single, Wrapping};

    fn place(i: u32, n: u32, key: u32) -> u32 {
        permute(Single, i, n, &shuffle(Single, n, Wrapping(mix_one(key)))).0
    }

    fn numbers(settings: &SamplerSettings, strategy: Strategy, key: u32, index: u32) -> Numbers<Single> {
        let mut sampler = Sampler::new(Single, settings, Dimension::wanted(strategy, true, true));
        sampler.start(Wrapping(key));
        sampler.draw(index)
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
