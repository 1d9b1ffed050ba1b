//! The window, driven by label and role as a user or a screen reader would: every control once.

mod controls;
mod files;
mod lab;
mod patterns;
mod picture;
mod place;
mod several;
mod table;
mod words;
