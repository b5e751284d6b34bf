//! The parts of the commands of `host-cli`. The binary parses, runs and maps errors to exit
//! codes; this library exists so that tests reach the parts.
#![forbid(unsafe_code)]

pub mod choice;
pub mod cli;
pub mod column;
pub mod command;
pub mod files;
pub mod keys;
pub mod log_plot;
pub mod options;
pub mod output;
pub mod picture;
pub mod picture_file;
pub mod whole;
pub mod within;
