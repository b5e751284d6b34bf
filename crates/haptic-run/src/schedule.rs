//! Schedule of a run: the number of ticks, the time of each, and the pace of time.

use crate::realtime::RealtimeOptions;
use haptic_loop::{LoopParameterError, realtime::PeriodicConfig};
use std::time::Duration;

/// The pace of a run: as fast as it can be computed, or by the clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// Virtual time, as fast as the machine goes.
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
    /// Number of ticks, including the one at time 0.
    pub samples: u64,
    /// Time from one tick to the next, s.
    pub sample_time_s: f64,
    /// Virtual time, or by the clock.
    pub pace: Pace,
}

impl Schedule {
    /// Options for the threads of a run.
    pub(crate) fn thread_options(&self) -> RealtimeOptions {
        match self.pace {
            Pace::Realtime(options) => options,
            Pace::Virtual => RealtimeOptions::default(),
        }
    }

    /// The clock of this machine, if the run follows it.
    ///
    /// # Errors
    /// If the clock cannot keep this sample time.
    pub fn clock(&self) -> Result<Option<PeriodicConfig>, LoopParameterError> {
        let Pace::Realtime(options) = self.pace else {
            return Ok(None);
        };
        // NaN, and what no `Duration` holds, become 0, which is refused.
        let period = Duration::try_from_secs_f64(self.sample_time_s).unwrap_or_default();
        let config = PeriodicConfig {
            thread: options,
            ..PeriodicConfig::new(period)
        };
        config.checked().map(Some)
    }
}
