//! Support of every on-target test: a way to end QEMU, whatever happens.
#![expect(unsafe_code, reason = "the runtime wants the fault handler marked so")]

use core::panic::PanicInfo;
use cortex_m_rt::{ExceptionFrame, exception};
use cortex_m_semihosting::{debug, hprintln};
// Brings the interrupt vectors.
use boards as _;

/// Ends QEMU with exit code 0.
pub(crate) fn pass() -> ! {
    exit(debug::EXIT_SUCCESS)
}

fn exit(status: debug::ExitStatus) -> ! {
    debug::exit(status);
    loop {
        cortex_m::asm::wfi();
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    hprintln!("{}", info);
    exit(debug::EXIT_FAILURE)
}

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    hprintln!("hard fault: {:?}", frame);
    exit(debug::EXIT_FAILURE)
}
