//! The commands of `host-cli`. The binary is [`main`]; the rest is here for tests.
#![forbid(unsafe_code)]

mod cli;
mod command;
mod files;
pub mod log_plot;
mod options;
mod output;
mod page;
mod parse;
pub mod picture;
pub mod picture_file;
mod table;

pub use cli::{main, parser};
