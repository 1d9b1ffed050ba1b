//! The window, driven by label and role as a user or a screen reader would: every control once.

mod against;
mod controls;
mod convergence;
mod disk;
mod explain;
mod export;
mod exr_slot;
mod files;
mod hall;
mod lab;
mod looks;
mod paper;
mod patterns;
mod picture;
mod place;
mod rectangle;
mod several;
mod share;
mod sizes;
mod studies;
mod table;
mod unhit;
mod words;
