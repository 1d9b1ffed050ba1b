//! The picture viewport: the shader against its twin on the CPU, published values of curves and maps,
//! zoom and pan. Pictures are drawn by a software driver; no display is needed.

mod layers;
mod meshes;
mod twin;
mod window;
mod zoom;
