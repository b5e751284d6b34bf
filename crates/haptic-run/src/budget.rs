//! Time of the ticks of a loop by the clock, by its parts: gathered off the tick, reported once a second while the loop runs.
//!
//! ```text
//! due ──lateness──▶ begun ──compute──▶ done ──rest of the period──▶ due
//! ```

use crate::realtime::Microseconds;
use haptic_loop::realtime::Durations;
use haptic_trial::flat::flat;
use std::collections::BTreeMap;

/// Device time from one summary to the next, s.
const EVERY_S: f64 = 1.0;

/// Parts of a tick, ns.
#[derive(Debug)]
pub(crate) struct TickParts {
    /// Time from when it was due to when it began.
    pub lateness_ns: u64,
    /// Time from there until the force was written and the history kept.
    pub compute_ns: u64,
}

/// Parts of the ticks since the last summary.
#[derive(Debug)]
pub(crate) struct Budget {
    lateness_ns: Durations,
    compute_ns: Durations,
    /// Device time of the next summary, s.
    due_s: f64,
}

impl Budget {
    pub(crate) fn new() -> Self {
        Self {
            lateness_ns: Durations::default(),
            compute_ns: Durations::default(),
            due_s: EVERY_S,
        }
    }

    /// Takes a tick in; the summary of a second that is over, as metadata of the log.
    pub(crate) fn take(
        &mut self,
        parts: TickParts,
        time_s: f64,
    ) -> Option<BTreeMap<String, String>> {
        self.lateness_ns.record(parts.lateness_ns);
        self.compute_ns.record(parts.compute_ns);
        if time_s < self.due_s {
            return None;
        }
        self.due_s = (time_s / EVERY_S).floor() * EVERY_S + EVERY_S;
        let mut values = BTreeMap::from([
            ("time_s".to_owned(), time_s.to_string()),
            ("ticks".to_owned(), self.lateness_ns.len().to_string()),
        ]);
        for (name, histogram) in [
            ("lateness", &mut self.lateness_ns),
            ("compute", &mut self.compute_ns),
        ] {
            let us = Microseconds::of(histogram);
            values.extend(flat(&us, &format!("{name}_us_"), "_"));
            histogram.reset();
        }
        Some(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_second_is_told_once_and_begins_anew() {
        let mut budget = Budget::new();
        let mut records = Vec::new();
        for tick in 0..=2500_u64 {
            let parts = TickParts {
                // The first second is ten times later than the others.
                lateness_ns: if tick <= 1000 { 50_000 } else { 5000 },
                compute_ns: 1000 + tick % 2,
            };
            records.extend(budget.take(parts, 1e-3 * tick as f64));
        }
        assert_eq!(records.len(), 2);
        assert_eq!(
            (&*records[0]["ticks"], &*records[1]["ticks"]),
            ("1001", "1000")
        );
        let us = |second: usize, key: &str| records[second][key].parse::<f64>().expect("a number");
        assert!((us(0, "lateness_us_p50") / 50.0 - 1.0).abs() < 0.01);
        assert!((us(1, "lateness_us_max") / 5.0 - 1.0).abs() < 0.01);
        assert!((us(1, "compute_us_p999") / 1.0 - 1.0).abs() < 0.01);
    }
}
