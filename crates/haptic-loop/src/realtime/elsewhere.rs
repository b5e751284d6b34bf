//! Systems other than Linux: no priority, no locked memory, no pinning.

use super::system::{Refusal, System};
use super::waiter::{StdWaiter, Waiter};
use std::time::Duration;
use std::vec::Vec;

/// The clock and sleep of this system.
#[derive(Clone, Copy, Debug, Default)]
pub struct SystemWaiter(StdWaiter);

impl SystemWaiter {
    /// Its origin is now.
    #[must_use]
    pub fn new() -> Self {
        Self(StdWaiter::default())
    }
}

impl Waiter for SystemWaiter {
    fn now(&mut self) -> Duration {
        self.0.now()
    }

    fn sleep_until(&mut self, time: Duration) {
        self.0.sleep_until(time);
    }
}

/// Cores that this process may run on; empty where the system does not say.
#[must_use]
pub fn allowed_cores() -> Vec<usize> {
    Vec::new()
}

/// Raises the priority of a thread of this process.
///
/// # Errors
/// Always, on this system.
pub fn raise_thread<T>(_: &std::thread::JoinHandle<T>, _: u8) -> Result<(), Refusal> {
    Err(Refusal::Unsupported)
}

/// The calling thread.
#[derive(Debug, Default)]
pub(super) struct CurrentThread;

impl System for CurrentThread {
    fn raise(&mut self, _: u8) -> Result<(), Refusal> {
        Err(Refusal::Unsupported)
    }

    fn pin(&mut self, _: usize) -> Result<(), Refusal> {
        Err(Refusal::Unsupported)
    }

    fn lock_memory(&mut self) -> Result<(), Refusal> {
        Err(Refusal::Unsupported)
    }

    fn restore(&mut self) {}
}
