#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod arc;
mod bounds;
mod circle;
mod curve;
mod late;
mod open_loop;

pub use arc::{Arc, Enclosed, Enclosing, count, is_clear};
pub use bounds::{Bounds, Jet, product};
pub use circle::{Place, StabilityVerdict};
pub use curve::{Curve, NodeValue};
pub use late::{Late, Unknown, Zero, delay_margin};
pub use open_loop::{AtAngle, LoopTerms, OpenLoop, Peak};

/// The crate of complex numbers.
pub use num_complex;
