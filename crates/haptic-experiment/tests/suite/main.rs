//! Tests of the public face of `haptic-experiment`, in one binary.

mod design;
mod drive;
mod measured_device;
mod models;
mod teleoperation;
mod touch;
