//! The picture: what the renderer is asked for, what of it is on screen, and the mouse on it.

pub mod black;
pub mod content;
pub mod engine;
pub mod figure;
pub mod film_texture;
pub mod foreign;
pub mod histogram;
pub mod interaction;
pub mod legend;
pub mod live;
pub mod normalise;
pub mod pane;
pub mod paper;
pub mod picking;
pub mod pixel;
pub mod planes;
pub mod png_file;
pub mod raster;
pub mod sheet;
pub mod shelf;
pub mod still;
pub mod swatch;
pub mod tone;
pub mod vector;
pub mod viewport;
