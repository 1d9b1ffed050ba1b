//! The kernel of MIS Lab: the estimator and all that runs once per sample.
//!
//! A camera ray hits a surface at x. What it reflects towards the eye is
//!
//! ```text
//! L(x, wo) = integral over directions of  bsdf(wo, wi) Le(wi) V(wi) |cos| dwi
//! ```
//!
//! and is estimated with one secondary ray per sample (two for `mis_all`), drawn from the lights, from the BSDF, or from
//! either, and weighted by multiple importance sampling.
//!
//! Reading order: [`estimator`] is the page all else serves, with the heuristics, BSDFs and warps it uses; [`light`] the
//! light technique; [`sampler`] the random numbers; [`lanes`] how one text runs on many pixels at once. [`request`] says
//! *what* is rendered. Machinery: [`geometry`] intersects rays, [`world`] is the built scene and what is culled for a
//! patch of pixels, [`tile`] walks over pixels, [`film`] adds up.

pub mod estimator;
pub mod film;
pub mod geometry;
pub mod lanes;
pub mod light;
pub mod request;
pub mod sampler;
pub mod tile;
pub mod world;
