//! Ranges of parameters, each in one place.

/// Smallest and largest order, see [`Order`](crate::Order).
pub(crate) const ORDERS: [f64; 2] = [-2.0, 2.0];
/// Smallest tolerance a design accepts.
pub const TOLERANCE_MIN: f64 = 1e-11;
/// Largest tolerance a design accepts.
pub const TOLERANCE_MAX: f64 = 0.1;
/// Shortest horizon a design accepts, samples.
pub const HORIZON_MIN: f64 = 1e2;
/// Longest horizon a design accepts, samples: 31 years at 1 kHz.
pub const HORIZON_MAX: f64 = 1e12;
