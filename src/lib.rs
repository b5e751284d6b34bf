#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
// The libraries that keep their promises, under the name of the project: it only re-exports. The package owns the end-to-end tests and the
// benches, too.

pub use fracdiff;
pub use haptic_analysis;
pub use haptic_loop;
pub use haptic_tissue;
