//! What a run asks of the pre-flight before a device is armed, and what it answers.

mod llewellyn;
mod verdict;

use crate::document::failure::Failure;
use haptic_analysis::Dynamics;
pub use llewellyn::CouplerVerdict;
use std::time::Duration;
pub use verdict::PreflightVerdict;

/// Time over which the round trip is measured.
pub(crate) const MEASURED: Duration = Duration::from_millis(200);

/// Request for the pre-flight, and the known dynamics of the device.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PreflightRequest {
    /// Run what is unstable, too.
    pub force_unstable: bool,
    /// Known dynamics of a device at a port.
    pub dynamics: Option<Dynamics>,
}

/// Whole samples of delay for a round trip, µs: it, and the tick that the force waits for, rounded up.
#[must_use]
pub(crate) fn delay_samples(round_trip_us: u64, sample_time_s: f64) -> usize {
    (1e-6 * round_trip_us as f64 / sample_time_s + 1.0).ceil() as usize
}

/// A loop that the analysis can look at.
pub(crate) trait PreflightSubject {
    /// Looks at the loop with this device and `line` samples of delay beside its own.
    ///
    /// # Errors
    /// A number that the analysis does not take.
    fn verdict(&self, dynamics: Dynamics, line: usize) -> Result<PreflightVerdict, Failure>;
}
