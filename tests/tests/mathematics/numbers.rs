//! Random numbers: where they lie, that each pattern holds what its name says, and that pixels, samples and dimensions
//! know nothing of each other.

use std::collections::HashSet;

use mislab_kernel::lanes::{Single, Wrapping};
use mislab_kernel::request::PerTechnique;
use mislab_kernel::sampler::{Dimension, Numbers, Pixels, RUN, Sampler, Which, patch_key};
use mislab_renderer::{SamplerKind, SamplerSettings, Strategy};
use mislab_tests::chi_square::{PValues, chi_square};
use mislab_tests::draws::Draws;
use mislab_tests::pair::INDEPENDENT;
use mislab_tests::statistics::z_limit;

use crate::once;
use crate::pairs::Pairs;

const SOBOL: SamplerSettings = SamplerSettings { kind: SamplerKind::PaddedSobol, strata: [1, 1], jitter: true };
const ALL: [bool; Dimension::ALL.len()] = [true; Dimension::ALL.len()];
const PAIRS: [Dimension; 3] = [Dimension::Pixel, Dimension::Light, Dimension::Bsdf];
const SINGLES: [Dimension; 3] = [Dimension::Technique, Dimension::LightChoice, Dimension::Lobe];

fn stratified(strata: [u32; 2], jitter: bool) -> SamplerSettings {
    SamplerSettings { kind: SamplerKind::PaddedStratified, strata, jitter }
}

fn key(x: u32, y: u32) -> Wrapping {
    once::key(3, x, y)
}

/// A sampler at a pixel.
fn at(settings: &SamplerSettings, x: u32, y: u32) -> Draws<Single> {
    wanting(ALL, settings, x, y)
}

/// A sampler at a pixel, for one dimension.
fn only(dimension: Dimension, settings: &SamplerSettings, x: u32, y: u32) -> Draws<Single> {
    wanting(Dimension::ALL.map(|other| other == dimension), settings, x, y)
}

fn wanting(wanted: [bool; Dimension::ALL.len()], settings: &SamplerSettings, x: u32, y: u32) -> Draws<Single> {
    let mut sampler = Draws::new(Single, settings, wanted);
    sampler.start(key(x, y), once::patch(3, x, y));
    sampler
}

/// What the nine numbers of [`each`] are.
const NAMES: [&str; 9] =
    ["technique", "which light", "lobe", "pixel x", "pixel y", "light x", "light y", "BSDF x", "BSDF y"];

/// The nine numbers of a sample.
fn each(numbers: &Numbers<Single>) -> [f64; 9] {
    let [a, b, c] = SINGLES.map(|dimension| numbers.get_1d(dimension));
    let [[d, e], [f, g], [h, i]] = PAIRS.map(|dimension| numbers.get_2d(dimension));
    [a, b, c, d, e, f, g, h, i].map(f64::from)
}

fn samplers() -> [SamplerSettings; 5] {
    [INDEPENDENT, SOBOL, stratified([6, 6], true), stratified([2, 3], true), stratified([1, 1], true)]
}

#[test]
fn strategies_ask_for_what_they_use() {
    use Strategy::{Bsdf, Light, Mis, MisAll};
    // Pixel, technique, which light, light, lobe, BSDF.
    for (strategy, lights, lobes, expected) in [
        (Light, false, false, [true, false, false, true, false, false]),
        (Light, true, true, [true, false, true, true, false, false]),
        (Bsdf, false, false, [true, false, false, false, false, true]),
        (Bsdf, true, true, [true, false, false, false, true, true]),
        (MisAll, false, false, [true, false, false, true, false, true]),
        (MisAll, true, false, [true, false, true, true, false, true]),
        (MisAll, false, true, [true, false, false, true, true, true]),
        (Mis, false, false, [true, true, false, true, false, true]),
        (Mis, true, true, [true, true, true, true, true, true]),
    ] {
        assert_eq!(Dimension::wanted(strategy, lights, lobes), expected, "{}, {lights}, {lobes}", strategy.name());
    }
}

#[test]
fn numbers_depend_on_nothing_but_their_names() {
    let bits = |numbers: &Numbers<Single>| each(numbers).map(f64::to_bits);
    for settings in samplers() {
        let mut sampler = at(&settings, 5, 9);
        let indices = [0, 1, 2, 35, 36, 37, 6, 5, 1000, 0, 999, 71, 72, 3, u32::MAX];
        for index in indices {
            // From the start, and of another pixel in between.
            let drawn = bits(&once::draw(&mut sampler, index));
            assert_eq!(
                drawn,
                bits(&once::draw(&mut at(&settings, 5, 9), index)),
                "{settings:?}, sample {index} by itself"
            );
            let other = bits(&once::draw(&mut at(&settings, 6, 9), index));
            sampler.start(key(6, 9), once::patch(3, 6, 9));
            assert_eq!(bits(&once::draw(&mut sampler, index)), other, "{settings:?}, sample {index} of the next pixel");
            sampler.start(key(5, 9), once::patch(3, 5, 9));
            let numbers = once::draw(&mut only(Dimension::Light, &settings, 5, 9), index);
            let expected = once::draw(&mut at(&settings, 5, 9), index).get_2d(Dimension::Light);
            assert_eq!(numbers.get_2d(Dimension::Light), expected, "{settings:?}, sample {index} of one dimension");
            for dimension in Dimension::ALL.into_iter().filter(|&other| other != Dimension::Light) {
                assert_eq!(numbers.get_2d(dimension), [0.0; 2], "{dimension:?}: not asked for");
            }
        }
    }
}

/// Those of a technique that is not asked for are left as they are.
#[test]
fn numbers_of_the_other_technique_are_left_alone() {
    for settings in samplers() {
        let all = once::draw(&mut at(&settings, 5, 9), 4);
        for [light, bsdf] in [[true, true], [true, false], [false, true], [false, false]] {
            let asked = PerTechnique { light, bsdf };
            let mut sampler = Sampler::new(&settings, ALL, 1);
            let mut pixels = Pixels::new(Single, key(5, 9));
            sampler.start(4, 1);
            sampler.enter(Single, once::patch(3, 5, 9));
            sampler.turn(Single, &mut pixels);
            let mut numbers = sampler.nothing(Single);
            sampler.sample(Single, Which { sample: 0, next: false }, &pixels).draw(asked, &mut numbers);
            let drawn = |dimension| match dimension {
                Dimension::Pixel => true,
                Dimension::Technique => false,
                Dimension::LightChoice | Dimension::Light => light,
                Dimension::Lobe | Dimension::Bsdf => bsdf,
            };
            for dimension in Dimension::ALL {
                let expected = if drawn(dimension) { all.get_2d(dimension) } else { [0.0; 2] };
                assert_eq!(numbers.get_2d(dimension), expected, "{settings:?}, {dimension:?}, asked {asked:?}");
            }
        }
    }
}

#[test]
fn numbers_fill_the_unit_interval() {
    for settings in samplers() {
        let mut range = [[1.0f64, 0.0]; 9];
        for x in 0..2000 {
            for index in 0..20 {
                let numbers = each(&once::draw(&mut at(&settings, x, 1), index));
                for ((range, name), u) in range.iter_mut().zip(NAMES).zip(numbers) {
                    assert!((0.0..1.0).contains(&u), "{settings:?}, {name}: {u}");
                    *range = [range[0].min(u), range[1].max(u)];
                }
            }
        }
        // 40 000 numbers; none beyond 1e-3 happens once in 1e17 times.
        assert!(range.iter().all(|[a, b]| *a < 1e-3 && *b > 1.0 - 1e-3), "{settings:?}: {range:?}");
    }
}

/// In the largest pattern the last stratum and its jitter may be rounded up to one: in these pixels they would be.
#[test]
fn numbers_stay_below_one() {
    let settings = stratified([256, 256], true);
    for x in [29, 34, 91] {
        let mut sampler = at(&settings, x, 0);
        let mut largest = 0.0f64;
        for index in 0..1 << 16 {
            let numbers = each(&once::draw(&mut sampler, index));
            assert!(numbers.iter().all(|u| (0.0..1.0).contains(u)), "pixel {x}, sample {index}: {numbers:?}");
            largest = numbers.iter().fold(largest, |a, &b| a.max(b));
        }
        assert_eq!(largest, f64::from(1.0f32.next_down()), "pixel {x}: the largest number below one");
    }
}

#[test]
fn numbers_are_fractions_of_24_bits() {
    for index in 0..1000 {
        for (u, name) in each(&once::draw(&mut at(&INDEPENDENT, 1, 2), index)).into_iter().zip(NAMES) {
            assert_eq!((u * 16_777_216.0).fract(), 0.0, "{name}: {u}");
        }
    }
}

#[test]
fn pixels_have_keys_of_their_own() {
    for seed in [0, 1, 2, 77, u32::MAX] {
        let mut keys = HashSet::new();
        let mut count = 0;
        for x in (0..400).chain(65_136..65_536) {
            for y in (0..100).chain(65_436..65_536) {
                keys.insert(once::key(seed, x, y).0);
                count += 1;
            }
        }
        assert_eq!(keys.len(), count, "seed {seed}: pixels with the same key");
    }
    let seeds: HashSet<u32> = (0..100_000).map(|seed| once::key(seed, 3, 4).0).collect();
    // Random 32-bit numbers: 1.2 pairs are expected to agree, 10 once in a million times.
    assert!(seeds.len() > 100_000 - 10, "{} keys of 100 000 seeds", seeds.len());
}

#[test]
fn patches_have_keys_of_their_own() {
    for seed in [0, 1, 2, 77, u32::MAX] {
        let columns = || (0..400).chain(8000..8192);
        let keys: HashSet<u32> =
            columns().flat_map(|x| columns().map(move |y| patch_key(seed, [8 * x, 8 * y]))).collect();
        assert_eq!(keys.len(), 592 * 592, "seed {seed}: patches with the same key");
    }
    let seeds: HashSet<u32> = (0..100_000).map(|seed| patch_key(seed, [16, 24])).collect();
    assert_eq!(seeds.len(), 100_000, "seeds with the same key");
}

/// However samples are cut into runs, they are those that come one at a time.
#[test]
fn runs_hold_the_samples_that_come_alone() {
    let patch = once::patch(3, 5, 9);
    for settings in samplers().into_iter().chain([stratified([5, 8], true)]) {
        for (first, count) in [(0, 1), (0, 200), (13, 7), (35, 2), (40, 100), (1_000_003, 50)] {
            let mut sampler = Sampler::new(&settings, ALL, 1);
            let mut pixels = Pixels::new(Single, key(5, 9));
            let (mut next, last) = (first, first + count);
            while next < last {
                let length = sampler.start(next, last - next);
                let what = format!("{settings:?}, {length} samples from {next}, {} left", last - next);
                assert!((1..=RUN as u32).contains(&length) && length <= last - next, "{what}");
                if settings.kind == SamplerKind::PaddedStratified {
                    let n = settings.strata[0] * settings.strata[1];
                    assert_eq!(next / n, (next + length - 1) / n, "{what}: more than a round");
                }
                sampler.enter(Single, patch);
                sampler.turn(Single, &mut pixels);
                for i in 0..length {
                    let mut numbers = sampler.nothing(Single);
                    let sample = sampler.sample(Single, Which { sample: i as usize, next: false }, &pixels);
                    numbers.set_technique(sample.technique());
                    sample.draw(PerTechnique::BOTH, &mut numbers);
                    let alone = once::draw(&mut at(&settings, 5, 9), next + i);
                    assert_eq!(each(&numbers), each(&alone), "{what}: number {i}");
                    // The second one of a pair, asked for by way of the first.
                    if i > 0 {
                        let which = Which { sample: i as usize - 1, next: true };
                        sampler.sample(Single, which, &pixels).draw(PerTechnique::BOTH, &mut numbers);
                        assert_eq!(each(&numbers), each(&alone), "{what}: number {i} from the one before");
                    }
                }
                next += length;
            }
        }
    }
}

/// Each bit of a pixel and of the seed flips each bit of the key half of the time.
#[test]
fn every_bit_of_a_key_depends_on_every_bit_of_its_pixel() {
    const TRIALS: u32 = 2000;
    let key = |[x, y, seed]: [u32; 3]| once::key(seed, x, y).0;
    let random = |i: u32, k: u32| (mislab_tests::light_scenes::random(i, k) * 65_536.0) as u32;
    let limit = z_limit(64 * 32);
    for (word, bits) in [(0, 16), (1, 16), (2, 32)] {
        for bit in 0..bits {
            let mut flips = [0u32; 32];
            for i in 0..TRIALS {
                let from = [random(i, 0), random(i, 1), random(i, 2) << 16 | random(i, 3)];
                let mut to = from;
                to[word] ^= 1 << bit;
                let changed = key(from) ^ key(to);
                for (k, flips) in flips.iter_mut().enumerate() {
                    *flips += changed >> k & 1;
                }
            }
            for (k, flips) in flips.into_iter().enumerate() {
                let z = (f64::from(flips) - f64::from(TRIALS) / 2.0) / (f64::from(TRIALS) / 4.0).sqrt();
                assert!(z.abs() < limit, "bit {bit} of word {word} flips bit {k} in {flips} of {TRIALS} trials");
            }
        }
    }
}

/// Each bit of a pixel's key, and of the index, flips each bit of an independent number half of the time.
#[test]
fn every_bit_of_a_number_depends_on_every_bit_of_its_key() {
    const TRIALS: u32 = 2000;
    let number = |[key, index]: [u32; 2]| {
        let numbers = once::numbers(key, index);
        (numbers.get_1d(Dimension::Lobe) * 16_777_216.0) as u32
    };
    let random = |i: u32, k: u32| (mislab_tests::light_scenes::random(i, k) * 65_536.0) as u32;
    let limit = z_limit(64 * 24);
    for word in 0..2 {
        for bit in 0..32 {
            let mut flips = [0u32; 24];
            for i in 0..TRIALS {
                let from = [random(i, 0) << 16 | random(i, 1), random(i, 2) << 16 | random(i, 3)];
                let mut to = from;
                to[word] ^= 1 << bit;
                let changed = number(from) ^ number(to);
                for (k, flips) in flips.iter_mut().enumerate() {
                    *flips += changed >> k & 1;
                }
            }
            for (k, flips) in flips.into_iter().enumerate() {
                let z = (f64::from(flips) - f64::from(TRIALS) / 2.0) / (f64::from(TRIALS) / 4.0).sqrt();
                assert!(z.abs() < limit, "bit {bit} of word {word} flips bit {k} in {flips} of {TRIALS} trials");
            }
        }
    }
}

/// Numbers of one pixel agree as often as chance wants: the counters below them are all different.
#[test]
fn numbers_of_a_pixel_seldom_agree() {
    const COUNT: u32 = 1 << 20;
    let numbers = f64::from(1 << 24);
    let mut sampler = at(&INDEPENDENT, 4, 4);
    // A bit for each number there is.
    let mut seen = [(); 9].map(|()| vec![0u64; 1 << 18]);
    let mut again = [0u32; 9];
    for index in 0..COUNT {
        for (k, u) in each(&once::draw(&mut sampler, index)).into_iter().enumerate() {
            let number = (u * numbers) as usize;
            let (word, bit) = (&mut seen[k][number / 64], 1 << (number % 64));
            again[k] += u32::from(*word & bit != 0);
            *word |= bit;
        }
    }
    let count = f64::from(COUNT);
    let expected = count - numbers * (1.0 - (-count / numbers).exp());
    for (again, name) in again.into_iter().zip(NAMES) {
        // About Poisson.
        let z = (f64::from(again) - expected) / expected.sqrt();
        assert!(z.abs() < z_limit(9), "{name}: {again} of {COUNT} numbers came before, expected {expected}");
    }
}

#[test]
fn dimensions_pixels_and_samples_are_independent() {
    let mut pairs = Pairs::new("pairs of random numbers", NAMES);
    // Pixels all over the picture, in rows.
    let place = |i: u32| (2 * (i % 300), 2 * (i / 300));
    for settings in [INDEPENDENT, SOBOL, stratified([4, 3], true)] {
        let name = settings.kind.name();
        let draw = |x: u32, y: u32, index: u32| each(&once::draw(&mut at(&settings, x, y), index));
        for index in [0, 7] {
            pairs.of_one(&format!("{name}, sample {index}"), |i| draw(place(i).0, place(i).1, index));
        }
        let beside = |i| [0, 1].map(|k| draw(place(i).0 + k, place(i).1, 2));
        pairs.of_two(&format!("{name}, next to each other"), beside);
        let above = |i| [0, 1].map(|k| draw(place(i).0, place(i).1 + k, 2));
        pairs.of_two(&format!("{name}, above each other"), above);
        pairs.of_two(&format!("{name}, two seeds"), |i| {
            [0, 1].map(|seed| {
                let mut sampler = Draws::new(Single, &settings, ALL);
                sampler.start(once::key(seed, i, 0), once::patch(seed, i, 0));
                each(&once::draw(&mut sampler, 2))
            })
        });
        // One round of strata and the next.
        let later = if settings.kind == SamplerKind::PaddedStratified { 12 } else { 1 };
        if settings.kind != SamplerKind::PaddedSobol {
            pairs.of_two(&format!("{name}, {later} samples later"), |i| {
                let mut sampler = at(&settings, i % 300, i / 300);
                [2, 2 + later].map(|index| each(&once::draw(&mut sampler, index)))
            });
        }
    }
    // Of one pixel, successive samples.
    pairs.of_two("one pixel", |i| {
        let mut sampler = at(&INDEPENDENT, 8, 8);
        [i, i + 1].map(|index| each(&once::draw(&mut sampler, index)))
    });
    pairs.judge(1188);
}

#[test]
fn every_stratum_gets_one_sample_of_each_round() {
    for strata in [[1, 1], [1, 5], [5, 1], [2, 3], [3, 4], [6, 6], [8, 8], [7, 11], [16, 16], [31, 33]] {
        let [nx, ny] = strata;
        let n = nx * ny;
        for jitter in [false, true] {
            let settings = stratified(strata, jitter);
            for pixel in 0..4 {
                let (mut sampler, centre) = (at(&settings, pixel, 0), stratified(strata, false));
                let mut centres = at(&centre, pixel, 0);
                let mut orders = HashSet::new();
                let rounds = if n < 100 { 5 } else { 2 };
                for round in 0..rounds {
                    let mut one = [(); 3].map(|()| vec![0; n as usize]);
                    let mut two = one.clone();
                    let mut order = Vec::new();
                    for i in 0..n {
                        let numbers = once::draw(&mut sampler, round * n + i);
                        // Rounding may move a number over the edge of its stratum, but not the stratum's centre.
                        let middle = once::draw(&mut centres, round * n + i);
                        for (count, dimension) in one.iter_mut().zip(SINGLES) {
                            let u = f64::from(middle.get_1d(dimension)) * f64::from(n);
                            count[u as usize] += 1;
                            assert!((u.fract() - 0.5).abs() < 1e-3, "{settings:?}: {u} is no centre");
                            let off = (f64::from(numbers.get_1d(dimension)) * f64::from(n) - u).abs();
                            assert!(off < if jitter { 0.501 } else { 1e-9 }, "{settings:?}: {off} from the centre");
                        }
                        for (count, dimension) in two.iter_mut().zip(PAIRS) {
                            let cells = |numbers: &Numbers<Single>| {
                                let [x, y] = numbers.get_2d(dimension).map(f64::from);
                                [x * f64::from(nx), y * f64::from(ny)]
                            };
                            let ([x, y], [jx, jy]) = (cells(&middle), cells(&numbers));
                            count[x as usize + nx as usize * y as usize] += 1;
                            let off = (x.fract() - 0.5).abs().max((y.fract() - 0.5).abs());
                            assert!(off < 1e-3, "{settings:?}: {x}, {y} is no centre");
                            let off = (jx - x).abs().max((jy - y).abs());
                            assert!(off < if jitter { 0.501 } else { 1e-9 }, "{settings:?}: {off} from the centre");
                            order.push(x as u32 + nx * y as u32);
                        }
                    }
                    for count in one.iter().chain(&two) {
                        assert!(count.iter().all(|&c| c == 1), "{settings:?}, pixel {pixel}, round {round}: {count:?}");
                    }
                    orders.insert(order);
                }
                assert!(n < 12 || orders.len() == rounds as usize, "{settings:?}: rounds in the same order");
            }
        }
    }
}

/// Of 2^k successive samples from a multiple of 2^k on, each has one of 2^k equal intervals of the technique's number
/// to itself, and no interval comes first more often than others.
#[test]
fn techniques_alternate() {
    for settings in [SOBOL, stratified([8, 8], true), stratified([2, 1], true), stratified([16, 4], false)] {
        let most =
            if settings.kind == SamplerKind::PaddedStratified { settings.strata[0] * settings.strata[1] } else { 64 };
        let mut firsts = [0u32; 8];
        for pixel in 0..400 {
            let mut sampler = only(Dimension::Technique, &settings, pixel, 7);
            for k in (0..=6).filter(|k| 1 << k <= most) {
                for block in [0, 1, 5] {
                    let mut seen = vec![false; 1 << k];
                    for i in 0..1 << k {
                        let number = once::draw(&mut sampler, (block << k) + i).get_1d(Dimension::Technique);
                        let cell = (number * (1 << k) as f32) as usize;
                        assert!(!seen[cell], "{settings:?}, pixel {pixel}: two of 2^{k} numbers in one interval");
                        seen[cell] = true;
                        if block == 0 && k == 0 {
                            firsts[(number * 8.0) as usize] += 1;
                        }
                    }
                }
            }
        }
        let outcome = chi_square(&firsts, &[50.0; 8], 5.0);
        if settings.jitter {
            let mut family = PValues::new("first techniques");
            family.test(format!("{settings:?}"), outcome);
            family.judge(1);
        }
    }
}

/// Positions inside a stratum are uniform, and independent of the stratum.
#[test]
fn jitter_is_uniform() {
    let settings = stratified([3, 4], true);
    let mut family = PValues::new("jitter");
    let mut one = [[0u32; 96]; 3];
    let mut two = [[0u32; 12 * 16]; 3];
    const ROUNDS: u32 = 4000;
    for round in 0..ROUNDS {
        let mut sampler = at(&settings, round % 64, round / 64);
        for i in 0..12 {
            let numbers = once::draw(&mut sampler, 12 * round + i);
            for (count, dimension) in one.iter_mut().zip(SINGLES) {
                count[(f64::from(numbers.get_1d(dimension)) * 96.0) as usize] += 1;
            }
            for (count, dimension) in two.iter_mut().zip(PAIRS) {
                let [x, y] = numbers.get_2d(dimension).map(f64::from);
                count[(x * 12.0) as usize + 12 * (y * 16.0) as usize] += 1;
            }
        }
    }
    for (count, dimension) in one.iter().zip(SINGLES) {
        family.test(format!("{dimension:?}"), chi_square(count, &[f64::from(ROUNDS) / 8.0; 96], 5.0));
    }
    for (count, dimension) in two.iter().zip(PAIRS) {
        family.test(format!("{dimension:?}"), chi_square(count, &[f64::from(ROUNDS) / 16.0; 192], 5.0));
    }
    family.judge(6);
}

/// Strata of two samples of a pixel, over many pixels: each pair of different ones about as often. (A tenth off is the
/// claim for 6 strata, and for the 36 and more of `sampler.rs`; pairs of 5 or 12 are up to 0.16 off.)
#[test]
fn strata_come_in_random_order() {
    let mut family = PValues::new("first strata");
    for (strata, i, j, limit) in [
        ([2, 3], 0, 1, 0.1),
        ([2, 3], 2, 5, 0.1),
        ([3, 4], 0, 1, 0.2),
        ([3, 4], 4, 9, 0.2),
        ([1, 5], 1, 3, 0.2),
        ([2, 4], 0, 7, 0.2),
    ] {
        let settings = stratified(strata, false);
        let n = strata[0] * strata[1];
        let trials = 60_000;
        let mut pairs = vec![0u32; (n * n) as usize];
        let mut firsts = vec![0u32; n as usize];
        for t in 0..trials {
            let mut sampler = only(Dimension::Lobe, &settings, t % 256, t / 256);
            let [a, b] =
                [i, j].map(|index| (once::draw(&mut sampler, index).get_1d(Dimension::Lobe) * n as f32) as u32);
            pairs[(a * n + b) as usize] += 1;
            firsts[a as usize] += 1;
        }
        let expected = f64::from(trials) / f64::from(n * (n - 1));
        let mut chi2 = 0.0;
        for (cell, &count) in pairs.iter().enumerate() {
            if cell as u32 / n == cell as u32 % n {
                assert_eq!(count, 0, "{strata:?}: a stratum twice");
            } else {
                chi2 += (f64::from(count) - expected).powi(2) / expected;
            }
        }
        let degrees = f64::from(n * (n - 1) - 1);
        // Relative deviation from uniform, less that of counting.
        let excess = ((chi2 - degrees).max(0.0) / f64::from(trials)).sqrt();
        assert!(excess < limit, "{strata:?}, samples {i} and {j}: {excess}");
        family
            .test(format!("{strata:?}"), chi_square(&firsts, &vec![f64::from(trials) / f64::from(n); n as usize], 5.0));
    }
    family.judge(6);
}

/// Whatever the order of its patch, a pixel is in every stratum equally often.
#[test]
fn pixels_of_a_patch_are_in_all_strata() {
    let mut family = PValues::new("strata of one patch");
    for strata in [[2, 3], [3, 4], [1, 5], [4, 4], [6, 6]] {
        let (settings, n) = (stratified(strata, false), strata[0] * strata[1]);
        for (patch, index) in [(77, 0), (12_345, n / 2)] {
            let trials = 30_000;
            let mut one = vec![0u32; n as usize];
            let mut two = one.clone();
            for trial in 0..trials {
                let mut sampler = Draws::new(Single, &settings, ALL);
                sampler.start(key(trial % 200, trial / 200), patch);
                let numbers = once::draw(&mut sampler, index);
                one[(numbers.get_1d(Dimension::Lobe) * n as f32) as usize] += 1;
                let [x, y] = numbers.get_2d(Dimension::Pixel);
                two[(x * strata[0] as f32) as usize + strata[0] as usize * (y * strata[1] as f32) as usize] += 1;
            }
            let expected = vec![f64::from(trials) / f64::from(n); n as usize];
            family.test(format!("{strata:?}, one number"), chi_square(&one, &expected, 5.0));
            family.test(format!("{strata:?}, two numbers"), chi_square(&two, &expected, 5.0));
        }
    }
    family.judge(20);
}

/// From sample to sample, neighbours in a patch seldom move by the same number of strata, forwards or backwards: else
/// all 64 pixels would be lucky or unlucky together, and the noise of a picture in progress would come in squares.
#[test]
fn neighbours_go_through_strata_in_ways_of_their_own() {
    for strata in [[8, 8], [6, 6]] {
        let settings = stratified(strata, false);
        let n = strata[0] * strata[1];
        let step = |x: u32, y: u32, index: u32| {
            let mut sampler = only(Dimension::LightChoice, &settings, x, y);
            let [a, b] = [index, index + 1]
                .map(|index| (once::draw(&mut sampler, index).get_1d(Dimension::LightChoice) * n as f32) as u32);
            (b + n - a) % n
        };
        let (mut alike, mut count) = (0u32, 0u32);
        for patch in 0..2000 {
            let (x, y) = (patch % 50 * 8, patch / 50 * 8);
            for index in [0, 7, 20] {
                let (here, there) = (step(x, y, index), step(x + 1 + patch % 7, y + 3, index));
                alike += u32::from(here == there || here == n - there);
                count += 1;
            }
        }
        // Independent permutations: 2 of n - 1.
        let (share, ideal) = (f64::from(alike) / f64::from(count), 2.0 / f64::from(n - 1));
        assert!(share < ideal + 0.05, "{strata:?}: {share} of the steps are alike, {ideal} would be by chance");
    }
}

/// Fails unless each of the 2^k points has an elementary interval of every shape to itself.
fn assert_net(points: &[[f64; 2]], what: impl Fn() -> String) {
    let k = points.len().ilog2();
    for a in 0..=k {
        let (columns, rows) = (f64::from(1 << a), f64::from(1 << (k - a)));
        let mut seen = vec![false; points.len()];
        for [x, y] in points {
            let cell = (x * columns) as usize + (1 << a) * (y * rows) as usize;
            assert!(!seen[cell], "{}: two points in one of {columns} x {rows} cells", what());
            seen[cell] = true;
        }
    }
}

#[test]
fn sobol_points_are_nets() {
    for pixel in 0..40 {
        for (k, first) in [(0, 5), (1, 6), (3, 0), (5, 32), (6, 1 << 20), (8, 256)] {
            let numbers: Vec<_> = (0..1 << k).map(|i| once::draw(&mut at(&SOBOL, pixel, 3), first + i)).collect();
            for dimension in PAIRS {
                let points: Vec<_> = numbers.iter().map(|n| n.get_2d(dimension).map(f64::from)).collect();
                assert_net(&points, || format!("{dimension:?}, pixel {pixel}, 2^{k} points from {first}"));
            }
            for dimension in SINGLES {
                let mut seen = vec![false; 1 << k];
                for numbers in &numbers {
                    let cell = (numbers.get_1d(dimension) * (1 << k) as f32) as usize;
                    assert!(!seen[cell], "{dimension:?}, pixel {pixel}: two points in one of 2^{k} intervals");
                    seen[cell] = true;
                }
            }
        }
    }
}

#[test]
fn long_runs_of_sobol_points_are_nets() {
    for pixel in 0..2 {
        let mut sampler = only(Dimension::Light, &SOBOL, pixel, 0);
        let points: Vec<_> =
            (0..1 << 17).map(|i| once::draw(&mut sampler, i).get_2d(Dimension::Light).map(f64::from)).collect();
        assert_net(&points, || format!("pixel {pixel}"));
    }
}

/// No two pixels share a pattern in any dimension, except that of techniques; those of a patch shuffle its order of strata in ways of their own.
#[test]
fn pixels_have_patterns_of_their_own() {
    let large = stratified([256, 256], false);
    for settings in [SOBOL, large, INDEPENDENT] {
        let mut seen = [(); 6].map(|()| HashSet::new());
        const PIXELS: u32 = 10_000;
        for pixel in 0..PIXELS {
            let mut sampler = at(&settings, pixel % 100, pixel / 100);
            let drawn = [0, 1, 2, 3].map(|index| once::draw(&mut sampler, index));
            for (seen, dimension) in seen.iter_mut().zip(Dimension::ALL) {
                seen.insert(drawn.map(|numbers| numbers.get_2d(dimension).map(f32::to_bits)));
            }
        }
        for (seen, dimension) in seen.iter().zip(Dimension::ALL) {
            if settings.kind == SamplerKind::PaddedStratified && dimension == Dimension::Technique {
                // Techniques alternate: four samples of a pixel leave 2^18 ways.
                assert!(seen.len() > 9700, "{} of {PIXELS} pixels have a pattern of their own", seen.len());
                continue;
            }
            assert_eq!(seen.len(), PIXELS as usize, "{settings:?}, {dimension:?}: pixels with the same pattern");
        }
    }
}
