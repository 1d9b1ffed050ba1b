//! The app of MIS Lab: window, panels and command line.

pub mod colormap;
pub mod film_texture;
pub mod legend;
pub mod tone;
pub mod view_state;
pub mod viewport;
