//! The heuristics at given densities. (Weights of the densities of whole scenes: `weights.rs`.)

use mislab_kernel::estimator::heuristic::{self, Rivals, Weighted};
use mislab_kernel::lanes::Single;
use mislab_renderer::Heuristic;

/// Four units in the last place of 1.
const ULPS: f32 = 4.0 * f32::EPSILON;

/// The weight of a technique of density `own`, and its effective density.
fn weigh(heuristic: Heuristic, own: f32, other: f32, wins_ties: bool) -> Weighted<Single> {
    heuristic::weigh(Single, heuristic, &Rivals { own, other, wins_ties })
}

/// Both weights, with the technique that wins ties first.
fn weights(heuristic: Heuristic, a: f32, b: f32) -> [f32; 2] {
    [weigh(heuristic, a, b, true).w, weigh(heuristic, b, a, false).w]
}

fn assert_sound([a, b]: [f32; 2], what: impl Fn() -> String) {
    assert!(a >= 0.0 && b >= 0.0 && (a + b - 1.0).abs() <= ULPS, "{}: weights {a} and {b}, sum {}", what(), a + b);
}

#[test]
fn weights_of_extreme_densities_sum_to_one() {
    let values = [0.0, 1e-45, 1e-38, 1e-20, 1e-6, 0.08, 0.999_999_9, 1.0, 3.0, 1e6, 3e13, 1e20, 1e38, f32::MAX];
    for heuristic in Heuristic::ALL {
        for a in values {
            for b in values {
                if a == 0.0 && b == 0.0 {
                    continue;
                }
                let w = weights(heuristic, a, b);
                assert_sound(w, || format!("{}, {a:e} and {b:e}", heuristic.name()));
                if a == 0.0 || b == 0.0 {
                    let expected = if a > 0.0 { [1.0, 0.0] } else { [0.0, 1.0] };
                    assert_eq!(w, expected, "{}: a technique that cannot draw a direction", heuristic.name());
                }
            }
        }
    }
}

#[test]
fn weights_are_those_of_the_book() {
    for i in -120..=120 {
        let (a, b) = (0.7f32, 0.7 * f32::powf(10.0, i as f32 / 20.0));
        let (x, y) = (f64::from(a), f64::from(b));
        for heuristic in Heuristic::ALL {
            let expected = match heuristic {
                Heuristic::Balance => x / (x + y),
                Heuristic::Power => x * x / (x * x + y * y),
                Heuristic::Cutoff if (x - 0.1 * y).abs() < 1e-6 || (y - 0.1 * x).abs() < 1e-6 => continue,
                Heuristic::Cutoff if x < 0.1 * y => 0.0,
                Heuristic::Cutoff if y < 0.1 * x => 1.0,
                Heuristic::Cutoff => x / (x + y),
                Heuristic::Maximum => f64::from(u8::from(x >= y)),
            };
            let found = weights(heuristic, a, b);
            let name = heuristic.name();
            let d = weigh(heuristic, a, b, true).d;
            assert!(
                (x / f64::from(d) - expected).abs() < 1e-6,
                "{name}, {a} and {b}: the effective density is {d}, expected {a} / {expected}"
            );
            assert!(
                (f64::from(found[0]) - expected).abs() < 1e-6,
                "{name}, {a} and {b}: {found:?}, expected {expected}"
            );
            assert_sound(found, || format!("{name}, {a} and {b}"));
        }
    }
}

#[test]
fn ties_go_to_one_technique_alone() {
    for a in [1e-30, 0.08, 3.0, 1e6, 1e30] {
        for heuristic in Heuristic::ALL {
            let expected = if heuristic == Heuristic::Maximum { [1.0, 0.0] } else { [0.5, 0.5] };
            assert_eq!(weights(heuristic, a, a), expected, "{}, twice {a:e}", heuristic.name());
        }
    }
}

#[test]
fn the_cutoff_drops_below_a_tenth_and_the_maximum_below_the_other() {
    for i in 0..200 {
        let a = 1e-3 * 1.07f32.powi(i);
        // A density of 0.999 of the limit is dropped, one of 1.001 is balanced.
        for (share, dropped) in [(0.0999, true), (0.1001, false)] {
            let b = a * share;
            let [w_a, w_b] = weights(Heuristic::Cutoff, a, b);
            let expected = if dropped { 0.0 } else { f64::from(b) / (f64::from(a) + f64::from(b)) };
            assert!((f64::from(w_b) - expected).abs() < 1e-6, "{a} and {b}: {w_b}, expected {expected}");
            assert_sound([w_a, w_b], || format!("{a} and {b}"));
        }
        for (b, wins) in [(a.next_down(), 1.0), (a.next_up(), 0.0)] {
            assert_eq!(weights(Heuristic::Maximum, a, b), [wins, 1.0 - wins], "{a} and {b}");
        }
    }
}
