//! What a loop asks of a system: a clock that waits; and how a system refuses.

use super::moment::Moment;
use core::fmt;
use std::time::Duration;

/// A clock and the ways to wait for it. Tests pass one whose time they make themselves.
pub trait Waiter {
    /// Time since an origin that never changes.
    fn now(&mut self) -> Duration;

    /// Lets others run until about this time; returns at once if it has passed. May be late.
    fn sleep_until(&mut self, time: Duration);

    /// Keeps the processor until this time.
    fn spin_until(&mut self, time: Duration) {
        while self.now() < time {
            core::hint::spin_loop();
        }
    }
}

/// `std::thread::sleep` for what is left: the plain way, to compare with.
#[derive(Clone, Copy, Debug)]
pub struct StdWaiter(Moment);

impl Default for StdWaiter {
    fn default() -> Self {
        Self(Moment::now())
    }
}

impl Waiter for StdWaiter {
    fn now(&mut self) -> Duration {
        self.0.elapsed()
    }

    fn sleep_until(&mut self, time: Duration) {
        let left = time.saturating_sub(self.0.elapsed());
        if !left.is_zero() {
            std::thread::sleep(left);
        }
    }
}

/// Why the system did not do what was asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Refusal {
    /// This user may not.
    NotPermitted,
    /// More than this user's limit.
    Limit,
    /// This system cannot.
    Unsupported,
    /// Its error code.
    Other(i32),
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotPermitted => f.write_str("not permitted"),
            Self::Limit => f.write_str("above this user's limit"),
            Self::Unsupported => f.write_str("not on this system"),
            Self::Other(code) => write!(f, "error {code} of the system"),
        }
    }
}

impl core::error::Error for Refusal {}
