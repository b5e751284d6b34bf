//! When a run began, by the wall clock: what lays a log beside the recording of a camera.

use chrono::{DateTime, SecondsFormat, Utc};
use std::{
    collections::BTreeMap,
    time::{Duration, SystemTime, UNIX_EPOCH},
};

/// Name of the metadata record that says when a run began.
pub const CLOCK: &str = "clock";

/// Wall-clock time of device time 0, and how well it is known.
///
/// ```text
/// log time = start + device time
/// ```
/// The wall clock of the machine that keeps the log is read once: steps of it during a run, and its
/// growing difference from the device's clock, are not in the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StartTime {
    /// Since 1970-01-01 UTC, ns.
    at_ns: u64,
    uncertainty: Duration,
}

impl StartTime {
    /// Device time 0 was at this moment. An earlier moment becomes 1970.
    #[must_use]
    pub fn at(moment: SystemTime) -> Self {
        Self {
            at_ns: since_1970_ns(moment),
            uncertainty: Duration::ZERO,
        }
    }

    /// Device time 0 was between these moments: their middle.
    #[must_use]
    pub fn between(earliest: SystemTime, latest: SystemTime) -> Self {
        let half = latest.duration_since(earliest).unwrap_or_default() / 2;
        Self {
            uncertainty: half,
            ..Self::at(earliest + half)
        }
    }

    /// Device time was `device_time_s` at this moment. A negative or invalid time becomes 0.
    #[must_use]
    pub fn before(moment: SystemTime, device_time_s: f64) -> Self {
        let ago = Duration::try_from_secs_f64(device_time_s).unwrap_or_default();
        Self::at(moment.checked_sub(ago).unwrap_or(UNIX_EPOCH))
    }

    /// Start time from the log times of a file; `None` for one that counts from the start of its run.
    pub(super) const fn of_log(log_time_ns: u64, device_time_ns: u64) -> Option<Self> {
        match log_time_ns.saturating_sub(device_time_ns) {
            0 => None,
            at_ns => Some(Self {
                at_ns,
                uncertainty: Duration::ZERO,
            }),
        }
    }

    /// Since 1970-01-01 UTC, ns.
    #[must_use]
    pub const fn since_1970_ns(self) -> u64 {
        self.at_ns
    }

    /// Time as RFC 3339 in UTC, to the nanosecond: `2026-11-20T12:31:49.000000000Z`.
    #[must_use]
    pub fn rfc3339(self) -> String {
        // Until the year 2262.
        let at_ns = i64::try_from(self.at_ns).unwrap_or(i64::MAX);
        DateTime::<Utc>::from_timestamp_nanos(at_ns).to_rfc3339_opts(SecondsFormat::Nanos, true)
    }

    /// The day in UTC: `2026-11-20`.
    #[must_use]
    pub fn day(self) -> String {
        let mut day = self.rfc3339();
        day.truncate("2026-11-20".len());
        day
    }

    /// The metadata record [`CLOCK`].
    pub(crate) fn metadata(self) -> BTreeMap<String, String> {
        let uncertainty_s = self.uncertainty.as_secs_f64();
        [
            ("started_utc", self.rfc3339()),
            ("start_uncertainty_s", uncertainty_s.to_string()),
        ]
        .map(|(key, value)| (key.to_owned(), value))
        .into()
    }
}

fn since_1970_ns(moment: SystemTime) -> u64 {
    let since = moment.duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_nanos()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `date -u -d 2026-11-20T12:31:49Z +%s`.
    const NOON_S: u64 = 1_795_177_909;

    #[test]
    fn a_start_is_written_as_rfc_3339_to_the_nanosecond() {
        let moment = UNIX_EPOCH + Duration::new(NOON_S, 7);
        let start = StartTime::at(moment);
        assert_eq!(start.rfc3339(), "2026-11-20T12:31:49.000000007Z");
        assert_eq!(start.since_1970_ns(), NOON_S * 1_000_000_000 + 7);
        let later = moment + Duration::from_millis(1500);
        assert_eq!(StartTime::before(later, 1.5), start);
        let values = StartTime::between(moment, later).metadata();
        assert_eq!(values["started_utc"], "2026-11-20T12:31:49.750000007Z");
        assert_eq!(values["start_uncertainty_s"], "0.75");
    }

    #[test]
    fn a_wrong_clock_gives_a_wrong_date_and_no_panic() {
        let early = UNIX_EPOCH - Duration::from_secs(5);
        assert_eq!(
            StartTime::at(early).rfc3339(),
            "1970-01-01T00:00:00.000000000Z"
        );
        let early = StartTime::before(UNIX_EPOCH, 1e300);
        assert_eq!(early.since_1970_ns(), 0);
        let late = StartTime::at(UNIX_EPOCH + Duration::from_secs(20_000_000_000));
        assert!(late.rfc3339().starts_with("2262-"));
    }

    #[test]
    fn log_times_that_count_from_the_run_have_no_start() {
        assert_eq!(StartTime::of_log(1_000, 1_000), None);
        assert_eq!(
            StartTime::of_log(5_000, 1_000).map(StartTime::since_1970_ns),
            Some(4_000)
        );
    }
}
