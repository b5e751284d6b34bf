//! Durations: counts by size, and quantiles of them.

use histogram::{Config, Histogram};

/// Range from 1 to 2³⁷ of a unit, 137 s in ns, in steps of at most 1/1024 of a duration.
const CONFIG: Config = match Config::new(10, 37) {
    Ok(config) => config,
    Err(_) => panic!("powers that the histogram can have"),
};

/// Counts of whole durations, in one unit of the caller's. To record one neither fails nor allocates; longer ones than 2³⁷ count as that.
#[derive(Clone, Debug)]
pub struct Durations {
    counts: Histogram,
    recorded: u64,
    longest: u64,
}

impl Default for Durations {
    fn default() -> Self {
        Self {
            counts: Histogram::with_config(&CONFIG),
            recorded: 0,
            longest: 0,
        }
    }
}

impl Durations {
    /// Counts a duration, in the caller's unit; it neither fails nor allocates.
    pub fn record(&mut self, duration: u64) {
        let within = duration.min((1 << CONFIG.max_value_power()) - 1);
        // Within its range none is refused.
        if self.counts.increment(within).is_ok() {
            self.recorded += 1;
            self.longest = self.longest.max(within);
        }
    }

    /// Number of those that were recorded.
    #[must_use]
    pub const fn len(&self) -> u64 {
        self.recorded
    }

    /// True if none was recorded.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.recorded == 0
    }

    /// The longest; 0 if none was recorded.
    #[must_use]
    pub const fn max(&self) -> u64 {
        self.longest
    }

    /// The duration that this share of them, 0 to 1, does not exceed, to 1/1024; 0 if none was recorded.
    #[must_use]
    pub fn quantile(&self, share: f64) -> u64 {
        let bucket = self.counts.quantile_bucket(share).ok().flatten();
        bucket.map_or(0, |bucket| bucket.end().min(self.longest))
    }

    /// Upper bounds, and the number of those up to each and above the one before, which is never 0.
    pub fn counts(&self) -> impl Iterator<Item = (u64, u64)> {
        let all = self.counts.iter();
        let some = all.filter(|bucket| bucket.count() > 0);
        some.map(|bucket| (bucket.end(), bucket.count()))
    }

    /// Forgets all durations, the longest too.
    pub fn reset(&mut self) {
        self.counts.reset();
        (self.recorded, self.longest) = (0, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    #[test]
    fn quantiles_are_those_of_the_sorted_durations() {
        let mut durations = Durations::default();
        assert_eq!((durations.quantile(0.5), durations.max()), (0, 0));
        let mut all: Vec<u64> = (0..9999_u64).map(|n| n * n * 7919 % 3_000_017).collect();
        all.iter().for_each(|one| durations.record(*one));
        all.sort_unstable();
        for share in [0.0, 0.1, 0.5, 0.99, 0.999, 1.0] {
            let rank = (libm::ceil(share * 9999.0) as usize).max(1);
            let (found, right) = (durations.quantile(share), all[rank - 1]);
            let off = found.abs_diff(right) as f64;
            assert!(off <= right as f64 / 1024.0, "{share}: {found} {right}");
        }
        assert_eq!((durations.len(), durations.max()), (9999, all[9998]));
        assert_eq!(
            durations.counts().map(|(_, count)| count).sum::<u64>(),
            9999
        );
        durations.record(u64::MAX);
        assert_eq!(durations.quantile(1.0), (1 << 37) - 1);
        durations.reset();
        assert!(durations.is_empty() && durations.counts().next().is_none());
    }
}
