//! Tests of the public face of `haptic-link`, in one binary.

mod damage;
mod document;
mod wire;
