//! Random numbers: where they lie, and that pixels, samples and dimensions know nothing of each other.

use std::collections::HashSet;

use mislab_kernel::lanes::{Single, Wrapping};
use mislab_kernel::request::PerTechnique;
use mislab_kernel::sampler::{Dimension, Numbers, Pixels, RUN, Sampler, Which, patch_key};
use mislab_renderer::{SamplerKind, SamplerSettings, Strategy};
use mislab_tests::draws::Draws;
use mislab_tests::pair::INDEPENDENT;
use mislab_tests::statistics::z_limit;

use crate::once;
use crate::pairs::Pairs;

pub const SOBOL: SamplerSettings = SamplerSettings { kind: SamplerKind::PaddedSobol, strata: [1, 1], jitter: true };
pub const ALL: [bool; Dimension::ALL.len()] = [true; Dimension::ALL.len()];
pub const PAIRS: [Dimension; 3] = [Dimension::Pixel, Dimension::Light, Dimension::Bsdf];
pub const SINGLES: [Dimension; 3] = [Dimension::Technique, Dimension::LightChoice, Dimension::Lobe];

pub fn stratified(strata: [u32; 2], jitter: bool) -> SamplerSettings {
    SamplerSettings { kind: SamplerKind::PaddedStratified, strata, jitter }
}

pub fn key(x: u32, y: u32) -> Wrapping {
    once::key(3, x, y)
}

/// A sampler at a pixel.
pub fn at(settings: &SamplerSettings, x: u32, y: u32) -> Draws<Single> {
    wanting(ALL, settings, x, y)
}

/// A sampler at a pixel, for one dimension.
pub fn only(dimension: Dimension, settings: &SamplerSettings, x: u32, y: u32) -> Draws<Single> {
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
