//! Fractional-order control for haptics. This package owns the end-to-end tests and the benches;
//! its library only re-exports the crates below it.
pub use fracdiff;
pub use haptic_loop;
