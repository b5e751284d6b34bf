//! Functions of a board that the device's end of the link needs.

use crate::Exchange;
use haptic_link::{Capabilities, Refusal, Simulation};
use haptic_loop::{Device, Fault, Reading};

/// A board: sensors and actuators of D axes, one unless said, or a simulation of them. More than one need the feature
/// `several-axes`.
///
/// [`read`](Device::read) and [`write`](Device::write) are called once a tick, in this order. An error of theirs, or of
/// [`idle`](Self::idle), is a fault that latches, and the board is told to [let go](Device::let_go) at each such tick.
pub trait Hardware<const D: usize = 1>: Device<f32, D, Error = Fault> {
    /// Result of [`prepare`](Self::prepare).
    type Setup;

    /// Name and abilities of the board.
    fn capabilities(&self) -> Capabilities;

    /// Makes what a configuration asks of the plant; outside the tick, so it may take its time.
    ///
    /// # Errors
    /// A plant that this board cannot be, a parameter outside its range.
    fn prepare(simulation: &Simulation, tick_period_us: u32) -> Result<Self::Setup, Refusal>;

    /// Makes of what was prepared what this very board is, as an emulated one that is told which device to be; outside the tick too.
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

    /// One tick while no force may act: makes sure of that, and reads. A simulated plant stands still.
    ///
    /// # Errors
    /// Fault of the board.
    fn idle(&mut self) -> Result<Reading<f32, D>, Fault>;

    /// Fault whose condition still holds, such as an open emergency stop; `None` if there is no such fault.
    fn persisting_fault(&self) -> Option<Fault> {
        None
    }

    /// Counts processor cycles, modulo 2³²; 0 for ever where nothing counts them.
    fn cycles(&self) -> u32 {
        0
    }
}

/// Somebody who lends a value to one user at a time: a critical section, a mutex.
pub trait Exclusive<T> {
    /// Runs `user` while nobody else can touch the value. Keep it short: ticks wait meanwhile.
    fn with<R>(&self, user: impl FnOnce(&mut T) -> R) -> R;
}

impl<T> Exclusive<T> for core::cell::RefCell<T> {
    fn with<R>(&self, user: impl FnOnce(&mut T) -> R) -> R {
        user(&mut self.borrow_mut())
    }
}

#[cfg(feature = "std")]
impl<T> Exclusive<T> for std::sync::Mutex<T> {
    fn with<R>(&self, user: impl FnOnce(&mut T) -> R) -> R {
        // Whoever panicked with it has been seen; the value itself is whole between two ticks.
        let mut value = self
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        user(&mut value)
    }
}
