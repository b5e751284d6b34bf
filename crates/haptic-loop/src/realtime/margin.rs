//! The lateness with which this machine wakes a thread.

use super::waiter::Waiter;
use std::time::Duration;

/// Sleeps by which the margin is measured.
const TRIAL_SLEEPS: usize = 50;

/// One and a half times the lateness that 9 of 10 sleeps keep, and 5 µs for the sleep's own cost.
pub(super) fn measure_margin(waiter: &mut impl Waiter, period: Duration) -> Duration {
    // Long sleeps let a processor doze deeper; the period itself, in the range where it does not take too long.
    let sleep = period.clamp(Duration::from_micros(100), Duration::from_millis(2));
    let mut lateness = [Duration::ZERO; TRIAL_SLEEPS];
    for late in &mut lateness {
        let due = waiter.now() + sleep;
        waiter.sleep_until(due);
        *late = waiter.now().saturating_sub(due);
    }
    lateness.sort_unstable();
    lateness[TRIAL_SLEEPS * 9 / 10] * 3 / 2 + Duration::from_micros(5)
}
