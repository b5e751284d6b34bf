//! A run by the clock: what is asked for its thread, and what it reports.

pub use haptic_loop::realtime::ThreadConfig as RealtimeOptions;
use haptic_loop::realtime::{Durations, RaisedThread, Timing, WorstCycle};
use haptic_trial::flat::flat;
use serde::Serialize;
use std::{collections::BTreeMap, time::Duration};

/// Quantiles of a time over all ticks, µs.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Microseconds {
    /// Half of them took no longer.
    pub p50: f64,
    /// 99 of 100 took no longer.
    pub p99: f64,
    /// 999 of 1000 took no longer.
    pub p999: f64,
    /// The longest.
    pub max: f64,
}

impl Microseconds {
    /// Quantiles of durations that were recorded in ns.
    pub fn of(durations: &Durations) -> Self {
        let at = |quantile| durations.quantile(quantile) as f64 / 1e3;
        Self {
            p50: at(0.5),
            p99: at(0.99),
            p999: at(0.999),
            max: durations.max() as f64 / 1e3,
        }
    }
}

/// A duration in µs, with its nanoseconds.
pub fn microseconds(time: Duration) -> f64 {
    time.as_nanos() as f64 / 1e3
}

/// Timing of a run by the clock.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct RealtimeSummary {
    /// Priority that was granted; null for a normal thread.
    pub priority: Option<u8>,
    /// The core that it was pinned to.
    pub pin: Option<usize>,
    /// True if the memory was locked.
    pub memory_locked: bool,
    /// Time before it was due for which a tick was waited for without sleeping, µs.
    pub spin_margin_us: f64,
    /// Time from when a tick was due to when it began.
    pub lateness_us: Microseconds,
    /// Time from its beginning to its end, including all that the loop does besides.
    pub compute_us: Microseconds,
    /// Time from when it was due to its end: both.
    pub tick_us: Microseconds,
    /// Number of ticks at least a period late because the machine woke the loop late.
    pub late_by_wake_up: u64,
    /// Number of ticks at least a period late because the previous tick took too long.
    pub late_by_compute: u64,
    /// Number of periods in which no tick began.
    pub skipped_periods: u64,
    /// The tick that ended latest after it was due.
    pub worst_cycle: Option<WorstTick>,
}

/// A tick, and what took how long.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct WorstTick {
    /// Its number in the log.
    pub number: u64,
    /// Time from when it was due to when it began, µs.
    pub lateness_us: f64,
    /// Time from its beginning to its end, µs.
    pub compute_us: f64,
}

impl From<WorstCycle> for WorstTick {
    fn from(worst: WorstCycle) -> Self {
        Self {
            number: worst.number,
            lateness_us: microseconds(worst.lateness),
            compute_us: microseconds(worst.compute),
        }
    }
}

impl RealtimeSummary {
    /// Summary of what a loop measured in a thread.
    pub(crate) fn of(timing: &Timing, thread: &RaisedThread, spin_margin: Duration) -> Self {
        let overruns = timing.overruns;
        Self {
            priority: thread.priority(),
            pin: thread.core(),
            memory_locked: thread.memory_is_locked(),
            spin_margin_us: microseconds(spin_margin),
            lateness_us: Microseconds::of(&timing.lateness_ns),
            compute_us: Microseconds::of(&timing.compute_ns),
            tick_us: Microseconds::of(&timing.tick_ns),
            late_by_wake_up: overruns.by_wake_up,
            late_by_compute: overruns.by_compute,
            skipped_periods: overruns.skipped_periods,
            worst_cycle: timing.worst.map(WorstTick::from),
        }
    }

    /// Metadata for the log: the numbers, and the histograms.
    pub(crate) fn metadata(&self, timing: &Timing) -> BTreeMap<String, String> {
        let mut values = flat(self, "", "_");
        for (name, histogram) in [
            ("lateness", &timing.lateness_ns),
            ("compute", &timing.compute_ns),
            ("tick", &timing.tick_ns),
        ] {
            values.insert(format!("{name}_histogram"), buckets(histogram));
        }
        values
    }
}

/// Pairs of upper bound, ns, and count, blanks between; four buckets to the octave, empty ones left out.
fn buckets(durations: &Durations) -> String {
    let bound = |end: u64| {
        let quarters = libm::ceil(4.0 * libm::log2(end as f64 / 100.0)).max(0.0);
        libm::round(100.0 * libm::exp2(0.25 * quarters)) as u64
    };
    let mut buckets = BTreeMap::new();
    for (end, count) in durations.counts() {
        *buckets.entry(bound(end)).or_insert(0) += count;
    }
    let pairs: Vec<String> = (buckets.iter())
        .map(|(bound, count)| format!("{bound}:{count}"))
        .collect();
    pairs.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_buckets_of_the_log_hold_every_cycle() {
        let mut durations = Durations::default();
        for n in 0..10_000_u64 {
            durations.record(n * n % 3_000_000);
        }
        let text = buckets(&durations);
        let mut last = 0;
        let mut total = 0;
        for pair in text.split(' ') {
            let (bound, count) = pair.split_once(':').expect("a pair");
            let bound: u64 = bound.parse().expect("a bound");
            assert!(bound > last, "{bound} after {last}");
            last = bound;
            total += count.parse::<u64>().expect("a count");
        }
        assert_eq!(total, 10_000);
        assert!((2_999_000..4_200_000).contains(&last), "{last}");
        assert_eq!(buckets(&Durations::default()), "");
    }
}
