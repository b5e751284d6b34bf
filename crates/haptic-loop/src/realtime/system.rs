//! Services that a loop needs from a system: a clock that waits; and how a system refuses.

use std::time::Duration;
use thiserror::Error;

/// The operating system's clock and its ways of waiting. Tests pass one whose time they make
/// themselves.
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

/// Why the system did not do what was asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SystemRefusal {
    /// This user may not do it.
    #[error("not permitted")]
    NotPermitted,
    /// More than this user's limit.
    #[error("above this user's limit")]
    Limit,
    /// This system has no such thing.
    #[error("not on this system")]
    Unsupported,
    /// Any other refusal, by the system's error code.
    #[error("error {0} of the system")]
    Other(i32),
}
