//! Functions of a board that the device's end of the link needs, and the exchange with one behind a line of its own.

use haptic_link::{
    Capabilities, Field, NOT_TAKEN, Refusal, SerialNumber, Simulation, SimulationKind, UNANSWERED,
};
use haptic_loop::{Device, Fault, Reading};

/// A board: sensors and actuators of D axes, or a simulation of them. More than one axis needs the feature
/// `several-axes`.
///
/// [`read`](Device::read) and [`write`](Device::write) are called once a tick, in this order. An
/// error of theirs, or of [`idle`](Self::idle), is a latching fault, and the board is made to [let
/// go](Device::let_go) at each such tick.
pub trait Hardware<const D: usize = 1>: Device<f32, D, Error = Fault> {
    /// Plant that a configuration may ask for; `()` on a board that simulates nothing.
    type Setup: PlantSetup;

    /// Name and abilities of the board.
    fn capabilities(&self) -> Capabilities;

    /// The number that tells this device from others of its kind: the unique number of its chip or flash, or that which its maker
    /// gave it. Limits and calibrations of a device are kept under it, so it must not change.
    fn serial_number(&self) -> SerialNumber {
        SerialNumber::NONE
    }

    /// The time that a controller takes; `None` where none is run. Devices of one axis only.
    #[cfg(feature = "controllers")]
    fn controller_cost(&self) -> Option<haptic_link::ControllerCost> {
        None
    }

    /// Adapts the prepared setup to this very board, such as an emulated one that can be any of several devices; outside the
    /// tick too.
    ///
    /// # Errors
    /// A plant that this board cannot be.
    fn fit(&self, setup: &mut Self::Setup) -> Result<(), Refusal> {
        let _ = setup;
        Ok(())
    }

    /// Takes over what was prepared, between two ticks. From then on ticks come at this period.
    fn install(&mut self, setup: Self::Setup, tick_period_us: u32);

    /// The exchange with a board behind a line of its own; `None` where this is the board.
    fn exchange(&mut self) -> Option<&mut Exchange> {
        None
    }

    /// A run begins: a simulated plant goes back to its start.
    fn restart(&mut self);

    /// A device that moves is driven from here on, where it stands: the last thing before a run.
    ///
    /// # Errors
    /// It must not move now, as with a force sensor that has not rested.
    fn drive(&mut self) -> Result<(), Refusal> {
        Ok(())
    }

    /// One tick while no force may act: makes sure of that, and reads. A simulated plant stands still.
    ///
    /// # Errors
    /// Fault of the board.
    fn idle(&mut self) -> Result<Reading<f32, D>, Fault>;

    /// Force of the hand on each axis, N, positive along the position, as the board's force sensor shows it: measured when the last
    /// [`read`](Device::read) or [`idle`](Self::idle) was, and asked for once a tick behind the force. NaN without a sensor, and where it
    /// gave nothing in this tick; 0 N would look like a measurement. Give its range in
    /// [`sensed_force_max_n`](Capabilities::sensed_force_max_n).
    fn sense(&mut self) -> [f32; D] {
        [f32::NAN; D]
    }

    /// Fault whose condition still holds, such as an open emergency stop, or an encoder that has lost counts and with them its zero;
    /// `None` if there is no such fault. Nobody can arm the device before.
    fn persisting_fault(&self) -> Option<Fault> {
        None
    }

    /// Counts processor cycles, modulo 2³²; 0 for ever where nothing counts them.
    fn cycles(&self) -> u32 {
        0
    }
}

/// A plant to be simulated, prepared but not yet installed.
pub trait PlantSetup: Sized {
    /// Makes what a configuration asks of the plant; outside the tick, so it may take its time.
    ///
    /// # Errors
    /// A plant that the board cannot be, a parameter outside its range.
    fn prepare(simulation: &Simulation, tick_period_us: u32) -> Result<Self, Refusal>;
}

/// Real hardware: refuses every simulated plant.
impl PlantSetup for () {
    fn prepare(simulation: &Simulation, _: u32) -> Result<(), Refusal> {
        match simulation.kind {
            SimulationKind::Real => Ok(()),
            SimulationKind::MassDamper
            | SimulationKind::RigidIndentation
            | SimulationKind::CompliantIndentation => {
                Err(Refusal::Unsupported(Field::SimulationKind))
            }
        }
    }
}

/// Somebody who lends a value to one user at a time: a critical section, a mutex.
pub trait Exclusive {
    /// Type of the value.
    type Value;

    /// Runs `user` with exclusive access to the value. Keep it short: ticks wait meanwhile.
    fn with<R>(&self, user: impl FnOnce(&mut Self::Value) -> R) -> R;
}

impl<T> Exclusive for core::cell::RefCell<T> {
    type Value = T;

    fn with<R>(&self, user: impl FnOnce(&mut T) -> R) -> R {
        user(&mut self.borrow_mut())
    }
}

#[cfg(feature = "std")]
impl<T> Exclusive for std::sync::Mutex<T> {
    type Value = T;

    fn with<R>(&self, user: impl FnOnce(&mut T) -> R) -> R {
        // Whoever panicked with it has been seen; the value itself is whole between two ticks.
        let mut value = self
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        user(&mut value)
    }
}

/// Parts of such an exchange that succeeded, in the same terms for every maker's board: the
/// hardware reports them as they happen, and the loop counts them.
///
/// ```
/// use haptic_link::{NOT_TAKEN, UNANSWERED};
/// use haptic_remote::Exchange;
///
/// let mut exchange = Exchange::default();
/// assert_eq!(exchange.unanswered(), 1);
/// exchange.sent(false);
/// assert_eq!((exchange.flaws(), exchange.unmeasured()), (UNANSWERED, 1));
/// // The answer comes a tick late; meanwhile no force was sent.
/// exchange.answered();
/// assert_eq!(exchange.flaws(), NOT_TAKEN);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Exchange {
    /// Ticks in a row without an answer.
    in_row: u32,
    /// Periods without a tick since the last answer.
    skipped: u32,
    /// Periods without an answer before the last one. A pause's motion may show in the position after it, or in the
    /// next.
    before: u32,
    /// The force of the last tick did not go out.
    withheld: bool,
    /// No force may act in this tick.
    at_rest: bool,
    flaws: u8,
}

/// Longest silence of a board that is asked for no force, s. Nothing can go wrong meanwhile, and a busy machine may hold it up.
const QUIET_MOST_S: f64 = 2.0;

impl Exchange {
    /// The answer of this tick has come.
    pub const fn answered(&mut self) {
        self.before = self.paused();
        (self.in_row, self.skipped) = (0, 0);
        self.flaws = if self.withheld { NOT_TAKEN } else { 0 };
    }

    /// It has not come. How many in a row have not by now.
    pub const fn unanswered(&mut self) -> u32 {
        self.in_row = self.in_row.saturating_add(1);
        self.flaws = UNANSWERED | if self.withheld { NOT_TAKEN } else { 0 };
        self.in_row
    }

    /// The force of this tick went out to the board, or did not.
    pub const fn sent(&mut self, went_out: bool) {
        self.withheld = !went_out;
    }

    /// A tick begins in which no force may act, or one that asks for a force.
    pub(crate) const fn rests(&mut self, at_rest: bool) {
        self.at_rest = at_rest;
    }

    /// True once the board is silent for too long: for so many ticks in a row where it is asked for a force, else for 2 s of ticks.
    #[must_use]
    pub fn is_silent(&self, most: u32, period_s: f64) -> bool {
        let quiet = if self.at_rest {
            (QUIET_MOST_S / period_s) as u32
        } else {
            0
        };
        self.in_row >= most.max(quiet)
    }

    pub(crate) const fn skip(&mut self, periods: u32) {
        self.skipped = self.skipped.saturating_add(periods);
    }

    /// Ticks in a row without an answer.
    #[must_use]
    pub const fn silent_ticks(&self) -> u32 {
        self.in_row
    }

    /// Periods without an answer since the last one.
    const fn paused(&self) -> u32 {
        self.skipped.saturating_add(self.in_row)
    }

    /// Most periods, beyond the usual one, between the last position and the next: a larger motion
    /// in that time is not a jump.
    #[must_use]
    pub const fn unmeasured(&self) -> u32 {
        self.paused().saturating_add(self.before)
    }

    /// Flaws of the last tick, bits as in a [`Sample`](haptic_link::Sample).
    #[must_use]
    pub const fn flaws(&self) -> u8 {
        self.flaws
    }
}
