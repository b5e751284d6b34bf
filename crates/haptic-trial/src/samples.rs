//! The samples of a run, wherever they are: in memory, or in its log.

use crate::tick::KeptSample;
use fracdiff::parameter::Shown;
use haptic_document::{Failure, bad_input, parameters::TRIAL_DURATION};
use haptic_message::TickMessage;
use std::{ops::RangeInclusive, path::PathBuf};

/// Reader of the ticks of a log in these files, in order.
pub type ReadTicks =
    fn(&[PathBuf], &mut dyn FnMut(&TickMessage) -> Result<(), Failure>) -> Result<(), Failure>;

/// Place of the samples of a run.
#[derive(Clone, Copy, Debug)]
pub enum Samples<'a> {
    /// Samples in memory, of a run that is short enough.
    Whole(&'a [KeptSample]),
    /// Samples in the files of the log, from this tick on, up to this one as it is counted from there.
    Logged(&'a [PathBuf], ReadTicks, RunStart, u64),
}

impl Samples<'_> {
    /// Hands over each sample, in order.
    ///
    /// # Errors
    /// Those of the log, and of who takes the samples.
    pub fn for_each(
        self,
        mut take: impl FnMut(&KeptSample) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        match self {
            Self::Whole(samples) => samples.iter().try_for_each(take),
            Self::Logged(files, read, start, last_tick) => read(files, &mut |message| {
                let counted = start.counted(KeptSample::of(message));
                let counted = counted.filter(|sample| sample.tick <= last_tick);
                counted.as_ref().map_or(Ok(()), &mut take)
            }),
        }
    }
}

/// Fewest and most samples of an experiment: at 1 kHz, eleven days. The disk is full before.
pub const SAMPLES: RangeInclusive<f64> = 10.0..=1e9;

/// Largest number of samples of a run kept in memory.
pub const WHOLE_MOST: u64 = 1_000_000;

/// True of a run whose samples are all kept in memory.
pub const fn keeps_all(samples: u64) -> bool {
    samples <= WHOLE_MOST
}

/// The tick of the log with which a run begins to count, and its time: 0 but where a simulated plant waits for its device to raise its
/// force.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RunStart {
    /// The tick, by its number in the log.
    pub tick: u64,
    sample_time_s: f64,
    /// Time of that tick where the run counts from between two ticks, s.
    pub lead_s: f64,
}

impl RunStart {
    /// Start at this tick, with this sample time.
    pub const fn at(tick: u64, sample_time_s: f64) -> Self {
        Self {
            tick,
            sample_time_s,
            lead_s: 0.0,
        }
    }

    /// The first tick at this time or after it, s; the run counts from the time itself.
    pub fn from(time_s: f64, sample_time_s: f64) -> Self {
        let tick = (time_s / sample_time_s).ceil().max(0.0);
        Self {
            lead_s: tick * sample_time_s - time_s,
            ..Self::at(tick as u64, sample_time_s)
        }
    }

    /// Its time in the log, s.
    pub const fn time_s(self) -> f64 {
        self.tick as f64 * self.sample_time_s
    }

    /// Time in the log from which the run counts, between two ticks or at one, s.
    pub fn begun_s(self) -> f64 {
        self.time_s() - self.lead_s
    }

    /// The sample counted from here on; `None` before.
    pub fn counted(self, sample: KeptSample) -> Option<KeptSample> {
        if self.tick == 0 {
            return Some(sample);
        }
        let tick = sample.tick.checked_sub(self.tick)?;
        let time_s = tick as f64 * self.sample_time_s + self.lead_s;
        Some(KeptSample {
            tick,
            time_s,
            ..sample
        })
    }
}

/// Ticks of a device before its run counts, of which its law remembers the motion.
#[derive(Clone, Copy, Debug, Default)]
pub struct Before<'a> {
    /// Those that came, by the tick of the device.
    pub samples: &'a [KeptSample],
    /// Number of them, lost ones included.
    pub ticks: u64,
}

/// The memory of an operator for a run of `samples` samples: a little more, so that the last weights are not at the very edge.
pub fn horizon(samples: u64) -> f64 {
    1.05 * samples as f64
}

/// Number of samples from time 0 to the end of a run, both included.
///
/// # Errors
/// A number of samples outside the range, with the parameter to change.
pub fn count(
    duration_s: f64,
    sample_time_s: f64,
    allowed: &RangeInclusive<f64>,
) -> Result<u64, Failure> {
    let samples = (duration_s / sample_time_s).round() + 1.0;
    if allowed.contains(&samples) {
        return Ok(samples as u64);
    }
    Err(bad_input!(
        "duration {} s in steps of {} s is {samples} samples, not in [{}, {:e}]: change {TRIAL_DURATION}",
        Shown(duration_s),
        Shown(sample_time_s),
        allowed.start(),
        allowed.end()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Drive that began between two ticks: the first after it counts, at the time from there.
    #[test]
    fn a_run_may_count_from_between_two_ticks() {
        let start = RunStart::from(0.5012, 1e-3);
        assert_eq!(start.tick, 502);
        let sample = KeptSample::of(&TickMessage {
            tick: 503,
            time_s: 0.503,
            ..TickMessage::at_rest(1)
        });
        let counted = start.counted(sample).expect("it is after the start");
        assert_eq!(counted.tick, 1);
        assert!((counted.time_s - 1.8e-3).abs() < 1e-12, "{counted:?}");
        assert!((start.time_s() - start.lead_s - 0.5012).abs() < 1e-12);
        assert_eq!(RunStart::from(-1.0, 1e-3).tick, 0);
    }
}
