//! Settings of a periodic loop.

use super::thread::ThreadConfig;
use crate::ParameterError;
use fracdiff::parameter::RangeError;
use std::time::Duration;

/// Shortest and longest period, s.
const PERIODS_S: core::ops::RangeInclusive<f64> = 1e-5..=1e3;

/// Time before the deadline at which sleeping ends and spinning begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SpinMargin {
    /// Measured on this machine at the start, a quarter of the period at most.
    #[default]
    Auto,
    /// This, a quarter of the period at most; zero never spins.
    Fixed(Duration),
}

/// A periodic loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PeriodicConfig {
    /// T, 10 µs to 1000 s.
    pub period: Duration,
    /// The wishes for the thread.
    pub thread: ThreadConfig,
    /// The part of the waiting that is spinning.
    pub spin_margin: SpinMargin,
}

impl PeriodicConfig {
    /// A normal thread, the margin measured.
    #[must_use]
    pub const fn new(period: Duration) -> Self {
        Self {
            period,
            thread: ThreadConfig {
                priority: None,
                pin: None,
                lock_memory: false,
            },
            spin_margin: SpinMargin::Auto,
        }
    }

    /// Itself, if a loop can run by it.
    ///
    /// # Errors
    /// A period outside 10 µs to 1000 s.
    pub fn checked(self) -> Result<Self, ParameterError> {
        let period_s = self.period.as_secs_f64();
        if PERIODS_S.contains(&period_s) {
            return Ok(self);
        }
        Err(RangeError::new("period", period_s, "in [1e-5, 1000]", "s").into())
    }
}
