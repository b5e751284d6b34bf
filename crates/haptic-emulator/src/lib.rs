#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod at_line;
pub mod board;
mod faulty_line;
pub mod haply;
pub mod inverse3;
mod lead;
pub mod moteus;

pub use at_line::{AtLine, DuplexDamage, NearLine, emulate};
pub use faulty_line::{FaultyLine, LineDamage, LineFaults};
