//! The app of MIS Lab: window, panels and command line.

pub mod app;
pub mod cli;
pub mod colormap;
pub mod command;
pub mod document;
pub mod engine;
pub mod files;
pub mod film_texture;
pub mod keys;
pub mod layout;
pub mod legend;
pub mod math;
pub mod panel;
pub mod picking;
pub mod png_file;
pub mod prefs;
pub mod swatch;
pub mod table_job;
pub mod theme;
pub mod tone;
pub mod view_state;
pub mod viewport;
pub mod widgets;

pub use app::{AppOptions, MisLabApp, NoWindow, run_app};
