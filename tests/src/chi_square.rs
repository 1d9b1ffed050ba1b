//! Pearson's chi-square test: p-values, pooling of rare cells, and families of tests judged together.

use crate::statistics::{SIGNIFICANCE, sidak};

/// Cells expected to hold fewer samples than this are pooled.
pub const LEAST_EXPECTED: f64 = 5.0;

/// ln of the gamma function for x > 0 (Lanczos, g = 7; relative error below 1e-14).
fn ln_gamma(x: f64) -> f64 {
    const C: [f64; 9] = [
        0.999_999_999_999_809_9,
        676.520_368_121_885_1,
        -1_259.139_216_722_402_8,
        771.323_428_777_653_1,
        -176.615_029_162_140_6,
        12.507_343_278_686_905,
        -0.138_571_095_265_720_12,
        9.984_369_578_019_572e-6,
        1.505_632_735_149_311_6e-7,
    ];
    let x = x - 1.0;
    let t = x + 7.5;
    let sum = C[0] + (1..9).map(|i| C[i] / (x + i as f64)).sum::<f64>();
    0.5 * std::f64::consts::TAU.ln() + (x + 0.5) * t.ln() - t + sum.ln()
}

/// Regularised upper incomplete gamma function Q(a, x), by its series or its continued fraction.
pub fn gamma_q(a: f64, x: f64) -> f64 {
    assert!(a > 0.0 && x >= 0.0, "gamma_q({a}, {x}), expected a > 0 and x >= 0");
    if x == 0.0 {
        return 1.0;
    }
    let scale = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-17 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return 1.0 - scale * sum;
    }
    // Lentz's method.
    let mut b = x + 1.0 - a;
    let mut c = 1e300;
    let mut d = 1.0 / b;
    let mut fraction = d;
    for i in 1..100_000 {
        let i = f64::from(i);
        let numerator = i * (a - i);
        b += 2.0;
        d = 1.0 / (numerator * d + b);
        c = b + numerator / c;
        let factor = c * d;
        fraction *= factor;
        if (factor - 1.0).abs() < 1e-16 {
            break;
        }
    }
    scale * fraction
}

/// Probability of a chi-square statistic above this one.
pub fn p_value(chi2: f64, degrees: usize) -> f64 {
    gamma_q(degrees as f64 / 2.0, chi2 / 2.0)
}

/// What a chi-square test found.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// The statistic.
    pub chi2: f64,
    /// Degrees of freedom.
    pub degrees: usize,
    /// Probability of a larger statistic.
    pub p: f64,
}

/// Compares counts with what is expected of them; both have the same total. Cells that expect fewer than
/// `least`, 5 or more, are pooled into one, which grows until it expects as many.
pub fn chi_square(observed: &[u32], expected: &[f64], least: f64) -> Outcome {
    assert_eq!(observed.len(), expected.len(), "every cell has an expectation");
    let (mut chi2, mut cells) = (0.0, 0);
    let mut pool = (0.0, 0.0);
    let mut smallest: Option<(f64, f64)> = None;
    for (&o, &e) in observed.iter().zip(expected) {
        let o = f64::from(o);
        if e < least {
            pool = (pool.0 + o, pool.1 + e);
            continue;
        }
        chi2 += (o - e).powi(2) / e;
        cells += 1;
        if smallest.is_none_or(|(_, least)| e < least) {
            smallest = Some((o, e));
        }
    }
    if pool.1 >= least || smallest.is_none() {
        chi2 += (pool.0 - pool.1).powi(2) / pool.1.max(f64::MIN_POSITIVE);
        cells += 1;
    } else if let Some((o, e)) = smallest {
        chi2 += (o + pool.0 - e - pool.1).powi(2) / (e + pool.1) - (o - e).powi(2) / e;
    }
    let degrees = cells - 1;
    Outcome { chi2, degrees, p: if degrees == 0 { 1.0 } else { p_value(chi2, degrees) } }
}

/// p-values that are judged together (Sidak).
#[derive(Debug)]
pub struct PValues {
    name: &'static str,
    values: Vec<(f64, String)>,
}

impl PValues {
    /// A family without tests.
    pub fn new(name: &'static str) -> Self {
        Self { name, values: Vec::new() }
    }

    /// Adds a test.
    pub fn test(&mut self, label: impl Into<String>, outcome: Outcome) {
        let label = format!("{}: chi^2 {:.1} with {} degrees", label.into(), outcome.chi2, outcome.degrees);
        // A NaN has to fail.
        self.values.push((if outcome.p.is_nan() { 0.0 } else { outcome.p }, label));
    }

    /// Panics with the least likely tests if any is less likely than the family's significance allows, or if
    /// there are fewer than `at_least`.
    #[track_caller]
    pub fn judge(mut self, at_least: usize) {
        let (name, count) = (self.name, self.values.len());
        assert!(count >= at_least, "{name}: {count} tests were made, expected at least {at_least}");
        let limit = sidak(SIGNIFICANCE, count);
        self.values.sort_by(|a, b| a.0.total_cmp(&b.0));
        println!("{name}: {count} tests, limit p >= {limit:.1e}; the least likely:");
        for (p, label) in self.values.iter().take(3) {
            println!("  p = {p:.2e}  {label}");
        }
        let failed: Vec<String> = self
            .values
            .iter()
            .take_while(|(p, _)| *p < limit)
            .take(30)
            .map(|(p, label)| format!("  p = {p:.2e}  {label}"))
            .collect();
        assert!(failed.is_empty(), "{name}: of {count} tests, p is below {limit:.1e} in\n{}", failed.join("\n"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn p_values_are_the_tables() {
        // One degree: erfc(sqrt(x / 2)); two: exp(-x / 2); the others from tables of quantiles.
        for (chi2, degrees, p) in [
            (3.841_458_820_694_124, 1, 0.05),
            (6.634_896_601_021_213, 1, 0.01),
            (46.051_701_859_880_92, 2, 1e-10),
            (18.307_038_053_275_146, 10, 0.05),
            (2.558_212_161_609_02, 10, 0.99),
            (124.342_113_404_003_85, 100, 0.05),
            (1_106.969_055_8, 1000, 0.01),
        ] {
            let found = p_value(chi2, degrees);
            assert!((found / p - 1.0).abs() < 1e-5, "chi^2 {chi2} with {degrees} degrees: {found}, expected {p}");
        }
        // Many degrees: Wilson and Hilferty's cube root is normal to a few percent of the tail.
        for (chi2, z) in [(20_100.0 + 2.0 * 200.5, 1.989), (20_100.0 + 4.0 * 200.5, 3.953)] {
            let p = p_value(chi2, 20_100);
            let found = crate::statistics::normal_upper_quantile(p);
            assert!((found - z).abs() < 0.02, "chi^2 {chi2}: p = {p:e}, z = {found}, expected about {z}");
        }
    }

    #[test]
    fn rare_cells_are_pooled() {
        let outcome =
            chi_square(&[50, 48, 1, 0, 1, 2, 1, 3], &[49.0, 49.0, 1.5, 1.0, 1.0, 1.5, 1.0, 2.0], LEAST_EXPECTED);
        assert_eq!(outcome.degrees, 2, "{outcome:?}");
        // One stray sample where none is expected joins the smallest cell.
        let outcome = chi_square(&[50, 49, 1], &[50.0, 50.0, 0.0], LEAST_EXPECTED);
        assert_eq!(outcome.degrees, 1, "{outcome:?}");
        assert!(outcome.p > 0.8, "{outcome:?}");
    }

    #[test]
    #[should_panic(expected = "of 2 tests, p is below")]
    fn a_family_fails_by_one_test() {
        let mut family = PValues::new("two");
        family.test("fine", chi_square(&[50, 49], &[50.0, 49.0], LEAST_EXPECTED));
        family.test("off", chi_square(&[50, 100], &[75.0, 75.0], LEAST_EXPECTED));
        family.judge(2);
    }
}
