#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod arc;
mod circle;
mod curve;

pub use arc::{Arc, Enclosed, count, is_clear};
pub use circle::{Count, Place};
pub use curve::{Curve, Sample};

/// The crate of complex numbers.
pub use num_complex;
