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

    /// Largest magnitude of a force that brakes, N, so many ticks after a fault or stop at which it was this large; 0 without braking.
    pub(super) fn braked(&self, from_n: f32, ticks: u32) -> f32 {
        if self.limits.braking_n_s_per_m <= 0.0 {
            return 0.0;
        }
        let left = 1.0 - f64::from(ticks) / f64::from(self.stop_ticks().max(1));
        (left.max(0.0) as f32) * from_n.max(self.limits.brake_force_n)
    }

    /// How the force falls after a fault or stop, in words.
    pub(super) const fn fall_in_words(&self) -> &'static str {
        if self.limits.braking_n_s_per_m > 0.0 {
            "growing only to brake, and less and less"
        } else {
            "never growing"
        }
    }

    /// Ticks of the stop time.
    pub(super) fn stop_ticks(&self) -> u32 {
        // A time in single precision is no whole number of ticks more.
        (f64::from(self.limits.stop_time_s) / self.period_s - 1e-4).ceil() as u32
    }
}
