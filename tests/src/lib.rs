//! What the tests of MIS Lab measure with: an oracle that integrates exactly, the statistics to
//! compare a picture with it, and small experiments on the renderer.
//!
//! `README.md` beside this crate lists what is claimed, by which test, with which significance.

pub mod charts;
pub mod chi_square;
pub mod depth;
pub mod draws;
pub mod experiment;
pub mod image;
pub mod light_scenes;
pub mod lobes;
pub mod moments;
pub mod oracle;
pub mod packets;
pub mod pair;
pub mod places;
pub mod quadrature;
pub mod statistics;
pub mod two_lanes;
