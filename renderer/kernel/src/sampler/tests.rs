//! What only this folder can see of its patterns.

use super::*;
use crate::lanes::{Single, Wrapping};
use crate::request::Strategy;

fn place(i: u32, n: u32, key: u32) -> u32 {
    Order::new(Strata::new(n), key).place(Single, Wrapping(i)).0
}

fn numbers(settings: &SamplerSettings, strategy: Strategy, key: u32, index: u32) -> Numbers<Single> {
    let mut sampler = Sampler::new(settings, Dimension::wanted(strategy, true, true), 1);
    sampler.start(index, 1);
    sampler.enter(Single, key);
    let mut numbers = sampler.nothing(Single);
    let mut pixels = Pixels::new(Single, Wrapping(key));
    sampler.turn(Single, &mut pixels);
    let sample = sampler.sample(Single, Which { sample: 0, next: false }, &pixels);
    numbers.set_technique(sample.technique());
    sample.draw(PerTechnique::BOTH, &mut numbers);
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
    for pixel in 0..8 {
        let kind = if pixel % 2 == 0 { SamplerKind::Sobol } else { SamplerKind::PaddedSobol };
        let settings = SamplerSettings { kind, strata: [1, 1], jitter: true };
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
    let settings = SamplerSettings { kind: SamplerKind::PaddedStratified, strata: [6, 6], jitter: true };
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
