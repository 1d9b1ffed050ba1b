//! Measurements that go on beside live pictures, and those of `mislab converge`: a reference that grows, points of error curves as their pictures are
//! finished, means and what they say of bias.
//!
//! Reading order: [`cells`] are the parts of a picture that get numbers of their own, [`mod@reference`] what errors are measured against,
//! [`points`] the pictures of the curves, [`blocks`] what is kept of them for parts chosen later, [`curves`] what is known of them so far, with [`slope`], [`means`] bias or noise,
//! [`replicates`] what the samples of a pattern are worth.

pub mod blocks;
pub mod cells;
pub mod curves;
pub mod means;
pub mod points;
pub mod reference;
pub mod replicates;
pub mod slope;

pub use self::blocks::{Blocks, whole_blocks};
pub use self::cells::{Cells, Part};
pub use self::curves::{Curves, Measure, Value};
pub use self::means::{Mean, p_values};
pub use self::points::{Found, Plan, in_background, measure};
pub use self::reference::{Against, News, grow};
pub use self::replicates::Replicated;
