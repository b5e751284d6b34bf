#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]
#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

mod differintegrator;
mod error;
pub mod full_memory;
mod order;
mod real;

pub use differintegrator::{Channel, Differintegrator};
pub use error::ParameterError;
pub use order::{Order, Seconds};
pub use real::Real;
