//! Bounds of the force during the test, by ticks.

use haptic_link::Limits;

/// Limits in force, and the time of a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    /// The limits.
    pub(super) limits: Limits,
    /// T, s.
    pub(super) period_s: f64,
}

impl Bounds {
    /// Largest magnitude of a force, N, that was this large so many ticks ago.
    pub(super) fn grown(&self, from_n: f32, ticks: u32) -> f32 {
        let step_n = f64::from(self.limits.force_rate_n_per_s) * self.period_s;
        let most_n = f64::from(from_n) + f64::from(ticks) * step_n;
        // A force that is beyond the limit already has not got there by this.
        from_n.max((most_n as f32).min(self.limits.force_n))
    }

    /// Ticks of the stop time.
    pub(super) fn stop_ticks(&self) -> u32 {
        // A time in single precision is no whole number of ticks more.
        (f64::from(self.limits.stop_time_s) / self.period_s - 1e-4).ceil() as u32
    }
}
