#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(unreachable_pub)]

pub mod analysis;
pub mod bench;
pub mod choices;
pub mod control_loop;
pub mod controller;
pub mod design;
pub mod form;
#[cfg(test)]
mod one_table;
pub mod plant;
pub mod tissue;
pub mod words;
pub mod zwidth;
