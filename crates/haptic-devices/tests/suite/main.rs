//! Tests of the public face of `haptic-devices`, in one binary.

mod haply;
mod kinematics;
mod moteus;
mod relaxation;
