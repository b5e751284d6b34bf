//! Tests of the public face of `haptic-experiment`, in one binary.

mod design;
mod log;
mod measured_device;
mod touch;
