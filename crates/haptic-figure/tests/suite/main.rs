//! Tests of the public face of `haptic-figure`, in one binary.

mod chart;
#[cfg(feature = "png")]
mod pdf;
mod picture;
mod places;
mod sheet;
