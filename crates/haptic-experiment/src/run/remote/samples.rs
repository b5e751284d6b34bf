//! The samples of a session: each kept once, each that is missing counted.

use super::session::{HostSession, applied_n};
use crate::run::ending::Ending;
use crate::run::fault_recorder::AFTER;
use crate::run::tell_end;
use crate::run::tick::{TickRecord, per_axis};
use haptic_link::{BatchItem, Sample};
use haptic_log::record::TickMessage;

/// Sample of what is known without the device: where the indenter is to be, m; the rest is not a number.
#[must_use]
pub(crate) fn blank(reference_m: f64) -> TickMessage {
    TickMessage {
        reference_m: reference_m.into(),
        indenter_position_m: f64::NAN.into(),
        contact_force_n: f64::NAN.into(),
        observed_energy_j: f64::NAN,
        ..TickMessage::default()
    }
}

impl<M: TickRecord, const D: usize> HostSession<'_, M, D> {
    /// Takes a sample of the device. One of another number of axes is none, and its tick is missing. False for one behind all that a
    /// device tells of a run that its fault has ended: it came because it was asked for.
    pub(super) fn take_sample(&mut self, sample: &Sample) -> bool {
        let Some(message) = self.message(sample) else {
            return true;
        };
        let tick = u64::from(sample.tick);
        if let Some(last) = self.last_told() {
            let falls = !self.record.has_fallen() && message.kept().applied_force_n != 0.0;
            // The next tick is none of those between, in which the device was not asked yet.
            if tick > last && tick != self.next_tick && !falls {
                self.came_until(last);
                return false;
            }
        }
        let counted = self.counts(tick);
        self.gap(tick);
        self.keep(message, counted);
        true
    }

    /// True if this tick is part of the result: none from a fault of the device on, though nobody knows which yet.
    pub(super) fn counts(&self, tick: u64) -> bool {
        tick < self.schedule.samples && self.record.ended.is_none() && !self.has_faulted(tick)
    }

    fn has_faulted(&self, tick: u64) -> bool {
        let faulted = self.link.fault_tick();
        faulted.is_some_and(|faulted| tick >= u64::from(faulted))
    }

    /// The last tick after a fault of the device that the log needs: those before it are told unasked.
    fn last_told(&self) -> Option<u64> {
        match self.record.ended {
            Some(Ending::DeviceFault(report)) => Some(u64::from(report.tick) + AFTER),
            _ => None,
        }
    }

    /// True if all is there that follows a fault of the device.
    pub(super) fn is_all_told(&self) -> bool {
        self.recorder.flight().is_full() && self.record.has_fallen()
    }

    /// A sample of the device as the log has it.
    pub(super) fn message(&self, sample: &Sample) -> Option<M> {
        if sample.axes.len() != D {
            return None;
        }
        let axes = &sample.axes;
        let tick = u64::from(sample.tick);
        let time_s = tick as f64 * self.schedule.sample_time_s;
        let applied_n = per_axis(&applied_n::<D>(sample));
        let of = |read: fn(&BatchItem) -> f32| axes.iter().map(|axis| read(axis).into()).collect();
        let mut message = (self.blank)(time_s - self.start_s());
        let logged = message.logged_mut();
        *logged = TickMessage {
            tick,
            time_s,
            position_m: of(|axis| axis.position_m),
            environment_force_n: of(|axis| axis.environment_force_n),
            commanded_force_n: applied_n,
            applied_force_n: applied_n,
            limiters: axes[0].limiters,
            flaws: axes[0].flaws,
            observed_energy_j: f64::NAN,
            ..*logged
        };
        Some(message)
    }

    /// Ticks so far that count.
    pub(super) const fn counted(&self) -> u64 {
        self.next_tick.saturating_sub(self.record.start.tick)
    }

    /// When the run begins to count, s.
    pub(super) fn start_s(&self) -> f64 {
        self.record.start.time_s()
    }

    /// Counts what is missing before this tick.
    pub(super) fn gap(&mut self, tick: u64) {
        self.came_until(tick);
        self.next_tick = tick + 1;
    }

    /// Counts what did not come of the ticks before this one.
    fn came_until(&mut self, tick: u64) {
        // Samples after a fault or the last tick are no part of the result, but of the log: those that are missing
        // there are lost.
        if tick > self.next_tick {
            let missing = tick - self.next_tick;
            self.samples_lost += missing;
            let time_s = tick as f64 * self.schedule.sample_time_s;
            let text = format!("{missing} samples before tick {tick} did not come");
            // A recorder that has ended is seen when it is closed.
            let _ = self.recorder.event(time_s, "lost", text);
            self.next_tick = tick;
        }
    }

    /// A run that finished, but whose last samples did not come.
    pub(super) fn count_missing_end(&mut self) {
        if self.record.ended.is_none() {
            self.came_until(self.schedule.samples);
        }
    }

    /// A fault on the device whose tick did not come, nor any later one.
    pub(super) fn count_missing_fault(&mut self) {
        if let Some(Ending::DeviceFault(report)) = self.record.ended {
            let made = u64::from(report.tick) + 1;
            self.came_until(made.min(self.schedule.samples));
        }
    }

    pub(super) fn keep(&mut self, message: M, counted: bool) {
        let logged = self.recorder.tick(message.logged());
        if counted {
            self.record.push(&message);
        } else if self.record.ended.is_some() || self.has_faulted(message.kept().tick) {
            self.record.push_after(&message);
        } else {
            self.record.falls(&message);
        }
        if logged.is_err() && self.record.ended.is_none() {
            self.record.ended = Some(Ending::LogStopped);
        }
    }

    pub(super) fn ends(&mut self, ended: Ending) {
        if self.record.ended.is_none() {
            self.record.ended = Some(ended);
            let tick = match ended {
                Ending::DeviceFault(report) => u64::from(report.tick),
                Ending::Impossible(what) => u64::from(what.tick()),
                _ => self.next_tick.saturating_sub(1),
            };
            let t = self.schedule.sample_time_s;
            let (at, event_s) = ((tick, tick as f64 * t), self.next_tick as f64 * t);
            tell_end(&mut self.recorder, ended, self.record.lateness, at, event_s);
        }
    }
}

#[cfg(test)]
mod tests {
    use haptic_log::record::flaw;

    #[test]
    fn flaws_have_the_same_bits_on_the_wire_and_in_a_log() {
        let wire = [
            haptic_link::UNANSWERED,
            haptic_link::NOT_TAKEN,
            haptic_link::IMPOSSIBLE,
        ];
        let log = [flaw::UNANSWERED, flaw::NOT_TAKEN, flaw::IMPOSSIBLE];
        assert_eq!(wire, log);
        assert!(!wire.contains(&flaw::LATE_FORCE));
    }
}
