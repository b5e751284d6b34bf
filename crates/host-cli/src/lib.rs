//! The commands of `host-cli`. The binary is [`main`]; the rest is here for tests.
#![forbid(unsafe_code)]

mod cli;
mod command;
mod files;
mod mcap;
mod names;
mod options;
mod output;
mod parse;
mod picture;
pub mod picture_file;
mod table;

pub use cli::{main, parser};
