//! The state of a bridge for other threads than the one that ticks: an atomic word each way.

use haptic_loop::Fault;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU16, Ordering};

/// Something wrong with a call of the program. Each latches [`Fault::BoardFailed`], and this says why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Trouble {
    /// A position that is NaN, infinite, or beyond single precision.
    Position = 1,
    /// A time that is not later than that of the call before.
    Time = 2,
    /// No position was given, or no room for the force.
    Nothing = 3,
    /// The library itself failed, which is a defect of it: it does not tick again.
    Panicked = 4,
}

impl Trouble {
    /// Every trouble, in the order of the numbers.
    pub const ALL: [Self; 4] = [Self::Position, Self::Time, Self::Nothing, Self::Panicked];

    /// One line with the remedy.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Position => {
                "a position was not a finite number: check the sensor, then arm again"
            }
            Self::Time => {
                "the time stood still or went back: give the microseconds of a clock that only goes on"
            }
            Self::Nothing => {
                "a tick had no position or no room for its force: pass arrays of three numbers"
            }
            Self::Panicked => {
                "the library failed and has let go for good: close it, open it again, and report this"
            }
        }
    }
}

/// Stops a bridge, or sees its fault, from any thread.
#[derive(Clone, Debug, Default)]
pub struct Handle(Arc<Status>);

#[derive(Debug, Default)]
struct Status {
    stop: AtomicBool,
    /// Code of the fault, and above it that of the trouble.
    fault: AtomicU16,
}

impl Handle {
    /// From the next tick on the force falls to zero, and the device is disarmed.
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
    pub fn trouble(&self) -> Option<Trouble> {
        let code = (self.0.fault.load(Ordering::Acquire) >> 8) as u8;
        Trouble::ALL
            .into_iter()
            .find(|trouble| *trouble as u8 == code)
    }

    /// True once for each stop. Read before it is written: a tick in which nobody stops costs no exchange between cores.
    pub(crate) fn take_stop(&self) -> bool {
        self.0.stop.load(Ordering::Relaxed) && self.0.stop.swap(false, Ordering::Acquire)
    }

    pub(crate) fn tell(&self, fault: u8, trouble: Option<Trouble>) {
        let trouble = trouble.map_or(0, |trouble| trouble as u8);
        let word = u16::from_le_bytes([fault, trouble]);
        self.0.fault.store(word, Ordering::Release);
    }
}
