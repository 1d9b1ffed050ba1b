//! Patterns whose one number chooses technique, light, lobe and direction: what they promise exactly, and that they are as
//! random as an estimate without bias needs.

use mislab_kernel::lanes::Single;
use mislab_kernel::sampler::{Dimension, Numbers};
use mislab_renderer::{SamplerKind, SamplerSettings, Strategy};
use mislab_tests::draws::Draws;

use crate::once;
use crate::pairs::Pairs;

const SOBOL: SamplerSettings = SamplerSettings { kind: SamplerKind::Sobol, strata: [1, 1], jitter: true };
const LATTICE: SamplerSettings = SamplerSettings { kind: SamplerKind::Lattice, strata: [1, 1], jitter: true };
const SIX: [&str; 6] = ["pixel x", "pixel y", "light u", "light v", "BSDF u", "BSDF v"];
const STRATA: [[u32; 2]; 12] =
    [[1, 1], [2, 1], [1, 7], [17, 1], [2, 3], [6, 6], [8, 8], [7, 5], [4, 16], [16, 16], [31, 33], [64, 2]];

fn strata(strata: [u32; 2], jitter: bool) -> SamplerSettings {
    SamplerSettings { kind: SamplerKind::Stratified, strata, jitter }
}

/// Of the strategy, where there are several lights and lobes; at a pixel.
fn at(settings: &SamplerSettings, strategy: Strategy, seed: u32, x: u32, y: u32) -> Draws<Single> {
    let mut sampler = Draws::new(Single, settings, Dimension::wanted(strategy, true, true));
    sampler.start(once::key(seed, x, y), once::patch(seed, x, y));
    sampler
}

fn two(numbers: &Numbers<Single>, dimension: Dimension) -> [f64; 2] {
    numbers.get_2d(dimension).map(f64::from)
}

/// The position in the pixel and both directions of `mis_all`.
fn six(numbers: &Numbers<Single>) -> [f64; 6] {
    let [a, b, c] = [Dimension::Pixel, Dimension::Light, Dimension::Bsdf].map(|d| two(numbers, d));
    [a[0], a[1], b[0], b[1], c[0], c[1]]
}

/// Which of `n` equal parts of the unit interval.
fn part(u: f64, n: u32) -> usize {
    (u * f64::from(n)) as usize
}

#[test]
fn every_cell_and_every_slot_of_either_axis_gets_one_sample_of_each_round() {
    for [nx, ny] in STRATA {
        let n = nx * ny;
        for jitter in [true, false] {
            let settings = strata([nx, ny], jitter);
            for pixel in 0..3 {
                // The middle of each slot: rounding may move a number over the edge of its slot, but not the middle.
                let mut middles = at(&strata([nx, ny], false), Strategy::MisAll, 3, pixel, 4);
                let mut sampler = at(&settings, Strategy::MisAll, 3, pixel, 4);
                for round in 0..2 {
                    let mut seen = vec![[[false; 3]; 2]; n as usize];
                    for i in 0..n {
                        let middle = once::draw(&mut middles, round * n + i);
                        let drawn = once::draw(&mut sampler, round * n + i);
                        for (group, dimension) in [Dimension::Light, Dimension::Bsdf].into_iter().enumerate() {
                            let [x, y] = two(&middle, dimension);
                            let cell = part(x, nx) + nx as usize * part(y, ny);
                            for (what, index) in [cell, part(x, n), part(y, n)].into_iter().enumerate() {
                                let seen = &mut seen[index][group][what];
                                assert!(!*seen, "{settings:?}, pixel {pixel}, {dimension:?}: {what} {index} twice");
                                *seen = true;
                            }
                            let off = |axis: usize| (two(&drawn, dimension)[axis] - [x, y][axis]).abs() * f64::from(n);
                            let most = if jitter { 0.501 } else { 0.0 };
                            assert!(off(0) <= most && off(1) <= most, "{settings:?}: {} and {} slots", off(0), off(1));
                        }
                    }
                }
            }
        }
    }
}

/// Where choices share out other columns evenly, directions have cells of those; what each light has of them is whole cells,
/// and the position in the pixel keeps its own.
#[test]
fn choices_have_whole_cells_where_that_can_be() {
    for (pixel_cells, parts, [nx, ny]) in [
        ([6, 6], 4, [12, 3]),
        ([6, 6], 9, [9, 4]),
        ([6, 6], 3, [6, 6]),
        ([6, 6], 5, [6, 6]),
        // Two of them share a column.
        ([6, 6], 18, [9, 4]),
        ([8, 8], 8, [16, 4]),
        ([9, 8], 8, [12, 6]),
        ([4, 4], 4, [8, 2]),
        ([8, 8], 4, [8, 8]),
        ([8, 8], 65, [8, 8]),
        ([10, 10], 4, [20, 5]),
        ([4, 16], 8, [8, 8]),
        ([7, 5], 2, [7, 5]),
    ] {
        let n = nx * ny;
        let wanted = Dimension::wanted(Strategy::MisAll, true, true);
        for x in 0..5 {
            let mut sampler = Draws::among(Single, &strata(pixel_cells, false), wanted, parts);
            sampler.start(once::key(3, x, 4), once::patch(3, x, 4));
            let (mut cells, mut rows) = (vec![[0; 3]; n as usize], vec![[0; 2]; n as usize]);
            for i in 0..n {
                let drawn = once::draw(&mut sampler, i);
                for (group, dimension) in [Dimension::Light, Dimension::Bsdf].into_iter().enumerate() {
                    let [u, v] = two(&drawn, dimension);
                    cells[part(u, nx) + nx as usize * part(v, ny)][group] += 1;
                    rows[part(v, n)][group] += 1;
                }
                let ([u, v], [nx, ny]) = (two(&drawn, Dimension::Pixel), pixel_cells);
                cells[part(u, nx) + nx as usize * part(v, ny)][2] += 1;
            }
            assert!(cells.iter().all(|count| *count == [1; 3]), "{pixel_cells:?}, {parts} parts: {cells:?}");
            assert!(rows.iter().all(|count| *count == [1; 2]), "{pixel_cells:?}, {parts} parts: {rows:?}");
        }
    }
}

/// The position in the pixel has cells and slots as well; without jitter it is in the middle of its cell.
#[test]
fn positions_in_the_pixel_fill_cells_and_slots() {
    for [nx, ny] in STRATA {
        let n = nx * ny;
        for jitter in [true, false] {
            let mut sampler = at(&strata([nx, ny], jitter), Strategy::Light, 3, 8, 1);
            let (mut cells, mut slots) = (vec![0; n as usize], [vec![0; n as usize], vec![0; n as usize]]);
            for i in 0..n {
                let [x, y] = two(&once::draw(&mut sampler, i), Dimension::Pixel);
                cells[part(x, nx) + nx as usize * part(y, ny)] += 1;
                slots[0][part(x, n)] += 1;
                slots[1][part(y, n)] += 1;
                for (u, n) in [(x, nx), (y, ny)] {
                    let off = ((u * f64::from(n)).fract() - 0.5).abs();
                    assert!(jitter || off < 1e-3, "{nx} x {ny}: {u} is no centre");
                }
            }
            assert!(cells.iter().all(|&count| count == 1), "{nx} x {ny}, jitter {jitter}: {cells:?}");
            let full = slots.iter().flatten().all(|&count| count == 1);
            assert!(full || !jitter, "{nx} x {ny}: {slots:?}");
        }
    }
}

/// Of the one-sample model: samples `2j` and `2j + 1` are half of the unit interval apart, and so one is drawn by the light
/// and one by the BSDF at c = 1/2.
#[test]
fn pairs_of_samples_have_one_of_each_technique() {
    for settings in [LATTICE, strata([8, 8], true), strata([6, 6], true), strata([2, 5], true), strata([2, 1], false)] {
        for pixel in 0..200 {
            let mut sampler = at(&settings, Strategy::Mis, 9, pixel, 2);
            for pair in [0, 1, 2, 17, 1000] {
                let [a, b] = [0, 1].map(|i| once::draw(&mut sampler, 2 * pair + i).get_1d(Dimension::Technique));
                assert!((a < 0.5) != (b < 0.5), "{settings:?}, pixel {pixel}: {a} and {b}");
                assert!(((a - b).abs() - 0.5).abs() < 1e-6, "{settings:?}, pixel {pixel}: {a} and {b}");
            }
        }
    }
}

/// The first `2^m` points, and any that follow from a multiple of `2^m` on, are one lattice: with two points it has
/// their difference, and the shortest is long, for a square that is stretched, too.
#[test]
fn every_power_of_two_is_a_good_lattice() {
    let hexagonal = (2.0 / 3f64.sqrt()).sqrt();
    for strategy in [Strategy::Light, Strategy::Mis, Strategy::MisAll] {
        for m in 0..=12 {
            for first in [0, 3 << m] {
                let mut sampler = at(&LATTICE, strategy, 1, 5, 5);
                for dimension in [Dimension::Pixel, Dimension::Light, Dimension::Bsdf] {
                    if strategy == Strategy::Light && dimension == Dimension::Bsdf {
                        continue;
                    }
                    let points: Vec<[u32; 2]> = (0..1 << m)
                        .map(|i| {
                            let numbers = once::draw(&mut sampler, first + i);
                            // All of the unit interval belongs to the one technique.
                            let one_sample = strategy == Strategy::Mis;
                            let left = if one_sample { numbers.after_technique(Single, true, 1.0) } else { numbers };
                            left.get_2d(dimension).map(|u| (u * 16_777_216.0) as u32)
                        })
                        .collect();
                    let difference = |p: [u32; 2]| [0, 1].map(|k| p[k].wrapping_sub(points[0][k]) & 0xff_ffff);
                    let mut lattice: Vec<_> = points.iter().map(|&p| difference(p)).collect();
                    lattice.sort_unstable();
                    let what = format!("{}, {dimension:?}, 2^{m} from {first}", strategy.name());
                    // Multiples of the point at 2^-m.
                    let generator = lattice[1 % lattice.len()];
                    for (k, &[x, y]) in lattice.iter().enumerate() {
                        let expected = generator.map(|g| g.wrapping_mul(k as u32) & 0xff_ffff);
                        assert_eq!([x, y], expected, "{what}: multiple {k}");
                    }
                    let shortest = |stretch: f64| {
                        let near = |v: u32| f64::from(v.min((1 << 24) - v)) / 16_777_216.0;
                        let length = |p: &[u32; 2]| (near(p[0]) * stretch.sqrt()).hypot(near(p[1]) / stretch.sqrt());
                        lattice[1..].iter().map(length).fold(f64::INFINITY, f64::min) * f64::from(1 << m).sqrt()
                            / hexagonal
                    };
                    if m >= 3 && dimension != Dimension::Pixel {
                        for stretch in [0.08, 0.2, 0.5, 1.0, 2.0, 5.0] {
                            assert!(shortest(stretch) > 0.49, "{what}, stretched {stretch}: {}", shortest(stretch));
                        }
                    }
                }
            }
        }
    }
}

/// What a choice leaves of a number is where it lies in its part: `n u - l` of the light l, `u / c` or
/// `(u - c) / (1 - c)` of a technique and of a lobe; never 1, and a number even where a part has no length.
#[test]
fn choices_leave_the_place_in_their_part() {
    for settings in [LATTICE, strata([8, 8], true), strata([7, 5], true)] {
        let mut sampler = at(&settings, Strategy::Mis, 2, 7, 7);
        for index in 0..4000 {
            let numbers = once::draw(&mut sampler, index);
            let u = f64::from(numbers.get_1d(Dimension::Technique));
            let v = numbers.get_2d(Dimension::Technique)[1];
            for c in [0.0, 1e-40, 1e-6, 0.1, 0.3, 0.5, 0.9, 1.0 - 1e-6, 1.0f32.next_down(), 1.0] {
                let by_light = numbers.get_1d(Dimension::Technique) < c;
                let after = numbers.after_technique(Single, by_light, c);
                let p = f64::from(c);
                let (expected, length) = if by_light { (u / p, p) } else { ((u - p) / (1.0 - p), 1.0 - p) };
                for dimension in [Dimension::Light, Dimension::Bsdf] {
                    let [rest, second] = after.get_2d(dimension);
                    assert!((0.0..1.0).contains(&rest), "{u} leaves {rest} at c = {c}");
                    let off = (f64::from(rest) - expected).abs();
                    assert!(off <= 2e-7 + 6e-8 / length, "{u} leaves {rest} at c = {c}, expected {expected}");
                    assert_eq!(second, v, "the second number is left alone");
                }
                assert_eq!(after.get_1d(Dimension::Technique), numbers.get_1d(Dimension::Technique), "c = {c}");
                if index > 500 {
                    continue;
                }
                let u = f64::from(after.get_1d(Dimension::LightChoice));
                for n in 1..=65 {
                    let (light, [rest, second]) = after.choose_light(Single, n);
                    let z = u * n as f64;
                    let near = z as u32 == light.0 || (z - z.round()).abs() < 1e-5;
                    assert!(near && light.0 < n as u32, "{u} of {n} chooses {light:?}");
                    assert!((0.0..1.0).contains(&rest) && second == v, "{u} of {n} leaves {rest}, {second}");
                    let off = (f64::from(rest) - (z - f64::from(light.0))).abs();
                    assert!(off < 1e-5, "{u} of {n} leaves {rest}");
                }
                for p in [0.5f32, 0.25] {
                    let (specular, [rest, second]) = after.choose_lobe(Single, p);
                    assert_eq!(specular, u < f64::from(p), "{u}");
                    let (start, length) = if specular { (0.0, p) } else { (p, 1.0 - p) };
                    let expected = (u - f64::from(start)) / f64::from(length);
                    assert!(
                        (f64::from(rest) - expected).abs() < 3e-7 && rest < 1.0 && second == v,
                        "{u} leaves {rest}"
                    );
                }
            }
        }
    }
}

/// Of N = n m samples every light, technique and lobe gets its share, to one sample.
#[test]
fn choices_are_as_even_as_can_be() {
    for (settings, count) in [(LATTICE, 64), (LATTICE, 1024), (strata([6, 6], true), 36), (strata([7, 5], true), 35)] {
        for pixel in 0..20 {
            let mut sampler = at(&settings, Strategy::Mis, 6, pixel, 0);
            let drawn: Vec<_> = (0..count).map(|i| once::draw(&mut sampler, i)).collect();
            for c in [0.1, 0.5, 0.9f32] {
                let by_light = |numbers: &Numbers<Single>| numbers.get_1d(Dimension::Technique) < c;
                let share = drawn.iter().filter(|numbers| by_light(numbers)).count() as f64;
                let expected = f64::from(c) * f64::from(count);
                assert!((share - expected).abs() <= 1.001, "{settings:?}: {share} of {count} at c = {c}");
                for n in [1, 2, 3, 4, 5, 7, 16] {
                    let mut counts = vec![0.0; n];
                    for numbers in drawn.iter().filter(|numbers| by_light(numbers)) {
                        let (light, _) = numbers.after_technique(Single, true, c).choose_light(Single, n);
                        counts[light.0 as usize] += 1.0;
                    }
                    let off = |count: &f64| (count - expected / n as f64).abs();
                    // An interval holds as many of equally spaced numbers as its length says, to one.
                    assert!(counts.iter().all(|count| off(count) <= 1.001), "{settings:?}, c = {c}: {counts:?}");
                }
            }
        }
    }
}

/// Each sample is uniform, its numbers know nothing of each other, nor of those of other pixels, seeds and rounds.
#[test]
fn numbers_pixels_and_rounds_are_independent() {
    let mut pairs = Pairs::new("pairs of numbers of lattices", SIX);
    let place = |i: u32| (2 * (i % 300), 2 * (i / 300));
    let patterns =
        [SOBOL, LATTICE, strata([8, 8], true), strata([6, 6], true), strata([7, 5], true), strata([1, 9], true)];
    for settings in patterns {
        let name = format!("{} {:?}", settings.kind.name(), settings.strata);
        let draw = |seed, x, y, index| six(&once::draw(&mut at(&settings, Strategy::MisAll, seed, x, y), index));
        for index in [0, 1, 7, 30] {
            pairs.of_one(&format!("{name}, sample {index}"), |i| draw(3, place(i).0, place(i).1, index));
        }
        let beside = |i| [0, 1].map(|k| draw(3, place(i).0 + k, place(i).1, 2));
        pairs.of_two(&format!("{name}, next to each other"), beside);
        let above = |i| [0, 1].map(|k| draw(3, place(i).0, place(i).1 + k, 2));
        pairs.of_two(&format!("{name}, above each other"), above);
        pairs.of_two(&format!("{name}, two seeds"), |i| [0, 1].map(|seed| draw(seed, i, 0, 2)));
        if settings.kind == SamplerKind::Stratified {
            let n = settings.strata[0] * settings.strata[1];
            let rounds = |i: u32| [0, 1].map(|round| draw(3, i % 300, i / 300, 2 + round * n));
            pairs.of_two(&format!("{name}, two rounds"), rounds);
        }
    }
    pairs.judge(6 * (4 * 15 + 3 * 36) + 4 * 36);
}

/// So a picture of the one-sample model at c = 0 or 1 is the one of that technique.
#[test]
fn the_techniques_share_a_pattern_where_one_of_them_is_drawn() {
    for settings in [SOBOL, LATTICE, strata([6, 6], true)] {
        for index in [0, 5, 50] {
            let draw = |strategy| once::draw(&mut at(&settings, strategy, 4, 3, 3), index);
            let (light, bsdf, all, mis) =
                (draw(Strategy::Light), draw(Strategy::Bsdf), draw(Strategy::MisAll), draw(Strategy::Mis));
            assert_eq!(light.get_2d(Dimension::Light), bsdf.get_2d(Dimension::Bsdf), "{settings:?}");
            assert_eq!(light.get_2d(Dimension::Light), mis.get_2d(Dimension::Technique), "{settings:?}");
            assert_eq!(light.get_2d(Dimension::Light), all.get_2d(Dimension::Light), "{settings:?}");
            assert_ne!(all.get_2d(Dimension::Light), all.get_2d(Dimension::Bsdf), "both are drawn: each has its own");
            for numbers in [bsdf, all, mis] {
                assert_eq!(numbers.get_2d(Dimension::Pixel), light.get_2d(Dimension::Pixel), "{settings:?}");
            }
        }
    }
}
