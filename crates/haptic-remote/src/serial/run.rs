//! The device as it runs: samples and notices in, forces out, each run followed to its end.

use super::{
    error::SerialError,
    link::{Command, DeviceMessage, HEARD_MOST, STOPPED, SerialLink},
};
use crate::LinkError;
use fracdiff::Real;
use haptic_link::{
    AXES_MAX, BatchItem, Event, EventKind, FaultReport, IMPOSSIBLE, Limits, Refusal, Request,
    Sample, State,
};
use haptic_loop::{Device, Limiters, Reading, SafeForce};
use nalgebra::SVector;
use std::{
    sync::{
        atomic::{AtomicBool, Ordering},
        mpsc::{RecvTimeoutError, TryRecvError, TrySendError},
    },
    time::Duration,
};

/// A run that gives no sample for this long is stuck.
const SAMPLE_TIMEOUT: Duration = Duration::from_millis(2000);
/// A pause in which a missing end is looked for, or somebody who stops the reading.
const PAUSE: Duration = Duration::from_millis(50);
/// Forces of which a device has one if they come in time.
pub(super) const IN_TIME: usize = Limits::DEFAULT.max_age_ticks as usize;

impl SerialLink {
    /// The next thing the device says unasked; `None` after the time, by what this machine
    /// [listened](crate::Patience). The end of a run and a fault are reported even if their frames were
    /// lost: answers to keep-alives say so too.
    pub fn hear(&mut self, most: Duration) -> Option<DeviceMessage> {
        let mut patience = self.patience(most);
        loop {
            if let Some(heard) = self.ahead.take() {
                return Some(self.noted(heard));
            }
            // The reader counts in steps of its own: the rest of one may be short.
            let pause = patience.left().max(Duration::from_millis(1));
            match self.heard.recv_timeout(pause.min(PAUSE)) {
                Ok(heard) => return Some(self.noted(heard)),
                Err(RecvTimeoutError::Disconnected) => {
                    return Some(DeviceMessage::Over(LinkError::Gone));
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
            if let Some(heard) = self.missed() {
                return Some(heard);
            }
            if self.is_silent(&mut patience) {
                return None;
            }
        }
    }

    /// Finds out why the device has been silent for this long during a run. It makes the device let go, and listens a little
    /// longer for its answer; after that, a device that does not answer is not waited for any more.
    #[must_use]
    pub fn silent(&self, waited: Duration) -> LinkError {
        self.answer_after(waited, Request::Disarm)
    }

    /// Finds out the reason as [`silent`](Self::silent) does, for a device that is only watched: it is asked once and not otherwise affected.
    #[must_use]
    pub fn unheard(&self, waited: Duration) -> LinkError {
        self.answer_after(waited, Request::GetStatistics)
    }

    fn answer_after(&self, waited: Duration, request: Request) -> LinkError {
        // Two tries. The answers to keep-alives have shown it before, unless the line lost them all.
        let waited_ms = waited.as_millis() as u64;
        // Nothing but the question feeds its watchdog any more.
        self.shared.conversation().set_keep_alive(None);
        let answers = match self.answers(request, STOPPED) {
            Ok(answers) => answers,
            Err(error) => return error,
        };
        if !answers {
            self.give_up();
        }
        if answers || self.shared.conversation().listened().silent() < waited / 2 {
            return LinkError::HeldUp { waited_ms };
        }
        LinkError::NoSamples { waited_ms }
    }

    /// Makes a device let go that has not answered a question, and asks on for some seconds, which a busy machine or a bad line
    /// may need, unless somebody stops; true if it answers then.
    #[must_use]
    pub fn answers_again(&self) -> bool {
        const MOST: Duration = Duration::from_secs(4);
        let mut patience = self.patience(MOST);
        loop {
            let answers = self.answers(Request::Disarm, Duration::MAX);
            let is_deaf = self.shared.deaf.load(Ordering::Relaxed);
            if answers != Ok(false) || is_deaf || self.is_over(&mut patience) {
                return answers == Ok(true);
            }
        }
    }

    /// True if the device answers within this time, if only by a refusal.
    fn answers(&self, request: Request, most: Duration) -> Result<bool, LinkError> {
        match self.ask_for(request, most) {
            Err(SerialError::Link(LinkError::NoAnswer { .. })) => Ok(false),
            Err(SerialError::Link(LinkError::Refused { refusal, .. }))
                if refusal != Refusal::Connection =>
            {
                Ok(true)
            }
            Err(SerialError::Link(error)) => Err(error),
            Err(_) => Err(LinkError::Gone),
            Ok(_) => Ok(true),
        }
    }

    /// Takes the next message if one is already there. Does not wait.
    pub fn try_hear(&mut self) -> Option<DeviceMessage> {
        if let Some(heard) = self.ahead.take() {
            return Some(self.noted(heard));
        }
        match self.heard.try_recv() {
            Ok(heard) => Some(self.noted(heard)),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(DeviceMessage::Over(LinkError::Gone)),
        }
    }

    /// Forgets what came and was not heard yet, but for the end of the line.
    pub(super) fn forget_until_now(&mut self) {
        for _ in 0..HEARD_MOST {
            match self.try_hear() {
                Some(heard @ DeviceMessage::Over(_)) => {
                    self.ahead = Some(heard);
                    return;
                }
                Some(_) => {}
                None => return,
            }
        }
    }

    /// Follows the run; a status from before what was heard says nothing about its end.
    fn noted(&mut self, heard: DeviceMessage) -> DeviceMessage {
        if let Some(over) = self.judged(&heard) {
            return over;
        }
        let over = match &heard {
            DeviceMessage::Sample(Sample { tick, axes, .. }) => {
                self.sampled(*tick, axes.first().map_or(0, |axis| axis.limiters));
                false
            }
            DeviceMessage::Event(event) => matches!(
                event.kind,
                EventKind::Finished | EventKind::Stopped | EventKind::Disarmed
            ),
            DeviceMessage::Fault(_) | DeviceMessage::Over(_) => true,
        };
        let withdrawn = |event: &Event| event.kind == EventKind::Withdrawn;
        if self.running.is_some()
            && matches!(&heard, DeviceMessage::Event(event) if withdrawn(event))
        {
            self.running = None;
            return DeviceMessage::Over(LinkError::Withdrawn);
        }
        self.running = match self.running {
            Some(_) if !over => Some(self.alives()),
            _ => None,
        };
        heard
    }

    /// The end of a run with an impossible sample. The device is ordered to let go before anything else is done.
    fn judged(&mut self, heard: &DeviceMessage) -> Option<DeviceMessage> {
        self.running?;
        let sample = match heard {
            DeviceMessage::Sample(sample) => sample,
            DeviceMessage::Event(event) => {
                if event.kind == EventKind::Started {
                    // Earlier samples date from before the run.
                    self.plausible.begin(self.period_us());
                }
                return None;
            }
            DeviceMessage::Fault(_) | DeviceMessage::Over(_) => return None,
        };
        // A device in a fault flags its own samples as invalid.
        let in_fault = |axis: &BatchItem| axis.limiters & Limiters::FAULT.bits() != 0;
        if sample.axes.iter().any(in_fault) {
            self.plausible.lets_go = true;
            return None;
        }
        let impossible = self.plausible.look(sample).err()?;
        if let Some(queue) = &self.commands {
            // Without room the one of the link's end must do.
            let _ = queue.try_send(Command::Tell(Request::Disarm));
        }
        self.running = None;
        let flawed = |axis: &BatchItem| BatchItem {
            flaws: axis.flaws | IMPOSSIBLE,
            ..*axis
        };
        self.impossible = Some(Sample {
            axes: sample.axes.iter().map(flawed).collect(),
            ..sample.clone()
        });
        Some(DeviceMessage::Over(LinkError::Impossible(impossible)))
    }

    /// Follows the samples of a run.
    fn sampled(&mut self, tick: u32, limiters: u8) {
        self.heard_tick = tick;
        if self.running.is_some() && limiters & Limiters::FAULT.bits() != 0 {
            self.fault_tick.get_or_insert(tick);
        }
    }

    /// The end of a run whose frame was lost, from two answers to keep-alives after the last thing heard.
    fn missed(&mut self) -> Option<DeviceMessage> {
        let newest = self.running?;
        if self.alives() < newest + 2 {
            return None;
        }
        // Messages that came meanwhile go first.
        if let Some(heard) = self.try_hear() {
            return Some(heard);
        }
        let (status, heard_tick) = (self.status(), self.heard_tick);
        let kind = match status.state {
            State::Fault => {
                self.running = None;
                return Some(DeviceMessage::Fault(FaultReport {
                    status,
                    tick: self.fault_tick.unwrap_or(heard_tick),
                    time_us: 0,
                }));
            }
            State::Armed => EventKind::Finished,
            State::Idle => EventKind::Disarmed,
            State::Running | State::Stopping => return None,
        };
        self.running = None;
        Some(DeviceMessage::Event(Event {
            kind,
            tick: heard_tick,
            time_us: 0,
        }))
    }

    /// [`read`](Device::read) that ends within 0.4 s of listening once `stop` is set and no sample comes. While samples come it
    /// reads on, so that a loop can let its force fall.
    ///
    /// # Errors
    /// As `read`; [`LinkError::Stopped`], after the device was ordered to let go.
    pub fn read_or_stop<F: Real, const D: usize>(
        &mut self,
        stop: &AtomicBool,
    ) -> Result<Reading<F, D>, SerialError> {
        let mut patience = self.patience(SAMPLE_TIMEOUT);
        let mut stopping = self.patience(STOPPED);
        loop {
            match self.hear(patience.left().min(PAUSE)) {
                Some(DeviceMessage::Sample(sample)) => {
                    if let Some((tick, position_m)) = self.noted_sample::<D>(sample) {
                        return Ok(Reading {
                            tick: u64::from(tick),
                            time_s: f64::from(tick) * self.period_s(),
                            position_m: position_m.map(|axis| F::from_f64(f64::from(axis))),
                        });
                    }
                }
                Some(DeviceMessage::Over(error)) => return Err(error.into()),
                Some(DeviceMessage::Fault(report)) => return Err(LinkError::Faulted(report).into()),
                Some(DeviceMessage::Event(_)) | None => {}
            }
            let stops = stop.load(Ordering::Relaxed);
            if stops && self.is_silent(&mut stopping) {
                let _ = self.silent(STOPPED);
                return Err(LinkError::Stopped.into());
            }
            if !stops && self.is_silent(&mut patience) {
                return Err(self.silent(SAMPLE_TIMEOUT).into());
            }
        }
    }

    /// Sends a force of a host loop, N, one element per axis. It never waits; if the queue is full,
    /// the force is dropped and counted.
    pub fn send_force(&self, tick: u32, force_n: &[f32]) {
        let request = Request::Force {
            tick,
            // More than a device has axes are no force.
            force_n: heapless::Vec::from_slice(force_n).unwrap_or_default(),
        };
        if let Some(queue) = &self.commands
            && let Err(TrySendError::Full(_)) = queue.try_send(Command::Tell(request))
        {
            self.shared.forces_dropped.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Notes the answer to a tick, sent or not.
    pub(super) fn answered(&mut self, force_n: [f32; AXES_MAX]) {
        if self.newest_answers.len() == IN_TIME {
            self.newest_answers.pop_front();
        }
        self.newest_answers.push_back(force_n.map(f32::to_bits));
    }

    /// Notes what the device did in a sample, and gives its tick and position; `None` for one of another number of axes, or of a tick
    /// that was read.
    fn noted_sample<const D: usize>(&mut self, sample: Sample) -> Option<(u32, SVector<f32, D>)> {
        let was_read = !self.newest.axes.is_empty() && sample.tick <= self.newest.tick;
        if sample.axes.len() != D || was_read {
            return None;
        }
        self.newest = sample;
        let Sample { tick, axes, .. } = &self.newest;
        let held_n = of_axes(axes.iter().map(|axis| axis.environment_force_n));
        self.follows = self.newest_answers.contains(&held_n.map(f32::to_bits));
        Some((*tick, SVector::from_fn(|axis, _| axes[axis].position_m)))
    }
}

/// One element for each axis; 0 where it is missing.
fn of_axes(mut elements: impl Iterator<Item = f32>) -> [f32; AXES_MAX] {
    core::array::from_fn(|_| elements.next().unwrap_or(0.0))
}

/// A host loop: the position comes from the newest sample, the force goes out at once.
///
/// A reading's time is n·T of its tick. [`read`](Device::read) waits for the next sample, up to 2 s, and reads each
/// in order. A force is sent only if no newer sample has come: whoever has fallen behind catches up first. Samples of
/// another number of axes are ignored.
impl<F: Real, const D: usize> Device<F, D> for SerialLink {
    type Error = SerialError;

    fn read(&mut self) -> Result<Reading<F, D>, SerialError> {
        self.read_or_stop(&AtomicBool::new(false))
    }

    fn write(&mut self, force: SafeForce<F, D>) -> Result<(), SerialError> {
        let newtons = self.shared.newtons();
        let force_n = force.newtons().map(|axis| newtons.commanded(axis.to_f64()));
        // As the device will say that it holds them.
        let held_n = force_n.map(|axis| newtons.made(axis));
        self.answered(of_axes(held_n.iter().copied()));
        if self.ahead.is_none() {
            self.ahead = self.try_hear();
        }
        if matches!(self.ahead, Some(DeviceMessage::Sample(_))) {
            self.forces_skipped += 1;
            return Ok(());
        }
        self.send_force(self.newest.tick, force_n.as_slice());
        Ok(())
    }

    /// Sent whatever has come meanwhile.
    fn let_go(&mut self) {
        let none = [0.0; D];
        self.answered(of_axes(none.into_iter()));
        self.send_force(self.newest.tick, &none);
    }
}
