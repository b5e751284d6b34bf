//! When the next sample is due, for a thread that has no clock of its own.
//!
//! ```text
//! due ← due + T;   a thread that is later than T begins at once, and the periods that have passed are not made up for
//! ```

use haptic_loop::realtime::Waiter;
use std::time::Duration;

#[derive(Debug, Default)]
pub(crate) struct Pace {
    due: Option<Duration>,
}

impl Pace {
    /// Waits until the next sample is due, by an absolute clock; its time then, µs.
    pub(crate) fn wait(&mut self, waiter: &mut impl Waiter, period: Duration) -> u64 {
        let now = waiter.now();
        let due = self.due.unwrap_or(now) + period;
        let late = now.saturating_sub(due);
        let skipped = (late.as_nanos() / period.as_nanos().max(1)) as u32;
        let due = due + skipped * period;
        self.due = Some(due);
        waiter.sleep_until(due);
        waiter.now().as_micros() as u64
    }
}
