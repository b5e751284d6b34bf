//! Systems other than Linux: no priority, no locked memory, no pinning.

use super::system::Refusal;
pub use super::system::StdWaiter as SystemWaiter;
use std::vec::Vec;

/// Cores that this process may run on; empty where the system does not say.
#[must_use]
pub const fn allowed_cores() -> Vec<usize> {
    Vec::new()
}

/// Raises the priority of a thread of this process.
///
/// # Errors
/// Always, on this system.
pub fn raise_thread<T>(_: &std::thread::JoinHandle<T>, _: u8) -> Result<(), Refusal> {
    Err(Refusal::Unsupported)
}

#[derive(Debug, Default)]
pub(super) struct CurrentThread;

#[expect(clippy::unused_self, reason = "as on a system that can")]
impl CurrentThread {
    pub(super) fn raise(&mut self, _: u8) -> Result<(), Refusal> {
        Err(Refusal::Unsupported)
    }

    pub(super) fn pin(&mut self, _: usize) -> Result<(), Refusal> {
        Err(Refusal::Unsupported)
    }

    pub(super) fn lock_memory(&mut self) -> Result<(), Refusal> {
        Err(Refusal::Unsupported)
    }

    pub(super) fn restore(&mut self) {}
}
