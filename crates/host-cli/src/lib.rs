//! What the commands of `host-cli` are made of. The binary parses, runs and maps errors to exit
//! codes; this library exists so that tests reach the parts.
#![forbid(unsafe_code)]

pub mod cli;
pub mod command;
pub mod design;
pub mod device;
#[cfg(unix)]
pub mod emulator;
pub mod experiment;
pub mod failure;
pub mod folder;
pub mod input;
pub mod live;
pub mod log_plot;
pub mod material;
pub mod output;
pub mod picture_file;
pub mod quantity;
pub mod record;
pub mod reproduce;
pub mod rt_check;
