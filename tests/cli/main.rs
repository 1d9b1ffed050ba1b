//! The command line as its users meet it: the built program is run, and its output, files and exit codes are looked at.

mod arguments;
mod bench;
mod compare;
mod converge;
mod info;
mod memory;
mod names;
mod place;
mod render;
mod table;
