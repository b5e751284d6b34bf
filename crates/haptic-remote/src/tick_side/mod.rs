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
mod ticking;

#[cfg(feature = "controllers")]
use crate::holding::Holding;
use crate::{
    hardware::Hardware,
    prepared::{Law, Prepared, prepare},
    records::{Records, Stream, Tick},
    rendered::Rendered,
};
use core::borrow::BorrowMut;
use haptic_link::{
    Configuration, DeviceReport, EventKind, Reason, Refusal, Simulation, State, Statistics, Status,
    Trouble,
};
use haptic_loop::{Controller, Engaged, Fault, SafetyChain, SafetyState};

/// The loop of a device with D axes, one unless said: controller, states, watchdog, flight recorder, samples to be sent.
///
/// - *Start-up*: idle, zero force, [`Configuration::PASSIVE`]. *Dropped* it leaves no force behind: it holds an [`Engaged`].
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
/// device.start(Start::ENDLESS).expect("it is armed");
/// for tick in 1..=10 {
///     device.tick(1000 * tick);
/// }
/// assert_eq!(device.status().state, State::Running);
/// assert_eq!(device.newest().tick, 9);
/// ```
#[derive(Debug)]
pub struct TickSide<H: Hardware<D>, const D: usize = 1, R = Records<D>> {
    engaged: Engaged<f32, D, Rendered<D>, H>,
    configuration: Configuration,
    digest: u32,
    state: State,
    /// State after a stop, and its news.
    after: (State, EventKind),
    fault: Option<Fault>,
    faults: u16,
    /// Reason of the latched fault.
    reason: Reason,
    /// The last one started since it was armed, whether it has ended or not.
    run: Option<u32>,
    ticks_left: Option<u32>,
    tick: u32,
    now_us: u64,
    heard_us: u64,
    late_in_row: u16,
    /// Periods without a tick before the next one.
    #[cfg(feature = "std")]
    missed: u32,
    /// The interval up to the next tick is not to be judged: it has been, or its period has changed.
    judged: bool,
    commanded_n: [f32; D],
    commanded_new: bool,
    idle_stream: Stream,
    run_stream: Stream,
    /// Ticks after a fault that are still sent as those of the run it ended.
    aftermath: u8,
    newest: Tick<D>,
    records: R,
    statistics: Statistics,
}

impl<H: Hardware<D>, const D: usize> TickSide<H, D> {
    /// A device at power-up.
    ///
    /// # Errors
    /// If the board refuses its first configuration, which is a defect of the board.
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
        // A board may tick at a single rate.
        let period_us = passive.tick_period_us.max(capabilities.tick_period_min_us);
        passive.tick_period_us = period_us.min(capabilities.tick_period_max_us);
        let limits = &mut passive.limits;
        limits.force_n = limits.force_n.min(capabilities.force_max_n);
        limits.force_rate_n_per_s = limits
            .force_rate_n_per_s
            .min(capabilities.force_rate_max_n_per_s);
        if capabilities.simulated {
            passive.simulation = Simulation::TESTBED;
        }
        prepare::<H, D>(passive, &Self::PASSIVE, &capabilities)
    }
}

impl<H: Hardware<D>, const D: usize, R: BorrowMut<Records<D>>> TickSide<H, D, R> {
    /// A device before its power-up: no law, no configuration. For a stack without room to build it twice, before
    /// [`wake`](Self::wake).
    pub fn asleep(hardware: H, chain: SafetyChain<f32>, records: R) -> Self {
        const {
            assert!(
                D == 1 || cfg!(feature = "several-axes"),
                "several axes need their messages"
            );
        };
        Self {
            engaged: Controller::new(Rendered::of(Law::none()), chain).into_engaged(hardware),
            configuration: Configuration::PASSIVE,
            digest: 0,
            state: State::Idle,
            after: (State::Idle, EventKind::Disarmed),
            fault: None,
            faults: 0,
            reason: Reason::of(Trouble::Nothing),
            run: None,
            ticks_left: None,
            tick: 0,
            now_us: 0,
            heard_us: 0,
            late_in_row: 0,
            #[cfg(feature = "std")]
            missed: 0,
            judged: true,
            commanded_n: [0.0; D],
            commanded_new: false,
            idle_stream: Stream::OFF,
            run_stream: Stream::OFF,
            aftermath: 0,
            newest: Tick::NONE,
            records,
            statistics: Statistics::default(),
        }
    }

    /// Ends the power-up: this configuration takes effect with the prepared coefficients, without a
    /// report.
    #[inline(never)]
    pub fn wake(&mut self, prepared: Prepared<H::Setup>, coefficients: &[f32]) {
        let Prepared {
            configuration,
            digest,
            law,
            chain,
            setup,
            #[cfg(feature = "several-axes")]
            surface,
            #[cfg(feature = "controllers")]
            controller,
        } = prepared;
        self.engaged
            .controller_mut()
            .replace_within(chain, |rendered| {
                law.put(&mut rendered.wall, coefficients);
                #[cfg(feature = "several-axes")]
                {
                    // It was checked.
                    let made = surface.map(|surface| crate::surface::shape(&surface));
                    rendered.surface = made.and_then(Result::ok);
                }
                #[cfg(feature = "controllers")]
                {
                    // It was checked.
                    let made = controller.map(|law| Holding::new(&law, coefficients));
                    rendered.holding = made.and_then(Result::ok);
                }
            });
        self.configuration = configuration;
        self.digest = digest;
        self.judged = true;
        let hardware = self.engaged.device_mut();
        hardware.install(setup, configuration.tick_period_us);
    }

    /// Current state and fault, as in every answer.
    #[must_use]
    pub fn status(&self) -> Status {
        Status {
            state: self.state,
            fault: self.fault.map_or(0, Fault::code),
            faults: self.faults,
            reason: self.reason,
        }
    }

    /// When the host was last heard as its watchdog counts it, µs: while a host loop runs, with a force.
    #[must_use]
    pub const fn heard_us(&self) -> u64 {
        self.heard_us
    }

    /// The configuration in force and its digest.
    #[must_use]
    pub const fn configuration(&self) -> (&Configuration, u32) {
        (&self.configuration, self.digest)
    }

    /// A coefficient of the operator in force.
    #[must_use]
    pub fn coefficient(&self, index: usize) -> Option<f32> {
        self.engaged
            .controller()
            .environment()
            .wall
            .inner()
            .operator()
            .value(index)
    }

    /// The board, to read what its own interrupts have found.
    pub const fn hardware(&self) -> &H {
        self.engaged.device()
    }

    /// The time that a controller takes; `None` if the device cannot run one, as with several axes.
    #[cfg(feature = "controllers")]
    pub fn controller_cost(&self) -> Option<haptic_link::ControllerCost> {
        self.hardware().controller_cost().filter(|_| D == 1)
    }

    /// The board, to let it take what its own interrupts have found.
    pub const fn hardware_mut(&mut self) -> &mut H {
        self.engaged.device_mut()
    }

    /// Counters of ticks and samples; the session adds the line's.
    #[must_use]
    pub const fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// The energy that the passivity guard has observed, J; 0 without one.
    #[must_use]
    pub fn observed_energy_j(&self) -> f32 {
        self.safety().observed_energy_j()
    }

    /// No force acts, and a device that moves is at rest.
    fn is_at_rest(&self) -> bool {
        self.safety().is_at_rest() && !self.hardware().moves()
    }

    fn safety(&self) -> &SafetyState<f32, D> {
        self.engaged.controller().safety()
    }

    /// The last tick; zeros before the first.
    #[must_use]
    pub const fn newest(&self) -> &Tick<D> {
        &self.newest
    }

    /// The answer to a question for a sample of the flight recorder, 0 the oldest. It has none before a fault has latched.
    ///
    /// # Errors
    /// An index behind its end.
    pub fn flight(&self, index: u16) -> Result<DeviceReport, Refusal> {
        self.records.borrow().flight.read(index)
    }

    /// The next thing to say, oldest first: events and faults, then samples.
    pub fn next_report(&mut self) -> Option<DeviceReport> {
        let more = matches!(self.state, State::Running | State::Stopping);
        let stream = self.stream();
        self.records.borrow_mut().outbox.next(stream, more)
    }
}
