//! Tests of the public face of `haptic-board`, in one binary.

mod failing;
mod hello;
mod quadrature;
