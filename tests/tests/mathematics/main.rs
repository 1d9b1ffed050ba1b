//! Every formula of the renderer against the same formula in f64, one number after the other, in about a second: what
//! `cargo mutants` runs for each mutant of the files that hold the mathematics.
//!
//! The other tests of this folder measure with many samples what is true on the average. Here each single value is
//! right or wrong.

mod estimator;
mod films;
mod formulas;
mod heuristics;
mod lattices;
mod lights;
mod numbers;
mod once;
mod pairs;
mod patterns;
mod surfaces;
mod twins;
mod warps;
