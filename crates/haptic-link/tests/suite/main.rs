//! Tests of the public face of `haptic-link`, in one binary.

mod damage;
mod document;
mod frames;
mod messages;
mod wire;
