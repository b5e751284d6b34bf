//! A haptic device: starts the board, wires its interrupts, serves the host.
//!
//! All that is yours is in `board.rs` (sensor, actuator) and `chip.rs` (clock, tick, serial line). Look for TODO.
#![no_std]
#![no_main]

mod board;
mod chip;

use board::{Board, NAME};
use core::panic::PanicInfo;
use cortex_m_rt::{ExceptionFrame, entry, exception};
use haptic_board::{
    DeviceMemory, Image, Parts, RetainedMemory, Ticker, TickerSlot, image, power_up, serve,
};

/// Board and version (major, minor, patch) of your firmware, by which `host-cli device flash` knows the image.
/// TODO: `Image::new` if your chip starts without `cortex-m-rt`: then nobody can tell that the board runs exactly this image.
// SAFETY: the linker script of `cortex-m-rt` lays the image out.
static IMAGE: Image = image!(unsafe NAME, [0, 1, 0]);

/// TODO: in a section that no start-up code clears (`#[unsafe(link_section = ".uninit.retained")]` with cortex-m-rt),
/// so that a watchdog's reset in a run is reported as the fault Reset. As it is, a reset looks like power-up.
static RETAINED: RetainedMemory = RetainedMemory::new();

static TICKER: TickerSlot<Board, chip::Timer> = TickerSlot::empty();

#[entry]
fn main() -> ! {
    static mut PLACE: DeviceMemory<Board> = DeviceMemory::new();

    let Parts {
        hardware,
        timer,
        mut line,
        mut watchdog,
    } = chip::start();
    let retained = RETAINED.take();
    let Ok((device, session)) = power_up(PLACE, hardware, IMAGE.version(), retained) else {
        chip::give_up();
    };
    session.set_image_digest(IMAGE.digest());
    TICKER.put(Ticker::new(device, timer, &RETAINED));
    // TODO: sleep (`cortex_m::asm::wfi`) once your line receives by interrupt or DMA. This one has to be looked at.
    let sleep = core::hint::spin_loop;
    serve(
        device,
        session,
        &mut line,
        &mut watchdog,
        chip::now_us,
        sleep,
    )
}

/// The tick. TODO: the interrupt of your timer; its priority is above that of the line.
#[exception]
fn SysTick() {
    TICKER.tick(chip::now_us);
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    chip::give_up()
}

#[exception]
unsafe fn HardFault(_: &ExceptionFrame) -> ! {
    chip::give_up()
}
