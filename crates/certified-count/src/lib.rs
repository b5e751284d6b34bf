#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod arc;
mod curve;
mod place;
mod winding;

pub use arc::{Arc, Enclosed, count, is_clear};
pub use curve::{Curve, Sample};
pub use place::Place;
pub use winding::Count;

/// The crate of complex numbers.
pub use num_complex;
