//! Full memory.
/// Smallest tolerance a design accepts.
pub const TOLERANCE_MIN: f64 = 1e-12;
/// Largest tolerance a design accepts.
pub const TOLERANCE_MAX: f64 = 0.1;
/// Shortest horizon, samples.
pub const HORIZON_MIN: f64 = 1e2;
/// Longest horizon, samples.
pub const HORIZON_MAX: f64 = 1e12;
