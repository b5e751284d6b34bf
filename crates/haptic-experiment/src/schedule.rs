//! Schedule of a run: the number of ticks, the time of each, and the pace of time.

use crate::realtime::RealtimeOptions;
use haptic_loop::ParameterError;
use haptic_loop::realtime::PeriodicConfig;
use std::time::Duration;

/// Pace of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// As fast as the machine goes.
    Virtual,
    /// One tick each sample time, by the clock.
    Realtime(RealtimeOptions),
}

impl std::fmt::Display for Pace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Virtual => "virtual",
            Self::Realtime(_) => "realtime",
        })
    }
}

/// Number of ticks, the time of each, and their pace.
#[derive(Clone, Copy, Debug)]
pub struct Schedule {
    /// Ticks, the one at time 0 included.
    pub samples: u64,
    /// T, s.
    pub sample_time_s: f64,
    /// Pace of time.
    pub pace: Pace,
}

impl Schedule {
    /// Options for the threads of a run.
    pub(crate) const fn thread_options(&self) -> RealtimeOptions {
        match self.pace {
            Pace::Realtime(options) => options,
            Pace::Virtual => RealtimeOptions::NORMAL,
        }
    }

    /// The clock of this machine, if the run follows it.
    pub(crate) fn clock(&self) -> Result<Option<PeriodicConfig>, ParameterError> {
        let Pace::Realtime(options) = self.pace else {
            return Ok(None);
        };
        // A number that is no duration becomes 0, and 0 is refused.
        let period = Duration::try_from_secs_f64(self.sample_time_s).unwrap_or_default();
        let config = PeriodicConfig {
            thread: options.thread(),
            ..PeriodicConfig::new(period)
        };
        config.checked().map(Some)
    }
}

/// The memory of an operator for a run of so many samples: a little more, so that the last weights are not at the very edge.
#[must_use]
pub fn horizon(samples: u64) -> f64 {
    1.05 * samples as f64
}
