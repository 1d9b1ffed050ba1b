//! The picture: what the renderer is asked for, what of it is on screen, and the mouse on it.

pub mod engine;
pub mod film_texture;
pub mod legend;
pub mod picking;
pub mod swatch;
pub mod tone;
pub mod viewport;
