//! The main loop of this board: the common one, compiled here, for size.

use crate::chip;
use haptic_board::{RetainedMemory, Shared};
use haptic_remote::DeviceSession;

#[expect(unsafe_code, reason = "a section is named")]
// SAFETY: the linker script has the section, in RAM, and any values of the words are allowed.
#[unsafe(link_section = ".uninit.retained")]
/// The words that survive a reset: no start-up code clears this section.
pub static RETAINED: RetainedMemory = RetainedMemory::new();

/// Serves the host, asleep when there is nothing to do.
#[inline(never)]
pub fn serve(
    device: &Shared<chip::Board>,
    session: &mut DeviceSession,
    line: &mut chip::Uart,
    watchdog: &mut chip::Watchdog,
) -> ! {
    haptic_board::serve(
        device,
        session,
        line,
        watchdog,
        chip::now_us,
        cortex_m::asm::wfi,
    )
}
