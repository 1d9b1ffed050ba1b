//! Renderer of MIS Lab.
pub mod bsdf;
pub mod build;
pub mod camera;
pub mod error;
pub mod estimator;
pub mod film;
pub mod frame;
pub mod geometry;
pub mod kernel;
pub mod lanes;
pub mod light;
pub mod metrics;
pub mod mis;
pub mod pbrt;
pub mod progressive;
pub mod sampler;
pub mod scene;
pub mod settings;
pub mod shape;
pub mod snapshot;
pub mod table;
pub mod warp;

pub use error::{Diagnostic, Error, Location};
pub use frame::{Channel, Frame, FrameStats, Layer};
pub use progressive::{Pace, Picture, Progress, Renderer, Request, State, Status, render, simd_level_name};
pub use scene::{Bsdf, Camera, Geometry, Light, Material, Reflectance, Scene, Shape};
pub use settings::{Heuristic, OneSampleWeights, PixelRect, SamplerKind, SamplerSettings, Settings, Strategy};
