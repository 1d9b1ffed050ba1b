//! What the user sets, and every way to set it, as plain data.

pub mod command;
pub mod document;
pub mod keys;
pub mod prefs;
pub mod view;
