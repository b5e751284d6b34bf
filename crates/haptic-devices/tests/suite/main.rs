//! Tests of the public face of `haptic-devices`, in one binary.

mod exact;
mod haply;
mod kinematics;
mod moteus;
