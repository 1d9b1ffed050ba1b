//! The app of MIS Lab: window, panels and command line.

pub mod app;
pub mod cli;
pub mod files;
pub mod lab;
pub mod launch;
pub mod layout;
pub mod look;
pub mod panel;
pub mod picture;
pub mod state;

pub use app::{AppOptions, MisLabApp};
pub use launch::{NoWindow, run_app};
