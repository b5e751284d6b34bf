//! The device as it runs: samples and notices in, forces out, each run followed to its end.

use super::error::SerialError;
use super::link::SerialLink;
use super::shared::{Command, Heard};
use crate::LinkError;
use fracdiff::Real;
use haptic_link::{Event, EventKind, FaultReport, Request, State};
use haptic_loop::{Device, Reading, SafeForce};
use nalgebra::SVector;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{RecvTimeoutError, TryRecvError, TrySendError};
use std::time::{Duration, Instant};

/// A run that gives no sample for so long is stuck.
const SAMPLE_TIMEOUT: Duration = Duration::from_millis(2000);

impl SerialLink {
    /// The next thing the device says unasked; `None` after the time. The end of a run and a fault are told even if
    /// their own frame was lost: what the device answers to keep-alives says so too.
    pub fn hear(&mut self, patience: Duration) -> Option<Heard> {
        /// A pause in which a missing end is looked for.
        const PAUSE: Duration = Duration::from_millis(50);
        let began = Instant::now();
        loop {
            if let Some(heard) = self.ahead.take() {
                return Some(self.noted(heard));
            }
            let left = patience.saturating_sub(began.elapsed());
            match self.heard.recv_timeout(left.min(PAUSE)) {
                Ok(heard) => return Some(self.noted(heard)),
                Err(RecvTimeoutError::Disconnected) => return Some(Heard::Over(LinkError::Gone)),
                Err(RecvTimeoutError::Timeout) => {}
            }
            if let Some(heard) = self.missed() {
                return Some(heard);
            }
            if began.elapsed() >= patience {
                return None;
            }
        }
    }

    /// Takes the next message if one is already there. Does not wait.
    pub fn try_hear(&mut self) -> Option<Heard> {
        if let Some(heard) = self.ahead.take() {
            return Some(self.noted(heard));
        }
        match self.heard.try_recv() {
            Ok(heard) => Some(self.noted(heard)),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Heard::Over(LinkError::Gone)),
        }
    }

    /// Follows the run; a status from before what was heard says nothing about its end.
    fn noted(&mut self, heard: Heard) -> Heard {
        let over = match heard {
            Heard::Sample(sample) => {
                self.heard_tick = sample.tick;
                false
            }
            Heard::Event(event) => matches!(
                event.kind,
                EventKind::Finished | EventKind::Stopped | EventKind::Disarmed
            ),
            Heard::Fault(_) | Heard::Over(_) => true,
        };
        self.running = match self.running {
            Some(_) if !over => Some(self.alives()),
            _ => None,
        };
        heard
    }

    /// The end of a run whose frame was lost, from two answers to keep-alives since anything else was heard: the
    /// second was asked for after it.
    fn missed(&mut self) -> Option<Heard> {
        let newest = self.running?;
        if self.alives() < newest + 2 {
            return None;
        }
        // Messages that came meanwhile go first.
        if let Some(heard) = self.try_hear() {
            return Some(heard);
        }
        let (status, tick) = (self.status(), self.heard_tick);
        let kind = match status.state {
            State::Fault => {
                self.running = None;
                return Some(Heard::Fault(FaultReport {
                    status,
                    tick,
                    time_us: 0,
                }));
            }
            State::Armed => EventKind::Finished,
            State::Idle => EventKind::Disarmed,
            State::Running | State::Stopping => return None,
        };
        self.running = None;
        Some(Heard::Event(Event {
            kind,
            tick,
            time_us: 0,
        }))
    }

    /// Sends a force of a host loop, N. Never waits; without room it is dropped and counted.
    pub fn send_force(&self, tick: u32, force_n: f32) {
        let force = Command::Tell(Request::Force { tick, force_n });
        if let Some(queue) = &self.commands
            && let Err(TrySendError::Full(_)) = queue.try_send(force)
        {
            self.shared.forces_dropped.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// A host loop: the position comes from the newest sample, the force goes out at once.
///
/// A reading's time is the tick's, n·T. [`read`](Device::read) waits for the next sample, up to 2 s; each
/// sample is read, in order, even when they come faster than they are read. A force is sent only if no newer sample has
/// come meanwhile: whoever has fallen behind computes what it has missed and answers the newest.
impl<F: Real> Device<F, 1> for SerialLink {
    type Error = SerialError;

    fn read(&mut self) -> Result<Reading<F, 1>, SerialError> {
        loop {
            match self.hear(SAMPLE_TIMEOUT) {
                Some(Heard::Sample(sample)) => {
                    self.newest_tick = sample.tick;
                    self.newest_limiters = sample.limiters;
                    self.newest_force_n = sample.force_n;
                    return Ok(Reading {
                        tick: u64::from(sample.tick),
                        time_s: f64::from(sample.tick) * self.period_s(),
                        position_m: SVector::from([F::from_f64(f64::from(sample.position_m))]),
                    });
                }
                Some(Heard::Over(error)) => return Err(error.into()),
                Some(Heard::Fault(report)) => return Err(LinkError::Faulted(report).into()),
                Some(Heard::Event(_)) => {}
                None => {
                    let waited_ms = SAMPLE_TIMEOUT.as_millis() as u64;
                    return Err(LinkError::NoSamples { waited_ms }.into());
                }
            }
        }
    }

    fn write(&mut self, force: SafeForce<F, 1>) -> Result<(), SerialError> {
        if self.ahead.is_none() {
            self.ahead = self.try_hear();
        }
        if matches!(self.ahead, Some(Heard::Sample(_))) {
            self.forces_skipped += 1;
            return Ok(());
        }
        self.send_force(self.newest_tick, force.newtons()[0].to_f64() as f32);
        Ok(())
    }
}
