//! Whether numbers that are drawn together know of each other: pairs of them fill the unit square evenly.

use mislab_tests::chi_square::{PValues, chi_square};

/// How often numbers are drawn for a test.
pub const COUNT: u32 = 12_000;
/// Cells per axis of the square.
const CELLS: usize = 8;

/// Tests of pairs of N numbers, by name.
pub struct Pairs<const N: usize> {
    names: [&'static str; N],
    family: PValues,
}

impl<const N: usize> Pairs<N> {
    /// None yet.
    pub fn new(title: &'static str, names: [&'static str; N]) -> Self {
        Self { names, family: PValues::new(title) }
    }

    /// Two numbers of one sample, each pair once; `draw(i)` makes the i-th sample.
    pub fn of_one(&mut self, label: &str, mut draw: impl FnMut(u32) -> [f64; N]) {
        self.test(label, |i| [draw(i); 2], |j, k| j < k);
    }

    /// One number of each of two samples; `draw(i)` makes the i-th of both.
    pub fn of_two(&mut self, label: &str, draw: impl FnMut(u32) -> [[f64; N]; 2]) {
        self.test(label, draw, |_, _| true);
    }

    fn test(&mut self, label: &str, mut draw: impl FnMut(u32) -> [[f64; N]; 2], wanted: impl Fn(usize, usize) -> bool) {
        let mut tables = vec![[0u32; CELLS * CELLS]; N * N];
        for i in 0..COUNT {
            let [a, b] = draw(i).map(|numbers| numbers.map(|u| (u * CELLS as f64) as usize));
            for (j, u) in a.into_iter().enumerate() {
                for (k, v) in b.into_iter().enumerate() {
                    tables[N * j + k][CELLS * u + v] += 1;
                }
            }
        }
        let expected = [f64::from(COUNT) / (CELLS * CELLS) as f64; CELLS * CELLS];
        for (pair, table) in tables.iter().enumerate() {
            let (j, k) = (pair / N, pair % N);
            if wanted(j, k) {
                let outcome = chi_square(table, &expected, 5.0);
                self.family.test(format!("{label}: {} and {}", self.names[j], self.names[k]), outcome);
            }
        }
    }

    /// Fails unless there were at least so many tests and all of them pass.
    pub fn judge(self, at_least: usize) {
        self.family.judge(at_least);
    }
}
