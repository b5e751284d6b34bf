//! Tests of the public face of `fractional-control`, in one binary.

mod golden;
mod notation;
mod streaming;
