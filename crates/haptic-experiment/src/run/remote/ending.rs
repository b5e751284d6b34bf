//! The end of a run that the device may not have heard of: what it still says, and what the run ended with.

use super::session::{AFTER_FAULT, HostSession};
use crate::run::ending::Ending;
use crate::run::tick::TickRecord;
use haptic_link::{EventKind, FaultReport};
use haptic_remote::LinkError;
use haptic_remote::serial::{Heard, SerialError};
use std::time::{Duration, Instant};

/// Time behind the watchdog time in which a device that hears nothing has let go.
const FALLEN: Duration = Duration::from_secs(2);

/// What a device says last of a run.
enum Last {
    /// That the run is over, and its force zero.
    Over,
    /// Its fault.
    Fault(FaultReport),
    /// Nothing.
    Nothing,
}

impl<M: TickRecord, const D: usize> HostSession<'_, M, D> {
    /// The line or the device is gone, or does not answer: the log keeps what there is, and what still comes.
    pub(super) fn give_up(&mut self, error: &SerialError) {
        let error = match error {
            SerialError::Link(error) => *error,
            // Errors that only opening can meet; this port was open.
            _ => LinkError::Gone,
        };
        if let LinkError::Impossible(what) = error {
            self.keep_impossible();
            self.ends(Ending::Impossible(what));
            // It was told to let go: how the force falls.
            let _ = self.hear_out();
            return;
        }
        self.deaf |= matches!(error, LinkError::NoAnswer { .. });
        let unheard = matches!(
            error,
            LinkError::NoAnswer { .. }
                | LinkError::Gone
                | LinkError::Refused {
                    request: "stop" | "disarm",
                    ..
                }
        );
        let last = match error {
            LinkError::Faulted(report) => Last::Fault(report),
            _ if unheard && self.may_run_on() => self.hear_out(),
            _ => Last::Nothing,
        };
        match last {
            Last::Over => {}
            Last::Fault(report) => self.ends_unasked(Ending::DeviceFault(report)),
            Last::Nothing => self.ends_unasked(Ending::LinkLost(error)),
        }
    }

    /// The sample that cannot be is in the log, as what it is, and no part of the result.
    fn keep_impossible(&mut self) {
        let message = self
            .link
            .impossible()
            .and_then(|sample| self.message(sample));
        if let Some(message) = message {
            self.gap(message.logged().tick);
            // A recorder that has ended is seen when it is closed.
            let _ = self.recorder.tick(message.logged());
        }
    }

    /// True if a run began whose end is not known.
    fn may_run_on(&self) -> bool {
        let ended = self.record.ended;
        !self.over && self.next_tick > 0 && matches!(ended, None | Some(Ending::Interrupted))
    }

    /// The run ended so. One that was to be stopped, and was not known to be over, did not end because somebody asked for it.
    fn ends_unasked(&mut self, ended: Ending) {
        if self.record.ended == Some(Ending::Interrupted) && !self.over {
            self.record.stop_unheard = true;
            self.record.ended = None;
        }
        self.ends(ended);
    }

    /// Takes what the device says of a run until that is over, or it is silent.
    fn hear_out(&mut self) -> Last {
        let until = Instant::now() + self.watchdog + FALLEN;
        while Instant::now() < until {
            match self.link.hear(AFTER_FAULT) {
                Some(Heard::Sample(sample)) => {
                    self.take_sample(&sample);
                }
                Some(Heard::Event(event)) => match event.kind {
                    EventKind::Finished | EventKind::Stopped | EventKind::Disarmed => {
                        return Last::Over;
                    }
                    EventKind::Configured | EventKind::Armed | EventKind::Started => {}
                },
                Some(Heard::Fault(report)) => return Last::Fault(report),
                Some(Heard::Over(_)) | None => break,
            }
        }
        Last::Nothing
    }
}
