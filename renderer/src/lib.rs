//! The renderer of MIS Lab: everything that makes pictures and numbers, and no window.
//!
//! A camera ray meets a surface at x. What it reflects towards the eye is
//!
//! ```text
//! L(x, wo) = integral over directions of  bsdf(wo, wi) Le(wi) V(wi) |cos| dwi
//! ```
//!
//! and is estimated with one secondary ray per sample (two for `mis_all`), drawn from the lights,
//! from the BSDF, or from either, and weighted by multiple importance sampling.
//!
//! Reading order: [`estimator`] is the page all else serves; [`mis`] the heuristics; [`light`],
//! [`bsdf`] and [`warp`] the two techniques' samples and densities; [`sampler`] the random numbers;
//! [`lanes`] how one text runs on many pixels at once. [`scene`] and [`settings`] say *what* is
//! rendered, [`build`], [`geometry`], [`shape`] and [`camera`] bring it into shape, [`kernel`] walks
//! over pixels, [`film`] adds up, [`progressive`] does so in the background and hands out a
//! [`frame`]. [`patch`] narrows the scene down for a few pixels at a time. [`inspect`] shows one point of one
//! pixel: what the estimator sees there, and what is exactly to be expected of it. [`pbrt`] reads scene files.

pub mod benchmark;
pub mod bsdf;
pub mod build;
pub mod camera;
pub mod error;
pub mod estimator;
pub mod film;
pub mod frame;
pub mod geometry;
pub mod inspect;
mod job;
pub mod kernel;
pub mod lanes;
pub mod light;
mod light_tree;
pub mod metrics;
pub mod mis;
pub mod patch;
pub mod pbrt;
pub mod progressive;
pub mod sampler;
pub mod scene;
pub mod settings;
pub mod shape;
pub mod snapshot;
pub mod table;
mod tree;
pub mod warp;

pub use error::{Diagnostic, Error, Location};
pub use frame::{Channel, Frame, FrameStats, Layer};
pub use progressive::{Pace, Picture, Progress, Renderer, Request, State, Status, render, simd_level_name};
pub use scene::{Bsdf, Camera, Geometry, Light, Material, Reflectance, Scene, Shape};
pub use settings::{Heuristic, OneSampleWeights, PixelRect, SamplerKind, SamplerSettings, Settings, Strategy};
