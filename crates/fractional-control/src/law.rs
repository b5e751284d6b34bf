//! A law of which a loop knows the response and how fast that can change.

use core::fmt::Debug;
use num_complex::Complex;
use std::sync::Arc;

/// A sampled law, f = −Z·q, as a function on the unit circle, w = e^(−jθ): analytic in |w| < 1, bounded on the circle.
pub trait SampledLaw: Debug + Send + Sync {
    /// Z(e^(−jθ)).
    fn response(&self, theta: f64) -> Complex<f64>;

    /// An upper bound of ∫|dZ/dθ| dθ over \[low, high\], 0 ≤ low ≤ high ≤ π; it falls to 0 with the width.
    fn variation(&self, low: f64, high: f64) -> f64;
}

/// A law that others share.
#[derive(Clone, Debug)]
pub(crate) struct SharedLaw(pub(crate) Arc<dyn SampledLaw>);

impl PartialEq for SharedLaw {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}
