//! The device's loop as a host moves it: arm, start, stop, forces, configurations.

use super::TickSide;
use crate::{
    hardware::Hardware,
    prepared::Prepared,
    records::{Records, Stream},
};
use core::borrow::BorrowMut;
use haptic_link::{EventKind, Field, LoopMode, Reason, Refusal, Start, State, Trouble};
use haptic_loop::Fault;

impl<H: Hardware<D>, const D: usize, R: BorrowMut<Records<D>>> TickSide<H, D, R> {
    /// Notes that the host was heard at this time. While a host loop runs, only its forces count.
    pub fn heard(&mut self, now_us: u64, is_force: bool) {
        let host_loop = self.configuration.loop_mode == LoopMode::Host;
        if is_force || !(host_loop && self.state == State::Running) {
            self.heard_us = self.heard_us.max(now_us);
        }
    }

    /// See [`Request::Arm`](haptic_link::Request::Arm).
    ///
    /// # Errors
    /// As there.
    pub fn arm(&mut self, faults: u16) -> Result<(), Refusal> {
        match self.state {
            State::Armed => return Ok(()),
            State::Idle | State::Fault => {}
            State::Running | State::Stopping => return Err(Refusal::State(self.state)),
        }
        if faults != self.faults {
            return Err(Refusal::UnknownFault);
        }
        if !self.is_at_rest() {
            return Err(Refusal::ForceNotZero);
        }
        // A board that was reset took the place where it stood for its zero.
        let reset = self.fault.filter(|&fault| fault == Fault::Reset);
        if let Some(fault) = reset.or_else(|| self.hardware().persisting_fault()) {
            return Err(Refusal::FaultPersists(fault.code()));
        }
        self.engaged.controller_mut().reset();
        self.fault = None;
        self.reason = Reason::of(Trouble::Nothing);
        self.run = None;
        self.records.borrow_mut().flight.clear();
        self.late_in_row = 0;
        self.state = State::Armed;
        self.event(EventKind::Armed);
        Ok(())
    }

    /// See [`Request::Disarm`](haptic_link::Request::Disarm). A latched fault stays.
    pub fn disarm(&mut self) {
        self.end_idle(EventKind::Disarmed);
    }

    /// Disarms as [`disarm`](Self::disarm) does, but by the device's own program and not by its host.
    pub fn withdraw(&mut self) {
        self.end_idle(EventKind::Withdrawn);
    }

    fn end_idle(&mut self, kind: EventKind) {
        match self.state {
            State::Armed => {
                self.state = State::Idle;
                self.event(kind);
            }
            State::Running => self.end(State::Idle, kind),
            State::Stopping => self.after = (State::Idle, kind),
            State::Idle | State::Fault => {}
        }
    }

    /// See [`Request::Start`](haptic_link::Request::Start).
    ///
    /// # Errors
    /// As there, and an invalid stream.
    pub fn start(&mut self, start: Start) -> Result<(), Refusal> {
        match self.state {
            // Sent again because the answer was lost: true already, even if it has ended.
            State::Armed | State::Running | State::Stopping if self.run == Some(start.run) => {
                return Ok(());
            }
            State::Armed => {}
            State::Idle | State::Running | State::Stopping | State::Fault => {
                return Err(Refusal::State(self.state));
            }
        }
        let stream = Stream::new(start.every, start.batch)?;
        if stream.every == 0 {
            return Err(Refusal::Unsupported(Field::Every));
        }
        self.engaged.controller_mut().reset();
        self.hardware_mut().restart();
        self.may_start()?;
        self.hardware_mut().drive()?;
        self.records.borrow_mut().outbox.forget_samples();
        self.records.borrow_mut().flight.clear();
        self.run = Some(start.run);
        self.ticks_left = (start.ticks > 0).then_some(start.ticks);
        self.run_stream = stream;
        self.tick = 0;
        (self.commanded_n, self.commanded_new) = ([0.0; D], false);
        self.state = State::Running;
        self.event(EventKind::Started);
        Ok(())
    }

    /// Settles a device loop where the device is, and checks that its force would be small here; that of a host loop is zero at first.
    #[inline(never)]
    fn may_start(&mut self) -> Result<(), Refusal> {
        if self.configuration.loop_mode == LoopMode::Host {
            return Ok(());
        }
        let reading = match self.hardware_mut().idle() {
            Ok(reading) => reading,
            Err(fault) => {
                self.give_way(fault);
                return Err(Refusal::State(State::Fault));
            }
        };
        let controller = self.engaged.controller_mut();
        controller.settle(&reading);
        controller
            .may_start(&reading)
            .map_err(|refused| Refusal::ForceNotSmall {
                wanted_n: refused.wanted_n as f32,
                allowed_n: refused.allowed_n as f32,
            })
    }

    /// See [`Request::Stop`](haptic_link::Request::Stop).
    ///
    /// # Errors
    /// When idle or in a fault: nothing runs.
    pub fn stop(&mut self) -> Result<(), Refusal> {
        match self.state {
            State::Running => {
                self.end(State::Armed, EventKind::Stopped);
                Ok(())
            }
            State::Stopping | State::Armed => Ok(()),
            State::Idle | State::Fault => Err(Refusal::State(self.state)),
        }
    }

    /// See [`Request::Force`](haptic_link::Request::Force). Ignored unless a host loop runs and the tick is of this
    /// run. One older than [`Limits::max_age_ticks`](haptic_link::Limits) latches [`Fault::StaleForce`]. Whether it
    /// will be applied.
    pub fn command(&mut self, tick: u32, force_n: [f32; D]) -> bool {
        let host_loop = self.configuration.loop_mode == LoopMode::Host;
        if !(host_loop && self.state == State::Running) {
            return false;
        }
        // From the tick that it answers to the one that applies it.
        let age = self.tick.wrapping_sub(tick);
        if age == 0 || age > u32::MAX / 2 {
            return false;
        }
        if age > u32::from(self.configuration.limits.max_age_ticks) {
            self.trip(Fault::StaleForce);
            return false;
        }
        self.commanded_n = force_n;
        self.commanded_new = true;
        true
    }

    /// See [`Request::Stream`](haptic_link::Request::Stream).
    pub(crate) fn stream_idle(&mut self, every: u16, batch: u8) -> Result<(), Refusal> {
        self.idle_stream = Stream::new(every, batch)?;
        if every == 0 && matches!(self.state, State::Idle | State::Armed | State::Fault) {
            self.records.borrow_mut().outbox.forget_samples();
        }
        Ok(())
    }

    /// Checks that a configuration can take effect now.
    pub(crate) fn may_install(&self) -> Result<(), Refusal> {
        match self.state {
            State::Idle => Ok(()),
            State::Fault if self.is_at_rest() => Ok(()),
            State::Fault => Err(Refusal::ForceNotZero),
            state @ (State::Armed | State::Running | State::Stopping) => Err(Refusal::State(state)),
        }
    }

    /// Makes a configuration take effect with the coefficients that were prepared. A latched fault stays.
    ///
    /// # Errors
    /// While armed, running or stopping, and in a fault before the force is zero.
    pub fn install(
        &mut self,
        prepared: Prepared<H::Setup>,
        coefficients: &[f32],
    ) -> Result<(), Refusal> {
        self.may_install()?;
        self.wake(prepared, coefficients);
        if let Some(fault) = self.fault {
            self.engaged.controller_mut().trip(fault);
        }
        self.event(EventKind::Configured);
        Ok(())
    }
}
