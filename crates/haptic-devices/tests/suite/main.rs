//! Tests of the public face of `haptic-devices`, in one binary.

mod haply;
mod inverse3;
mod kinematics;
mod moteus;
mod relaxation;
