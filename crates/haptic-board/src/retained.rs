//! Two words that survive a reset.

use core::sync::atomic::{AtomicU32, Ordering};

/// Word in [`RetainedMemory::live`] while the device was not idle.
const ARMED: u32 = 0x5AFE_F0CE;

/// Memory that a reset leaves alone, if the board puts it where no start-up code clears it: a
/// section such as `.uninit` of `cortex-m-rt`. In an ordinary static it is cleared, and a reset
/// goes undetected.
#[derive(Debug, Default)]
pub struct RetainedMemory {
    boot: AtomicU32,
    live: AtomicU32,
}

impl RetainedMemory {
    /// Memory for a static. The initial values have no effect, because this memory is not initialised.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            boot: AtomicU32::new(0),
            live: AtomicU32::new(0),
        }
    }

    /// Reads the memory and starts it afresh. Call this once, at start-up.
    #[must_use]
    pub fn take(&self) -> Retained {
        // Only loads and stores: some processors have nothing else, and nothing runs in parallel at start-up.
        let boot = self.boot.load(Ordering::Relaxed).wrapping_add(1);
        self.boot.store(boot, Ordering::Relaxed);
        let was_armed = self.live.load(Ordering::Relaxed) == ARMED;
        self.set_armed(false);
        Retained { boot, was_armed }
    }

    pub(crate) fn set_armed(&self, armed: bool) {
        self.live
            .store(if armed { ARMED } else { 0 }, Ordering::Relaxed);
    }
}

/// The values that survived the last reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Retained {
    /// A number that changes with each reset; after power-up it is whatever the memory contained.
    /// With the times of the hellos and what the hosts contribute, it makes the numbers of
    /// connections, so the chip needs no random source.
    pub boot: u32,
    /// The device was armed, running, with a force or in a fault when it was reset: its zero may be lost, and a second reset finds
    /// it again. After power-up by chance true
    /// once in 4·10⁹ times.
    pub was_armed: bool,
}
