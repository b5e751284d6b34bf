//! The tick: time judged, a force or none, what is remembered of it, and how runs end.

use super::TickSide;
use crate::{
    hardware::Hardware,
    records::{Notice, Records, Stream, Tick},
};
use core::borrow::BorrowMut;
use haptic_link::{Event, EventKind, FaultReport, LoopMode, NOT_TAKEN, Reason, State, UNANSWERED};
use haptic_loop::{Fault, Limiters};
use nalgebra::SVector;

/// Number of ticks after a fault that are sent unasked: the host's record must not depend on how soon it asks.
const AFTERMATH_TICKS: u8 = 100;

impl<H: Hardware<D>, const D: usize, R: BorrowMut<Records<D>>> TickSide<H, D, R> {
    /// One tick, at this time since power-up.
    pub fn tick(&mut self, now_us: u64) {
        let began = self.hardware().cycles();
        self.judge_time(now_us);
        if matches!(self.state, State::Armed | State::Running) {
            let watchdog_us = u64::from(1000 * u32::from(self.configuration.limits.watchdog_ms));
            if now_us > self.heard_us.wrapping_add(watchdog_us) {
                self.trip(Fault::HostSilent);
            }
        }
        match self.act() {
            Ok(sample) => self.keep(sample),
            Err(fault) => self.fail(fault),
        }
        if let Some(fault) = self.safety().fault() {
            self.trip(fault);
        }
        self.settle();
        self.tick = self.tick.wrapping_add(1);
        let cycles = self.hardware().cycles().wrapping_sub(began);
        let statistics = &mut self.statistics;
        statistics.ticks = statistics.ticks.wrapping_add(1);
        statistics.tick_cycles_last = cycles;
        statistics.tick_cycles_max = statistics.tick_cycles_max.max(cycles);
    }

    /// Reports that periods have passed without a tick; call before the next [`tick`](Self::tick).
    /// They are numbered and part of a run, but have no samples, so a tick's number still gives its
    /// time. The law takes them in on the straight line from the last position to the next.
    pub fn skip(&mut self, periods: u32) {
        if let Some(exchange) = self.hardware_mut().exchange() {
            exchange.skip(periods);
        }
        self.engaged.controller_mut().skip(u64::from(periods));
        self.tick = self.tick.wrapping_add(periods);
        #[cfg(feature = "std")]
        {
            self.missed = periods;
        }
        if let Some(left) = &mut self.ticks_left {
            *left = left.saturating_sub(periods);
        }
    }

    /// Looks at the position between two ticks, for a program that measures more often: beyond a limit of it there is no force at
    /// once, not from the next tick on.
    pub fn look(&mut self) {
        let looked = self.hardware_mut().read();
        let closed = matches!(self.state, State::Running | State::Stopping);
        let looked = looked.and_then(|reading| {
            if closed {
                self.engaged.controller().strays(&reading.position_m)
            } else {
                Ok(())
            }
        });
        if let Err(fault) = looked {
            self.give_way(fault);
        }
    }

    /// Nothing ticked for longer than the watchdog time; call before the next [`tick`](Self::tick).
    /// The old force answered an old position, so it is dropped.
    pub fn stood_still(&mut self) {
        if self.state != State::Idle {
            self.give_way(Fault::HostSilent);
        }
    }

    /// Reports that the timer fired again before the tick was done; call after
    /// [`tick`](Self::tick). The next tick is late because of it and is not counted again.
    pub fn overrun(&mut self) {
        self.judged = true;
        self.late();
    }

    /// A [fault](Self::trip) in which the device's own program has a part.
    pub fn trip_because(&mut self, fault: Fault, reason: Reason) {
        if self.fault.is_none() {
            self.reason = reason;
        }
        self.trip(fault);
    }

    /// A fault that something else has found. Not inlined: it happens once, and the tick would have a copy at each place.
    #[inline(never)]
    pub fn trip(&mut self, fault: Fault) {
        if self.fault.is_some() {
            return;
        }
        self.engaged.controller_mut().trip(fault);
        self.fault = Some(fault);
        let ran = matches!(self.state, State::Running | State::Stopping);
        self.aftermath = if ran { AFTERMATH_TICKS } else { 0 };
        self.faults = self.faults.wrapping_add(1);
        self.state = State::Fault;
        self.records.borrow_mut().flight.fault();
        let notice = Notice::Fault(FaultReport {
            status: self.status(),
            tick: self.tick,
            time_us: self.now_us,
        });
        self.records.borrow_mut().outbox.notify(notice);
    }

    /// No force at all, at once, because none can be computed.
    #[inline(never)]
    pub(super) fn give_way(&mut self, fault: Fault) {
        self.engaged.let_go(fault);
        self.trip(fault);
    }

    /// The board could not measure or apply in a tick, which is kept with the last position.
    #[inline(never)]
    fn fail(&mut self, fault: Fault) {
        self.trip(fault);
        self.keep(Tick {
            tick: self.tick,
            time_us: self.now_us as u32,
            position_m: self.newest.position_m,
            limiters: Limiters::FAULT.bits(),
            ..Tick::NONE
        });
    }

    fn judge_time(&mut self, now_us: u64) {
        let period = u64::from(self.configuration.tick_period_us);
        let late_us = self.now_us.wrapping_add(2 * period);
        self.now_us = now_us;
        if core::mem::take(&mut self.judged) {
            return;
        }
        if now_us >= late_us {
            self.late();
        } else {
            self.late_in_row = 0;
        }
    }

    #[inline(never)]
    fn late(&mut self) {
        self.statistics.overruns = self.statistics.overruns.wrapping_add(1);
        self.late_in_row = self.late_in_row.saturating_add(1);
        let most = self.configuration.limits.late_ticks;
        let closed = matches!(self.state, State::Armed | State::Running);
        if closed && most > 0 && self.late_in_row >= most {
            self.trip(Fault::TickOverrun);
        }
    }

    /// Reads, and applies a force if there may be one. What the engaged loop refuses has let go already.
    fn act(&mut self) -> Result<Tick<D>, Fault> {
        #[cfg(feature = "std")]
        let missed = core::mem::take(&mut self.missed);
        let forced = match self.state {
            State::Running | State::Stopping => true,
            State::Fault => !self.is_at_rest(),
            State::Idle | State::Armed => false,
        };
        if let Some(exchange) = self.hardware_mut().exchange() {
            exchange.rests(!forced);
        }
        if !forced {
            return self.rest();
        }
        let commanded = match self.configuration.loop_mode {
            LoopMode::Device => None,
            LoopMode::Host => {
                if self.state == State::Running && !self.commanded_new {
                    self.statistics.stale_forces = self.statistics.stale_forces.wrapping_add(1);
                }
                self.commanded_new = false;
                Some(SVector::from(self.commanded_n))
            }
        };
        let exchange = self.hardware_mut().exchange();
        let unmeasured = exchange.map_or(0, |exchange| exchange.unmeasured());
        if unmeasured > 0 {
            self.engaged.controller_mut().unmeasured(unmeasured);
        }
        #[cfg(feature = "std")]
        let done = {
            let last_m = SVector::from(self.newest.position_m);
            (self.engaged).tick_after(missed, &last_m, commanded.as_ref())?
        };
        // A timer of a board misses none that it would not count as late.
        #[cfg(not(feature = "std"))]
        let done = self.engaged.tick_commanded(commanded.as_ref())?;
        let (tick, time_us) = (self.tick, self.now_us as u32);
        let (flaws, sensed_force_n) = (self.flaws(), self.hardware_mut().sense());
        Ok(Tick::of(&done, tick, time_us, flaws, sensed_force_n))
    }

    /// A tick while no force may act, which is in no hurry: the one that makes a force is laid out for speed.
    #[cold]
    fn rest(&mut self) -> Result<Tick<D>, Fault> {
        let idle = self.engaged.device_mut().idle();
        let reading = idle.inspect_err(|&fault| self.give_way(fault))?;
        Ok(Tick {
            tick: self.tick,
            time_us: self.now_us as u32,
            position_m: reading.position_m.into(),
            flaws: self.flaws(),
            sensed_force_n: self.hardware_mut().sense(),
            ..Tick::NONE
        })
    }

    /// Flaws of the exchange in this tick, counted: here for the boards of all makers.
    fn flaws(&mut self) -> u8 {
        let flaws = self
            .hardware_mut()
            .exchange()
            .map_or(0, |exchange| exchange.flaws());
        let statistics = &mut self.statistics;
        let unanswered = u32::from(flaws & UNANSWERED != 0);
        let not_taken = u32::from(flaws & NOT_TAKEN != 0);
        statistics.unanswered = statistics.unanswered.wrapping_add(unanswered);
        statistics.forces_not_taken = statistics.forces_not_taken.wrapping_add(not_taken);
        flaws
    }

    fn keep(&mut self, sample: Tick<D>) {
        self.newest = sample;
        self.records.borrow_mut().flight.take(sample);
        if self.stream().takes(sample.tick) && !self.records.borrow_mut().outbox.take(sample) {
            self.statistics.samples_dropped = self.statistics.samples_dropped.wrapping_add(1);
        }
        if self.state == State::Fault {
            self.outlive();
        }
    }

    /// One tick more after a fault. Not inlined: it would be part of every tick.
    #[inline(never)]
    fn outlive(&mut self) {
        self.aftermath = self.aftermath.saturating_sub(1);
    }

    pub(super) fn stream(&self) -> Stream {
        match self.state {
            State::Running | State::Stopping => self.run_stream,
            // Samples after a fault belong to the run that the fault ended.
            State::Fault if self.aftermath > 0 || !self.is_at_rest() => self.run_stream,
            State::Idle | State::Armed | State::Fault => self.idle_stream,
        }
    }

    fn settle(&mut self) {
        if self.state == State::Running
            && let Some(left) = &mut self.ticks_left
        {
            *left = left.saturating_sub(1);
            if *left == 0 {
                self.end(State::Armed, EventKind::Finished);
            }
        }
        if self.state == State::Stopping && self.is_at_rest() {
            let (state, kind) = self.after;
            self.state = state;
            self.event(kind);
        }
    }

    pub(super) fn end(&mut self, state: State, kind: EventKind) {
        self.engaged.controller_mut().stop();
        self.after = (state, kind);
        self.state = State::Stopping;
    }

    #[inline(never)]
    pub(super) fn event(&mut self, kind: EventKind) {
        self.records
            .borrow_mut()
            .outbox
            .notify(Notice::Event(Event {
                kind,
                tick: self.tick,
                time_us: self.now_us,
            }));
    }
}
