//! The app of MIS Lab: window, panels and command line.

pub mod view_state;
pub mod viewport;
