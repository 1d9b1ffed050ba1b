//! How things look and what they are called: words, colours, type.

pub mod colormap;
pub mod layer;
pub mod names;
pub mod theme;
pub mod versus;
pub mod zoom;
