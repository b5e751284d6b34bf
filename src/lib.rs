#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
// This package owns the end-to-end tests and the benches; its library only re-exports.

pub use fracdiff;
pub use haptic_analysis;
pub use haptic_loop;
