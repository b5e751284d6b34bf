//! Tests of the public face of `haptic-experiment`, in one binary; `selftest` waits for devices by the clock and has its own.

mod drive;
mod measured_device;
mod models;
mod teleoperation;
mod touch;
