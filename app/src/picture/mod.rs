//! The picture: what the renderer is asked for, what of it is on screen, and the mouse on it.

pub mod against;
pub mod black;
pub mod blind;
pub mod engine;
pub mod figure;
pub mod film_texture;
pub mod histogram;
pub mod interaction;
pub mod legend;
pub mod live;
pub mod normalise;
pub mod pane;
pub mod picking;
pub mod pixel;
pub mod planes;
pub mod raster;
pub mod shelf;
pub mod still;
pub mod swatch;
pub mod tone;
pub mod variance;
pub mod viewport;
