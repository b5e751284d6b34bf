//! The interrupts of AN386 that are used, and their vectors.

use cortex_m::interrupt::InterruptNumber;

/// Interrupts, by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(
    non_camel_case_types,
    reason = "named like their handlers, as the runtime expects it"
)]
#[repr(u16)]
pub enum interrupt {
    /// UART0 has received a byte.
    UART0_RX = 0,
    /// UART0 has sent a byte.
    UART0_TX = 1,
}

#[expect(unsafe_code, reason = "the numbers of the interrupts")]
// SAFETY: the numbers are those of AN386, and no two are the same.
unsafe impl InterruptNumber for interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}

#[expect(unsafe_code, reason = "handlers are found by the linker")]
// SAFETY: the linker script has defaults for both names, and handlers have this type.
unsafe extern "C" {
    fn UART0_RX();
    fn UART0_TX();
}

/// Vectors of interrupts 0 and 1. The others are never enabled.
#[expect(
    unsafe_code,
    reason = "the linker puts vectors where the hardware reads them"
)]
// SAFETY: the runtime's linker script expects the table under this name in this section.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
pub(super) static __INTERRUPTS: [unsafe extern "C" fn(); 2] = [UART0_RX, UART0_TX];
