//! Tests of the public face of `haptic-board`, in one binary.

mod hello;
mod quadrature;
