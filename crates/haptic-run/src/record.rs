//! Memory of a run: the samples of a short one, sums of any.
//!
//! ```text
//! up to 10⁶ samples    kept here; sums over the whole history are exact
//! more                 in the log alone, read once more for the report
//! ```
//! So memory does not grow with the length of a run.

use super::{link_summary::LinkSummary, realtime::RealtimeSummary};
use haptic_loop::realtime::{Durations, RaisedThread};
use haptic_message::{EndKind, RunEnd};
use haptic_trial::{
    ending::{Ending, Fall, ForceKeeper, Lateness, LetGo},
    samples::{Before, RunStart, keeps_all},
    sensor_offset::Tare,
    tick::{KeptSample, TickRecord},
};

/// Record of a run, up to where it ended; everything else is in the log.
#[derive(Debug)]
pub struct RunRecord {
    /// Start of the run in the log.
    pub start: RunStart,
    /// The samples; `None` for a run of more than [`WHOLE_MOST`](haptic_trial::samples::WHOLE_MOST), whose samples are in its log.
    pub whole: Option<Vec<KeptSample>>,
    /// Samples of the device from its first tick to the beginning of a run with a partner: its tissue remembers where it was.
    pub approach: Vec<KeptSample>,
    /// Number of samples that count.
    pub samples: u64,
    /// The last sample that counts; `None` before the first.
    pub last: Option<KeptSample>,
    /// Time that each tick took, ns, the simulated rig included.
    pub tick_ns: Durations,
    /// Number of ticks that began at least one sample time late; 0 in virtual time.
    pub missed_deadlines: u64,
    /// Timing of a run by the clock of this machine.
    pub realtime: Option<RealtimeSummary>,
    /// Real-time settings that were refused, and how to get them granted: one sentence for the user.
    pub not_realtime: Option<String>,
    /// Samples and events that the recorder had to drop.
    pub dropped: u64,
    /// Samples in which a limiter of the safety chain acted.
    pub limited: u64,
    /// All limiters that acted, as [`bits`](haptic_loop::Limiters::bits).
    pub limiters: u8,
    /// Why the run ended before its time, if it did.
    pub ended: Option<Ending>,
    /// The run was to be stopped, but the device did not confirm the stop.
    pub stop_unheard: bool,
    /// Counts of the link, if there was one.
    pub link: Option<LinkSummary>,
    /// Lateness of this host up to which the device at the other end does not trip.
    pub lateness: Option<Lateness>,
    /// The one that takes the force away when the link is lost.
    pub keeper: ForceKeeper,
    /// Words of a served device whose board said nothing any more.
    pub board_lost: Option<String>,
    /// Offset of the device's force sensor.
    pub sensor: Tare,
    largest_force_n: f64,
    farthest_m: f64,
    after: After,
}

/// Forces in the log after the last sample that counts: on their way to zero.
#[derive(Debug, Default)]
struct After {
    fall: Fall,
    largest_n: f64,
}

impl RunRecord {
    /// Empty, with room for the samples, if they are to be kept.
    #[must_use]
    pub fn with_room_for(samples: u64) -> Self {
        let whole = if keeps_all(samples) {
            Some(Vec::with_capacity(samples as usize))
        } else {
            None
        };
        Self {
            start: RunStart::default(),
            whole,
            approach: Vec::new(),
            samples: 0,
            last: None,
            tick_ns: Durations::default(),
            missed_deadlines: 0,
            realtime: None,
            not_realtime: None,
            dropped: 0,
            limited: 0,
            limiters: 0,
            ended: None,
            stop_unheard: false,
            link: None,
            lateness: None,
            keeper: ForceKeeper::default(),
            board_lost: None,
            sensor: Tare::default(),
            largest_force_n: 0.0,
            farthest_m: 0.0,
            after: After::default(),
        }
    }

    /// Largest magnitude of the commanded force, N, of the samples that count.
    pub const fn largest_force_n(&self) -> f64 {
        self.largest_force_n
    }

    /// Largest magnitude of the commanded force in all samples, those after an early end included, N.
    pub const fn peak_force_n(&self) -> f64 {
        self.largest_force_n.max(self.after.largest_n)
    }

    /// Largest position of all samples, those after an early end included, m; at least 0.
    pub const fn farthest_m(&self) -> f64 {
        self.farthest_m
    }

    /// True if the device cannot be used any more: its link is lost, or its board.
    pub const fn device_lost(&self) -> bool {
        self.board_lost.is_some() || matches!(self.ended, Some(Ending::LinkLost(_)))
    }

    /// Release of the force, if the run ended before its time.
    pub fn let_go(&self) -> Option<LetGo> {
        let ended = self.ended?;
        Some(match self.lost() {
            Some(_) => LetGo::Commanded,
            None if self.stop_unheard => LetGo::unheard(ended, self.after.fall, self.keeper),
            None => LetGo::of(ended, self.after.fall, self.keeper),
        })
    }

    /// Why the run ended before its time, in words, if it did.
    pub fn reason(&self) -> Option<String> {
        let ended = self.ended?;
        if let Some(lost) = self.lost() {
            return Some(lost.to_owned());
        }
        Some(if self.stop_unheard {
            format!(
                "interrupted, but the device did not say that it stopped: {}",
                ended.reason(None)
            )
        } else {
            ended.reason(self.lateness)
        })
    }

    /// Words of the board whose loss ended the run.
    fn lost(&self) -> Option<&str> {
        let words = self.board_lost.as_deref();
        words.filter(|_| {
            matches!(
                self.ended,
                Some(Ending::DeviceFault(_) | Ending::LinkLost(_))
            )
        })
    }

    /// Time of the last sample, s; 0 without samples.
    pub fn duration_s(&self) -> f64 {
        self.last.map_or(0.0, |last| last.time_s)
    }

    /// Samples and events that the disk was too slow for.
    pub fn dropped_by_disk(&self) -> u64 {
        let line = self.link.as_ref().map_or(0, LinkSummary::samples_missing);
        self.dropped.saturating_sub(line)
    }

    /// End of the run, for its log: `planned` samples were to be made, `made` were.
    pub fn end(&self, planned: u64, made: u64) -> RunEnd {
        let ended = match self.ended {
            None => EndKind::Finished,
            // The log of a run that could not be written is cut: this does not reach it.
            Some(
                Ending::Interrupted
                | Ending::OtherLeft
                | Ending::Swing
                | Ending::Untared
                | Ending::LogStopped
                | Ending::Stopped(_),
            ) => EndKind::Interrupted,
            Some(Ending::Fault(_) | Ending::DeviceFault(_) | Ending::Impossible(_)) => {
                EndKind::Fault
            }
            Some(Ending::LinkLost(_) | Ending::Silent) => EndKind::Link,
        };
        RunEnd {
            ended,
            reason: self.reason().unwrap_or_default(),
            planned_samples: planned,
            made_samples: made,
            dropped_samples: self.dropped,
        }
    }

    /// Keeps what a raised thread was refused.
    pub(crate) fn raised(&mut self, thread: &RaisedThread) {
        self.not_realtime = thread.fallback().map(|fallback| fallback.to_string());
    }

    /// Adds a sample, if it counts.
    pub fn push(&mut self, message: &impl TickRecord) {
        let logged = message.kept();
        let Some(sample) = self.start.counted(logged) else {
            return;
        };
        self.limited += u64::from(sample.limiters != 0);
        self.limiters |= sample.limiters;
        self.samples += 1;
        self.largest_force_n = sample.force_n.abs().max(self.largest_force_n);
        self.farthest_m = self.farthest_m.max(sample.position_m);
        self.last = Some(sample);
        self.after.fall.before(logged.tick, logged.applied_force_n);
        if let Some(whole) = &mut self.whole {
            whole.push(sample);
        }
    }

    /// Adds a sample that is in the log but no part of the result: the force is on its way to zero.
    pub fn push_after(&mut self, message: &impl TickRecord) {
        let sample = message.kept();
        let force_n = sample.applied_force_n.abs();
        self.falls(message);
        self.after.largest_n = self.after.largest_n.max(force_n);
        self.farthest_m = self.farthest_m.max(sample.position_m);
    }

    /// Samples and ticks before the run, from where a full history has to be summed: the first tick at which the device was engaged, not that from
    /// which the run counts.
    pub fn before(&self) -> Before<'_> {
        Before {
            samples: &self.approach,
            ticks: if self.approach.is_empty() {
                0
            } else {
                self.start.tick
            },
        }
    }

    /// True if the newest sample has no force.
    pub(crate) const fn has_fallen(&self) -> bool {
        self.after.fall.has_fallen()
    }

    /// Looks at the force of a sample behind those that count.
    pub(crate) fn falls(&mut self, message: &impl TickRecord) {
        let sample = message.kept();
        let fall = &mut self.after.fall;
        // Relative to the first tick that counts, as the end of the run is.
        let time_s = sample.time_s - self.start.time_s();
        fall.after(sample.tick, time_s, sample.applied_force_n);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_message::TickMessage;

    #[test]
    fn a_run_counts_from_its_start() {
        let start = RunStart::at(502, 1e-3);
        let mut record = RunRecord::with_room_for(10);
        record.start = start;
        for tick in 500..505 {
            record.push(&TickMessage {
                tick,
                time_s: tick as f64 * 1e-3,
                limiters: 16 * u8::from(tick < 502),
                ..TickMessage::at_rest(1)
            });
        }
        let whole = record.whole.as_deref().unwrap_or_default();
        let counted: Vec<_> = whole
            .iter()
            .map(|sample| (sample.tick, sample.time_s))
            .collect();
        assert_eq!(counted, [(0, 0.0), (1, 1e-3), (2, 2e-3)]);
        assert_eq!((record.samples, record.limited), (3, 0));
        assert_eq!(RunStart::default().counted(whole[2]), Some(whole[2]));
    }
}
