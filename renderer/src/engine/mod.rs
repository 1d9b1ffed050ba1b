//! The progressive renderer: worker threads that turn requests into a stream of frames.
//!
//! A picture's request waits in one slot: the latest wins. Submitting bumps the picture's generation, and that is
//! also how work is cancelled: workers hold a tile for about 2 ms and drop whatever belongs to an older generation. A pass
//! adds the same number of samples to every tile and is published whole or not at all, so that spp is uniform over a frame.
//!
//! Workers and windows share one lock, held for moments only: to claim a tile, to hand it back, to submit. Tiles are
//! rendered, scenes built and frames looked at without it.
//!
//! Reading order, each file knowing only those before it: [`status`] and [`subscription`] are what a caller says and hears,
//! [`lockstep`] the rule that keeps pictures abreast, [`spent`] what processor time went into, `job` one generation being rendered, `schedule` what is next for a
//! picture, `core` whose turn it is, `worker` the threads, [`renderer`] the handles, [`blocking`] a picture rendered to its target while the caller waits.

pub mod blocking;
mod core;
mod job;
pub mod lockstep;
pub mod renderer;
mod schedule;
pub mod spent;
pub mod status;
pub mod subscription;
mod worker;

pub use blocking::{Progress, render, render_with};
pub use lockstep::{Abreast, Lockstep};
pub use renderer::{Picture, Renderer, simd_level_name, step_aside};
pub use spent::Spent;
pub use status::{Pace, State, Status};
pub use subscription::{Frames, Marks, Subscription};
