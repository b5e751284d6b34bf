//! The time between ticks as it is, against what was declared.
//!
//! ```text
//! a mean over 0.2 s beyond 1.05·T, over 2 s beyond 1.02·T, more than 20 ticks missing in a row, or 20 late ticks in a row:  too slow
//! ```
//! Forces that depend on a rate are wrong by as much as the period is. Jitter is no such thing: 0.3 ms at both ends of 0.2 s are
//! 0.3 %, and pauses of 3 ms twice a second 0.4 % of 2 s.

use crate::clock::Call;
use haptic_link::{Reason, Trouble};

/// Length of a window, µs, and the divisor of T that gives the allowed excess of its mean.
const WINDOWS: [(u64, u64); 2] = [(200_000, 20), (2_000_000, 50)];
/// Ticks that may be missing in a row, and ticks in a row that are not yet a fault by being late.
const IN_ROW: u32 = 20;

#[derive(Clone, Copy, Debug, Default)]
struct Window {
    since_us: u64,
    ticks: u64,
    /// Mean of the last window that was whole, ns.
    mean_ns: u64,
}

#[derive(Debug)]
pub(crate) struct Meter {
    declared_us: u64,
    windows: [Window; 2],
    late: u32,
}

impl Meter {
    pub(crate) fn new(declared_us: u64) -> Self {
        Self {
            declared_us,
            windows: [Window::default(); 2],
            late: 0,
        }
    }

    /// Mean period over the last 2 s, or 0.2 s at first, ns; 0 before these.
    pub(crate) fn mean_ns(&self) -> u32 {
        let means = self.windows.map(|window| window.mean_ns as u32);
        if means[1] > 0 { means[1] } else { means[0] }
    }

    /// Counts a tick; why the thread is too slow, if it is. After a pause the means begin anew.
    pub(crate) fn tick(&mut self, call: &Call) -> Option<Reason> {
        let is_late = call.stood_us >= 2 * self.declared_us;
        self.late = if is_late { self.late + 1 } else { 0 };
        let pauses = call.skipped > IN_ROW;
        if pauses || call.stood_us == 0 {
            let since_us = call.now_us;
            self.windows = self.windows.map(|_| Window {
                since_us,
                ..Window::default()
            });
        }
        let alone = pauses || self.late >= IN_ROW;
        let mut slow_us = alone.then_some(call.stood_us);
        for (window, (length_us, share)) in self.windows.iter_mut().zip(WINDOWS) {
            let passed_us = call.now_us - window.since_us;
            window.ticks += u64::from(passed_us > 0);
            if passed_us >= length_us {
                window.mean_ns = 1000 * passed_us / window.ticks;
                (window.since_us, window.ticks) = (call.now_us, 0);
            }
            if window.mean_ns * share > 1000 * self.declared_us * (share + 1) {
                slow_us = slow_us.or(Some(window.mean_ns / 1000));
            }
        }
        slow_us.map(|slow_us| Reason {
            trouble: Trouble::Slow,
            measured_us: u32::try_from(slow_us).unwrap_or(u32::MAX),
            told_us: self.declared_us as u32,
        })
    }
}
