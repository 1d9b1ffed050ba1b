//! The renderer of MIS Lab: everything that makes pictures and numbers, and no window.
//!
//! What runs once per sample (the estimator, lights, BSDFs, random numbers, intersections) is a crate of its own,
//! [`kernel`]: start reading at its [`kernel::estimator`]. Here a [`Request`] becomes a stream of [`Frame`]s: [`engine`]
//! renders in the background, [`frame`] is an immutable snapshot with its [`layer`]s; [`pbrt`] reads scene files,
//! [`snapshot`] reads and writes EXR files, [`metrics`], [`table`] and [`study`] measure; [`inspect`] answers in plain floats what happens at one pixel,
//! [`black`] why there is nothing to see, [`blind`] what cannot be seen, [`plane`] which strategy is best where.

pub mod batch;
pub mod benchmark;
pub mod black;
pub mod blind;
pub mod convergence;
pub mod engine;
pub mod error;
mod file;
pub mod frame;
pub mod inspect;
pub mod layer;
pub mod memory;
pub mod metrics;
mod near;
pub mod pbrt;
pub mod plane;
pub mod platform;
mod shade;
pub mod snapshot;
pub mod study;
pub mod table;

pub use engine::{
    Abreast, Frames, Lockstep, Marks, Pace, Picture, Progress, Renderer, Spent, State, Status, Subscription, render,
    simd_level_name, step_aside,
};
pub use error::{Diagnostic, Error, Location};
pub use frame::{Frame, FrameStats};
pub use layer::{Channel, Layer};
pub use mislab_kernel as kernel;
pub use mislab_kernel::request::{
    Bsdf, Camera, Estimator, Geometry, Heuristic, ImageSettings, Light, Material, OneSampleWeights, PixelRect,
    Reflectance, Request, SamplerKind, SamplerSettings, Sampling, Scene, Settings, Shape, Strategy, Technique,
};
pub use mislab_kernel::world::projection;
