//! Time since power-up, from a counter that wraps.

use core::cell::Cell;
use critical_section::Mutex;

/// Extends a 32-bit counter of microseconds to 64 bits. It must be read at least once in 71
/// minutes; a tick does.
#[derive(Debug)]
pub struct Clock(Mutex<Cell<u64>>);

impl Clock {
    /// Starts at 0.
    #[must_use]
    pub const fn new() -> Self {
        Self(Mutex::new(Cell::new(0)))
    }

    /// The time, µs, from the present value of the counter.
    pub fn now_us(&self, counter: impl FnOnce() -> u32) -> u64 {
        critical_section::with(|token| {
            let last = self.0.borrow(token);
            let passed = counter().wrapping_sub(last.get() as u32);
            last.set(last.get() + u64::from(passed));
            last.get()
        })
    }
}

impl Default for Clock {
    fn default() -> Self {
        Self::new()
    }
}
