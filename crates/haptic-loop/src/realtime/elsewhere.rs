//! Systems other than Linux: no locked memory, no pinning; a priority on Windows alone.

use super::moment::Moment;
use super::system::{SystemRefusal, Waiter};
use std::time::Duration;
use std::vec::Vec;
#[cfg(windows)]
use thread_priority::{
    Error, ThreadPriority, WinAPIThreadPriority, get_current_thread_priority,
    set_current_thread_priority,
};

/// The share of a period that may be spinning is one in this many. A sleep there ends half a millisecond late and more: the standard
/// library asks Windows for its finest timer, of 0.5 ms.
pub(super) const SPINNING_IS_ONE_IN: u32 = 1;

/// `std::thread::sleep` for the remaining time.
#[derive(Clone, Copy, Debug)]
pub struct SystemWaiter(Moment);

impl Default for SystemWaiter {
    fn default() -> Self {
        Self(Moment::now())
    }
}

impl Waiter for SystemWaiter {
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

/// Cores that this process may run on; empty where the system does not say.
#[must_use]
pub const fn allowed_cores() -> Vec<usize> {
    Vec::new()
}

/// Raises the priority of a thread of this process.
///
/// # Errors
/// Always, on this system.
pub fn raise_thread<T>(_: &std::thread::JoinHandle<T>, _: u8) -> Result<(), SystemRefusal> {
    Err(SystemRefusal::Unsupported)
}

#[derive(Debug, Default)]
pub(super) struct CurrentThread {
    #[cfg(windows)]
    before: Option<ThreadPriority>,
}

#[expect(clippy::unused_self, reason = "as on a system that can")]
impl CurrentThread {
    #[cfg(windows)]
    pub(super) fn raise(&mut self, _: u8) -> Result<(), SystemRefusal> {
        let before = get_current_thread_priority().ok();
        // The one above all others that needs no right, whatever number was asked for.
        let highest = ThreadPriority::Os(WinAPIThreadPriority::TimeCritical.into());
        set_current_thread_priority(highest).map_err(|error| {
            if let Error::OS(code) = error {
                SystemRefusal::Other(code)
            } else {
                SystemRefusal::Unsupported
            }
        })?;
        self.before = before;
        Ok(())
    }

    #[cfg(not(windows))]
    pub(super) fn raise(&mut self, _: u8) -> Result<(), SystemRefusal> {
        Err(SystemRefusal::Unsupported)
    }

    pub(super) fn pin(&mut self, _: usize) -> Result<(), SystemRefusal> {
        Err(SystemRefusal::Unsupported)
    }

    pub(super) fn lock_memory(&mut self) -> Result<(), SystemRefusal> {
        Err(SystemRefusal::Unsupported)
    }

    pub(super) fn restore(&mut self) {
        #[cfg(windows)]
        if let Some(before) = self.before.take() {
            let _ = set_current_thread_priority(before);
        }
    }
}

#[cfg(all(test, windows))]
mod tests {
    use super::*;

    #[test]
    fn a_thread_is_afterwards_what_it_was_before() {
        let before = get_current_thread_priority();
        let mut thread = CurrentThread::default();
        assert_eq!(thread.raise(80), Ok(()));
        assert_ne!(get_current_thread_priority(), before);
        thread.restore();
        assert_eq!(get_current_thread_priority(), before);
    }
}
