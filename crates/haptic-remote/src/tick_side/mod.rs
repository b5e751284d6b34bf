//! The device's loop: what runs in the tick interrupt.
//!
//! ```text
//!            arm               start                 all ticks done, stop        force zero
//!   Idle ─────────▶ Armed ─────────────▶ Running ────────────────────▶ Stopping ──────────▶ Armed
//!    ▲                │ disarm               │ disarm ─▶ Stopping ─▶ Idle
//!    └────────────────┘                      │ any fault, from any state
//!                                            ▼
//!   Armed ◀── arm, force zero ─────────── Fault
//! ```

mod requests;

use crate::hardware::Hardware;
use crate::outbox::{Notice, Stream};
use crate::prepared::{DeviceWall, Law, Prepared, prepare};
use crate::records::Records;
use core::borrow::BorrowMut;
use haptic_link::{
    Configuration, Event, EventKind, FaultReport, Flight, LoopMode, Refusal, Report, Sample,
    Simulation, State, Statistics, Status,
};
use haptic_loop::{Controller, Fault, Limiters, SafetyChain};
use nalgebra::SVector;

/// So many ticks after a fault are sent unasked: what a host keeps of them must not depend on how soon it asks.
const AFTERMATH_TICKS: u8 = 100;

/// State after a stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum After {
    Armed(EventKind),
    Idle,
}

/// The loop of a device with one axis: controller, states, watchdog, flight recorder, samples to be sent.
///
/// - *Start-up*: idle, zero force, [`Configuration::PASSIVE`].
/// - *Watchdog*: armed or running, silence longer than [`Limits::watchdog_ms`](haptic_link::Limits) latches
///   [`Fault::HostSilent`].
/// - *Cost* of a tick: controller and hardware, and some 50 operations; no allocation, no panic. Memory:
///   about 7 KiB, of which the operator and its history 3 KiB.
///
/// ```
/// use haptic_link::{Start, State};
/// use haptic_remote::{SimulatedPlant, TickSide};
///
/// let plant = SimulatedPlant::new("demo", || 0);
/// let mut device = TickSide::new(plant).expect("a simulated board always starts");
/// device.arm(0).expect("nothing is wrong");
/// device
///     .start(Start { run: 1, ticks: 0, every: 1, batch: 1 })
///     .expect("it is armed");
/// for tick in 1..=10 {
///     device.tick(1000 * tick);
/// }
/// assert_eq!(device.status().state, State::Running);
/// assert_eq!(device.newest().tick, 9);
/// ```
#[derive(Debug)]
pub struct TickSide<H: Hardware, R = Records> {
    hardware: H,
    controller: Controller<f32, 1, DeviceWall>,
    configuration: Configuration,
    digest: u32,
    state: State,
    after: After,
    fault: Option<Fault>,
    faults: u16,
    /// The last one started since it was armed, whether it has ended or not.
    run: Option<u32>,
    ticks_left: Option<u32>,
    tick: u32,
    now_us: u64,
    heard_us: u64,
    late_in_row: u16,
    /// The interval up to the next tick is not to be judged: it has been, or its period has changed.
    judged: bool,
    commanded_n: f32,
    commanded_new: bool,
    idle_stream: Stream,
    run_stream: Stream,
    /// Ticks after a fault that are still sent as those of the run it ended.
    aftermath: u8,
    newest: Sample,
    records: R,
    statistics: Statistics,
}

impl<H: Hardware> TickSide<H> {
    /// A device at power-up.
    ///
    /// # Errors
    /// If the board cannot be without a configuration, which is a defect of the board.
    pub fn new(hardware: H) -> Result<Self, Refusal> {
        let passive = Self::passive(&hardware)?;
        let mut device = Self::asleep(hardware, passive.chain, Records::new());
        device.wake(passive, &Self::PASSIVE);
        Ok(device)
    }

    /// Coefficients of a board without a configuration.
    pub const PASSIVE: [f32; 1] = [0.0];

    /// Prepared state of a board without a configuration: no force, its plant at rest.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn passive(hardware: &H) -> Result<Prepared<H::Setup>, Refusal> {
        let capabilities = hardware.capabilities();
        let mut passive = Configuration::PASSIVE;
        let limits = &mut passive.limits;
        limits.force_n = limits.force_n.min(capabilities.force_max_n);
        limits.force_rate_n_per_s = limits
            .force_rate_n_per_s
            .min(capabilities.force_rate_max_n_per_s);
        if capabilities.simulated {
            passive.simulation = Simulation::TESTBED;
        }
        prepare::<H>(passive, &Self::PASSIVE, &capabilities)
    }
}

impl<H: Hardware, R: BorrowMut<Records>> TickSide<H, R> {
    /// A device before its power-up is done: no law and no configuration yet. For a stack without room to build it twice:
    /// first this, in its place, then [`wake`](Self::wake).
    pub fn asleep(hardware: H, chain: SafetyChain<f32>, records: R) -> Self {
        Self {
            hardware,
            controller: Controller::new(Law::none(), chain),
            configuration: Configuration::PASSIVE,
            digest: 0,
            state: State::Idle,
            after: After::Idle,
            fault: None,
            faults: 0,
            run: None,
            ticks_left: None,
            tick: 0,
            now_us: 0,
            heard_us: 0,
            late_in_row: 0,
            judged: true,
            commanded_n: 0.0,
            commanded_new: false,
            idle_stream: Stream::OFF,
            run_stream: Stream::OFF,
            aftermath: 0,
            newest: Sample::default(),
            records,
            statistics: Statistics::default(),
        }
    }

    /// Power-up is done: this configuration is in force with the coefficients that were prepared, whatever there was before,
    /// and nobody is told.
    #[inline(never)]
    pub fn wake(&mut self, prepared: Prepared<H::Setup>, coefficients: &[f32]) {
        let Prepared {
            configuration,
            digest,
            law,
            chain,
            setup,
        } = prepared;
        self.controller
            .replace_within(chain, |wall| law.put(wall, coefficients));
        self.configuration = configuration;
        self.digest = digest;
        self.judged = true;
        self.hardware.install(setup, configuration.tick_period_us);
    }

    /// One tick, at this time since power-up.
    pub fn tick(&mut self, now_us: u64) {
        let began = self.hardware.cycles();
        self.judge_time(now_us);
        if matches!(self.state, State::Armed | State::Running) {
            let watchdog_us = 1000 * u64::from(self.configuration.limits.watchdog_ms);
            if now_us.saturating_sub(self.heard_us) > watchdog_us {
                self.trip(Fault::HostSilent);
            }
        }
        match self.act() {
            Ok(sample) => self.keep(sample),
            Err(fault) => self.fail(fault),
        }
        if let Some(fault) = self.controller.safety().fault() {
            self.trip(fault);
        }
        self.settle();
        self.tick = self.tick.wrapping_add(1);
        let cycles = self.hardware.cycles().wrapping_sub(began);
        let statistics = &mut self.statistics;
        statistics.ticks = statistics.ticks.wrapping_add(1);
        statistics.tick_cycles_last = cycles;
        statistics.tick_cycles_max = statistics.tick_cycles_max.max(cycles);
    }

    /// Periods have passed without a tick. To be told before the next [`tick`](Self::tick): they have their numbers and their part of
    /// a run, but no samples, so that a tick's number is its time whatever happened.
    pub fn skip(&mut self, periods: u32) {
        self.tick = self.tick.wrapping_add(periods);
        if let Some(left) = &mut self.ticks_left {
            *left = left.saturating_sub(periods);
        }
    }

    /// The timer fired again before the tick was done. To be told after [`tick`](Self::tick); the next one,
    /// which then begins late, is not counted once more.
    pub fn overrun(&mut self) {
        self.judged = true;
        self.late();
    }

    /// A fault that something else has found. Not inlined: it happens once, and the tick would have a copy at each place.
    #[inline(never)]
    pub fn trip(&mut self, fault: Fault) {
        if self.fault.is_some() {
            return;
        }
        self.controller.trip(fault);
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

    /// The board cannot measure or apply: no force at all, at once, because none can be computed.
    #[inline(never)]
    fn give_way(&mut self, fault: Fault) {
        self.trip(fault);
        self.hardware.let_go();
        self.controller.let_go();
    }

    /// The same in a tick, which is kept with the last position.
    #[inline(never)]
    fn fail(&mut self, fault: Fault) {
        self.give_way(fault);
        self.keep(Sample {
            tick: self.tick,
            time_us: self.now_us as u32,
            position_m: self.newest.position_m,
            limiters: Limiters::FAULT.bits(),
            ..Sample::default()
        });
    }

    fn judge_time(&mut self, now_us: u64) {
        let period = u64::from(self.configuration.tick_period_us);
        let passed = now_us.saturating_sub(self.now_us);
        self.now_us = now_us;
        if core::mem::take(&mut self.judged) {
            return;
        }
        if passed >= 2 * period {
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

    /// Reads, and applies a force if there may be one.
    fn act(&mut self) -> Result<Sample, Fault> {
        let forced = match self.state {
            State::Running | State::Stopping => true,
            State::Fault => !self.controller.safety().is_at_rest(),
            State::Idle | State::Armed => false,
        };
        let mut sample = Sample {
            tick: self.tick,
            time_us: self.now_us as u32,
            ..Sample::default()
        };
        if !forced {
            sample.position_m = self.hardware.idle()?.position_m[0];
            return Ok(sample);
        }
        let commanded = match self.configuration.loop_mode {
            LoopMode::Device => None,
            LoopMode::Host => {
                if self.state == State::Running && !self.commanded_new {
                    self.statistics.stale_forces = self.statistics.stale_forces.wrapping_add(1);
                }
                self.commanded_new = false;
                Some(SVector::from([self.commanded_n]))
            }
        };
        let done = self
            .controller
            .tick_either(&mut self.hardware, commanded.as_ref())?;
        sample.position_m = done.reading.position_m[0];
        sample.environment_force_n = done.environment_force_n[0];
        sample.force_n = done.force.newtons()[0];
        sample.limiters = done.limiters.bits();
        Ok(sample)
    }

    /// Flight recorder and stream.
    fn keep(&mut self, sample: Sample) {
        self.newest = sample;
        self.records.borrow_mut().flight.take(sample);
        if self.stream().takes(sample.tick) && !self.records.borrow_mut().outbox.take(sample) {
            self.statistics.samples_dropped = self.statistics.samples_dropped.wrapping_add(1);
        }
        if self.state == State::Fault {
            self.aftermath = self.aftermath.saturating_sub(1);
        }
    }

    fn stream(&self) -> Stream {
        match self.state {
            State::Running | State::Stopping => self.run_stream,
            // Samples after a fault belong to the run that the fault ended.
            State::Fault if self.aftermath > 0 || !self.controller.safety().is_at_rest() => {
                self.run_stream
            }
            _ => self.idle_stream,
        }
    }

    /// Ends runs and stops.
    fn settle(&mut self) {
        if self.state == State::Running
            && let Some(left) = &mut self.ticks_left
        {
            *left = left.saturating_sub(1);
            if *left == 0 {
                self.end(After::Armed(EventKind::Finished));
            }
        }
        if self.state == State::Stopping && self.controller.safety().is_at_rest() {
            let (state, kind) = match self.after {
                After::Armed(kind) => (State::Armed, kind),
                After::Idle => (State::Idle, EventKind::Disarmed),
            };
            self.state = state;
            self.event(kind);
        }
    }

    fn end(&mut self, after: After) {
        self.controller.stop();
        self.after = after;
        self.state = State::Stopping;
    }

    #[inline(never)]
    fn event(&mut self, kind: EventKind) {
        self.records
            .borrow_mut()
            .outbox
            .notify(Notice::Event(Event {
                kind,
                tick: self.tick,
                time_us: self.now_us,
            }));
    }

    /// State and fault.
    #[must_use]
    pub fn status(&self) -> Status {
        Status {
            state: self.state,
            fault: self.fault.map_or(0, Fault::code),
            faults: self.faults,
        }
    }

    /// The configuration in force and its digest.
    #[must_use]
    pub const fn configuration(&self) -> (&Configuration, u32) {
        (&self.configuration, self.digest)
    }

    /// A coefficient of the operator in force.
    #[must_use]
    pub fn coefficient(&self, index: usize) -> Option<f32> {
        self.controller.environment().operator().value(index)
    }

    /// The board.
    pub const fn hardware(&self) -> &H {
        &self.hardware
    }

    /// The board, to let it take what its own interrupts have found.
    pub const fn hardware_mut(&mut self) -> &mut H {
        &mut self.hardware
    }

    /// Counters of this side.
    #[must_use]
    pub const fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// The energy that the passivity guard has observed, J; 0 without one.
    #[must_use]
    pub fn observed_energy_j(&self) -> f32 {
        self.controller.safety().observed_energy_j()
    }

    /// The last tick; zeros before the first.
    #[must_use]
    pub const fn newest(&self) -> &Sample {
        &self.newest
    }

    /// A sample of the flight recorder, 0 the oldest. It has none before a fault has latched.
    ///
    /// # Errors
    /// An index behind its end.
    pub fn flight(&self, index: u16) -> Result<Flight, Refusal> {
        self.records.borrow().flight.read(index)
    }

    /// The next thing to say, oldest first: events and faults, then samples.
    pub fn next_report(&mut self) -> Option<Report> {
        let more = matches!(self.state, State::Running | State::Stopping);
        let stream = self.stream();
        self.records.borrow_mut().outbox.next(stream, more)
    }
}
