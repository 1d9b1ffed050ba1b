//! Renderer of MIS Lab.
pub mod error;
pub mod frame;
pub mod metrics;
pub mod pbrt;
pub mod progressive;
pub mod scene;
pub mod settings;
pub mod snapshot;
pub mod table;

pub use error::{Diagnostic, Error, Location};
pub use frame::{Channel, Frame, FrameStats, Layer};
pub use progressive::{Pace, Picture, Progress, Renderer, Request, State, Status, render, simd_level_name};
pub use scene::{Bsdf, Camera, Geometry, Light, Material, Reflectance, Scene, Shape};
pub use settings::{Heuristic, OneSampleWeights, PixelRect, SamplerKind, SamplerSettings, Settings, Strategy};
