//! People stop early: the first n samples of any sampler are unbiased for any n.
//!
//! The samples of one pixel depend on each other, so errors are judged over 4096 independent
//! replicates: pixels with other seeds.

use glam::DVec3;
use mislab_kernel::lanes::{Single, Wrapping};
use mislab_kernel::sampler::{Dimension, Numbers, patch_key, pixel_keys};
use mislab_renderer::{Channel, Estimator, SamplerKind, SamplerSettings, Sampling, Settings, Strategy};
use mislab_tests::draws::Draws;
use mislab_tests::experiment::{independent, keyhole, render, veach};
use mislab_tests::oracle::{LUMINANCE, World};
use mislab_tests::statistics::Family;

const REPLICATES: u32 = 4096;
const LENGTHS: [u32; 13] = [1, 2, 3, 5, 7, 13, 23, 36, 50, 63, 64, 65, 100];

fn of(kind: SamplerKind, strata: [u32; 2]) -> (String, SamplerSettings) {
    (format!("{} {}x{}", kind.name(), strata[0], strata[1]), SamplerSettings { kind, strata, jitter: true })
}

/// Those with a number for every choice.
fn padded() -> Vec<(String, SamplerSettings)> {
    let mut all: Vec<_> = [[8, 8], [6, 6], [3, 5], [1, 1]].map(|s| of(SamplerKind::PaddedStratified, s)).into();
    all.push(of(SamplerKind::Independent, [1, 1]));
    all.push(of(SamplerKind::PaddedSobol, [1, 1]));
    all
}

/// Those with one number for all choices.
fn nested() -> Vec<(String, SamplerSettings)> {
    let mut all: Vec<_> = [[8, 8], [6, 6], [3, 5], [1, 9]].map(|s| of(SamplerKind::Stratified, s)).into();
    all.push(of(SamplerKind::Lattice, [1, 1]));
    all.push(of(SamplerKind::Sobol, [1, 1]));
    all
}

/// Functions of a sample's numbers whose mean is zero: moments of every number, products of both
/// axes, a box and a step, and products between dimensions.
fn functions(random: &Numbers<Single>) -> Vec<(&'static str, f64)> {
    let one = |d| f64::from(random.get_1d(d));
    let two = |d| random.get_2d(d).map(f64::from);
    let step = |u: f64, at: f64| if u < at { 1.0 - at } else { -at };
    let mut values = Vec::new();
    for d in [Dimension::Technique, Dimension::LightChoice, Dimension::Lobe] {
        let u = one(d);
        values.extend([("u", u - 0.5), ("u^2", u * u - 1.0 / 3.0), ("step", step(u, 0.37))]);
    }
    for d in [Dimension::Pixel, Dimension::Light, Dimension::Bsdf] {
        let [u, v] = two(d);
        let inside = if u < 0.3 && v < 0.7 { 1.0 } else { 0.0 };
        values.extend([("u", u - 0.5), ("v", v - 0.5), ("u^2", u * u - 1.0 / 3.0), ("v^2", v * v - 1.0 / 3.0)]);
        values.extend([("u v", (u - 0.5) * (v - 0.5)), ("box", inside - 0.21)]);
    }
    let [x, y] = two(Dimension::Pixel);
    let ([a, b], [c, d]) = (two(Dimension::Light), two(Dimension::Bsdf));
    let (t, k, lobe) = (one(Dimension::Technique), one(Dimension::LightChoice), one(Dimension::Lobe));
    for (name, p, q) in [
        ("pixel x, light u", x, a),
        ("pixel y, light v", y, b),
        ("pixel x, bsdf u", x, c),
        ("light u, bsdf u", a, c),
        ("light v, bsdf v", b, d),
        ("technique, light u", t, a),
        ("technique, light choice", t, k),
        ("light choice, light u", k, a),
        ("lobe, bsdf u", lobe, c),
        ("lobe, technique", lobe, t),
    ] {
        values.push((name, (p - 0.5) * (q - 0.5)));
    }
    values
}

/// Functions of what each choice draws and leaves whose mean is zero, where one number is for all choices; in the one-sample
/// model at this c, of five lights and two lobes.
fn nested_functions(random: &Numbers<Single>, c: f32) -> Vec<(&'static str, f64)> {
    let by_light = random.get_1d(Dimension::Technique) < c;
    let after = random.after_technique(Single, by_light, c);
    let (light, [a, b]) = after.choose_light(Single, 5);
    let (specular, [lobe, _]) = after.choose_lobe(Single, 0.5);
    let technique = if by_light { 1.0 - f64::from(c) } else { -f64::from(c) };
    let light = f64::from(light.0) / 4.0 - 0.5;
    let specular = if specular { 0.5 } else { -0.5 };
    let [x, y] = random.get_2d(Dimension::Pixel).map(f64::from);
    let (a, b, lobe) = (f64::from(a), f64::from(b), f64::from(lobe));
    let inside = if a < 0.3 && b < 0.7 { 1.0 } else { 0.0 };
    let mut values = vec![("technique", technique), ("light", light), ("lobe", specular), ("box", inside - 0.21)];
    values.extend([("u", a - 0.5), ("v", b - 0.5), ("u^2", a * a - 1.0 / 3.0), ("v^2", b * b - 1.0 / 3.0)]);
    values.extend([("u v", (a - 0.5) * (b - 0.5)), ("lobe's u", lobe - 0.5), ("x y", (x - 0.5) * (y - 0.5))]);
    values.extend([("technique, light", technique * light), ("technique, lobe", technique * specular)]);
    for (name, choice) in [("technique", technique), ("light", light)] {
        values.extend([(name, choice * (a - 0.5)), (name, choice * (b - 0.5)), (name, choice * (x - 0.5))]);
    }
    values.extend([("lobe, u", specular * (lobe - 0.5)), ("lobe, v", specular * (b - 0.5))]);
    values.extend([("x, u", (x - 0.5) * (a - 0.5)), ("y, v", (y - 0.5) * (b - 0.5))]);
    values
}

#[test]
fn every_prefix_of_the_numbers_is_unbiased() {
    let mut family = Family::new("prefixes of numbers");
    for (name, settings) in padded() {
        test_numbers(&mut family, &name, &settings, functions);
    }
    family.judge(6 * 13 * 37);
}

#[test]
fn every_prefix_of_nested_choices_is_unbiased() {
    let mut family = Family::new("prefixes of nested choices");
    for (name, settings) in nested() {
        for c in [0.5, 0.3] {
            test_numbers(&mut family, &format!("{name}, c = {c}"), &settings, |random| nested_functions(random, c));
        }
    }
    family.judge(5 * 2 * 13 * 23);
}

/// Tests that functions of the numbers have the mean zero over each prefix of the samples of a pixel.
fn test_numbers(
    family: &mut Family,
    name: &str,
    settings: &SamplerSettings,
    functions: impl Fn(&Numbers<Single>) -> Vec<(&'static str, f64)>,
) {
    let last = LENGTHS[LENGTHS.len() - 1];
    // Sums over replicates of the prefix mean and its square, by length and function.
    let mut sums: Vec<Vec<(&str, f64, f64)>> = vec![Vec::new(); LENGTHS.len()];
    for replicate in 0..REPLICATES {
        let mut sampler = Draws::new(Single, settings, Dimension::wanted(Strategy::Mis, true, true));
        let (x, y) = (Wrapping(replicate % 61), Wrapping(replicate / 61));
        sampler.start(pixel_keys(Single, replicate, x, y), patch_key(replicate, [x.0 & !7, y.0 & !7]));
        let mut running: Vec<f64> = Vec::new();
        for index in 0..last {
            let values = functions(&sampler.draw(index));
            running.resize(values.len(), 0.0);
            for (sum, (_, value)) in running.iter_mut().zip(&values) {
                *sum += value;
            }
            if let Some(at) = LENGTHS.iter().position(|&n| n == index + 1) {
                sums[at].resize(values.len(), ("", 0.0, 0.0));
                for ((sum, running), (label, _)) in sums[at].iter_mut().zip(&running).zip(&values) {
                    let mean = running / f64::from(index + 1);
                    *sum = (*label, sum.1 + mean, sum.2 + mean * mean);
                }
            }
        }
    }
    let n = f64::from(REPLICATES);
    for (length, sums) in LENGTHS.iter().zip(&sums) {
        for (i, (label, sum, squares)) in sums.iter().enumerate() {
            let mean = sum / n;
            let error = ((squares / n - mean * mean) / (n - 1.0)).sqrt();
            // Numbers are multiples of 2^-24.
            family.test(format!("{name}, {length} samples, {label} ({i})"), mean, 0.0, error.hypot(6e-8));
        }
    }
}

#[test]
fn every_prefix_of_a_picture_is_unbiased() {
    const EYE: DVec3 = DVec3::new(0.0, 2.0, 15.0);
    let mut family = Family::new("prefixes of pictures");
    let scene = veach();
    // On the floor, where every light is seen and the integrand is smooth.
    let target = DVec3::new(0.7, -4.14615, 7.0);
    let view = keyhole(&scene, EYE, target);
    let point = World::new(&scene).point(EYE, target);
    for strategy in [Strategy::Light, Strategy::MisAll, Strategy::Mis] {
        let base = independent(1, 1, [32, 32]);
        let expected = point
            .sample(&Settings { estimator: Estimator { strategy, ..base.estimator }, ..base }, LUMINANCE)
            .total
            .mean();
        for (name, sampler) in padded().into_iter().chain(nested()) {
            for spp in LENGTHS {
                let mut values = Vec::new();
                for seed in 0..REPLICATES / 1024 {
                    let base = independent(spp, 500 + seed, [32, 32]);
                    let settings = Settings {
                        estimator: Estimator { strategy, ..base.estimator },
                        sampling: Sampling { sampler, ..base.sampling },
                        ..base
                    };
                    let frame = render(&view, &settings);
                    let channels = [Channel::R, Channel::G, Channel::B].map(|c| frame.channel(c));
                    values
                        .extend((0..1024).map(|i| LUMINANCE.dot(channels.each_ref().map(|c| f64::from(c[i])).into())));
                }
                let n = values.len() as f64;
                let mean = values.iter().sum::<f64>() / n;
                let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
                let error = (variance / n).sqrt().hypot(3e-5 * expected);
                family.test(format!("{}, {name}, {spp} samples", strategy.name()), mean, expected, error);
            }
        }
    }
    family.judge(3 * 11 * 13);
}
