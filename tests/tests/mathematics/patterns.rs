//! Patterns of random numbers hold what their names say: strata a sample each, Sobol points nets, and every pixel one of its own.

use std::collections::HashSet;

use mislab_kernel::lanes::Single;
use mislab_kernel::sampler::{Dimension, Numbers};
use mislab_renderer::SamplerKind;
use mislab_tests::chi_square::{PValues, chi_square};
use mislab_tests::draws::Draws;
use mislab_tests::pair::INDEPENDENT;

use crate::numbers::{ALL, PAIRS, SINGLES, SOBOL, at, key, only, stratified};
use crate::once;

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
