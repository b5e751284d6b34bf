//! Tests of the public face of `haptic-experiment`, in one binary.

mod against;
mod contact;
mod design;
mod log;
mod touch;
