#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]
#[cfg(feature = "std")]
extern crate std;

mod device;
mod error;
mod safety;
pub mod units;

pub use device::{Device, Reading};
pub use error::ParameterError;
pub use safety::{Fault, Limiters, SafeForce, SafetyChain, SafetyState};
