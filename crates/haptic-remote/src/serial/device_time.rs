//! Time of a served device, for what is emulated behind it.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Time of a device that is served [in its own time](super::Served::in_its_own_time): that of its ticks, µs. Whoever emulates its
/// hardware lives in it too.
#[derive(Clone, Debug, Default)]
pub struct DeviceTime(Arc<AtomicU64>);

impl DeviceTime {
    /// The time of the last tick, µs; 0 before the first. It goes on where the device is served anew.
    #[must_use]
    pub fn now_us(&self) -> u64 {
        self.0.load(Ordering::Acquire)
    }

    pub(super) fn pass(&self, passed_us: u64) {
        self.0.fetch_add(passed_us, Ordering::AcqRel);
    }
}
