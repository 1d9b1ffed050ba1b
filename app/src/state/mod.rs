//! What the user sets, and every way to set it, as plain data.

pub mod arrangement;
pub mod command;
pub mod destination;
pub mod document;
pub mod edit;
pub mod file_name;
pub mod history;
pub mod keys;
pub mod pacing;
pub mod passes;
pub mod paths;
pub mod placement;
pub mod prefs;
pub mod presses;
pub mod share;
pub mod study;
pub mod view;
