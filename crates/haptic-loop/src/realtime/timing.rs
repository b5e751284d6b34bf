//! The times that a periodic loop measured of itself.

use super::durations::Durations;
use std::time::Duration;

/// Distributions of the time that each cycle spent.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Timing {
    /// Times from when a cycle was due to when it began, ns.
    pub lateness_ns: Durations,
    /// Times from the beginning of a cycle to its end, ns.
    pub compute_ns: Durations,
    /// Times from when a cycle was due to its end, ns.
    pub tick_ns: Durations,
    /// Cycles that began a period late or more, by their cause.
    pub overruns: Overruns,
    /// The one that ended latest after it was due; `None` before the first has ended.
    pub worst: Option<WorstCycle>,
}

/// Cycles that began a whole period late or more.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Overruns {
    /// Cycles that were late because the thread woke up late.
    pub by_wake_up: u64,
    /// Because the cycle before took longer than it had.
    pub by_compute: u64,
    /// Periods skipped because of that.
    pub skipped_periods: u64,
}

impl Overruns {
    /// Cycles that began a whole period late or more.
    #[must_use]
    pub const fn cycles(&self) -> u64 {
        self.by_wake_up + self.by_compute
    }
}

/// The cycle that ended latest after it was due.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WorstCycle {
    /// Number of cycles that ran before it.
    pub number: u64,
    /// Time from when it was due to when it began.
    pub lateness: Duration,
    /// Time from there to its end.
    pub compute: Duration,
}

impl Timing {
    pub(super) fn begun(&mut self, lateness_ns: u64, skipped: u64, by_compute: bool) {
        self.lateness_ns.record(lateness_ns);
        if skipped > 0 {
            self.overruns.skipped_periods += skipped;
            if by_compute {
                self.overruns.by_compute += 1;
            } else {
                self.overruns.by_wake_up += 1;
            }
        }
    }

    pub(super) fn ended(&mut self, number: u64, lateness_ns: u64, compute_ns: u64) {
        self.compute_ns.record(compute_ns);
        self.tick_ns.record(lateness_ns + compute_ns);
        let cycle = WorstCycle {
            number,
            lateness: Duration::from_nanos(lateness_ns),
            compute: Duration::from_nanos(compute_ns),
        };
        if self.worst.is_none_or(|worst| worst.tick() < cycle.tick()) {
            self.worst = Some(cycle);
        }
    }
}

impl WorstCycle {
    /// Time from when it was due to its end.
    #[must_use]
    pub fn tick(&self) -> Duration {
        self.lateness + self.compute
    }
}
