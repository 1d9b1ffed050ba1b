//! What the user sets, and every way to set it, as plain data.

pub mod command;
pub mod document;
pub mod edit;
pub mod history;
pub mod keys;
pub mod pacing;
pub mod placement;
pub mod prefs;
pub mod presses;
pub mod view;
