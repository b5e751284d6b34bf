#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod controller;
mod error;
mod form;
mod header;
mod number;

pub use error::HeaderError;
pub use header::{CHeader, WallLaw};
pub use number::CNumber;
