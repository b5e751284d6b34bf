//! The commands of `host-cli`. The binary is [`main`]; the rest is here for tests.
#![forbid(unsafe_code)]

mod cli;
mod command;
mod files;
mod options;
mod output;
mod page;
mod parse;
mod picture;
pub mod picture_file;
mod table;

pub use cli::{main, parser};
pub use command::run::TABLES;
