#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod arc;
mod circle;
mod curve;
mod late;

pub use arc::{Arc, Enclosed, count, is_clear};
pub use circle::{Count, Place};
pub use curve::{Curve, Sample};
pub use late::{Late, Unknown, Zero, delay_margin};

/// The crate of complex numbers.
pub use num_complex;
