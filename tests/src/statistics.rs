//! Significance: normal quantiles, Sidak's correction, and families of tests judged together.

/// Family-wise significance of every statistical test here: the chance that a correct renderer,
/// with other seeds, fails a family.
pub const SIGNIFICANCE: f64 = 0.01;

/// Upper quantile of the standard normal: P(Z > z) = p, for p in (0, 1/2]. (Wichura 1988, AS241;
/// relative error 1e-15.)
pub fn normal_upper_quantile(p: f64) -> f64 {
    assert!(p > 0.0 && p <= 0.5, "tail probability {p}, expected a number in (0, 1/2]");
    let polynomial = |coefficients: &[f64; 8], x: f64| coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c);
    let q = 0.5 - p;
    if q <= 0.425 {
        const A: [f64; 8] = [
            3.387_132_872_796_366_5,
            133.141_667_891_784_38,
            1_971.590_950_306_551_3,
            13_731.693_765_509_46,
            45_921.953_931_549_87,
            67_265.770_927_008_7,
            33_430.575_583_588_13,
            2_509.080_928_730_122_7,
        ];
        const B: [f64; 8] = [
            1.0,
            42.313_330_701_600_91,
            687.187_007_492_057_9,
            5_394.196_021_424_751,
            21_213.794_301_586_597,
            39_307.895_800_092_71,
            28_729.085_735_721_943,
            5_226.495_278_852_854,
        ];
        let r = 0.180_625 - q * q;
        return q * polynomial(&A, r) / polynomial(&B, r);
    }
    let r = (-p.ln()).sqrt();
    if r <= 5.0 {
        const C: [f64; 8] = [
            1.423_437_110_749_683_5,
            4.630_337_846_156_546,
            5.769_497_221_460_691,
            3.647_848_324_763_204_5,
            1.270_458_252_452_368_4,
            0.241_780_725_177_450_6,
            0.022_723_844_989_269_184,
            7.745_450_142_783_414e-4,
        ];
        const D: [f64; 8] = [
            1.0,
            2.053_191_626_637_759,
            1.676_384_830_183_803_8,
            0.689_767_334_985_1,
            0.148_103_976_427_480_08,
            0.015_198_666_563_616_457,
            5.475_938_084_995_345e-4,
            1.050_750_071_644_416_9e-9,
        ];
        return polynomial(&C, r - 1.6) / polynomial(&D, r - 1.6);
    }
    const E: [f64; 8] = [
        6.657_904_643_501_103,
        5.463_784_911_164_114,
        1.784_826_539_917_291_3,
        0.296_560_571_828_504_87,
        0.026_532_189_526_576_124,
        0.001_242_660_947_388_078_4,
        2.711_555_568_743_487_6e-5,
        2.010_334_399_292_288_1e-7,
    ];
    const F: [f64; 8] = [
        1.0,
        0.599_832_206_555_888,
        0.136_929_880_922_735_8,
        0.014_875_361_290_850_615,
        7.868_691_311_456_133e-4,
        1.846_318_317_510_054_7e-5,
        1.421_511_758_316_446e-7,
        2.044_263_103_389_939_8e-15,
    ];
    polynomial(&E, r - 5.0) / polynomial(&F, r - 5.0)
}

/// Significance of each of `count` independent tests that together have `family` (Sidak).
pub fn sidak(family: f64, count: usize) -> f64 {
    -f64::exp_m1(f64::ln_1p(-family) / count as f64)
}

/// Largest |z| that `count` two-sided z-tests with family-wise [`SIGNIFICANCE`] allow.
pub fn z_limit(count: usize) -> f64 {
    normal_upper_quantile(sidak(SIGNIFICANCE, count) / 2.0)
}

/// Tests that are judged together, so that one of many is not failed by chance alone.
#[derive(Debug)]
pub struct Family {
    name: &'static str,
    scores: Vec<(f64, String)>,
}

impl Family {
    /// A family without tests.
    pub fn new(name: &'static str) -> Self {
        Self { name, scores: Vec::new() }
    }

    /// Adds the test that `measured` is `expected` with this standard error.
    pub fn test(&mut self, label: impl Into<String>, measured: f64, expected: f64, standard_error: f64) {
        let z = if measured == expected { 0.0 } else { (measured - expected) / standard_error };
        let label = format!("{}: {measured:.6e}, expected {expected:.6e} +- {standard_error:.1e}", label.into());
        // A NaN has to fail.
        self.scores.push((if z.is_nan() { f64::INFINITY } else { z }, label));
    }

    /// Adds the test that `measured` is `expected` up to a systematic difference of `allowance`, and noise.
    pub fn test_within(&mut self, label: impl Into<String>, measured: f64, expected: f64, allowance: f64, error: f64) {
        let nearest = expected + (measured - expected).clamp(-allowance, allowance);
        self.test(label, measured, nearest, error);
    }

    /// How many tests there are.
    pub fn len(&self) -> usize {
        self.scores.len()
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.scores.is_empty()
    }

    /// Judges the family: panics with the worst tests if any is beyond [`z_limit`], or if there are
    /// fewer than `at_least` tests, so that none of them vanishes unnoticed.
    #[track_caller]
    pub fn judge(mut self, at_least: usize) {
        let (name, count) = (self.name, self.scores.len());
        assert!(count >= at_least, "{name}: {count} tests were made, expected at least {at_least}");
        let limit = z_limit(count);
        self.scores.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
        let failed = self.scores.iter().filter(|(z, _)| z.abs() > limit).count();
        let mean_square = self.scores.iter().map(|(z, _)| z * z).sum::<f64>() / count as f64;
        println!("{name}: {count} tests, limit |z| <= {limit:.2}, mean z^2 {mean_square:.3}; the largest:");
        for (z, label) in self.scores.iter().take(3) {
            println!("  z = {z:+.2}  {label}");
        }
        if failed > 0 {
            let worst: Vec<String> =
                self.scores.iter().take(failed.min(24)).map(|(z, label)| format!("  z = {z:+.2}  {label}")).collect();
            panic!("{name}: {failed} of {count} tests beyond |z| = {limit:.2}\n{}", worst.join("\n"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_the_tables() {
        for (p, z) in [
            (0.5, 0.0),
            (0.025, 1.959_963_984_540_054),
            (1e-3, 3.090_232_306_167_813_5),
            (1e-9, 5.997_807_015_007_687),
            (1e-15, 7.941_345_326_170_997),
        ] {
            assert!((normal_upper_quantile(p) - z).abs() < 1e-12 * (1.0 + z), "p = {p}: {}", normal_upper_quantile(p));
        }
        assert!((sidak(0.01, 1000) - 1.005_028_6e-5).abs() < 1e-10, "{}", sidak(0.01, 1000));
    }

    #[test]
    #[should_panic(expected = "1 of 2 tests beyond")]
    fn a_family_fails_by_one_test() {
        let mut family = Family::new("two");
        family.test("fine", 1.0, 1.1, 0.1);
        family.test("off", 2.0, 1.0, 0.1);
        family.judge(2);
    }
}
