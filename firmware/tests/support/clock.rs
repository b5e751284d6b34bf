//! Instructions, counted by `SysTick` while QEMU takes 64 ns for each: `-icount shift=6`.
//!
//! `SysTick` counts at 25 MHz, every 40 ns, so n instructions are 1.6 n counts, and n is known exactly.

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// Starts the count.
pub(crate) fn start() {
    let Some(mut core) = cortex_m::Peripherals::take() else {
        panic!("once");
    };
    core.SYST.set_clock_source(SystClkSource::Core);
    core.SYST.set_reload(0x00ff_ffff);
    core.SYST.clear_current();
    core.SYST.enable_counter();
}

/// Instructions of these counts of `SysTick`: 64 ns / 40 ns = 8/5.
pub(crate) fn instructions(counts: u32) -> u32 {
    (5 * counts + 4) / 8
}

/// Counts from a reading of `SysTick` to a later one: it counts down, 24 bits.
pub(crate) fn passed(from: u32, to: u32) -> u32 {
    from.wrapping_sub(to) & 0x00ff_ffff
}

/// Counts of an empty measurement.
pub(crate) fn overhead() -> u32 {
    let before = SYST::get_current();
    passed(before, SYST::get_current())
}
