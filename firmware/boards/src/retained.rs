//! Two words that survive a reset, in memory that no start-up code clears.

use core::sync::atomic::{AtomicU32, Ordering};

/// In [`LIVE`] while the device was armed.
const ARMED: u32 = 0x5AFE_F0CE;

#[expect(unsafe_code, reason = "a section is named")]
// SAFETY: the linker script has the section, in RAM, and any value of the word is allowed.
#[unsafe(link_section = ".uninit.boot")]
static BOOT: AtomicU32 = AtomicU32::new(0);

#[expect(unsafe_code, reason = "a section is named")]
// SAFETY: as above.
#[unsafe(link_section = ".uninit.live")]
static LIVE: AtomicU32 = AtomicU32::new(0);

/// The memory retained over the last reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Retained {
    /// Another number after each reset; after power-up whatever the memory came up with. With the times of the hellos
    /// and what the hosts contribute, it makes the numbers of connections: this chip has no source of chance.
    pub boot: u32,
    /// The device was armed, running or with a force when it was reset. After power-up by chance true
    /// once in 4·10⁹ times.
    pub was_armed: bool,
}

impl Retained {
    /// To be called once, at start-up.
    #[must_use]
    pub fn take() -> Self {
        let boot = BOOT.load(Ordering::Relaxed).wrapping_add(1);
        BOOT.store(boot, Ordering::Relaxed);
        Self {
            boot,
            was_armed: LIVE.swap(0, Ordering::Relaxed) == ARMED,
        }
    }

    /// To be known after the next reset.
    pub(crate) fn set_armed(armed: bool) {
        LIVE.store(if armed { ARMED } else { 0 }, Ordering::Relaxed);
    }
}
