//! Tests of the public face of `haptic-figure`, in one binary.

mod chart;
mod picture;
mod places;
mod sheet;
mod theory;
