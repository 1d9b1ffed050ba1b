//! The panels, one function each: they read the state they show and push [`crate::state::command::Command`]s.

pub mod caption;
pub mod compare;
pub mod display;
pub mod explain;
pub mod exposure;
pub mod file_caption;
pub mod formula;
pub mod help;
pub mod hint;
pub mod math;
pub mod menu;
pub mod messages;
pub mod number;
pub mod open;
pub mod palette;
pub mod picture;
pub mod sampling;
pub mod save;
pub mod scene;
pub mod status;
pub mod strategy;
pub mod study;
pub mod table;
pub mod table_job;
pub mod warnings;
pub mod widgets;
