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

use crate::flight::FlightRecorder;
use crate::hardware::Hardware;
use crate::outbox::{Notice, Outbox, Stream};
use crate::prepared::{DeviceWall, Prepared, prepare};
use haptic_link::{
    Configuration, Event, EventKind, FaultReport, Field, Flight, LoopMode, Refusal, Report, Sample,
    Simulation, Start, State, Statistics, Status,
};
use haptic_loop::{Controller, Fault};
use nalgebra::SVector;

/// So many ticks after a fault are sent unasked: what a host keeps of them must not depend on how soon it asks.
const AFTERMATH_TICKS: u8 = 100;

/// Where a stop leads.
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
#[derive(Debug)]
pub struct TickSide<H: Hardware> {
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
    outbox: Outbox,
    flight: FlightRecorder,
    statistics: Statistics,
}

impl<H: Hardware> TickSide<H> {
    /// A device at power-up.
    ///
    /// # Errors
    /// If the board cannot be without a configuration, which is a defect of the board.
    pub fn new(hardware: H) -> Result<Self, Refusal> {
        let passive = Self::passive(&hardware)?;
        Ok(Self::with(hardware, passive))
    }

    /// What a board does without a configuration: no force, its plant at rest.
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
        prepare::<H>(passive, &[0.0], &capabilities)
    }

    /// A device at power-up, with this configuration: where there is no room to build it twice.
    pub fn with(mut hardware: H, prepared: Prepared<H::Setup>) -> Self {
        let Prepared {
            configuration,
            digest,
            wall,
            chain,
            setup,
        } = prepared;
        hardware.install(setup, configuration.tick_period_us);
        Self {
            hardware,
            controller: Controller::new(wall, chain),
            configuration,
            digest,
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
            outbox: Outbox::default(),
            flight: FlightRecorder::default(),
            statistics: Statistics::default(),
        }
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
            Err(fault) => self.give_way(fault),
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

    /// The timer fired again before the tick was done. To be told after [`tick`](Self::tick); the next one,
    /// which then begins late, is not counted once more.
    pub fn overrun(&mut self) {
        self.judged = true;
        self.late();
    }

    /// A fault that something else has found.
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
        self.flight.fault();
        self.outbox.notify(Notice::Fault(FaultReport {
            status: self.status(),
            tick: self.tick,
            time_us: self.now_us,
        }));
    }

    /// The board cannot measure or apply: no force at all, at once, because none can be computed.
    fn give_way(&mut self, fault: Fault) {
        self.trip(fault);
        self.hardware.let_go();
        self.controller.let_go();
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
        self.flight.take(sample);
        if self.stream().takes(sample.tick) && !self.outbox.take(sample) {
            self.statistics.samples_dropped = self.statistics.samples_dropped.wrapping_add(1);
        }
        if self.state == State::Fault {
            self.aftermath = self.aftermath.saturating_sub(1);
        }
    }

    fn stream(&self) -> Stream {
        match self.state {
            State::Running | State::Stopping => self.run_stream,
            // What follows a fault belongs to the run that it ended.
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

    fn event(&mut self, kind: EventKind) {
        self.outbox.notify(Notice::Event(Event {
            kind,
            tick: self.tick,
            time_us: self.now_us,
        }));
    }

    /// The host was heard at this time. While a host loop runs only its forces count.
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
            state => return Err(Refusal::State(state)),
        }
        if faults != self.faults {
            return Err(Refusal::UnknownFault);
        }
        if !self.controller.safety().is_at_rest() {
            return Err(Refusal::ForceNotZero);
        }
        if let Some(fault) = self.hardware.persisting_fault() {
            return Err(Refusal::FaultPersists(fault.code()));
        }
        self.controller.reset();
        self.fault = None;
        self.run = None;
        self.flight.clear();
        self.late_in_row = 0;
        self.state = State::Armed;
        self.event(EventKind::Armed);
        Ok(())
    }

    /// See [`Request::Disarm`](haptic_link::Request::Disarm). A latched fault stays.
    pub fn disarm(&mut self) {
        match self.state {
            State::Armed => {
                self.state = State::Idle;
                self.event(EventKind::Disarmed);
            }
            State::Running => self.end(After::Idle),
            State::Stopping => self.after = After::Idle,
            State::Idle | State::Fault => {}
        }
    }

    /// See [`Request::Start`](haptic_link::Request::Start).
    ///
    /// # Errors
    /// As there, and a stream that is none.
    pub fn start(&mut self, start: Start) -> Result<(), Refusal> {
        match self.state {
            // Sent again because the answer was lost: true already, even if it has ended.
            State::Armed | State::Running | State::Stopping if self.run == Some(start.run) => {
                return Ok(());
            }
            State::Armed => {}
            state => return Err(Refusal::State(state)),
        }
        let stream = Stream::new(start.every, start.batch)?;
        if stream.every == 0 {
            return Err(Refusal::Unsupported(Field::Every));
        }
        self.controller.reset();
        self.hardware.restart();
        self.may_start()?;
        self.outbox.forget_samples();
        self.flight.clear();
        self.run = Some(start.run);
        self.ticks_left = (start.ticks > 0).then_some(start.ticks);
        self.run_stream = stream;
        self.tick = 0;
        (self.commanded_n, self.commanded_new) = (0.0, false);
        self.state = State::Running;
        self.event(EventKind::Started);
        Ok(())
    }

    /// Whether the force of a device loop would be small where the device is now. A force of the host's is
    /// zero at first.
    #[inline(never)]
    fn may_start(&mut self) -> Result<(), Refusal> {
        if self.configuration.loop_mode == LoopMode::Host {
            return Ok(());
        }
        let reading = match self.hardware.idle() {
            Ok(reading) => reading,
            Err(fault) => {
                self.give_way(fault);
                return Err(Refusal::State(State::Fault));
            }
        };
        self.controller
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
                self.end(After::Armed(EventKind::Stopped));
                Ok(())
            }
            State::Stopping | State::Armed => Ok(()),
            State::Idle | State::Fault => Err(Refusal::State(self.state)),
        }
    }

    /// See [`Request::Force`](haptic_link::Request::Force). Ignored unless a host loop runs, and when it answers no
    /// tick of this run. One that is older than [`Limits::max_age_ticks`](haptic_link::Limits) latches
    /// [`Fault::StaleForce`]. Whether it will be applied.
    pub fn command(&mut self, tick: u32, force_n: f32) -> bool {
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
    ///
    /// # Errors
    /// A batch that is none.
    pub fn stream_idle(&mut self, every: u16, batch: u8) -> Result<(), Refusal> {
        self.idle_stream = Stream::new(every, batch)?;
        if every == 0 && matches!(self.state, State::Idle | State::Armed | State::Fault) {
            self.outbox.forget_samples();
        }
        Ok(())
    }

    /// Whether a configuration can take effect now.
    ///
    /// # Errors
    /// While armed, running or stopping, and in a fault before the force is zero.
    pub fn may_install(&self) -> Result<(), Refusal> {
        match self.state {
            State::Idle => Ok(()),
            State::Fault if self.controller.safety().is_at_rest() => Ok(()),
            State::Fault => Err(Refusal::ForceNotZero),
            state => Err(Refusal::State(state)),
        }
    }

    /// Makes a configuration take effect. A latched fault stays.
    ///
    /// # Errors
    /// As [`may_install`](Self::may_install).
    pub fn install(&mut self, prepared: Prepared<H::Setup>) -> Result<(), Refusal> {
        self.may_install()?;
        let Prepared {
            configuration,
            digest,
            wall,
            chain,
            setup,
        } = prepared;
        self.controller.replace(wall, chain);
        if let Some(fault) = self.fault {
            self.controller.trip(fault);
        }
        self.configuration = configuration;
        self.digest = digest;
        self.judged = true;
        self.hardware.install(setup, configuration.tick_period_us);
        self.event(EventKind::Configured);
        Ok(())
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

    /// What this side has counted.
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
        self.flight.read(index)
    }

    /// The next thing to say, oldest first: events and faults, then samples.
    pub fn next_report(&mut self) -> Option<Report> {
        let more = matches!(self.state, State::Running | State::Stopping);
        self.outbox.next(self.stream(), more)
    }
}
