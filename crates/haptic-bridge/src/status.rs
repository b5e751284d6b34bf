//! The state of a bridge for other threads than the one that ticks: atomic words each way.

use haptic_link::{Reason, Status, Trouble};
use haptic_loop::Fault;
use std::sync::{
    Arc,
    atomic::{AtomicBool, AtomicU16, AtomicU32, AtomicU64, Ordering},
};

/// Stops a bridge, or sees its fault, from any thread.
#[derive(Clone, Debug, Default)]
pub struct Handle(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    stop: AtomicBool,
    /// Code of the fault, and above it the number of the trouble.
    fault: AtomicU16,
    /// Times of that trouble, packed into one word.
    times: AtomicU64,
    /// Calls so far, and the time that the last one gave, µs.
    calls: AtomicU32,
    told_us: AtomicU64,
    /// Times of a unit that is wrong, as the thread of the line has found it; 0 for a good one.
    unit: AtomicU64,
}

impl Handle {
    /// Lets the force fall to zero from the next tick on, and disarms the device.
    pub fn stop(&self) {
        self.0.stop.store(true, Ordering::Release);
    }

    /// The fault that is latched.
    #[must_use]
    pub fn fault(&self) -> Option<Fault> {
        Fault::from_code(self.0.fault.load(Ordering::Acquire) as u8)
    }

    /// The program's part in that fault.
    #[must_use]
    pub fn reason(&self) -> Option<Reason> {
        let number = self.0.fault.load(Ordering::Acquire) >> 8;
        let trouble = *Trouble::ALL.get(usize::from(number))?;
        reason(trouble, self.0.times.load(Ordering::Relaxed)).some()
    }

    /// True once for each stop. Read before it is written: a tick without a stop costs no exchange between cores.
    pub(crate) fn take_stop(&self) -> bool {
        self.0.stop.load(Ordering::Relaxed) && self.0.stop.swap(false, Ordering::Acquire)
    }

    pub(crate) fn tell(&self, status: Status) {
        let word = u16::from_le_bytes([status.fault, status.reason.trouble as u8]);
        if self.0.fault.load(Ordering::Relaxed) != word {
            self.0.times.store(times(status.reason), Ordering::Relaxed);
            self.0.fault.store(word, Ordering::Release);
        }
    }

    /// A call of the program, for the thread of the line.
    pub(crate) fn called(&self, time_us: u64) {
        let calls = self.0.calls.load(Ordering::Relaxed).wrapping_add(1);
        self.0.told_us.store(time_us, Ordering::Relaxed);
        self.0.calls.store(calls, Ordering::Relaxed);
    }

    /// Calls so far, modulo 2³², and the time that the last one gave, µs.
    pub(crate) fn calls(&self) -> (u32, u64) {
        let calls = self.0.calls.load(Ordering::Relaxed);
        (calls, self.0.told_us.load(Ordering::Relaxed))
    }

    /// The time that is given is in another unit, or in none.
    pub(crate) fn judge_unit(&self, wrong: Option<Reason>) {
        self.0.unit.store(wrong.map_or(0, times), Ordering::Relaxed);
    }

    pub(crate) fn wrong_unit(&self) -> Option<Reason> {
        let unit = self.0.unit.load(Ordering::Relaxed);
        (unit != 0).then(|| reason(Trouble::Unit, unit))
    }
}

const fn reason(trouble: Trouble, times: u64) -> Reason {
    Reason {
        trouble,
        measured_us: (times >> 32) as u32,
        told_us: times as u32,
    }
}

fn times(reason: Reason) -> u64 {
    u64::from(reason.measured_us) << 32 | u64::from(reason.told_us)
}
